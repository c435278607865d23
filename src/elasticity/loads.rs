//! Nodal forces of body forces, surface tractions and initial stresses, in full numbering [N].

use super::element::{GaussPoints, gauss_point, shape_functions};
use super::{ElasticityError, check};
use crate::mesh::{FractureFace, HexMesh, face_geometry, for_each_point};

/// Stress in the order xx, yy, zz, xy, yz, xz [Pa].
pub type Voigt = [f64; 6];

/// Place of σ_ij in [`Voigt`].
pub(crate) const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Share of the largest pull on a face below which what differs from its mean is rounding. Unit: 1.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Calls `visit(e, points)` for every element.
fn for_each_element(
    mesh: &HexMesh,
    mut visit: impl FnMut(usize, &GaussPoints),
) -> Result<(), ElasticityError> {
    for e in 0..mesh.elements.len() {
        visit(e, &check::gauss_points(mesh, e)?);
    }
    Ok(())
}

/// Forces of a body force b per region: `f_a = ∫ N_a b dV`; `body[region]` in [N/m³], for example ρg.
///
/// # Errors
/// [`ElasticityError`] for an inverted element or a region without a value.
pub fn body_force(mesh: &HexMesh, body: &[[f64; 3]]) -> Result<Vec<f64>, ElasticityError> {
    check::regions(mesh, body.len())?;
    let shapes: [[f64; 8]; 8] = std::array::from_fn(|q| shape_functions(gauss_point(q)));
    let mut force = vec![0.0; 3 * mesh.nodes.len()];
    for_each_element(mesh, |e, points| {
        let b = body[usize::from(mesh.regions[e])];
        for (a, node) in mesh.elements[e].iter().enumerate() {
            let volume: f64 = (0..8).map(|q| points.weights[q] * shapes[q][a]).sum();
            for i in 0..3 {
                force[3 * *node as usize + i] += volume * b[i];
            }
        }
    })?;
    Ok(force)
}

/// Forces of a constant traction on faces: `f_a = ∫ N_a t dS`, 2×2 Gauss points; `traction` in [Pa].
pub fn surface_traction(nodes: &[[f64; 3]], faces: &[[u32; 4]], traction: [f64; 3]) -> Vec<f64> {
    let mut force = vec![0.0; 3 * nodes.len()];
    for face in faces {
        let areas = face_geometry(&face.map(|node| nodes[node as usize])).node_areas;
        for (node, area) in face.iter().zip(areas) {
            for i in 0..3 {
                force[3 * *node as usize + i] += area * traction[i];
            }
        }
    }
    force
}

/// Forces of a constant pressure on faces: `f_a = −∫ N_a p n dS`, n being that of every point, so that a constant stress balances it on faces
/// that are not plane, too; `pressure` in [Pa], corners counter-clockwise around n.
pub fn surface_pressure(nodes: &[[f64; 3]], faces: &[[u32; 4]], pressure: f64) -> Vec<f64> {
    let mut force = vec![0.0; 3 * nodes.len()];
    for face in faces {
        let corners = face.map(|node| nodes[node as usize]);
        let shape = face_geometry(&corners);
        // equal nodes of equal faces have equal forces, to the last bit
        let t = shape.frame[0].map(|n| -pressure * n);
        let mut shares = shape.node_areas.map(|area| t.map(|t| area * t));
        for (share, tilt) in shares
            .iter_mut()
            .zip(shape.tilts(&corners).iter().flatten())
        {
            (0..3).for_each(|i| share[i] -= pressure * tilt[i]);
        }
        for (node, share) in face.iter().zip(shares) {
            (0..3).for_each(|i| force[3 * *node as usize + i] += share[i]);
        }
    }
    force
}

/// Forces of an initial stress: `f = −∫ Bᵀ σ0 dV`; `stress(region, x)` in [Pa], tension positive.
///
/// # Errors
/// [`ElasticityError::Inverted`] for an inverted element.
pub fn initial_stress(
    mesh: &HexMesh,
    stress: impl Fn(usize, [f64; 3]) -> Voigt,
) -> Result<Vec<f64>, ElasticityError> {
    let shapes: [[f64; 8]; 8] = std::array::from_fn(|q| shape_functions(gauss_point(q)));
    let mut force = vec![0.0; 3 * mesh.nodes.len()];
    for_each_element(mesh, |e, points| {
        let x = check::corners(mesh, e);
        for q in 0..8 {
            let at = [0, 1, 2].map(|i| (0..8).map(|a| shapes[q][a] * x[a][i]).sum());
            let sigma = stress(usize::from(mesh.regions[e]), at);
            for (a, node) in mesh.elements[e].iter().enumerate() {
                for i in 0..3 {
                    let divergence: f64 = (0..3)
                        .map(|j| points.gradients[a][j][q] * sigma[VOIGT[i][j]])
                        .sum();
                    force[3 * *node as usize + i] -= points.weights[q] * divergence;
                }
            }
        }
    })?;
    Ok(force)
}

/// What an initial stress pulls on the corners of a face beyond its mean on it, `∫ N_a σ0 n dS − B σ0(centre) n` [N]; `pull(x, n)` is
/// σ0 n. 0 where that is rounding.
///
/// [`initial_stress`] is that of the cut body, and a closed face holds its two sides by one traction: where σ0 grows with depth, its corners
/// were pulled apart or pressed by what differs from it, and level layers moved. An open face holds nothing.
pub fn pull_beyond_mean(
    mesh: &HexMesh,
    face: &FractureFace,
    pull: impl Fn([f64; 3], [f64; 3]) -> [f64; 3],
) -> [[f64; 3]; 4] {
    let corners = face.minus.nodes.map(|node| mesh.nodes[node as usize]);
    let mean = pull(face.center, face.frame[0]);
    let mut beyond = face.node_areas.map(|area| mean.map(|t| -area * t));
    let normal: f64 = (0..3).map(|i| mean[i] * face.frame[0][i]).sum();
    for (beyond, tilt) in beyond
        .iter_mut()
        .zip(face.tilts.iter().flat_map(|t| t.iter()))
    {
        (0..3).for_each(|i| beyond[i] -= normal * tilt[i]);
    }
    let mut size = mean
        .iter()
        .fold(0.0, |m: f64, t| m.max(face.area * t.abs()));
    for_each_point(&corners, |x, shape, n| {
        let pulled = pull(x, n);
        for a in 0..4 {
            (0..3).for_each(|i| beyond[a][i] += shape[a] * pulled[i]);
        }
        size = pulled.iter().fold(size, |m, t| m.max(t.abs()));
    });
    match beyond.iter().flatten().any(|f| f.abs() > ROUNDING * size) {
        true => beyond,
        false => [[0.0; 3]; 4],
    }
}

/// Calls `add(3·node + component, f)` with what such corners pull at the side that the normal of the face leaves, and with −f at the other.
pub fn between_sides(
    face: &FractureFace,
    corners: &[[f64; 3]; 4],
    mut add: impl FnMut(usize, f64),
) {
    for (nodes, sign) in [(face.minus.nodes, 1.0), (face.plus.nodes, -1.0)] {
        for (node, own) in nodes.iter().zip(corners) {
            (0..3).for_each(|i| add(3 * *node as usize + i, sign * own[i]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, Sample};
    use super::*;

    fn distorted() -> HexMesh {
        sample::mesh(Sample {
            cells: [3, 4, 2],
            distortion: 0.2,
            regions: 2,
            ..Sample::default()
        })
    }

    /// Σ f and Σ x × f.
    fn resultant(nodes: &[[f64; 3]], force: &[f64]) -> [f64; 6] {
        let mut sum = [0.0; 6];
        for (x, f) in nodes.iter().zip(force.chunks_exact(3)) {
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                sum[i] += f[i];
                sum[3 + i] += x[j] * f[k] - x[k] * f[j];
            }
        }
        sum
    }

    fn assert_near(a: &[f64], b: &[f64]) {
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() < 1e-12, "{a:?} is not {b:?}");
        }
    }

    #[test]
    fn weight_has_its_resultant_and_its_moment() {
        let mesh = sample::mesh(Sample {
            cells: [3, 4, 2],
            grading: 0.2,
            ..Sample::default()
        });
        let (x, y, z) = (3.64, 5.368, 2.2);
        let force = body_force(&mesh, &[[0.0, 0.0, -2.0]]).unwrap();
        let weight = -2.0 * x * y * z;
        let expected = [0.0, 0.0, weight, weight * y / 2.0, -weight * x / 2.0, 0.0];
        assert_near(&resultant(&mesh.nodes, &force), &expected);
    }

    #[test]
    fn a_traction_has_its_resultant_and_its_moment() {
        let nodes = [
            [0.0, 0.0, 1.0],
            [2.0, 0.0, 1.0],
            [2.0, 3.0, 1.0],
            [0.0, 3.0, 1.0],
        ];
        let t = [0.5, -1.0, 2.0];
        let force = surface_traction(&nodes, &[[0, 1, 2, 3]], t);
        let f = t.map(|v| 6.0 * v);
        let (x, y, z) = (1.0, 1.5, 1.0);
        let moment = [
            y * f[2] - z * f[1],
            z * f[0] - x * f[2],
            x * f[1] - y * f[0],
        ];
        assert_near(
            &resultant(&nodes, &force),
            &[f[0], f[1], f[2], moment[0], moment[1], moment[2]],
        );
    }

    #[test]
    fn a_trapezoid_gives_more_to_its_long_side() {
        let corners = [
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [3.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
        ];
        let areas = face_geometry(&corners).node_areas;
        // ∫ (1−η)(4−2η)/… on the reference square: 5/6 per bottom corner, 4/6 per top corner.
        assert_near(&areas, &[5.0 / 6.0, 5.0 / 6.0, 4.0 / 6.0, 4.0 / 6.0]);
    }

    #[test]
    fn a_constant_initial_stress_is_balanced_by_its_boundary_tractions() {
        let mesh = sample::mesh(Sample {
            cells: [2, 3, 2],
            ..Sample::default()
        });
        let sigma = [1.0, -2.0, 0.5, 0.25, -0.75, 0.4];
        let mut force = initial_stress(&mesh, |_, _| sigma).unwrap();
        // f + Σ over the six sides of σ0·n vanishes node by node.
        for axis in 0..3 {
            for (side, sign) in [(0.0, -1.0), ([2.0, 3.0, 2.0][axis], 1.0)] {
                let traction = [0, 1, 2].map(|i| sign * sigma[VOIGT[i][axis]]);
                let faces: Vec<[u32; 4]> = mesh
                    .elements
                    .iter()
                    .filter_map(|e| face_on(&mesh, e, axis, side))
                    .collect();
                let t = surface_traction(&mesh.nodes, &faces, traction);
                force.iter_mut().zip(&t).for_each(|(f, t)| *f += t);
            }
        }
        assert!(force.iter().all(|f| f.abs() < 1e-13), "{force:?}");
    }

    /// The face of an element whose nodes lie on the plane x_axis = side, in cyclic order.
    fn face_on(mesh: &HexMesh, element: &[u32; 8], axis: usize, side: f64) -> Option<[u32; 4]> {
        const FACES: [[usize; 4]; 6] = [
            [0, 1, 2, 3],
            [4, 5, 6, 7],
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
        ];
        let on = |n: &u32| mesh.nodes[*n as usize][axis] == side;
        FACES
            .map(|f| f.map(|a| element[a]))
            .into_iter()
            .find(|f| f.iter().all(on))
    }

    #[test]
    fn a_pressure_on_faces_that_are_not_plane_is_balanced_by_a_constant_stress() {
        let cells = [3, 2, 4];
        let mut mesh = sample::mesh(Sample {
            cells,
            ..Sample::default()
        });
        let on_sides = |mesh: &HexMesh| -> Vec<[u32; 4]> {
            let side = |axis: usize, far: bool| {
                let end = if far { cells[axis] as f64 } else { 0.0 };
                let found = mesh.elements.iter();
                let outward = move |face: [u32; 4]| {
                    let n = face_geometry(&face.map(|a| mesh.nodes[a as usize])).frame[0];
                    let is_out = (n[axis] > 0.0) == far;
                    let [a, b, c, d] = face;
                    if is_out { face } else { [d, c, b, a] }
                };
                let found = found.filter_map(move |e| face_on(mesh, e, axis, end));
                found.map(outward).collect::<Vec<_>>()
            };
            let sides = (0..3).flat_map(|axis| [(axis, false), (axis, true)]);
            sides.flat_map(|(axis, far)| side(axis, far)).collect()
        };
        let faces = on_sides(&mesh);
        let mut random = fracas_operators::random::Random::new(73);
        for x in mesh.nodes.iter_mut().flatten() {
            *x += random.between(-0.1, 0.1);
        }
        let stress = [-2.5, -2.5, -2.5, 0.0, 0.0, 0.0];
        let mut force = initial_stress(&mesh, |_, _| stress).unwrap();
        let pressed = surface_pressure(&mesh.nodes, &faces, 2.5);
        force.iter_mut().zip(&pressed).for_each(|(f, p)| *f += p);
        assert!(force.iter().all(|f| f.abs() < 1e-13), "{force:?}");
    }

    #[test]
    fn an_initial_stress_has_no_resultant_and_no_moment() {
        let force = initial_stress(&distorted(), |region, x| {
            [region as f64, 1.0 + x[2], -2.0 * x[2], 0.3, 0.1 * x[2], 0.0]
        })
        .unwrap();
        assert_near(&resultant(&distorted().nodes, &force), &[0.0; 6]);
    }

    #[test]
    fn a_stress_that_grows_with_depth_carries_the_weight_of_inner_nodes() {
        let mesh = sample::mesh(Sample {
            cells: [2, 2, 4],
            grading: 0.3,
            ..Sample::default()
        });
        // σ_zz,z = γ with body force −γ
        let stress = initial_stress(&mesh, |_, x| [0.0, 0.0, 2.0 * x[2], 0.0, 0.0, 0.0]).unwrap();
        let weight = body_force(&mesh, &[[0.0, 0.0, -2.0]]).unwrap();
        for layer in 1..4 {
            let dof = 3 * (4 + 9 * layer) + 2;
            assert!(weight[dof] < -0.5);
            assert!((stress[dof] + weight[dof]).abs() < 1e-13);
        }
    }
}
