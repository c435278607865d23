//! Block operators over named fields: a block that is not there is zero and costs nothing.

use crate::operator::assert_product;
use crate::{Field, Layout, LinearOperator, Real, Shape};

/// Operators placed in the grid of a [`Layout`], each with a factor: `[A B1; B2 −H]` is
/// ```text
/// BlockOperator::new(layout).with([U, U], 1.0, a).with([U, T], 1.0, b1).with([T, U], 1.0, b2).with([T, T], -1.0, h)
/// ```
/// A product adds them in this order.
pub struct BlockOperator<'a, R> {
    layout: Layout,
    blocks: Vec<Block<'a, R>>,
}

/// A factor times an operator.
struct Block<'a, R> {
    row: Field,
    column: Field,
    factor: R,
    operator: Box<dyn LinearOperator<R> + 'a>,
}

impl<'a, R: Real> BlockOperator<'a, R> {
    /// Zero.
    pub fn new(layout: Layout) -> Self {
        let blocks = Vec::new();
        Self { layout, blocks }
    }

    /// The same with `factor` times an operator in the given row and column; stops if it does not fit, naming the block.
    #[must_use]
    pub fn with(
        mut self,
        [row, column]: [Field; 2],
        factor: R,
        operator: impl LinearOperator<R> + 'a,
    ) -> Self {
        assert_eq!(
            operator.shape(),
            Shape::new(
                self.layout.range(row).len(),
                self.layout.range(column).len()
            ),
            "block ({}, {}) does not fit",
            row.letter,
            column.letter
        );
        self.blocks.push(Block {
            row,
            column,
            factor,
            operator: Box::new(operator),
        });
        self
    }

    /// The fields.
    pub fn layout(&self) -> Layout {
        self.layout
    }
}

impl<R: Real> LinearOperator<R> for BlockOperator<'_, R> {
    fn shape(&self) -> Shape {
        Shape::square(self.layout.len())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(self.shape(), x, y);
        for block in &self.blocks {
            let [x_j] = self.layout.split([block.column], x);
            let [y_i] = self.layout.split_mut([block.row], y);
            block
                .operator
                .apply_add(alpha * block.factor, x_j, y_i, work);
        }
    }

    fn work_len(&self) -> usize {
        let lengths = self.blocks.iter().map(|block| block.operator.work_len());
        lengths.max().unwrap_or(0)
    }

    fn flops(&self) -> u64 {
        self.blocks.iter().map(|block| block.operator.flops()).sum()
    }

    fn sum_over_parts(&self, sums: &mut [R]) {
        // the same memories share the vectors of all blocks
        if let Some(block) = self.blocks.first() {
            block.operator.sum_over_parts(sums);
        }
    }
}
