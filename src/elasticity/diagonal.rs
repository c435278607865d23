//! The diagonal of the stiffness, element by element.

use super::element::{ElementMatrix, Geometry};
use super::{Elastic, ElasticityError, check};
use crate::mesh::{HexMesh, Places};
use fracas_operators::small::{cholesky, times};
use rayon::prelude::*;

/// Elements whose entries wait in memory before they are added: 12 MB.
const BATCH: usize = 1 << 16;

/// Elements that one task computes.
const PER_TASK: usize = 512;

/// Entries of an element: `[node][component]`.
type Entries = [[f64; 3]; 8];

/// `diag A` in full numbering, before any displacement is prescribed [N/m].
///
/// # Cost
/// O(elements); elements are added in order, so the bits do not depend on the number of threads.
///
/// # Errors
/// [`ElasticityError`] for an inverted element or a region without a material.
pub fn diagonal(mesh: &HexMesh, materials: &[Elastic]) -> Result<Vec<f64>, ElasticityError> {
    let all = Sum {
        count: mesh.elements.len(),
        element: |e| e,
        nodes: mesh.nodes.len(),
        place: |node| Some(node as usize),
    };
    all.of(mesh, materials, own)
}

/// The diagonal of the element matrix.
fn own(geometry: &Geometry, material: Elastic) -> Entries {
    std::array::from_fn(|a| geometry.stiffness_diagonal(a, material))
}

/// `[D, D̃]` at `nodes`, `3·place + component` [N/m], D = diag(A) and `A ⪯ D̃`:
/// ```text
/// A = Σ A_e ⪯ Σ ω_e diag(A_e),   ω_e ≥ λ_max(diag(A_e)⁻¹ A_e)
/// ```
///
/// # Cost
/// O(elements at these nodes), some 10 µs each; bits as those of [`diagonal`].
///
/// # Errors
/// [`ElasticityError`] for an inverted element or a region without a material.
pub(crate) fn diagonals_at(
    nodes: &Places,
    mesh: &HexMesh,
    materials: &[Elastic],
) -> Result<[Vec<f64>; 2], ElasticityError> {
    let is_near = |corners: &[u32; 8]| corners.iter().any(|node| nodes.of(*node).is_some());
    let all = 0..mesh.elements.len();
    let near: Vec<usize> = all.filter(|e| is_near(&mesh.elements[*e])).collect();
    let sum = Sum {
        count: near.len(),
        element: |i| near[i],
        nodes: nodes.nodes().len(),
        place: |node| nodes.of(node),
    };
    Ok([
        sum.of(mesh, materials, own)?,
        sum.of(mesh, materials, above)?,
    ])
}

/// `ω_e diag(A_e)`.
fn above(geometry: &Geometry, material: Elastic) -> Entries {
    let omega = largest_ratio(&geometry.stiffness(material));
    own(geometry, material).map(|entries| entries.map(|entry| omega * entry))
}

/// Steps of the power method before the first bound is tried.
const POWERS: usize = 20;

/// Factor from one bound that is tried to the next. Unit: 1.
const NEXT: f64 = 1.01;

/// A bound of `λ_max(D⁻¹K)`, D = diag(K), for K ⪰ 0: `τ D − K` has a Cholesky factor, and as a rule not 2 % above.
fn largest_ratio(k: &ElementMatrix) -> f64 {
    let root: [f64; 24] = std::array::from_fn(|i| k[i][i].sqrt());
    let scaled: ElementMatrix =
        std::array::from_fn(|i| std::array::from_fn(|j| k[i][j] / (root[i] * root[j])));
    // any start: a poor one costs tries
    let mut v: [f64; 24] = std::array::from_fn(|i| 1.0 + (i * i % 7) as f64);
    let mut tau = 1.0;
    for _ in 0..POWERS {
        let product = times(&scaled, &v);
        let size = product.iter().map(|y| y * y).sum::<f64>().sqrt();
        tau = size / v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v = product.map(|y| y / size);
    }
    // at 24, the trace, it holds for every K
    while tau < 24.0 {
        tau *= NEXT;
        let rest: ElementMatrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { tau - 1.0 } else { -scaled[i][j] })
        });
        if cholesky(&rest, ROUNDING).is_ok() {
            return tau;
        }
    }
    24.0
}

/// Share of its diagonal entry below which a pivot may be rounding. Unit: 1.
const ROUNDING: f64 = 1e-13;

/// A sum over elements `element(0..count)` at nodes that have a place.
struct Sum<E, P> {
    count: usize,
    element: E,
    /// How many nodes have a place.
    nodes: usize,
    place: P,
}

impl<E: Fn(usize) -> usize + Sync, P: Fn(u32) -> Option<usize>> Sum<E, P> {
    /// `Σ entries(e)`, `3·place + component`, in the order of the elements.
    fn of(
        &self,
        mesh: &HexMesh,
        materials: &[Elastic],
        entries_of: impl Fn(&Geometry, Elastic) -> Entries + Sync,
    ) -> Result<Vec<f64>, ElasticityError> {
        check::regions(mesh, materials.len())?;
        let mut diagonal = vec![0.0; 3 * self.nodes];
        let mut entries: Vec<Entries> = vec![[[0.0; 3]; 8]; BATCH.min(self.count)];
        let element = &self.element;
        for first in (0..self.count).step_by(BATCH) {
            let batch = first..self.count.min(first + BATCH);
            entries[..batch.len()]
                .par_iter_mut()
                .with_min_len(PER_TASK)
                .enumerate()
                .try_for_each(|(i, entries)| {
                    let e = element(first + i);
                    let material = materials[usize::from(mesh.regions[e])];
                    *entries = entries_of(&check::geometry(mesh, e)?, material);
                    Ok(())
                })?;
            for (i, entries) in batch.zip(&entries) {
                for (node, entry) in mesh.elements[element(i)].iter().zip(entries) {
                    if let Some(place) = (self.place)(*node) {
                        for k in 0..3 {
                            diagonal[3 * place + k] += entry[k];
                        }
                    }
                }
            }
        }
        Ok(diagonal)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, Sample};
    use super::super::stiffness;
    use super::*;
    use fracas_solvers::eigen::dense::symmetric_eigenvalues;

    fn rocks() -> [Elastic; 2] {
        [(3.0, 0.2), (1.0, 0.35)].map(|(young, poisson)| Elastic { young, poisson })
    }

    fn mesh_of(distortion: f64) -> HexMesh {
        sample::mesh(Sample {
            cells: [4, 3, 3],
            distortion,
            regions: 2,
            split: true,
            ..Sample::default()
        })
    }

    #[test]
    fn it_is_the_diagonal_of_the_assembled_matrix() {
        for distortion in [0.0, 0.15] {
            let mesh = mesh_of(distortion);
            let a = stiffness(&mesh, &rocks()).unwrap().to_csr();
            for (i, d) in diagonal(&mesh, &rocks()).unwrap().into_iter().enumerate() {
                assert_eq!(d, *a.get(i, i).unwrap(), "row {i}");
            }
        }
    }

    #[test]
    fn the_one_above_is_above_and_half_of_it_is_not() {
        for distortion in [0.0, 0.15] {
            let mesh = mesh_of(distortion);
            let a = stiffness(&mesh, &rocks()).unwrap().to_csr();
            let nodes = Places::new(mesh.nodes.len(), 0..mesh.nodes.len() as u32);
            let [own, above] = diagonals_at(&nodes, &mesh, &rocks()).unwrap();
            assert_eq!(own, diagonal(&mesh, &rocks()).unwrap());
            let scaled = faer::Mat::from_fn(above.len(), above.len(), |i, j| {
                a.get(i, j).copied().unwrap_or(0.0) / (above[i] * above[j]).sqrt()
            });
            let values = symmetric_eigenvalues(scaled.as_ref()).unwrap();
            let largest = values[values.len() - 1];
            assert!((0.5..=1.0).contains(&largest), "{distortion}: {largest}");
        }
    }

    #[test]
    fn some_nodes_have_the_entries_that_they_have_among_all() {
        let mesh = mesh_of(0.15);
        let count = mesh.nodes.len();
        let of = |nodes: &Places| diagonals_at(nodes, &mesh, &rocks()).unwrap();
        let all = of(&Places::new(count, 0..count as u32));
        let some = Places::new(count, (2..count as u32).step_by(5));
        for (found, all) in of(&some).iter().zip(&all) {
            for (entries, node) in found.chunks(3).zip(some.nodes()) {
                assert_eq!(entries, &all[3 * *node as usize..][..3], "node {node}");
            }
        }
    }

    #[test]
    fn the_ratio_of_an_element_is_its_largest_eigenvalue_within_two_percent() {
        let mut dice = fracas_operators::random::Random::new(41);
        for case in 0..200 {
            let size = [0, 1, 2].map(|_| dice.scale(1e-2, 1e2));
            let mut nodes = crate::mesh::jacobian::CORNERS
                .map(|c| [0, 1, 2].map(|i| size[i] * (1.0 + 0.5 * c[i])));
            for (x, i) in nodes.iter_mut().zip([0, 1, 2].into_iter().cycle()) {
                x[i] += 0.2 * size[i] * dice.between(-1.0, 1.0);
            }
            let material = Elastic {
                young: dice.scale(1e-3, 1e3),
                poisson: dice.between(0.0, 0.4999),
            };
            let Ok(geometry) = Geometry::new(&nodes) else {
                continue;
            };
            let k = geometry.stiffness(material);
            let scaled = faer::Mat::from_fn(24, 24, |i, j| k[i][j] / (k[i][i] * k[j][j]).sqrt());
            let values = symmetric_eigenvalues(scaled.as_ref()).unwrap();
            let ratio = largest_ratio(&k) / values[23];
            assert!((1.0..1.021).contains(&ratio), "case {case}: {ratio}");
        }
    }
}
