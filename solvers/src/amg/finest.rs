//! The finest level: A, or S_u = A + F Fᵀ, in 3×3 node blocks.

use super::node_map::{NONE, NodeMap};
use super::sweeps::{SINGULAR, SweepMatrix};
use crate::SetupError;
use crate::smoothers::entries::finite_entries;
use fracas_operators::small::{Matrix3, cast, equilibrated_inverse};
use fracas_operators::sparse::{Pattern, SparseMatrix};
use fracas_operators::{Real, Shape};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Name of the matrix in messages; the caller knows better.
const BLOCK: &str = "A";

/// The finest level, ready.
pub(super) struct Finest<R> {
    /// Blocks divided by `scale`.
    pub(super) matrix: SweepMatrix<R>,
    /// A power of two near the largest diagonal entry of A.
    pub(super) scale: f64,
    /// What rounding to R takes from the row sums: `Σ_j (A_ij − Ã_ij)`. Added to the diagonal in coarse products, it keeps
    /// the energy of translations right to double precision.
    pub(super) defect: Vec<Matrix3<f64>>,
}

/// `A + F Fᵀ`, assembled node by node; F is absent for a plain A.
pub(super) struct Sum<'a> {
    pub(super) a: &'a SparseMatrix<f64>,
    /// F and Fᵀ, both by rows.
    pub(super) factor: Option<(SparseMatrix<f64>, SparseMatrix<f64>)>,
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
        let factor = factor.map(|f| {
            let f = if f.is_csr() { f.clone() } else { f.to_csr() };
            let transpose = f.transpose_view().to_csr();
            (f, transpose)
        });
        Ok(Self { a, factor })
    }

    /// Calls `visit(column, value)` for every contribution to row i.
    #[inline(always)]
    fn for_each(&self, i: usize, mut visit: impl FnMut(usize, f64)) {
        let row = |m: &SparseMatrix<f64>, i: usize| m.indptr().outer_inds_sz(i);
        let range = row(self.a, i);
        let (columns, values) = (self.a.indices(), self.a.data());
        for k in range {
            visit(columns[k] as usize, values[k]);
        }
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
        self.nodes(map, |i, visit| self.for_each(i, |j, _| visit(j)))
    }

    /// Node columns of every node row of A alone, where F Fᵀ adds others: nodes that an element joins.
    pub(super) fn bonds(&self, map: &NodeMap) -> Option<Pattern> {
        self.factor.as_ref()?;
        Some(self.nodes(map, |i, visit| {
            let range = self.a.indptr().outer_inds_sz(i);
            self.a.indices()[range]
                .iter()
                .for_each(|j| visit(*j as usize));
        }))
    }

    fn nodes(&self, map: &NodeMap, row: impl Fn(usize, &mut dyn FnMut(usize)) + Sync) -> Pattern {
        let slots = map.slots();
        let scratch = || vec![NONE; map.nodes()];
        Pattern::collect(map.nodes(), scratch, |node, seen, columns| {
            let start = columns.len();
            let mut see = |other: usize| {
                if seen[other] != node as u32 {
                    seen[other] = node as u32;
                    columns.push(other as u32);
                }
            };
            see(node);
            for i in map.of_node(node).iter().filter(|i| **i != NONE) {
                row(*i as usize, &mut |j| see(slots[j] as usize / 3));
            }
            columns[start..].sort_unstable();
        })
    }

    /// Largest diagonal entry of A, for scaling.
    fn scale(&self) -> f64 {
        let largest = (0..self.a.rows())
            .into_par_iter()
            .filter_map(|i| self.a.get(i, i).copied())
            .reduce(|| 0.0_f64, f64::max);
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
        let slots = map.slots();
        let outside = AtomicUsize::new(usize::MAX);
        let scratch = || (vec![0_u32; map.nodes()], Vec::<Matrix3<f64>>::new());
        pattern.fill(&mut blocks, scratch, |nodes, part, (place, row)| {
            let start = pattern.offsets[nodes.start];
            for node in nodes {
                let columns = pattern.row(node);
                row.clear();
                row.resize(columns.len(), [[0.0; 3]; 3]);
                for (k, j) in columns.iter().enumerate() {
                    place[*j as usize] = k as u32;
                }
                for (c, i) in map.of_node(node).iter().enumerate() {
                    if *i != NONE {
                        self.for_each(*i as usize, |j, value| {
                            let slot = slots[j] as usize;
                            let at = place[slot / 3] as usize;
                            if columns.get(at) == Some(&(slot as u32 / 3)) {
                                row[at][c][slot % 3] += value;
                            } else {
                                outside.fetch_min(*i as usize, Ordering::Relaxed);
                            }
                        });
                    }
                }
                let own = &mut row[place[node] as usize];
                let largest = own[0][0].max(own[1][1]).max(own[2][2]);
                for (c, i) in map.of_node(node).iter().enumerate() {
                    if *i == NONE {
                        own[c][c] = largest;
                    }
                }
                for (target, block) in part[pattern.offsets[node] - start..].iter_mut().zip(&*row) {
                    *target = block.map(|row| row.map(|v| R::of(v / scale)));
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
        let matrix = SweepMatrix::new(pattern.offsets, pattern.columns, blocks, inverse);
        let defect = self.defect(map, &matrix, scale);
        Ok(Finest {
            matrix,
            scale,
            defect,
        })
    }

    /// `Σ_j (A_ij − Ã_ij)` of every node row, Ã the stored blocks.
    fn defect<R: Real>(
        &self,
        map: &NodeMap,
        stored: &SweepMatrix<R>,
        scale: f64,
    ) -> Vec<Matrix3<f64>> {
        let slots = map.slots();
        let of_row = |node: usize| {
            let mut defect: Matrix3<f64> = [[0.0; 3]; 3];
            for (c, i) in map.of_node(node).iter().enumerate() {
                if *i != NONE {
                    let sum = &mut defect[c];
                    self.for_each(*i as usize, |j, v| sum[slots[j] as usize % 3] += v / scale);
                    for (_, block) in stored.row(node) {
                        (0..3).for_each(|k| sum[k] -= block[c][k].to_f64_exact());
                    }
                }
            }
            for (c, i) in map.of_node(node).iter().enumerate() {
                if *i == NONE {
                    (0..3).for_each(|k| defect[k][c] = 0.0);
                }
            }
            defect
        };
        (0..map.nodes()).into_par_iter().map(of_row).collect()
    }
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
