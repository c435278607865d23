//! One step of coarsening.

use super::Amg;
use super::aggregation::{Aggregates, aggregate};
use super::block;
use super::galerkin::{self, Patterns};
use super::lambda::largest_eigenvalue;
use super::prolongation::{self, Prolongation};
use super::rows::Pattern;
use super::sweeps::SweepMatrix;
use super::tentative::Tentative;
use fracas_operators::Real;

/// Coarse nodes over fine nodes above which coarsening has stagnated. Unit: 1.
pub(super) const STAGNATED: f64 = 0.7;

/// Entries of a coarse matrix over those of the fine one above which the prolongation stays unsmoothed: where fractures cut
/// the rock into pieces of a few elements, smoothing across them fills the coarse matrix and gains little. Unit: 1.
const FILL: f64 = 0.5;

/// What coarsening of one level gives: N unknowns per coarse node.
pub(super) struct Coarse<const N: usize, const K: usize> {
    /// Which aggregate every node joined; where coarse nodes are fine ones, the coarse node that it takes most from.
    pub(super) aggregates: Aggregates,
    /// Which coarse nodes share a piece of rock; `None` once that no longer matters.
    pub(super) bonds: Option<Pattern>,
    /// P.
    pub(super) prolongation: Prolongation<N>,
    /// `A_c = PᵀA P`.
    pub(super) matrix: SweepMatrix<f64>,
    /// True when fractures cut the rock into pieces of a few elements, so that P of the aggregates is not smoothed.
    pub(super) network: bool,
    /// Near-null vectors of `A_c`, three rows per block row.
    pub(super) modes: Vec<[[f64; K]; 3]>,
    /// Upper estimate of `λ_max(D⁻¹A)` of the fine matrix.
    pub(super) lambda_max: f64,
}

/// Unknowns up to which a network of pieces of rock is solved directly instead of being coarsened further: pieces turn
/// against each other like gears, which no aggregate of several pieces can do.
const NETWORK: usize = 16_000;

impl<const N: usize, const K: usize> Coarse<N, K> {
    /// True when another level is worth it.
    pub(super) fn goes_on(&self, settings: &Amg) -> bool {
        let n = 3 * self.matrix.rows();
        n > settings.coarsest && !(self.network && n <= NETWORK)
    }
}

/// A way to make coarse unknowns.
pub(super) trait Coarsener<const N: usize, const K: usize> {
    /// Coarsens `a + Δ` (block-diagonal Δ, may be empty) with `group` block rows per node; `None` when it does not get
    /// coarser. A coarse row in an error is named by a fine one.
    fn coarsen<R: Real>(
        settings: &Amg,
        depth: usize,
        a: &SweepMatrix<R>,
        defect: &[[f64; 9]],
        bonds: Option<&Pattern>,
        group: usize,
        modes: &[[[f64; K]; 3]],
    ) -> Result<Option<Coarse<N, K>>, NotPositive>;
}

/// Aggregates of nodes, with as many unknowns each as there are modes.
pub(super) struct SmoothedAggregation;

/// A diagonal block of `A_c` that is not positive definite: scalar row.
pub(super) struct NotPositive(pub(super) usize);

impl<const K: usize> Coarsener<K, K> for SmoothedAggregation {
    fn coarsen<R: Real>(
        settings: &Amg,
        depth: usize,
        a: &SweepMatrix<R>,
        defect: &[[f64; 9]],
        bonds: Option<&Pattern>,
        group: usize,
        modes: &[[[f64; K]; 3]],
    ) -> Result<Option<Coarse<K, K>>, NotPositive> {
        let theta = settings.strength * 0.5_f64.powi(depth as i32);
        let nodes = a.rows() / group;
        let coarser = |aggregates: &Aggregates| {
            aggregates.count > 0 && (aggregates.count as f64) < STAGNATED * nodes as f64
        };
        let mut aggregates = aggregate(a, bonds, group, theta);
        let mut bonds = bonds.filter(|_| coarser(&aggregates));
        if bonds.is_none() && !coarser(&aggregates) {
            // every piece of rock is one aggregate: from here on across the fractures
            aggregates = aggregate(a, None, group, theta);
        }
        if !coarser(&aggregates) {
            return Ok(None);
        }
        let lambda_max = largest_eigenvalue(a);
        let tentative = Tentative::new(&aggregates, group, modes);
        let pattern = prolongation::pattern(a, group, &aggregates);
        let mut patterns = Patterns::new(a, &pattern, aggregates.count);
        let entries = K * K * patterns.coarse().columns.len();
        let network = entries as f64 > FILL * (9 * a.block_count()) as f64;
        let prolongation = if !network {
            prolongation::smoothed(a, group, &aggregates, &tentative, pattern, lambda_max)
        } else {
            let plain = prolongation::tentative(group, &aggregates, &tentative);
            patterns = Patterns::new(a, &plain.pattern, aggregates.count);
            plain
        };
        let blocks = galerkin::product(a, defect, &prolongation, &patterns);
        let matrix = coarse_matrix(patterns.coarse(), blocks).map_err(|NotPositive(row)| {
            let node = aggregates.first_nodes()[row / K];
            NotPositive(3 * node * group + row % 3)
        })?;
        let modes = tentative.coarse.iter();
        let bonds = bonds.take().map(|bonds| aggregates.bonds(bonds));
        Ok(Some(Coarse {
            network,
            bonds,
            aggregates,
            prolongation,
            matrix,
            modes: modes
                .flat_map(|rows| rows.as_chunks::<3>().0.iter().copied())
                .collect(),
            lambda_max,
        }))
    }
}

/// K×K blocks cut into 3×3 ones; unknowns without a column in P get a diagonal entry that keeps them apart.
pub(super) fn coarse_matrix<const K: usize>(
    pattern: &Pattern,
    mut nodes: Vec<[[f64; K]; K]>,
) -> Result<SweepMatrix<f64>, NotPositive> {
    let parts = K / 3;
    let rows = parts * pattern.rows();
    let mut offsets = Vec::with_capacity(rows + 1);
    offsets.push(0);
    let mut columns = Vec::with_capacity(parts * parts * nodes.len());
    let mut blocks: Vec<[f64; 9]> = Vec::with_capacity(columns.capacity());
    let mut inverses = Vec::with_capacity(rows);
    for i in 0..pattern.rows() {
        let range = pattern.offsets[i]..pattern.offsets[i + 1];
        let own = range.start + pattern.row(i).partition_point(|j| (*j as usize) < i);
        let largest = (0..K).map(|k| nodes[own][k][k]).fold(0.0, f64::max);
        for k in 0..K {
            let row_is_zero = nodes[own][k].iter().all(|v| *v == 0.0);
            if row_is_zero {
                nodes[own][k][k] = if largest > 0.0 { largest } else { 1.0 };
            }
        }
        for part in 0..parts {
            for (j, node) in pattern.row(i).iter().zip(&nodes[range.clone()]) {
                for other in 0..parts {
                    columns.push(parts as u32 * j + other as u32);
                    blocks.push(std::array::from_fn(|k| {
                        node[3 * part + k / 3][3 * other + k % 3]
                    }));
                }
            }
            let diagonal: [f64; 9] =
                std::array::from_fn(|k| nodes[own][3 * part + k / 3][3 * part + k % 3]);
            let row = 3 * (parts * i + part);
            inverses.push(block::inverse(&diagonal).map_err(|c| NotPositive(row + c))?);
            offsets.push(columns.len());
        }
    }
    Ok(SweepMatrix::new(offsets, columns, blocks, inverses))
}

#[cfg(test)]
mod tests {
    use crate::SetupError;
    use crate::amg::Amg;
    use crate::elastic_sample::cube;
    use fracas_operators::sparse::{SparseMatrix, Triplets};

    #[test]
    fn a_coarse_matrix_that_is_not_positive_is_named_by_a_row_near_the_defect() {
        let (a, coordinates) = cube(8);
        // softer than nothing in the last corner: blocks stay positive, the energy of a motion of many nodes does not
        let soft = |i: usize| coordinates[i].position.iter().all(|x| *x >= 5.0);
        let mut triplets = Triplets::new((a.rows(), a.rows()));
        for (value, (i, j)) in a.iter() {
            let shift = if i == j && soft(i as usize) {
                0.4 * value
            } else {
                0.0
            };
            triplets.add_triplet(i as usize, j as usize, value - shift);
        }
        let a: SparseMatrix<f64> = triplets.to_csr();
        let settings = Amg {
            coarsest: 50,
            ..Amg::default()
        };
        for known in [Some(&coordinates[..]), None] {
            let error = settings.build(&a, known).unwrap_err();
            let SetupError::NotPositiveDefinite { row, .. } = error else {
                panic!("{error}");
            };
            let place = coordinates[row - 1].position;
            assert!(place.iter().all(|x| *x >= 3.0), "row {row} at {place:?}");
        }
    }
}
