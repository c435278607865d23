//! Classical coarsening of vector problems: the unknowns of the coarse nodes are unknowns of the fine ones.
//!
//! | step | file |
//! |---|---|
//! | strong connections between nodes | `strength` |
//! | coarse nodes: a maximal independent set | `independent_set` |
//! | P that reproduces the modes | `least_squares` |
//! | P of less energy among those | `energy` |
//! | `A_c = PᵀA P` | `level` |

mod energy;
mod independent_set;
mod least_squares;
mod level;
mod nodes;
mod pseudo_inverse;
mod strength;
#[cfg(test)]
mod tests;

pub(super) use level::Classical;

use fracas_operators::small::Matrix3;
use fracas_operators::sparse::{Pattern, SparseRows};
use independent_set::Splitting;
use least_squares::Modes;
use nodes::{NodeBlocks, diagonal};
use strength::Strength;

/// Steps of energy minimisation. Two take most of what can be gained on the pattern of P.
const ENERGY_STEPS: usize = 2;

/// P by nodes: rows are fine nodes, columns coarse ones.
type Interpolation = SparseRows<Matrix3<f64>>;

/// Coarse nodes, and a P that reproduces the modes before its energy is minimised.
#[derive(Clone, Debug)]
struct Start {
    splitting: Splitting,
    interpolation: Interpolation,
}

impl Start {
    /// For a symmetric matrix by nodes and its near-null modes.
    ///
    /// `P V_c = V` with the modes V of the fine nodes and V_c of the coarse ones, except where a row would exceed norm 10.
    /// Components that no mode moves are not interpolated. The same bits for any number of threads.
    fn new<const K: usize>(a: &NodeBlocks, bonds: Option<&Pattern>, modes: &Modes<K>) -> Self {
        assert_eq!(a.pattern.rows(), modes.len(), "nodes and modes");
        let graph = Strength::new(a, bonds);
        let splitting = independent_set::splitting(&graph);
        let graphs = [&graph, &Strength::complete(a)];
        Self {
            interpolation: least_squares::interpolation(graphs, &splitting, modes),
            splitting,
        }
    }

    /// Coarse nodes.
    fn count(&self) -> usize {
        self.splitting.nodes.len()
    }

    /// P of less energy on the same pattern; `inverse`: of the diagonal blocks.
    fn minimised<const K: usize>(
        &self,
        a: &NodeBlocks,
        inverse: &[Matrix3<f64>],
        modes: &Modes<K>,
    ) -> Interpolation {
        let mut p = self.interpolation.clone();
        energy::minimise(a, inverse, &self.splitting, modes, &mut p, ENERGY_STEPS);
        p
    }
}
