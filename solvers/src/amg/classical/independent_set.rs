//! Coarse nodes: a maximal independent set.

use super::strength::Strength;
use fracas_operators::random::splitmix64;

/// A fine node in the numbering of the coarse ones.
pub(super) const FINE: u32 = u32::MAX;

/// What is known of a node.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Undecided,
    Coarse,
    Fine,
}

/// Coarse nodes and the place of every node among them.
#[derive(Clone, Debug)]
pub(super) struct Splitting {
    /// Ascending nodes.
    pub(super) nodes: Vec<u32>,
    /// Number of every node among the coarse ones, or [`FINE`].
    pub(super) number: Vec<u32>,
}

/// Parallel modified independent set by Luby's rounds: a node whose weight `degree + hash ∈ [0, 1)` exceeds those of its
/// undecided neighbours becomes coarse, they become fine. A node without neighbours is fine: a smoother solves it.
///
/// Weights depend on the graph and on node numbers alone.
///
/// # Source
/// H. De Sterck, U. M. Yang, J. J. Heys, SIAM J. Matrix Anal. Appl. 27 (2006) 1019–1039.
pub(super) fn splitting(graph: &Strength) -> Splitting {
    let n = graph.len();
    let weight = |i: usize| (graph.neighbours(i).len(), splitmix64(i as u64), i);
    let mut state: Vec<State> = (0..n)
        .map(|i| match graph.neighbours(i) {
            [] => State::Fine,
            _ => State::Undecided,
        })
        .collect();
    let mut undecided: Vec<usize> = (0..n).filter(|i| state[*i] == State::Undecided).collect();
    while !undecided.is_empty() {
        let heaviest = |i: usize| {
            let mut rivals = graph.neighbours(i).iter().map(|j| *j as usize);
            rivals.all(|j| state[j] != State::Undecided || weight(j) < weight(i))
        };
        let chosen: Vec<usize> = undecided.iter().copied().filter(|i| heaviest(*i)).collect();
        for i in chosen {
            state[i] = State::Coarse;
            for j in graph.neighbours(i) {
                state[*j as usize] = State::Fine;
            }
        }
        undecided.retain(|i| state[*i] == State::Undecided);
    }
    let nodes: Vec<u32> = (0..n as u32)
        .filter(|i| state[*i as usize] == State::Coarse)
        .collect();
    let mut number = vec![FINE; n];
    for (k, i) in nodes.iter().enumerate() {
        number[*i as usize] = k as u32;
    }
    Splitting { nodes, number }
}
