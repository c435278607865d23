//! What a hierarchy costs.

use super::Smoother;
use serde::Serialize;
use std::fmt;

/// One level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LevelSummary {
    /// Unknowns.
    pub n: usize,
    /// Stored entries of the matrix (zeros inside blocks included); half the flops of a product where nothing is stored.
    pub nnz: usize,
    /// Bytes of matrix, transfer operators and smoother.
    pub bytes: usize,
}

/// Which smoother a hierarchy has, and why.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Smoothing {
    /// Never [`Smoother::Auto`].
    pub smoother: Smoother,
    /// Share of the nodes that are links of a chain, `‖A_ij‖_F ≥ 0.45 √(‖A_ii‖_F ‖A_jj‖_F)` for a j ≠ i, along which no aggregate
    /// is made, or which resists changes of volume, where that decided; `None` where the settings name the smoother.
    pub chained: Option<f64>,
}

impl Smoothing {
    /// Share of nodes with such a neighbour from which the matrix is one of chains; fewer are outliers that the iteration
    /// around the cycle takes care of. Unit: 1.
    pub(crate) const CHAINED: f64 = 0.25;
}

impl fmt::Display for Smoothing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.smoother.name())?;
        match self.chained {
            None => Ok(()),
            Some(share) => write!(
                f,
                ": {:.0} % of the nodes are links of a chain ({:.0} % call for fsai)",
                100.0 * share,
                100.0 * Self::CHAINED
            ),
        }
    }
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
