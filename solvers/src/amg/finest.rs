//! The finest level: A, or S_u = A + F Fᵀ, in 3×3 node blocks.

use super::halved::HalvedMatrix;
use super::matrix::{NodeMatrix, SINGULAR};
use super::node_map::{NONE, NodeMap};
use crate::smoothers::entries::finite_entries;
use crate::{DofCoordinate, SetupError};
use fracas_operators::small::{Matrix3, cast, equilibrated_inverse};
use fracas_operators::sparse::{Pattern, SparseMatrix, Transposed};
use fracas_operators::{Real, Shape};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Nodes whose blocks one task sums.
const NODES_PER_TASK: usize = 2048;

/// Name of the matrix in messages; the caller knows better.
const BLOCK: &str = "A";

/// The finest level, ready.
pub(super) struct Finest<R> {
    /// Blocks divided by `scale`.
    pub(super) matrix: NodeMatrix<R>,
    /// A power of two near the largest diagonal entry of A.
    pub(super) scale: f64,
    /// What rounding to R takes from the row sums: `Σ_j (A_ij − Ã_ij)`. Added to the diagonal in coarse products, it keeps
    /// the energy of translations right to double precision.
    pub(super) defect: Vec<Matrix3<f64>>,
}

/// `A + F Fᵀ`, assembled node by node; F is absent for a plain A.
pub(super) struct Sum<'a> {
    a: Stored<'a>,
    /// F and Fᵀ, both by rows.
    factor: Option<(SparseMatrix<f64>, SparseMatrix<f64>)>,
    /// The unknowns that an element joins, row by row, where the entries of A do not tell.
    joined: Option<&'a Pattern>,
}

/// A in either form.
enum Stored<'a> {
    Rows(&'a SparseMatrix<f64>),
    /// And the transpose of the pattern of its L.
    Half(&'a HalvedMatrix, Transposed),
}

impl<'a> Sum<'a> {
    /// Checks sizes, storage and numbers.
    pub(super) fn new(
        a: &'a SparseMatrix<f64>,
        factor: Option<&SparseMatrix<f64>>,
    ) -> Result<Self, SetupError> {
        let found = Shape::new(a.rows(), a.cols());
        if !found.is_square() || !a.is_csr() {
            return Err(SetupError::Shape {
                block: BLOCK,
                found,
                expected: Shape::square(found.rows),
                reason: "multigrid needs a square matrix stored by rows",
            });
        }
        finite_entries(BLOCK, a)?;
        if let Some(f) = factor {
            assert_eq!(f.rows(), a.rows(), "rows of F and of A");
        }
        Ok(Self {
            a: Stored::Rows(a),
            factor: factor.map(with_transpose),
            joined: None,
        })
    }

    /// An A of which only the unknowns in the same row of `joined` share an element.
    pub(super) fn joined_by(self, joined: &'a Pattern) -> Self {
        let joined = Some(joined);
        Self { joined, ..self }
    }

    /// Of half an A, which has been checked.
    pub(super) fn of_half(a: &'a HalvedMatrix, factor: Option<&SparseMatrix<f64>>) -> Self {
        Self {
            a: Stored::Half(a, a.transposed()),
            factor: factor.map(with_transpose),
            joined: None,
        }
    }

    /// Nodes of the unknowns.
    pub(super) fn map(&self, coordinates: Option<&[DofCoordinate]>) -> Arc<NodeMap> {
        match &self.a {
            Stored::Rows(a) => Arc::new(NodeMap::new(a, coordinates)),
            Stored::Half(a, _) => a.map.clone(),
        }
    }

    /// Calls `visit(column, value)` for every contribution of F Fᵀ to row i.
    #[inline(always)]
    fn for_each_added(&self, i: usize, mut visit: impl FnMut(usize, f64)) {
        let row = |m: &SparseMatrix<f64>, i: usize| m.indptr().outer_inds_sz(i);
        if let Some((f, transpose)) = &self.factor {
            for k in row(f, i) {
                let (t, f_it) = (f.indices()[k] as usize, f.data()[k]);
                for l in row(transpose, t) {
                    visit(transpose.indices()[l] as usize, f_it * transpose.data()[l]);
                }
            }
        }
    }

    /// Node columns of every node row, those of F Fᵀ included.
    pub(super) fn pattern(&self, map: &NodeMap) -> Pattern {
        self.nodes(map, |i, visit| self.for_each_added(i, |j, _| visit(j)))
    }

    /// Nodes that an element joins with the node of every row, where other entries couple further ones: those of A alone beside F Fᵀ, or
    /// those that were named.
    pub(super) fn bonds(&self, map: &NodeMap) -> Option<Pattern> {
        match self.joined {
            Some(joined) => Some(of_nodes(joined, map)),
            None => (self.factor.as_ref()).map(|_| self.nodes(map, |_, _| ())),
        }
    }

    /// Node columns of A and those of the unknowns that `added` visits for a row.
    fn nodes(&self, map: &NodeMap, added: impl Fn(usize, &mut dyn FnMut(usize)) + Sync) -> Pattern {
        let slots = map.slots();
        let scratch = || vec![NONE; map.nodes()];
        Pattern::collect(map.nodes(), scratch, |node, seen, columns| {
            let start = columns.len();
            // unknowns of a node follow each other
            let mut last = usize::MAX;
            let mut see = |other: usize| {
                if other != last && seen[other] != node as u32 {
                    seen[other] = node as u32;
                    columns.push(other as u32);
                }
                last = other;
            };
            see(node);
            if let Stored::Half(a, transposed) = &self.a {
                (a.half.pattern.row(node).iter()).for_each(|j| see(*j as usize));
                (transposed.row(node).iter()).for_each(|(j, _)| see(*j as usize));
            }
            for i in map.of_node(node).iter().filter(|i| **i != NONE) {
                if let Stored::Rows(a) = self.a {
                    let range = a.indptr().outer_inds_sz(*i as usize);
                    (a.indices()[range].iter()).for_each(|j| see(slots[*j as usize] as usize / 3));
                }
                added(*i as usize, &mut |j| see(slots[j] as usize / 3));
            }
            columns[start..].sort_unstable();
        })
    }

    /// Largest diagonal entry of A, for scaling.
    fn scale(&self) -> f64 {
        let largest = match &self.a {
            Stored::Rows(a) => (0..a.rows())
                .into_par_iter()
                .filter_map(|i| a.get(i, i).copied())
                .reduce(|| 0.0_f64, f64::max),
            Stored::Half(a, _) => a.diagonal().fold(0.0, f64::max),
        };
        if largest > 0.0 {
            largest.log2().round().exp2()
        } else {
            1.0
        }
    }

    /// The node blocks on a pattern that holds all of them. Empty slots get the largest diagonal entry of their node, so that
    /// they stay out of everything.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] for an entry outside the pattern, [`SetupError::BadDiagonal`] or
    /// [`SetupError::NotPositiveDefinite`], all with the row.
    pub(super) fn blocks<R: Real>(
        &self,
        map: &NodeMap,
        pattern: Pattern,
    ) -> Result<Finest<R>, SetupError> {
        let scale = self.scale();
        let mut blocks = vec![[[R::zero(); 3]; 3]; pattern.columns.len()];
        let mut defect = vec![[[0.0; 3]; 3]; pattern.rows()];
        let outside = AtomicUsize::new(usize::MAX);
        let mut tasks = Vec::new();
        let mut rest = &mut blocks[..];
        for (k, defect) in defect.chunks_mut(NODES_PER_TASK).enumerate() {
            let first = k * NODES_PER_TASK;
            let nodes = first..first + defect.len();
            let length = pattern.offsets[nodes.end] - pattern.offsets[first];
            let (part, tail) = rest.split_at_mut(length);
            rest = tail;
            tasks.push((nodes, part, defect));
        }
        let scratch = || (vec![0_u32; map.nodes()], Vec::<Matrix3<f64>>::new());
        (tasks.into_par_iter()).for_each_init(scratch, |(place, row), (nodes, part, defects)| {
            let start = pattern.offsets[nodes.start];
            for (node, defect) in nodes.zip(defects) {
                let columns = pattern.row(node);
                self.node_row(map, (node, columns), (place, row), &outside);
                let target = &mut part[pattern.offsets[node] - start..][..columns.len()];
                *defect = rounded(row, scale, target);
                for (c, i) in map.of_node(node).iter().enumerate() {
                    if *i == NONE {
                        defect[c] = [0.0; 3];
                        (0..3).for_each(|k| defect[k][c] = 0.0);
                    }
                }
            }
        });
        let outside = outside.into_inner();
        if outside < usize::MAX {
            return Err(SetupError::NotApplicable {
                method: "refreshing a hierarchy",
                reason: format!(
                    "row {} (counted from 1) couples nodes that the first matrix did not couple; build a new one",
                    outside + 1
                ),
            });
        }
        let inverse = inverses(&pattern, &blocks, |row| {
            map.of_node(row / 3)[row % 3] as usize
        })?;
        let matrix = NodeMatrix::new(pattern, blocks, inverse);
        Ok(Finest {
            matrix,
            scale,
            defect,
        })
    }

    /// The blocks of a node row in f64, in the order of its columns; `place` has room for every node. An entry outside of them
    /// leaves its row in `outside`.
    #[inline(always)]
    fn node_row(
        &self,
        map: &NodeMap,
        (node, columns): (usize, &[u32]),
        (place, row): (&mut [u32], &mut Vec<Matrix3<f64>>),
        outside: &AtomicUsize,
    ) {
        let slots = map.slots();
        row.clear();
        row.resize(columns.len(), [[0.0; 3]; 3]);
        for (k, j) in columns.iter().enumerate() {
            place[*j as usize] = k as u32;
        }
        if let Stored::Half(a, transposed) = &self.a {
            let at = |j: usize| {
                let at = place[j] as usize;
                let is_here = columns.get(at) == Some(&(j as u32));
                if !is_here {
                    let unknown = map.of_node(node).iter().min().copied().unwrap_or(0);
                    outside.fetch_min(unknown as usize, Ordering::Relaxed);
                }
                is_here.then_some(at)
            };
            let own = [(node, &a.half.diagonal[node])];
            for (j, block) in a.half.before(node).chain(own) {
                if let Some(at) = at(j) {
                    row[at] = *block;
                }
            }
            for (j, k) in transposed.row(node) {
                if let Some(at) = at(*j as usize) {
                    row[at] = fracas_operators::small::transposed(&a.half.blocks[*k as usize]);
                }
            }
        }
        for (c, i) in map.of_node(node).iter().enumerate() {
            if *i != NONE {
                let mut add = |j: usize, value: f64| {
                    let slot = slots[j] as usize;
                    let at = place[slot / 3] as usize;
                    if columns.get(at) == Some(&(slot as u32 / 3)) {
                        row[at][c][slot % 3] += value;
                    } else {
                        outside.fetch_min(*i as usize, Ordering::Relaxed);
                    }
                };
                if let Stored::Rows(a) = self.a {
                    for k in a.indptr().outer_inds_sz(*i as usize) {
                        add(a.indices()[k] as usize, a.data()[k]);
                    }
                }
                self.for_each_added(*i as usize, add);
            }
        }
        let own = &mut row[place[node] as usize];
        let largest = own[0][0].max(own[1][1]).max(own[2][2]);
        for (c, i) in map.of_node(node).iter().enumerate() {
            if *i == NONE {
                own[c][c] = largest;
            }
        }
    }
}

/// A pattern of unknowns, as one of their nodes.
fn of_nodes(unknowns: &Pattern, map: &NodeMap) -> Pattern {
    let slots = map.slots();
    let scratch = || ();
    Pattern::collect(map.nodes(), scratch, |node, (), columns| {
        let start = columns.len();
        for i in map.of_node(node).iter().filter(|i| **i != NONE) {
            let joined = unknowns.row(*i as usize);
            columns.extend(joined.iter().map(|j| slots[*j as usize] / 3));
        }
        let mut own = columns.split_off(start);
        own.sort_unstable();
        own.dedup();
        columns.append(&mut own);
    })
}

/// A matrix and its transpose, both by rows.
fn with_transpose(f: &SparseMatrix<f64>) -> (SparseMatrix<f64>, SparseMatrix<f64>) {
    let f = if f.is_csr() { f.clone() } else { f.to_csr() };
    let transpose = f.transpose_view().to_csr();
    (f, transpose)
}

/// Rounds the blocks of a row, divided by `scale`; gives what that takes from their sum.
#[inline(always)]
fn rounded<R: Real>(row: &[Matrix3<f64>], scale: f64, target: &mut [Matrix3<R>]) -> Matrix3<f64> {
    let mut defect = [[0.0; 3]; 3];
    for (target, block) in target.iter_mut().zip(row) {
        for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
            let value = block[r][c] / scale;
            target[r][c] = R::of(value);
            defect[r][c] += value - target[r][c].to_f64_exact();
        }
    }
    defect
}

/// Inverse diagonal blocks; `unknown(row)` names the unknown of a scalar row in errors.
fn inverses<R: Real>(
    pattern: &Pattern,
    blocks: &[Matrix3<R>],
    unknown: impl Fn(usize) -> usize + Sync,
) -> Result<Vec<Matrix3<R>>, SetupError> {
    let of_row = |i: usize| {
        let k = pattern.row(i).partition_point(|j| (*j as usize) < i);
        let own = cast(&blocks[pattern.offsets[i] + k]);
        let inverse = equilibrated_inverse(own, [true; 3], SINGULAR).map_err(|c| {
            if own[c][c] > 0.0 {
                SetupError::NotPositiveDefinite {
                    block: BLOCK,
                    row: unknown(3 * i + c) + 1,
                    advice: "the 3×3 block of its node has a pivot that is not positive".into(),
                }
            } else {
                SetupError::BadDiagonal {
                    block: BLOCK,
                    row: unknown(3 * i + c) + 1,
                    value: own[c][c],
                    method: "amg",
                }
            }
        })?;
        Ok(cast(&inverse))
    };
    let rows = 0..pattern.rows();
    let all: Option<Vec<_>> = rows
        .clone()
        .into_par_iter()
        .map(|i| of_row(i).ok())
        .collect();
    // the first row that fails, whatever the number of threads
    all.map_or_else(|| rows.map(of_row).collect(), Ok)
}
