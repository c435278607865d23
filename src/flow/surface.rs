//! The open faces of fractures as a surface that pressures open.

use crate::contact::ContactState;
use crate::elasticity::Elastic;
use crate::mesh::{FractureFace, HexMesh};
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::saddle::Surface;
use std::collections::BTreeMap;

/// `L_ab = ∫ ∇N_a·∇N_b dS` of the bilinear functions of a face, its corners in its plane. Unit: 1.
fn laplacian(corners: [[f64; 2]; 4]) -> [[f64; 4]; 4] {
    let mut l = [[0.0; 4]; 4];
    let at = 1.0 / 3f64.sqrt();
    for [xi, eta] in [[-at, -at], [at, -at], [at, at], [-at, at]] {
        let by = [
            [-0.25 * (1.0 - eta), -0.25 * (1.0 - xi)],
            [0.25 * (1.0 - eta), -0.25 * (1.0 + xi)],
            [0.25 * (1.0 + eta), 0.25 * (1.0 + xi)],
            [-0.25 * (1.0 + eta), 0.25 * (1.0 - xi)],
        ];
        // J_ij = ∂x_j/∂ξ_i
        let mut j = [[0.0; 2]; 2];
        for (corner, by) in corners.iter().zip(by) {
            for (row, by) in j.iter_mut().zip(by) {
                row[0] += by * corner[0];
                row[1] += by * corner[1];
            }
        }
        let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        let gradient = by.map(|[a, b]| {
            [
                (j[1][1] * a - j[0][1] * b) / det,
                (j[0][0] * b - j[1][0] * a) / det,
            ]
        });
        for (row, a) in l.iter_mut().zip(gradient) {
            for (entry, b) in row.iter_mut().zip(gradient) {
                *entry += det.abs() * (a[0] * b[0] + a[1] * b[1]);
            }
        }
    }
    l
}

/// The [`Surface`] of the open faces, forces and volumes counted in `unit`.
///
/// Its nodes are those of open faces with two sides, for each fracture its own; a closed face holds them, as tips do. Across a junction
/// each fracture goes on as if there was none.
pub fn surface(
    mesh: &HexMesh,
    faces: &[FractureFace],
    materials: &[Elastic],
    states: &[ContactState],
    unit: f64,
) -> Surface {
    let is_open = |f: usize| states[f] == ContactState::Open;
    let node = |face: &FractureFace, a: usize| {
        let (minus, plus) = (face.minus.nodes[a], face.plus.nodes[a]);
        (minus != plus).then(|| (face.fracture, mesh.origin[minus as usize]))
    };
    let mut numbers: BTreeMap<(u16, u32), usize> = BTreeMap::new();
    for (_, face) in faces.iter().enumerate().filter(|(f, _)| is_open(*f)) {
        for key in (0..4).filter_map(|a| node(face, a)) {
            let next = numbers.len();
            numbers.entry(key).or_insert(next);
        }
    }
    let n = numbers.len();
    let mut volume = Triplets::new((faces.len(), n));
    let mut laplace = Triplets::new((n, n));
    let (mut area, mut weighted) = (vec![0.0; n], vec![0.0; n]);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (f, face) in faces.iter().enumerate() {
        let of = |a: usize| node(face, a).and_then(|key| numbers.get(&key).copied());
        let places = [0, 1, 2, 3].map(of);
        if places == [None; 4] {
            continue;
        }
        let soft = |element: u32| {
            let rock = materials[usize::from(mesh.regions[element as usize])];
            2.0 * (1.0 - rock.poisson * rock.poisson) / rock.young
        };
        let compliance = soft(face.minus.element) + soft(face.plus.element);
        let corners = face.minus.nodes.map(|node| mesh.nodes[node as usize]);
        let [_, t1, t2] = face.frame;
        let along = |x: &[f64; 3], t: [f64; 3]| -> f64 { (0..3).map(|i| x[i] * t[i]).sum() };
        let l = laplacian(corners.map(|x| [along(&x, t1), along(&x, t2)]));
        for (a, place) in places.iter().enumerate() {
            let Some(place) = *place else { continue };
            area[place] += face.node_areas[a];
            weighted[place] += face.node_areas[a] * compliance;
            for i in 0..3 {
                low[i] = low[i].min(corners[a][i]);
                high[i] = high[i].max(corners[a][i]);
            }
            if is_open(f) {
                volume.add_triplet(f, place, unit * face.node_areas[a]);
            }
            for (b, other) in places.iter().enumerate() {
                match *other {
                    Some(other) if a == b || is_open(f) => {
                        laplace.add_triplet(place, other, l[a][b]);
                    }
                    _ => {}
                }
            }
        }
    }
    let laplacian: SparseMatrix<f64> = laplace.to_csr();
    let most = Surface::highest(&laplacian, &area);
    let diagonal: f64 = (0..3).map(|i| (high[i] - low[i]).powi(2)).sum();
    let least = std::f64::consts::PI.powi(2) / diagonal;
    Surface {
        volume: volume.to_csr(),
        interval: (least.min(0.1 * most), most),
        laplacian,
        compliance: weighted.iter().zip(&area).map(|(w, a)| w / a).collect(),
        area,
    }
}
