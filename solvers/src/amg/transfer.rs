//! P and Pᵀ between two levels, in 3×3 blocks.

use super::prolongation::Prolongation;
use fracas_operators::sparse::Block3;
use fracas_operators::{LinearOperator, Real};

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
        let entries = parts * p.blocks.len();
        let forward = || {
            let (mut columns, mut blocks) =
                (Vec::with_capacity(entries), Vec::with_capacity(entries));
            for (aggregate, block) in p.pattern.columns.iter().zip(&p.blocks) {
                for part in 0..parts {
                    columns.push(parts as u32 * aggregate + part as u32);
                    blocks.push(cut(block, part, false));
                }
            }
            let offsets = p.pattern.offsets.iter().map(|o| parts * o).collect();
            Block3::from_raw(offsets, columns, blocks, parts * aggregates)
        };
        let transposed = || {
            // Pᵀ: counted, then filled row by row of P
            let mut offsets = vec![0; parts * aggregates + 1];
            for aggregate in &p.pattern.columns {
                (0..parts).for_each(|part| offsets[parts * *aggregate as usize + part + 1] += 1);
            }
            (0..parts * aggregates).for_each(|j| offsets[j + 1] += offsets[j]);
            let mut next = offsets.clone();
            let mut columns = vec![0; entries];
            let mut blocks = vec![[R::zero(); 9]; entries];
            for i in 0..p.pattern.rows() {
                for (aggregate, block) in p.row(i) {
                    for part in 0..parts {
                        let at = &mut next[parts * aggregate + part];
                        columns[*at] = i as u32;
                        blocks[*at] = cut(block, part, true);
                        *at += 1;
                    }
                }
            }
            Block3::from_raw(offsets, columns, blocks, p.pattern.rows())
        };
        let (p, transposed) = rayon::join(forward, transposed);
        Self { p, transposed }
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
