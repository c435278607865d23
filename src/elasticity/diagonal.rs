//! The diagonal of the stiffness, element by element.

use super::{Elastic, ElasticityError, check};
use crate::mesh::HexMesh;
use rayon::prelude::*;

/// Elements whose entries wait in memory before they are added: 12 MB.
const BATCH: usize = 1 << 16;

/// Elements that one task computes.
const PER_TASK: usize = 512;

/// `diag A` in full numbering, before any displacement is prescribed [N/m].
///
/// # Cost
/// O(elements); elements are added in order, so the bits do not depend on the number of threads.
///
/// # Errors
/// [`ElasticityError`] for an inverted element or a region without a material.
pub fn diagonal(mesh: &HexMesh, materials: &[Elastic]) -> Result<Vec<f64>, ElasticityError> {
    check::regions(mesh, materials.len())?;
    let mut diagonal = vec![0.0; 3 * mesh.nodes.len()];
    let mut entries = vec![[[0.0; 3]; 8]; BATCH.min(mesh.elements.len())];
    for (batch, elements) in mesh.elements.chunks(BATCH).enumerate() {
        entries[..elements.len()]
            .par_iter_mut()
            .with_min_len(PER_TASK)
            .enumerate()
            .try_for_each(|(i, entries)| {
                let e = batch * BATCH + i;
                let geometry = check::geometry(mesh, e)?;
                let material = materials[usize::from(mesh.regions[e])];
                for (a, entry) in entries.iter_mut().enumerate() {
                    *entry = geometry.stiffness_diagonal(a, material);
                }
                Ok(())
            })?;
        for (nodes, entries) in elements.iter().zip(&entries) {
            for (node, entry) in nodes.iter().zip(entries) {
                for i in 0..3 {
                    diagonal[3 * *node as usize + i] += entry[i];
                }
            }
        }
    }
    Ok(diagonal)
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, Sample};
    use super::super::stiffness;
    use super::*;

    #[test]
    fn it_is_the_diagonal_of_the_assembled_matrix() {
        let rocks = [
            Elastic {
                young: 3.0,
                poisson: 0.2,
            },
            Elastic {
                young: 1.0,
                poisson: 0.35,
            },
        ];
        for distortion in [0.0, 0.15] {
            let mesh = sample::mesh(Sample {
                cells: [4, 3, 3],
                distortion,
                regions: 2,
                split: true,
                ..Sample::default()
            });
            let a = stiffness(&mesh, &rocks).unwrap().to_csr();
            for (i, d) in diagonal(&mesh, &rocks).unwrap().into_iter().enumerate() {
                assert_eq!(d, *a.get(i, i).unwrap(), "row {i}");
            }
        }
    }
}
