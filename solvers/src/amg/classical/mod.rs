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
mod interpolation;
mod least_squares;
mod level;
mod nodes;
mod pseudo_inverse;
mod strength;
#[cfg(test)]
mod tests;

pub(super) use level::Classical;

use super::rows::Pattern;
use interpolation::Interpolation;
use least_squares::Modes;
use nodes::NodeBlocks;
use strength::Strength;

/// Steps of energy minimisation. Two take most of what can be gained on the pattern of P.
const ENERGY_STEPS: usize = 2;

/// A coarse level.
#[derive(Clone, Debug)]
struct Coarse {
    /// Coarse nodes, ascending.
    nodes: Vec<u32>,
    /// P.
    interpolation: Interpolation,
}

/// Coarse nodes and P for a symmetric matrix by nodes, the inverses of its diagonal blocks, and its near-null modes.
///
/// `P V_c = V` with the modes V of the fine nodes and V_c of the coarse ones, except where a row would exceed norm 10.
/// Components that no mode moves are not interpolated. The same bits for any number of threads.
fn coarsen<const K: usize>(
    a: &NodeBlocks,
    inverse: &[[f64; 9]],
    bonds: Option<&Pattern>,
    modes: &Modes<K>,
) -> Coarse {
    assert!(a.len() == modes.len() && a.len() == inverse.len());
    let graph = Strength::new(a, bonds);
    let splitting = independent_set::splitting(&graph);
    let graphs = [&graph, &Strength::complete(a)];
    let mut interpolation = least_squares::interpolation(graphs, &splitting, modes);
    energy::minimise(
        a,
        inverse,
        &splitting,
        modes,
        &mut interpolation,
        ENERGY_STEPS,
    );
    Coarse {
        nodes: splitting.nodes,
        interpolation,
    }
}
