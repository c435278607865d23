//! Block operators over named fields: a zero block is `None` and costs nothing.

use crate::operator::assert_product;
use crate::{LinearOperator, Real, Shape};

/// Lengths and names of the fields in a vector, for example `(u, t)` or `(u, t, p)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout<const N: usize> {
    /// One-letter names of the fields, as in `n_u`, `r_t`.
    pub names: [&'static str; N],
    /// Lengths of the fields.
    pub lengths: [usize; N],
}

impl<const N: usize> Layout<N> {
    /// Fields `names` with `lengths`.
    pub const fn new(names: [&'static str; N], lengths: [usize; N]) -> Self {
        Self { names, lengths }
    }

    /// Total length.
    pub fn len(&self) -> usize {
        self.lengths.iter().sum()
    }

    /// True when every field is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Destructures a vector by physics: `let [r_u, r_t] = layout.split(r);`.
    pub fn split<'v, R>(&self, vector: &'v [R]) -> [&'v [R]; N] {
        assert_eq!(vector.len(), self.len(), "vector does not fit {self:?}");
        let mut rest = vector;
        self.lengths.map(|n| {
            let (field, tail) = rest.split_at(n);
            rest = tail;
            field
        })
    }

    /// The same for a writable vector.
    pub fn split_mut<'v, R>(&self, vector: &'v mut [R]) -> [&'v mut [R]; N] {
        assert_eq!(vector.len(), self.len(), "vector does not fit {self:?}");
        let mut rest = vector;
        self.lengths.map(|n| {
            let (field, tail) = std::mem::take(&mut rest).split_at_mut(n);
            rest = tail;
            field
        })
    }
}

/// An N×N grid of operators over a [`Layout`], each with a factor: `[A B1; B2 −H]` is
/// `[[1·A, 1·B1], [1·B2, −1·H]]`.
pub struct BlockOperator<'a, R, const N: usize> {
    layout: Layout<N>,
    blocks: [[Option<Block<'a, R>>; N]; N],
}

/// A factor times an operator.
pub type Block<'a, R> = (R, &'a dyn LinearOperator<R>);

impl<'a, R: Real, const N: usize> BlockOperator<'a, R, N> {
    /// The grid `blocks[row][column]`; stops if a block does not fit the layout, naming it.
    pub fn new(layout: Layout<N>, blocks: [[Option<Block<'a, R>>; N]; N]) -> Self {
        for (i, row) in blocks.iter().enumerate() {
            for (j, block) in row.iter().enumerate() {
                if let Some((_, operator)) = block {
                    let expected = Shape::new(layout.lengths[i], layout.lengths[j]);
                    assert_eq!(
                        operator.shape(),
                        expected,
                        "block ({}, {}) does not fit",
                        layout.names[i],
                        layout.names[j]
                    );
                }
            }
        }
        Self { layout, blocks }
    }

    /// The fields.
    pub fn layout(&self) -> Layout<N> {
        self.layout
    }

    fn present(&self) -> impl Iterator<Item = &Block<'a, R>> {
        self.blocks.iter().flatten().flatten()
    }
}

impl<R: Real, const N: usize> LinearOperator<R> for BlockOperator<'_, R, N> {
    fn shape(&self) -> Shape {
        Shape::square(self.layout.len())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(self.shape(), x, y);
        let fields = self.layout.split(x);
        for (row, y_i) in self.blocks.iter().zip(self.layout.split_mut(y)) {
            for (block, x_j) in row.iter().zip(fields) {
                if let Some((factor, operator)) = block {
                    operator.apply_add(alpha * *factor, x_j, y_i, work);
                }
            }
        }
    }

    fn work_len(&self) -> usize {
        self.present().map(|b| b.1.work_len()).max().unwrap_or(0)
    }

    fn flops(&self) -> u64 {
        self.present().map(|b| b.1.flops()).sum()
    }
}
