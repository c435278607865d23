//! How a system is solved: plain data.

use super::{Problem, Route, SolveError, Solved, Solver, SystemKind};
use fracas_solvers::Observer;
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{InnerChoice, Measure, SaddleMethod};
use serde::{Deserialize, Serialize};

/// How one system `𝒜x = b` is solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Solve {
    /// What preconditions the whole system, with C and the inner solver.
    pub method: SaddleMethod,
    /// What may take the place of its inner solver.
    pub inner: InnerRule,
    /// The iteration; by default GMRES where its basis fits into memory, else what does.
    pub krylov: Option<KrylovChoice>,
    /// What the tolerance is for.
    pub measure: Measure,
    /// Relative to what the measure says. Unit: 1.
    pub tolerance: f64,
    /// Iterations over all restarts, of each inner solver.
    pub max_iterations: usize,
    /// What tractions are counted in while iterating [Pa]; by default balanced for a scene and its export, 1 for matrices of other codes.
    pub traction_unit: Option<f64>,
    /// By default that of the system, or [`RightHandSide::Sin`] where it has none.
    pub rhs: Option<RightHandSide>,
    /// Says why it took what it took.
    pub explain: bool,
}

impl Default for Solve {
    fn default() -> Self {
        Self {
            method: SaddleMethod::default(),
            inner: InnerRule::default(),
            krylov: None,
            measure: Measure::default(),
            tolerance: 1e-8,
            max_iterations: 1000,
            traction_unit: None,
            rhs: None,
            explain: false,
        }
    }
}

/// What may take the place of the inner solver of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InnerRule {
    /// Nothing.
    Fixed,
    /// For a body, which is held, what [`Auto`](Self::Auto) takes, where it cannot be set up.
    #[default]
    OrElse,
    /// What fits the system: a factorization of up to 5,000 displacements; beyond, in turn, geometric multigrid on a grid that is not [thin](crate::mesh::is_thin),
    /// algebraic multigrid, a factorization. One with which the iteration gets nowhere gives way to a factorization that fits into memory,
    /// else to the next one.
    Auto,
}

/// b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RightHandSide {
    /// Of the system.
    #[serde(rename = "folder")]
    System,
    /// `b_i = sin(i)`, i = 1…n: every scale at once.
    #[serde(rename = "sin(i)")]
    Sin,
    /// `b_i = 1`.
    #[serde(rename = "ones")]
    Ones,
    /// Of the caller ([`Solver::set_rhs`]); before one is given that of the system.
    #[serde(rename = "given")]
    Given,
}

impl RightHandSide {
    /// Its entries, `own` being that of the system.
    pub fn entries(self, own: Vec<f64>) -> Vec<f64> {
        let n = own.len();
        match self {
            Self::System | Self::Given => own,
            Self::Sin => (1..=n).map(|i| (i as f64).sin()).collect(),
            Self::Ones => vec![1.0; n],
        }
    }
}

impl Solve {
    /// Sets up and solves.
    ///
    /// # Errors
    /// [`SolveError`]; not converging is a value.
    pub fn solve(
        &self,
        problem: &Problem,
        observer: &mut dyn Observer,
    ) -> Result<Solved, SolveError> {
        self.set_up(problem, observer)?.solve(observer)
    }

    /// Everything that does not depend on a right-hand side.
    ///
    /// # Errors
    /// [`SolveError`]: of settings, of the problem, of the method.
    pub fn set_up(
        &self,
        problem: &Problem,
        observer: &mut dyn Observer,
    ) -> Result<Solver, SolveError> {
        super::set_up::set_up(self, problem, observer)
    }

    fn asks_for_geometric(&self) -> bool {
        let is_geometric = matches!(self.method.inner(), Some(InnerChoice::Geometric(_)));
        is_geometric && self.inner != InnerRule::Auto
    }

    /// Which method solves this problem, and what takes its place; nothing is read but sizes, and nothing is meshed.
    ///
    /// # Errors
    /// Settings that are out of range or fit neither each other nor the problem.
    pub fn route(&self, problem: &Problem) -> Result<Route, SolveError> {
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        if !(is_positive(self.tolerance) && self.tolerance < 1.0) {
            let value = self.tolerance;
            return Err(SolveError::Tolerance { value });
        }
        if let Some(value) = self.traction_unit.filter(|unit| !is_positive(*unit)) {
            return Err(SolveError::Unit { value });
        }
        let kind = match problem {
            // one that is asked for by name has the entries made beside it
            Problem::Body(_) if self.explain && !self.asks_for_geometric() => {
                SystemKind::Entries("an explanation")
            }
            _ => problem.kind(),
        };
        Ok(Route::new(
            &self.method,
            self.inner,
            kind,
            problem.displacements(),
        )?)
    }
}
