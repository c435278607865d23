//! The coarse matrix.

use super::matrix::NodeMatrix;
use super::prolongation::Prolongation;
use super::transfer::TransferPattern;
use fracas_operators::Real;
use fracas_operators::simd::{Kernel, Lanes, Level};
use fracas_operators::small::{Matrix3, add_product, add_transposed_product};
use fracas_operators::sparse::Pattern;
use rayon::prelude::*;
use std::ops::Range;

/// Fine block rows whose products one task sums.
const ROWS_PER_TASK: usize = 2048;

/// Tasks whose partial sums are held at once.
const WAVE: usize = 8;

/// Patterns of `A P` and of `PᵀA P`, which outlive changes of values.
#[derive(Clone, Debug)]
pub(super) struct Patterns {
    product: Pattern,
    coarse: Pattern,
}

/// Marks of the columns of one row.
struct Marks {
    row: Vec<u32>,
}

impl Patterns {
    /// Symbolic products.
    pub(super) fn new<R: Real>(a: &NodeMatrix<R>, transfer: &TransferPattern) -> Self {
        let TransferPattern { p, transposed } = transfer;
        let aggregates = transposed.rows();
        let marks = || Marks {
            row: vec![u32::MAX; aggregates],
        };
        let union = |i: usize,
                     parts: &mut dyn Iterator<Item = &[u32]>,
                     marks: &mut Marks,
                     columns: &mut Vec<u32>| {
            let start = columns.len();
            for j in parts.flatten() {
                if marks.row[*j as usize] != i as u32 {
                    marks.row[*j as usize] = i as u32;
                    columns.push(*j);
                }
            }
            columns[start..].sort_unstable();
        };
        let product = Pattern::collect(a.rows(), marks, |i, marks, columns| {
            let mut parts = a.columns_of(i).iter().map(|k| p.row(*k as usize));
            union(i, &mut parts, marks, columns);
        });
        let coarse = Pattern::collect(aggregates, marks, |i, marks, columns| {
            let rows = transposed.row(i).iter();
            let mut parts = rows.map(|(k, _)| product.row(*k as usize));
            union(i, &mut parts, marks, columns);
        });
        Self { product, coarse }
    }

    pub(super) fn bytes(&self) -> usize {
        self.product.bytes() + self.coarse.bytes()
    }

    /// Pattern of `PᵀA P`, coarse node by coarse node.
    pub(super) fn coarse(&self) -> &Pattern {
        &self.coarse
    }
}

/// Blocks of a symmetric matrix, those left of the diagonal left out.
pub(super) struct Upper<const K: usize> {
    /// Places of the pattern left of the diagonal in this row and those above it.
    skipped: Vec<usize>,
    blocks: Vec<[[f64; K]; K]>,
}

impl<const K: usize> Upper<K> {
    /// Zero on a pattern.
    fn zero(pattern: &Pattern) -> Self {
        let mut skipped = Vec::with_capacity(pattern.rows());
        let mut sum = 0;
        for i in 0..pattern.rows() {
            sum += upper(pattern, i as u32);
            skipped.push(sum);
        }
        Self {
            blocks: vec![[[0.0; K]; K]; pattern.columns.len() - sum],
            skipped,
        }
    }

    /// The block at a place of row i that is not left of the diagonal.
    pub(super) fn at(&self, i: usize, place: usize) -> &[[f64; K]; K] {
        &self.blocks[place - self.skipped[i]]
    }
}

/// The K×K blocks of `A_c = Pᵀ(A + Δ)P` on [`Patterns::coarse`]; Δ is the block-diagonal `defect` of rounded rows.
///
/// # Cost
/// `A P` in full, half of `Pᵀ(A P)`: A is symmetric. Tasks sum over their own rows of the fine level; their sums are
/// added in a fixed order.
pub(super) fn product<S: Real, R: Real, const K: usize>(
    a: &NodeMatrix<S>,
    defect: &[Matrix3<f64>],
    p: Prolongation<'_, R, K>,
    patterns: &Patterns,
) -> Upper<K> {
    let coarse = &patterns.coarse;
    let mut sums_of_all = Upper::zero(coarse);
    let level = Level::best();
    let tasks: Vec<Range<usize>> = (0..a.rows())
        .step_by(ROWS_PER_TASK)
        .map(|start| start..a.rows().min(start + ROWS_PER_TASK))
        .collect();
    for wave in tasks.chunks(WAVE) {
        let sums: Vec<Partial<K>> = wave
            .par_iter()
            .map(|rows| {
                let mut partial = Partial::new(rows.clone(), p.pattern, coarse);
                level.run::<f64>(Accumulate {
                    a,
                    defect,
                    p,
                    patterns,
                    rows: rows.clone(),
                    partial: &mut partial,
                });
                partial
            })
            .collect();
        sums.iter()
            .for_each(|partial| partial.add_to(coarse, &mut sums_of_all));
    }
    sums_of_all
}

/// Sums of one task: the upper part of the coarse rows that its fine rows touch.
struct Partial<const K: usize> {
    /// Coarse rows touched, ascending.
    rows: Vec<u32>,
    /// Where their sums begin.
    offsets: Vec<usize>,
    sums: Vec<[[f64; K]; K]>,
}

/// First column of the upper part of a coarse row, counted within the row.
fn upper(coarse: &Pattern, i: u32) -> usize {
    coarse.row(i as usize).partition_point(|j| *j < i)
}

impl<const K: usize> Partial<K> {
    fn new(rows: Range<usize>, p: &Pattern, coarse: &Pattern) -> Self {
        let range = p.offsets[rows.start]..p.offsets[rows.end];
        let mut touched = p.columns[range].to_vec();
        touched.sort_unstable();
        touched.dedup();
        let mut offsets = vec![0];
        for i in &touched {
            let length = coarse.row(*i as usize).len() - upper(coarse, *i);
            offsets.push(offsets[offsets.len() - 1] + length);
        }
        Self {
            sums: vec![[[0.0; K]; K]; offsets[offsets.len() - 1]],
            rows: touched,
            offsets,
        }
    }

    fn add_to(&self, coarse: &Pattern, all: &mut Upper<K>) {
        for (k, i) in self.rows.iter().enumerate() {
            let sums = &self.sums[self.offsets[k]..self.offsets[k + 1]];
            let start = coarse.offsets[*i as usize] + upper(coarse, *i);
            let start = start - all.skipped[*i as usize];
            for (block, sum) in all.blocks[start..].iter_mut().zip(sums) {
                for (row, sum) in block.iter_mut().zip(sum) {
                    row.iter_mut().zip(sum).for_each(|(b, s)| *b += s);
                }
            }
        }
    }
}

struct Accumulate<'a, S, R, const K: usize> {
    a: &'a NodeMatrix<S>,
    defect: &'a [Matrix3<f64>],
    p: Prolongation<'a, R, K>,
    patterns: &'a Patterns,
    rows: Range<usize>,
    partial: &'a mut Partial<K>,
}

impl<S: Real, R: Real, const K: usize> Kernel<f64> for Accumulate<'_, S, R, K> {
    #[inline(always)]
    fn run<L: Lanes<f64>>(self) {
        let Self {
            a,
            defect,
            p,
            patterns,
            rows,
            partial,
        } = self;
        let coarse = &patterns.coarse;
        let mut images: Vec<[[f64; K]; 3]> = Vec::new();
        // where a coarse column stands in the current row of A P
        let mut place = vec![0_u32; coarse.rows()];
        for i in rows {
            let columns = patterns.product.row(i);
            for (k, j) in columns.iter().enumerate() {
                place[*j as usize] = k as u32;
            }
            // (A P)_i = Σ_k A_ik P_k
            images.clear();
            images.resize(columns.len(), [[0.0; K]; 3]);
            for (k, a_ik) in a.row(i) {
                for (j, p_kj) in p.row(k) {
                    add_product(&mut images[place[j] as usize], a_ik, p_kj);
                }
            }
            if let Some(delta) = defect.get(i) {
                for (j, p_ij) in p.row(i) {
                    add_product(&mut images[place[j] as usize], delta, p_ij);
                }
            }
            // (A_c)_IJ += P_iIᵀ (A P)_iJ for J ≥ I
            for (node, p_i) in p.row(i) {
                let slot = partial.rows.partition_point(|r| (*r as usize) < node);
                let sums = &mut partial.sums[partial.offsets[slot]..partial.offsets[slot + 1]];
                let targets = coarse.row(node);
                let targets = &targets[targets.len() - sums.len()..];
                let first = columns.partition_point(|j| (*j as usize) < node);
                let mut t = 0;
                for (j, image) in columns[first..].iter().zip(&images[first..]) {
                    while targets[t] != *j {
                        t += 1;
                    }
                    add_transposed_product(&mut sums[t], p_i, image);
                }
            }
        }
    }
}
