//! What can be wrong with the data of a solver: which block, which row, what to do.

/// A preconditioner or factorization cannot be built from this data.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// A block is not positive definite where the method needs it.
    #[error("block {block} is not positive definite (row {row}, counted from 1): {advice}")]
    NotPositiveDefinite {
        /// `A`, `S_u`, `C`, …
        block: &'static str,
        /// First offending row, counted from 1.
        row: usize,
        /// What to do.
        advice: String,
    },
    /// A block is singular to working precision.
    #[error("block {block} is singular to working precision{}: {advice}", row.map_or(String::new(), |r| format!(" (row {r}, counted from 1)")))]
    Singular {
        /// `A`, `S_u`, …
        block: &'static str,
        /// First offending row, counted from 1, where it is known.
        row: Option<usize>,
        /// What to do.
        advice: String,
    },
    /// A diagonal entry that must be divided by is zero, negative or missing.
    #[error(
        "block {block} has the diagonal entry {value:e} in row {row} (counted from 1); {method} needs a positive one{}",
        held_by_b1(block, *value)
    )]
    BadDiagonal {
        /// `A`, `S_u`, …
        block: &'static str,
        /// Row, counted from 1.
        row: usize,
        /// The entry.
        value: f64,
        /// Who needs it.
        method: &'static str,
    },
    /// NaN or infinity.
    #[error("block {block} holds {value} at row {row}, column {column} (counted from 1)")]
    NotFinite {
        /// `A`, `B1`, …
        block: &'static str,
        /// Row, counted from 1.
        row: usize,
        /// Column, counted from 1.
        column: usize,
        /// NaN or ±inf.
        value: f64,
    },
    /// Sizes of two blocks disagree.
    #[error("block {block} is {found}, expected {expected} because {reason}")]
    Shape {
        /// `B1`, `H`, …
        block: &'static str,
        /// What it is.
        found: fracas_operators::Shape,
        /// What it must be.
        expected: fracas_operators::Shape,
        /// Which other block says so.
        reason: &'static str,
    },
    /// A method that does not apply to this system.
    #[error("{method} does not apply: {reason}")]
    NotApplicable {
        /// The method.
        method: &'static str,
        /// Why, and what to take instead.
        reason: String,
    },
    /// A backend that was not compiled in.
    #[error(
        "{backend} is not part of this build; compile with --features {feature}, or choose another backend"
    )]
    NotBuilt {
        /// `CHOLMOD`, `UMFPACK`, `GAMG`, …
        backend: &'static str,
        /// Cargo feature that adds it.
        feature: &'static str,
    },
    /// Too little memory, or a size beyond what a library can index.
    #[error("{method} ran out of memory on {n} equations{}; {advice}", match bytes {
        Some(bytes) => format!(", for which it asked for {:.3} GB", 1e-9 * *bytes as f64),
        None => String::new(),
    })]
    OutOfMemory {
        /// The method.
        method: &'static str,
        /// Equations.
        n: usize,
        /// Bytes asked for, where the library tells.
        bytes: Option<usize>,
        /// What to do.
        advice: String,
    },
}

impl SetupError {
    /// The same error with the name of the block that the caller knows.
    #[must_use]
    pub fn in_block(mut self, name: &'static str) -> Self {
        match &mut self {
            Self::NotPositiveDefinite { block, .. }
            | Self::Singular { block, .. }
            | Self::BadDiagonal { block, .. }
            | Self::NotFinite { block, .. }
            | Self::Shape { block, .. } => *block = name,
            Self::NotApplicable { .. } | Self::NotBuilt { .. } | Self::OutOfMemory { .. } => {}
        }
        self
    }
}

/// What to take where a block needs what A does not hold.
fn held_by_b1(block: &str, value: f64) -> &'static str {
    match (block, value) {
        ("A", 0.0) => "; if B1 holds what moves there, take racp, mcp or direct",
        _ => "",
    }
}
