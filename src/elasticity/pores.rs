//! Nodal forces of pore pressures that differ from element to element.

use super::{ElasticityError, check};
use crate::mesh::HexMesh;
use rayon::prelude::*;

/// Elements of one task.
const ELEMENTS_PER_TASK: usize = 256;

/// Elements whose forces are held at a time.
const ELEMENTS_AT_A_TIME: usize = 1 << 16;

/// Adds the forces of a pressure [Pa] in each of some elements, by which total stress falls, in full numbering [N]: `f_a = p_e ∫ ∇N_a dV`,
/// 2×2×2 Gauss points. The same bits for any number of threads.
///
/// # Errors
/// [`ElasticityError::Inverted`] for an inverted element.
pub fn pore_forces(
    mesh: &HexMesh,
    elements: &[u32],
    pressures: &[f64],
    force: &mut [f64],
) -> Result<(), ElasticityError> {
    assert_eq!(elements.len(), pressures.len(), "pressures of elements");
    let of = |(e, p): (&u32, &f64)| -> Result<[[f64; 3]; 8], ElasticityError> {
        let points = check::gauss_points(mesh, *e as usize)?;
        let integral = |a: usize, i: usize| -> f64 {
            let slopes = points.gradients[a][i].iter().zip(points.weights);
            slopes.map(|(slope, weight)| weight * slope).sum()
        };
        Ok(std::array::from_fn(|a| {
            [0, 1, 2].map(|i| p * integral(a, i))
        }))
    };
    let parts = elements.chunks(ELEMENTS_AT_A_TIME);
    for (elements, pressures) in parts.zip(pressures.chunks(ELEMENTS_AT_A_TIME)) {
        let all: Vec<Result<_, _>> = (elements.par_iter().with_min_len(ELEMENTS_PER_TASK))
            .zip(pressures)
            .map(of)
            .collect();
        for (e, of_nodes) in elements.iter().zip(all) {
            for (node, f) in mesh.elements[*e as usize].iter().zip(of_nodes?) {
                (0..3).for_each(|i| force[3 * *node as usize + i] += f[i]);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::loads;
    use super::super::sample::{self, Sample};
    use super::*;

    #[test]
    fn equal_pressures_are_an_isotropic_initial_stress() {
        let mesh = sample::mesh(Sample {
            cells: [3, 4, 2],
            distortion: 0.2,
            regions: 2,
            ..Sample::default()
        });
        let pressures = [3.0, -0.5];
        let expected = loads::initial_stress(&mesh, |region, _| {
            let p = pressures[region];
            [-p, -p, -p, 0.0, 0.0, 0.0]
        });
        let mut force = vec![0.0; 3 * mesh.nodes.len()];
        for region in 0..2 {
            let own = (0..mesh.elements.len() as u32)
                .filter(|e| usize::from(mesh.regions[*e as usize]) == region);
            let own: Vec<u32> = own.collect();
            let equal = vec![pressures[region]; own.len()];
            pore_forces(&mesh, &own, &equal, &mut force).unwrap();
        }
        for (f, g) in force.iter().zip(expected.unwrap()) {
            assert!((f - g).abs() < 1e-14, "{f} {g}");
        }
    }
}
