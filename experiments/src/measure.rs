//! One preconditioned iteration, measured in counts that do not depend on the machine.

use crate::report::Cell;
use fracas_operators::Preconditioner;
use fracas_solvers::Silent;
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::saddle::{Iterated, SaddleBlocks, SaddleOperator};

/// Relative residual in the tables of the lecture and of the experiments.
pub const TOLERANCE: f64 = 1e-8;

/// Iterations after which a method counts as failed.
pub const LIMIT: usize = 1000;

/// How an iteration went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The iteration that ran: GMRES may have become FGMRES.
    pub krylov: KrylovChoice,
    /// n_it, where the true residual met the tolerance.
    pub iterations: Option<usize>,
    /// C_s, where the true residual met the tolerance.
    pub cost: Option<f64>,
}

impl Measured {
    /// Iterates `𝒜 x = rhs` from `start` with the true residual as the judge.
    pub fn new(
        blocks: &SaddleBlocks,
        preconditioner: &dyn Preconditioner<f64>,
        krylov: KrylovChoice,
        rhs: &[f64],
        start: Vec<f64>,
    ) -> Self {
        let operator = SaddleOperator::new(blocks);
        let system = System {
            operator: &operator,
            preconditioner,
            rhs,
        };
        let criteria = Criteria {
            relative_tolerance: TOLERANCE,
            max_iterations: LIMIT,
        };
        let mut x = start;
        let iterated = Iterated::new(&system, krylov, &criteria, &mut x, &mut Silent);
        Self {
            krylov: iterated.krylov,
            iterations: iterated.iterations(),
            cost: iterated.c_s(),
        }
    }

    /// n_it for checks: infinite where the method failed.
    pub fn count(&self) -> f64 {
        self.iterations.map_or(f64::INFINITY, |n| n as f64)
    }
}

/// n_it as a cell, the "X" of the published tables where the method failed.
pub fn count_cell(measured: Option<&Measured>) -> Cell {
    match measured.and_then(|m| m.iterations) {
        Some(n) => n.into(),
        None => Cell::Failed,
    }
}

/// C_s as a cell.
pub fn cost_cell(measured: Option<&Measured>) -> Cell {
    measured
        .and_then(|m| m.cost)
        .map_or(Cell::Failed, Cell::Real)
}
