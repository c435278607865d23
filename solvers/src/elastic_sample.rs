//! Elasticity on a box of trilinear bricks, for the tests of preconditioners.

use crate::DofCoordinate;
use fracas_operators::laws::probe;
use fracas_operators::sparse::{SparseMatrix, Triplets};

/// Poisson's ratio of the samples.
const POISSON: f64 = 0.25;

/// Stiffness of `cells` bricks of size `h`, Young's modulus by cell, the face x = 0 clamped and removed.
pub(crate) fn clamped_box(
    cells: [usize; 3],
    h: [f64; 3],
    young: impl Fn([usize; 3]) -> f64,
) -> (SparseMatrix<f64>, Vec<DofCoordinate>) {
    let unit = brick(h);
    let nodes = cells.map(|c| c + 1);
    // nodes of the face x = 0 are left out
    let unknown = |at: [usize; 3], component: usize| {
        let node = at[0].checked_sub(1)? + (nodes[0] - 1) * (at[1] + nodes[1] * at[2]);
        Some(3 * node + component)
    };
    let n = 3 * cells[0] * nodes[1] * nodes[2];
    let mut triplets = Triplets::new((n, n));
    for_each(cells, |cell| {
        let modulus = young(cell);
        let dof = |a: usize| unknown(std::array::from_fn(|d| cell[d] + ((a / 3) >> d & 1)), a % 3);
        for a in 0..24 {
            for b in 0..24 {
                if let (Some(i), Some(j)) = (dof(a), dof(b)) {
                    triplets.add_triplet(i, j, modulus * unit[a][b]);
                }
            }
        }
    });
    let mut coordinates = Vec::with_capacity(n);
    for_each([cells[0], nodes[1], nodes[2]], |at| {
        let position = [
            (at[0] + 1) as f64 * h[0],
            at[1] as f64 * h[1],
            at[2] as f64 * h[2],
        ];
        coordinates.extend((0..3).map(|component| DofCoordinate {
            position,
            component,
        }));
    });
    (triplets.to_csr(), coordinates)
}

/// A cube of unit bricks with modulus 1.
pub(crate) fn cube(cells: usize) -> (SparseMatrix<f64>, Vec<DofCoordinate>) {
    clamped_box([cells; 3], [1.0; 3], |_| 1.0)
}

/// x fastest.
fn for_each(counts: [usize; 3], mut visit: impl FnMut([usize; 3])) {
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            (0..counts[0]).for_each(|x| visit([x, y, z]));
        }
    }
}

/// `∫ εᵀ D ε` of a brick with modulus 1; bit d of a node is its place along axis d.
fn brick(h: [f64; 3]) -> [[f64; 24]; 24] {
    let lambda = POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let mu = 0.5 / (1.0 + POISSON);
    let volume = h[0] * h[1] * h[2] / 8.0;
    let mut k = [[0.0; 24]; 24];
    for q in 0..8 {
        let point = |d: usize| if q >> d & 1 == 1 { 1.0 } else { -1.0 } / 3f64.sqrt();
        let gradient = |a: usize, d: usize| {
            let sign = |e: usize| if a >> e & 1 == 1 { 1.0 } else { -1.0 };
            let others = (0..3).filter(|e| *e != d).map(|e| 1.0 + sign(e) * point(e));
            0.25 * sign(d) / h[d] * others.product::<f64>()
        };
        for a in 0..8 {
            for b in 0..8 {
                let inner: f64 = (0..3).map(|d| gradient(a, d) * gradient(b, d)).sum();
                for i in 0..3 {
                    for j in 0..3 {
                        let shear = gradient(a, j) * gradient(b, i);
                        let diagonal = if i == j { inner } else { 0.0 };
                        k[3 * a + i][3 * b + j] += volume
                            * (lambda * gradient(a, i) * gradient(b, j) + mu * (shear + diagonal));
                    }
                }
            }
        }
    }
    k
}

/// A name, a matrix and where its unknowns are.
pub(crate) type Sample = (&'static str, SparseMatrix<f64>, Vec<DofCoordinate>);

/// Cubes of cells: alike, in layers, flat, of random stiffness, far away.
pub(crate) fn bodies(cells: usize) -> Vec<Sample> {
    let name = |name, (a, coordinates)| (name, a, coordinates);
    let layers = |c: [usize; 3]| {
        if (c[2] / 3).is_multiple_of(2) {
            1.0
        } else {
            1e3
        }
    };
    let noise: Vec<f64> = probe(cells * cells * cells, 5);
    let random = |c: [usize; 3]| 10f64.powf(4.0 * noise[c[0] + cells * (c[1] + cells * c[2])]);
    vec![
        name("cube", cube(cells)),
        name("layers", clamped_box([cells; 3], [1.0; 3], layers)),
        name(
            "flat elements",
            clamped_box([cells; 3], [1.0, 1.0, 0.1], |_| 1.0),
        ),
        name("random contrast", clamped_box([cells; 3], [1.0; 3], random)),
        name("far from the origin", {
            let (a, mut coordinates) = cube(cells);
            coordinates.iter_mut().for_each(|c| c.position[0] += 300.0);
            (a, coordinates)
        }),
    ]
}
