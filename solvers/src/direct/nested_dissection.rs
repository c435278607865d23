//! Fill-reducing order by nested dissection of the graph of a matrix, after equal nodes are merged.
//!
//! Unknowns with the same closed neighbourhood (the three displacements of a node, say) are eliminated one after the
//! other by any good order. They are merged first, without coordinates, and METIS sees a graph of nodes.
#![allow(unsafe_code, reason = "calls a C library")]

use super::graph::Graph;
use crate::SetupError;
use fracas_operators::sparse::SparseMatrix;
use metis_sys as m;
use std::sync::Mutex;

unsafe extern "C" {
    /// Does nothing, but brings `metis_errors.c` into the program: METIS then gives up without signals.
    pub(super) fn fracas_metis_errors();
}

/// METIS draws from the generator of the C library, which is one per process: calls take turns, so that the same
/// pattern always gets the same order.
pub(super) static GENERATOR: Mutex<()> = Mutex::new(());

/// Seed of that generator: any fixed number.
pub(super) const SEED: m::idx_t = 1;

/// Order of elimination of the unknowns of a square matrix: entry k is the unknown eliminated k-th.
///
/// Only the pattern of `A + Aᵀ` counts.
///
/// # Cost
/// O(nnz) to merge equal unknowns, then METIS on the merged graph: about 5 % of a 3-D factorization.
///
/// # Errors
/// [`SetupError::OutOfMemory`] beyond 2³¹ − 1 edges of the merged graph.
///
/// # Source
/// G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20 (1998) 359–392 (METIS); C. Ashcraft, SIAM J. Sci. Comput. 16 (1995)
/// 1404–1411 (compressed graphs).
pub fn nested_dissection(a: &SparseMatrix<f64>) -> Result<Vec<usize>, SetupError> {
    let (graph, members) = Graph::of_pattern(a).compressed();
    let nodes = order_nodes(&graph, &members)?;
    let order: Vec<usize> = nodes
        .iter()
        .flat_map(|node| members[*node].iter().copied())
        .collect();
    debug_assert_eq!(order.len(), a.rows());
    Ok(order)
}

/// METIS on a graph whose node `i` stands for `members[i].len()` unknowns.
fn order_nodes(graph: &Graph, members: &[Vec<usize>]) -> Result<Vec<usize>, SetupError> {
    let n = graph.nodes();
    if graph.neighbours.is_empty() {
        return Ok((0..n).collect());
    }
    let too_large = |_| SetupError::OutOfMemory {
        method: "METIS",
        n,
        bytes: None,
        advice: "its indices have 32 bits: solve smaller blocks or use an iterative method"
            .to_owned(),
    };
    let index = |i: usize| m::idx_t::try_from(i).map_err(too_large);
    let mut offsets = graph
        .offsets
        .iter()
        .map(|&i| index(i))
        .collect::<Result<Vec<_>, _>>()?;
    let mut neighbours = graph
        .neighbours
        .iter()
        .map(|&i| index(i))
        .collect::<Result<Vec<_>, _>>()?;
    let mut weights = members
        .iter()
        .map(|group| index(group.len()))
        .collect::<Result<Vec<_>, _>>()?;
    let mut count = index(n)?;
    let mut options: [m::idx_t; m::METIS_NOPTIONS as usize] = [-1; m::METIS_NOPTIONS as usize];
    options[m::moptions_et_METIS_OPTION_SEED as usize] = SEED;
    options[m::moptions_et_METIS_OPTION_COMPRESS as usize] = 0;
    let (mut order, mut position) = (vec![0; n], vec![0; n]);
    let turn = GENERATOR
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    // Safety: every array has the length METIS documents, and the graph is symmetric without loops.
    let status = unsafe {
        fracas_metis_errors();
        m::METIS_NodeND(
            &mut count,
            offsets.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            weights.as_mut_ptr(),
            options.as_mut_ptr(),
            order.as_mut_ptr(),
            position.as_mut_ptr(),
        )
    };
    drop(turn);
    if status != m::rstatus_et_METIS_OK {
        return Err(SetupError::OutOfMemory {
            method: "METIS",
            n,
            bytes: None,
            advice: format!("it stopped with status {status}; solve smaller blocks"),
        });
    }
    Ok(order.into_iter().map(|i| i as usize).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::sparse::Triplets;
    use proptest::prelude::*;

    fn pattern(n: usize, entries: &[(usize, usize)]) -> SparseMatrix<f64> {
        let mut triplets = Triplets::new((n, n));
        for &(i, j) in entries {
            triplets.add_triplet(i % n, j % n, 1.0);
        }
        triplets.to_csr()
    }

    proptest! {
        #[test]
        fn the_order_is_a_permutation_and_repeats_itself(
            n in 1usize..60,
            entries in proptest::collection::vec((0usize..60, 0usize..60), 0..300),
        ) {
            let a = pattern(n, &entries);
            let order = nested_dissection(&a).unwrap();
            let mut sorted = order.clone();
            sorted.sort_unstable();
            prop_assert!(sorted.iter().copied().eq(0..n));
            prop_assert_eq!(order, nested_dissection(&a).unwrap());
        }
    }

    #[test]
    fn concurrent_orders_equal_the_sequential_one() {
        let entries: Vec<_> = (0..900usize)
            .flat_map(|i| [(i, i + 1), (i, i + 30), (i, i)])
            .filter(|&(_, j)| j < 900)
            .collect();
        let a = pattern(900, &entries);
        let alone = nested_dissection(&a).unwrap();
        let together: Vec<_> = std::thread::scope(|scope| {
            let runs: Vec<_> = (0..4)
                .map(|_| scope.spawn(|| nested_dissection(&a).unwrap()))
                .collect();
            runs.into_iter().map(|run| run.join().unwrap()).collect()
        });
        assert!(together.iter().all(|order| *order == alone));
    }

    /// Signals that this process handles, as a bit per number from 1.
    #[cfg(target_os = "linux")]
    fn caught() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find_map(|l| l.strip_prefix("SigCgt:"));
        u64::from_str_radix(line.unwrap().trim(), 16).unwrap()
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn no_signal_is_handled_while_metis_is_at_work() {
        use std::sync::atomic::{AtomicBool, Ordering};
        let before = caught();
        let n = 40_000;
        let entries: Vec<_> = (0..n)
            .flat_map(|i| [(i, i + 1), (i, i + 200), (i, i)])
            .filter(|&(_, j)| j < n)
            .collect();
        let a = pattern(n, &entries);
        let done = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                nested_dissection(&a).unwrap();
                done.store(true, Ordering::Relaxed);
            });
            let mut looks = 0;
            while !done.load(Ordering::Relaxed) {
                assert_eq!(caught(), before, "METIS handles a signal");
                looks += 1;
            }
            assert!(looks > 10, "METIS was looked at {looks} times");
        });
    }
}
