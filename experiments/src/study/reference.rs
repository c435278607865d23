//! True errors: against the solution of a direct solver.

use super::product::Case;
use super::solving;
use anyhow::ensure;
use fracas::elasticity::FreeStiffness;
use fracas::run::Stop;
use fracas::solve::{InnerRule, Problem, Solve};
use fracas_solvers::Silent;
use fracas_solvers::saddle::{
    Assembled, Direct, EnergyNorms, SaddleBlocks, SaddleMethod, SaddleSystem, StrainNorm, T, U,
};
use std::sync::Arc;

/// Error that the reference itself may have. Unit: 1.
const TOLERANCE: f64 = 1e-12;

/// A solution with what errors are measured by.
pub(super) struct Reference {
    case: Case,
    blocks: Arc<SaddleBlocks>,
    /// Where the load of the scene prescribes displacements: their part of the strain counts, too.
    stiffness: Option<FreeStiffness<f64>>,
    x: Vec<f64>,
}

impl Reference {
    /// Of the system of a row.
    ///
    /// # Errors
    /// Where a direct solver fails.
    pub(super) fn new(case: &Case, problem: &Problem, stop: &dyn Stop) -> anyhow::Result<Self> {
        let loaded = problem.load(&mut Silent)?;
        let stiffness = match &loaded.body {
            Some(body) if case.has_own_load() => body.displaced_stiffness()?,
            _ => None,
        };
        let settings = Solve {
            method: SaddleMethod::Direct(Direct::default()),
            inner: InnerRule::Fixed,
            tolerance: TOLERANCE,
            rhs: (case.setting.rhs.as_ref())
                .and_then(|rhs| rhs.value)
                .map(|load| load.known()),
            ..Solve::default()
        };
        let mut solver = settings.set_up(problem, &mut Silent)?;
        solving::load(&mut solver, case);
        let solved = solver.solve(&mut solving::Watch::of(stop))?;
        ensure!(
            solved.has_converged(),
            "the reference did not converge to {TOLERANCE:e}{}",
            solved
                .reason
                .map_or(String::new(), |why| format!(": {why}"))
        );
        Ok(Self {
            case: case.clone(),
            blocks: loaded.blocks,
            stiffness,
            x: solved.x,
        })
    }

    /// True where it serves this row, too.
    pub(super) fn serves(&self, case: &Case) -> bool {
        self.case.same_system(case)
    }

    /// `‖u − u_ref‖/‖u_ref‖` and `‖t − t_ref‖/‖t_ref‖` in the norms of energy.
    pub(super) fn errors(&self, x: &[f64]) -> [f64; 2] {
        let strain = (self.stiffness.as_ref())
            .map(|a| -> StrainNorm<'_> { Box::new(move |u| a.strain_norm(u)) });
        let system = Assembled::new(&self.blocks, strain);
        let norms = system.norms(self.stiffness.is_some());
        let e: Vec<f64> = x.iter().zip(&self.x).map(|(a, b)| a - b).collect();
        let relative = EnergyNorms::relative(norms.error(&e), norms.solution(&self.x), TOLERANCE);
        [relative[U], relative[T]]
    }
}
