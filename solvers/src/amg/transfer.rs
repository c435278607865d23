//! P and Pᵀ between two levels, in 3×3 blocks.

use super::prolongation::Prolongation;
use fracas_operators::sparse::Block3;
use fracas_operators::{LinearOperator, Real};
use rayon::prelude::*;

/// Prolongation and restriction.
#[derive(Clone, Debug)]
pub(super) struct Transfer<R> {
    p: Block3<R>,
    transposed: Block3<R>,
}

impl<R: Real> Transfer<R> {
    /// Splits the 3×K blocks into K/3 square ones.
    pub(super) fn new<const K: usize>(p: &Prolongation<K>, aggregates: usize) -> Self {
        let parts = K / 3;
        let cut = |block: &[[f64; K]; 3], part: usize, transpose: bool| -> [R; 9] {
            std::array::from_fn(|k| {
                let (r, c) = if transpose {
                    (k % 3, k / 3)
                } else {
                    (k / 3, k % 3)
                };
                R::of(block[r][3 * part + c])
            })
        };
        let place = |aggregate: u32, part: usize| parts as u32 * aggregate + part as u32;
        let entries = p.pattern.columns.par_iter().zip(&p.blocks);
        let columns = entries
            .clone()
            .flat_map_iter(|(aggregate, _)| (0..parts).map(|part| place(*aggregate, part)));
        let blocks =
            entries.flat_map_iter(|(_, block)| (0..parts).map(|part| cut(block, part, false)));
        let offsets = p.pattern.offsets.iter().map(|o| parts * o).collect();
        let forward = Block3::from_raw(
            offsets,
            columns.collect(),
            blocks.collect(),
            parts * aggregates,
        );

        // row (aggregate, part) of Pᵀ: the rows of P that hold the aggregate
        let rows = p.pattern.transposed(aggregates);
        let of_part = |k: usize| (k / parts, k % parts);
        let mut offsets = vec![0];
        for k in 0..parts * aggregates {
            offsets.push(offsets[k] + rows.row(of_part(k).0).len());
        }
        let lines = (0..parts * aggregates).into_par_iter().map(of_part);
        let columns = lines
            .clone()
            .flat_map_iter(|(aggregate, _)| rows.row(aggregate).iter().copied());
        let blocks = lines.flat_map_iter(|(aggregate, part)| {
            rows.row(aggregate).iter().filter_map(move |i| {
                let block = p.row(*i as usize).find(|(j, _)| *j == aggregate);
                block.map(|(_, block)| cut(block, part, true))
            })
        });
        let (columns, blocks) = (columns.collect(), blocks.collect());
        let transposed = Block3::from_raw(offsets, columns, blocks, p.pattern.rows());
        Self {
            p: forward,
            transposed,
        }
    }

    /// `b_c ← Pᵀ r`.
    pub(super) fn restrict(&self, r: &[R], coarse: &mut [R]) {
        self.transposed.apply(r, coarse, &mut []);
    }

    /// `x ← x + P x_c`.
    pub(super) fn prolong_add(&self, coarse: &[R], x: &mut [R]) {
        self.p.apply_add(R::one(), coarse, x, &mut []);
    }

    /// Flops of one restriction and one prolongation.
    pub(super) fn flops(&self) -> u64 {
        36 * self.p.block_count() as u64
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        2 * size_of_val(self.p.blocks()) + 2 * size_of_val(self.p.columns())
    }
}
