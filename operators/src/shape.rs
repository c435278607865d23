//! Rows × columns.

use std::fmt;

/// Rows and columns of an operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Length of the result.
    pub rows: usize,
    /// Length of the argument.
    pub cols: usize,
}

impl Shape {
    /// A `rows × cols` shape.
    pub const fn new(rows: usize, cols: usize) -> Self {
        Self { rows, cols }
    }

    /// An `n × n` shape.
    pub const fn square(n: usize) -> Self {
        Self { rows: n, cols: n }
    }

    /// Shape of the adjoint.
    pub const fn transposed(self) -> Self {
        Self {
            rows: self.cols,
            cols: self.rows,
        }
    }

    /// True when rows equal columns.
    pub const fn is_square(self) -> bool {
        self.rows == self.cols
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}×{}", self.rows, self.cols)
    }
}
