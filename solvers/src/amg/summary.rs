//! What a hierarchy costs.

use super::Smoothing;
use serde::Serialize;
use std::fmt;

/// One level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LevelSummary {
    /// Unknowns.
    pub n: usize,
    /// Stored entries of the matrix (zeros inside blocks included).
    pub nnz: usize,
    /// Bytes of matrix, transfer operators and smoother.
    pub bytes: usize,
}

/// Levels, complexities and memory of a hierarchy, finest level first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Finest level first.
    pub levels: Vec<LevelSummary>,
    /// Σ nnz / nnz of the finest level.
    pub operator_complexity: f64,
    /// Σ n / n of the finest level.
    pub grid_complexity: f64,
    /// What the coarse spaces reproduce: `"rigid-body modes"`, or `"constants (no coordinates)"`.
    pub near_null_space: &'static str,
    /// What smooths, and why.
    pub smoothing: Smoothing,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "level          n          nnz      MiB")?;
        for (k, level) in self.levels.iter().enumerate() {
            let mib = level.bytes as f64 / f64::from(1 << 20);
            writeln!(f, "{k:>5} {:>10} {:>12} {mib:>8.1}", level.n, level.nnz)?;
        }
        write!(
            f,
            "operator complexity {:.2}, grid complexity {:.2}, coarse spaces hold the {}; smoother {}",
            self.operator_complexity, self.grid_complexity, self.near_null_space, self.smoothing
        )
    }
}
