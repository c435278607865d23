//! Stresses of a displacement field, a tensor per element.

use super::element::{GaussPoints, gauss_point, shape_functions};
use super::loads::Voigt;
use super::{Elastic, ElasticityError, check};
use crate::mesh::HexMesh;
use rayon::prelude::*;

/// Mean stress of every element: `σ_e = 1/|e| ∫_e (σ0 + λ tr(ε) I + 2G ε) dV`, ε = sym ∇u, 2×2×2 Gauss points.
///
/// `u` is in full numbering [m]; `initial(region, x)` is σ0 [Pa].
///
/// # Shape
/// A tensor per element in the order xx, yy, zz, xy, yz, xz, which is also VTK's.
///
/// # Units
/// Pa, tension positive.
///
/// # Errors
/// [`ElasticityError`] for an inverted element or a region without a material.
pub fn element_stress(
    mesh: &HexMesh,
    materials: &[Elastic],
    u: &[f64],
    initial: impl Fn(usize, [f64; 3]) -> Voigt + Sync,
) -> Result<Vec<Voigt>, ElasticityError> {
    assert_eq!(u.len(), 3 * mesh.nodes.len(), "length of u");
    check::regions(mesh, materials.len())?;
    let shapes: [[f64; 8]; 8] = std::array::from_fn(|q| shape_functions(gauss_point(q)));
    let of_element = |e: usize| {
        let points = check::gauss_points(mesh, e)?;
        let region = usize::from(mesh.regions[e]);
        let volume: f64 = points.weights.iter().sum();
        let x = check::corners(mesh, e);
        let mut sum = mean_strain_stress(&points, &mesh.elements[e], materials[region], u);
        for (shape, weight) in shapes.iter().zip(points.weights) {
            let at = [0, 1, 2].map(|i| (0..8).map(|a| shape[a] * x[a][i]).sum());
            let sigma = initial(region, at);
            (0..6).for_each(|k| sum[k] += weight * sigma[k]);
        }
        Ok(sum.map(|s| s / volume))
    };
    // errors are looked at in order, so that the first inverted element is the one named
    let all: Vec<_> = (0..mesh.elements.len())
        .into_par_iter()
        .map(of_element)
        .collect();
    all.into_iter().collect()
}

/// `∫_e (λ tr(ε) I + 2G ε) dV`.
fn mean_strain_stress(
    points: &GaussPoints,
    nodes: &[u32; 8],
    material: Elastic,
    u: &[f64],
) -> Voigt {
    // G_ij = ∫ ∂u_i/∂x_j
    let mut g = [[0.0; 3]; 3];
    for (a, node) in nodes.iter().enumerate() {
        for j in 0..3 {
            let slope: f64 = (0..8)
                .map(|q| points.weights[q] * points.gradients[a][j][q])
                .sum();
            for i in 0..3 {
                g[i][j] += slope * u[3 * *node as usize + i];
            }
        }
    }
    let pressure = material.lambda() * (g[0][0] + g[1][1] + g[2][2]);
    let shear = material.shear();
    [
        pressure + 2.0 * shear * g[0][0],
        pressure + 2.0 * shear * g[1][1],
        pressure + 2.0 * shear * g[2][2],
        shear * (g[0][1] + g[1][0]),
        shear * (g[1][2] + g[2][1]),
        shear * (g[0][2] + g[2][0]),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, Sample};
    use super::super::{loads, stiffness};
    use super::*;
    use fracas_operators::LinearOperator;

    const ROCKS: [Elastic; 2] = [
        Elastic {
            young: 3.0,
            poisson: 0.2,
        },
        Elastic {
            young: 7.0,
            poisson: 0.35,
        },
    ];

    const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]];

    fn distorted() -> HexMesh {
        sample::mesh(Sample {
            cells: [3, 4, 2],
            distortion: 0.2,
            regions: 2,
            split: true,
            ..Sample::default()
        })
    }

    fn near(a: &Voigt, b: &Voigt) {
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() < 1e-12, "{a:?} is not {b:?}");
        }
    }

    #[test]
    fn a_linear_displacement_has_its_stress_in_every_element() {
        let mesh = distorted();
        let h = [[0.3, -0.1, 0.2], [0.5, 0.7, -0.4], [0.6, 0.1, -0.2]];
        let u: Vec<f64> = mesh
            .nodes
            .iter()
            .flat_map(|x| h.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]))
            .collect();
        let initial = [1.0, -2.0, 0.5, 0.25, -0.75, 0.4];
        let stress = element_stress(&mesh, &ROCKS, &u, |_, _| initial).unwrap();
        for (sigma, region) in stress.iter().zip(&mesh.regions) {
            let rock = ROCKS[usize::from(*region)];
            let expected: Vec<f64> = PAIRS
                .iter()
                .zip(initial)
                .map(|([i, j], s0)| {
                    let delta = if i == j { 1.0 } else { 0.0 };
                    s0 + rock.lambda() * delta * (h[0][0] + h[1][1] + h[2][2])
                        + rock.shear() * (h[*i][*j] + h[*j][*i])
                })
                .collect();
            near(sigma, &expected.try_into().unwrap());
        }
    }

    #[test]
    fn the_mean_stress_of_the_body_is_the_moment_of_its_nodal_forces() {
        // virtual work with the linear field x_j: Σ_e |e| σ_ij = Σ_a x_j (A u − f0)_ai
        let mesh = distorted();
        let u: Vec<f64> = (0..3 * mesh.nodes.len())
            .map(|i| (1.7 * i as f64).sin())
            .collect();
        let initial =
            |region: usize, x: [f64; 3]| [region as f64, 1.0 + x[2], -x[2], 0.3, 0.1 * x[2], 0.2];
        let stress = element_stress(&mesh, &ROCKS, &u, initial).unwrap();
        let a = stiffness(&mesh, &ROCKS).unwrap();
        let mut force = vec![0.0; u.len()];
        a.apply(&u, &mut force, &mut vec![0.0; a.work_len()]);
        let load = loads::initial_stress(&mesh, initial).unwrap();
        force.iter_mut().zip(&load).for_each(|(f, f0)| *f -= f0);
        for (k, [i, j]) in PAIRS.into_iter().enumerate() {
            let integral: f64 = stress
                .iter()
                .enumerate()
                .map(|(e, sigma)| mesh.element_volume(e) * sigma[k])
                .sum();
            let moment: f64 = mesh
                .nodes
                .iter()
                .enumerate()
                .map(|(a, x)| x[j] * force[3 * a + i])
                .sum();
            assert!(
                (integral - moment).abs() < 1e-10,
                "{k}: {integral} {moment}"
            );
        }
    }

    #[test]
    fn an_element_without_material_is_named() {
        let mesh = distorted();
        let u = vec![0.0; 3 * mesh.nodes.len()];
        let error = element_stress(&mesh, &ROCKS[..1], &u, |_, _| [0.0; 6]).unwrap_err();
        assert!(
            matches!(error, ElasticityError::NoMaterial { region: 1, .. }),
            "{error}"
        );
    }
}
