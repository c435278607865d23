//! One step of coarsening.

use super::Amg;
use super::aggregation::Aggregates;
use super::galerkin::{self, Patterns, Upper};
use super::matrix::{NodeMatrix, SINGULAR};
use super::prolongation::Prolongation;
use super::transfer::{Transfer, TransferPattern};
use fracas_operators::Real;
use fracas_operators::small::{Matrix3, equilibrated_inverse, transposed};
use fracas_operators::sparse::Pattern;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Coarse nodes over fine nodes above which coarsening has stagnated. Unit: 1.
pub(super) const STAGNATED: f64 = 0.7;

/// Coarse nodes that one task cuts into blocks.
const NODES_PER_TASK: usize = 128;

/// What does not change with the values of a matrix: which coarse unknowns there are, and what they reach.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Which coarse node every node joined; where coarse nodes are fine ones, the one that it takes most from.
    pub(super) aggregates: Aggregates,
    /// Where P has blocks.
    pub(super) transfer: Arc<TransferPattern>,
    /// Where `A_c` has blocks.
    pub(super) patterns: Patterns,
}

impl Frame {
    /// For P of this pattern.
    pub(super) fn new<S: Real>(a: &NodeMatrix<S>, aggregates: Aggregates, p: Pattern) -> Self {
        let transfer = TransferPattern::new(p, aggregates.count);
        Self {
            patterns: Patterns::new(a, &transfer),
            transfer: Arc::new(transfer),
            aggregates,
        }
    }

    /// P and Pᵀ by the blocks of P.
    pub(super) fn transfer<R: Real, const N: usize>(
        &self,
        blocks: Vec<[[R; N]; 3]>,
    ) -> Transfer<R> {
        Transfer::new(self.transfer.clone(), blocks)
    }

    /// P and `A_c = Pᵀ(A + Δ)P` for a P with these blocks.
    pub(super) fn values<S: Real, R: Real, const N: usize>(
        &self,
        a: &NodeMatrix<S>,
        defect: Vec<Matrix3<f64>>,
        blocks: Vec<[[R; N]; 3]>,
    ) -> Result<Values<R, N>, NotPositive> {
        let p = Prolongation {
            pattern: &self.transfer.p,
            blocks: &blocks,
        };
        let coarse = galerkin::product(a, &defect, p, &self.patterns);
        drop(defect);
        Ok(Values {
            matrix: coarse_matrix(self.patterns.coarse(), &coarse)?,
            blocks,
        })
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.aggregates.of) + self.transfer.bytes() + self.patterns.bytes()
    }
}

/// What follows from the values of a matrix.
pub(super) struct Values<R, const N: usize> {
    /// P.
    pub(super) blocks: Vec<[[R; N]; 3]>,
    /// `A_c = PᵀA P`.
    pub(super) matrix: NodeMatrix<f64>,
}

/// What is known of a level besides its matrix.
pub(super) struct Known<const K: usize> {
    /// Which nodes share a piece of rock, where the matrix joins others, too; `None` once that no longer matters.
    pub(super) bonds: Option<Pattern>,
    /// Near-null vectors, three rows per block row.
    pub(super) modes: Vec<[[f64; K]; 3]>,
    /// Where the nodes are, a coarse one in the middle of its own; empty without coordinates.
    pub(super) positions: Vec<[f64; 3]>,
}

/// A step that has been planned, and what the next one starts from.
pub(super) struct Planned<P, const K: usize> {
    pub(super) step: P,
    pub(super) known: Known<K>,
}

/// A way to make coarse unknowns, N per coarse node, planned once for all matrices of one pattern whose strong connections
/// are those of the first.
pub(super) trait Coarsener<const N: usize, const K: usize>: Sized + Send + Sync {
    /// Chooses coarse unknowns of `a` with `group` block rows per node; `None` when it does not get coarser.
    fn plan<S: Real>(
        settings: &Amg,
        depth: usize,
        a: &NodeMatrix<S>,
        known: &Known<K>,
        group: usize,
    ) -> Option<Planned<Self, K>>;

    /// P and the coarse matrix of `a + Δ` (block-diagonal Δ, may be empty); λ_max is that of `D⁻¹a`. A coarse row in
    /// an error is that of [`Frame`].
    fn values<S: Real, R: Real>(
        &self,
        a: &NodeMatrix<S>,
        defect: Vec<Matrix3<f64>>,
        lambda_max: f64,
    ) -> Result<Values<R, N>, NotPositive>;

    /// The coarse unknowns.
    fn frame(&self) -> &Frame;

    /// Unknowns of the next level up to which it is solved directly instead of being coarsened.
    fn direct_below(&self, settings: &Amg) -> usize {
        settings.coarsest
    }

    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// A diagonal block of `A_c` that is not positive definite: scalar row of `A_c`.
pub(super) struct NotPositive(pub(super) usize);

/// Consecutive coarse nodes and what is theirs of the coarse matrix.
struct Task<'a> {
    nodes: Range<usize>,
    columns: &'a mut [u32],
    blocks: &'a mut [Matrix3<f64>],
    inverses: &'a mut [Matrix3<f64>],
}

/// K×K blocks cut into 3×3 ones; those left of the diagonal mirror the others. Unknowns without a column in P get a
/// diagonal entry that keeps them apart.
fn coarse_matrix<const K: usize>(
    pattern: &Pattern,
    nodes: &Upper<K>,
) -> Result<NodeMatrix<f64>, NotPositive> {
    let parts = K / 3;
    let rows = parts * pattern.rows();
    let mut offsets = Vec::with_capacity(rows + 1);
    offsets.push(0);
    for i in 0..pattern.rows() {
        let length = parts * pattern.row(i).len();
        (0..parts).for_each(|_| offsets.push(offsets[offsets.len() - 1] + length));
    }
    let entries = parts * parts * pattern.columns.len();
    let mut columns = vec![0; entries];
    let mut blocks = vec![[[0.0; 3]; 3]; entries];
    let mut inverses = vec![[[0.0; 3]; 3]; rows];
    let mut tasks = Vec::with_capacity(pattern.rows() / NODES_PER_TASK + 1);
    let (mut all_columns, mut all_blocks) = (&mut columns[..], &mut blocks[..]);
    for (k, own_inverses) in inverses.chunks_mut(parts * NODES_PER_TASK).enumerate() {
        let first = k * NODES_PER_TASK;
        let last = first + own_inverses.len() / parts;
        let length = offsets[parts * last] - offsets[parts * first];
        let (own_columns, other_columns) = all_columns.split_at_mut(length);
        let (own_blocks, other_blocks) = all_blocks.split_at_mut(length);
        (all_columns, all_blocks) = (other_columns, other_blocks);
        tasks.push(Task {
            nodes: first..last,
            columns: own_columns,
            blocks: own_blocks,
            inverses: own_inverses,
        });
    }
    let cut = |task: Task<'_>| {
        let Task {
            nodes: range,
            columns,
            blocks,
            inverses,
        } = task;
        let start = offsets[parts * range.start];
        let first = range.start;
        for i in range {
            let diagonal = diagonal(pattern, nodes, i);
            let length = parts * pattern.row(i).len();
            let own = offsets[parts * i] - start;
            for (place, at) in (pattern.offsets[i]..pattern.offsets[i + 1]).enumerate() {
                let j = pattern.columns[at];
                let node = match (j as usize).cmp(&i) {
                    std::cmp::Ordering::Less => {
                        let j = j as usize;
                        transposed(nodes.at(j, pattern.place(j, i as u32)))
                    }
                    std::cmp::Ordering::Equal => diagonal,
                    std::cmp::Ordering::Greater => *nodes.at(i, at),
                };
                for part in 0..parts {
                    for other in 0..parts {
                        let to = own + part * length + parts * place + other;
                        columns[to] = parts as u32 * j + other as u32;
                        blocks[to] = three(&node, part, other);
                    }
                }
            }
            for part in 0..parts {
                let row = 3 * (parts * i + part);
                let inverse =
                    equilibrated_inverse(three(&diagonal, part, part), [true; 3], SINGULAR);
                inverses[parts * (i - first) + part] = inverse.map_err(|c| row + c)?;
            }
        }
        Ok(())
    };
    let worst = tasks.into_par_iter().map(cut).filter_map(Result::err).min();
    match worst {
        Some(row) => Err(NotPositive(row)),
        None => {
            let pattern = Pattern { offsets, columns };
            Ok(NodeMatrix::new(pattern, blocks, inverses))
        }
    }
}

/// The diagonal block of a node, symmetric to the last bit and without a zero row.
fn diagonal<const K: usize>(pattern: &Pattern, nodes: &Upper<K>, i: usize) -> [[f64; K]; K] {
    let stored = nodes.at(i, pattern.place(i, i as u32));
    let mut own: [[f64; K]; K] =
        std::array::from_fn(|r| std::array::from_fn(|c| stored[r.min(c)][r.max(c)]));
    let largest = (0..K).map(|k| own[k][k]).fold(0.0, f64::max);
    for k in 0..K {
        if own[k].iter().all(|v| *v == 0.0) {
            own[k][k] = if largest > 0.0 { largest } else { 1.0 };
        }
    }
    own
}

/// A 3×3 part of a block.
fn three<const K: usize>(node: &[[f64; K]; K], part: usize, other: usize) -> Matrix3<f64> {
    std::array::from_fn(|r| std::array::from_fn(|c| node[3 * part + r][3 * other + c]))
}
