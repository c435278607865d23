//! The linear systems of Newton: one preconditioner for as long as it serves.

use super::{ContactJacobian, ContactProblem, LinearFailure};
use crate::contact::Coupling;
use fracas_operators::Preconditioner;
use fracas_operators::vector::norm2;
use fracas_solvers::Observer;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Criteria, KrylovChoice, Outcome, Report, Sqmr, System};
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, Racp, RacpInverse};
use std::sync::Arc;

/// Displacements up to which S_u is factorized when the scene does not choose. Unit: 1.
const FACTORIZED: usize = 20_000;

type Inverse = RacpInverse<Box<dyn Preconditioner<f64>>, Arc<Coupling<f64>>>;

/// Solves Jacobians with RACP of the all-stick body.
///
/// `M = [A B; Bᵀ −C]` with `C = C_local + |diag H|` knows nothing of the states: a slipping or open face has `ωA_f`,
/// which C_local resembles, on its diagonal, so that the iterations grow by less than a half while A, B and S_u stay what
/// they are. One set-up serves a whole run.
pub(super) struct Linear {
    settings: Racp,
    max_krylov: usize,
    inverse: Option<Inverse>,
    work: Vec<f64>,
}

/// A solved system.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved {
    pub(super) krylov: &'static str,
    pub(super) report: Report,
    pub(super) setup: bool,
}

impl Linear {
    pub(super) fn new(problem: &ContactProblem<'_>) -> Self {
        let body = problem.body();
        let by_size = || {
            let small = body.constraints.free_len() <= FACTORIZED;
            Racp {
                augmentation: AugmentationChoice::LocalH,
                inner: match small {
                    true => InnerChoice::default(),
                    false => InnerChoice::Amg(Default::default()),
                },
            }
        };
        Self {
            settings: body.solver.racp.unwrap_or_else(by_size),
            max_krylov: body.solver.max_krylov,
            inverse: None,
            work: Vec::new(),
        }
    }

    /// Settings in use.
    pub(super) fn settings(&self) -> Racp {
        self.settings
    }

    /// `x ← J⁻¹ b` to a relative residual; short recurrences where J is symmetric.
    pub(super) fn solve(
        &mut self,
        problem: &ContactProblem<'_>,
        jacobian: &ContactJacobian<'_>,
        rhs: &[f64],
        tolerance: f64,
        x: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<Solved, LinearFailure> {
        let setup = self.inverse.is_none();
        let inverse = match &mut self.inverse {
            Some(inverse) => inverse,
            none => none.insert(prepare(self.settings, problem)?),
        };
        let symmetric = jacobian.is_symmetric() && inverse.is_linear() && !inverse.is_single();
        let krylov = match symmetric {
            true => KrylovChoice::Sqmr(Sqmr {}),
            false => KrylovChoice::default(),
        }
        .flexible_for(inverse as &dyn Preconditioner<f64>);
        let system = System {
            operator: jacobian,
            preconditioner: inverse,
            rhs,
        };
        let criteria = Criteria {
            relative_tolerance: tolerance,
            max_iterations: self.max_krylov,
        };
        let method = krylov.method::<f64>();
        let needed = method.work_len(&system, &criteria);
        if self.work.len() < needed {
            self.work.resize(needed, 0.0);
        }
        x.fill(0.0);
        let report = method.solve_in(&system, &criteria, x, observer, &mut self.work[..needed])?;
        let limit = report.outcome == Outcome::IterationLimit;
        if limit || !norm2(x).is_finite() {
            return Err(LinearFailure::IterationLimit {
                krylov: krylov.name(),
                iterations: report.iterations,
                residual: report.relative_residual,
                tolerance,
            });
        }
        Ok(Solved {
            krylov: krylov.name(),
            report,
            setup,
        })
    }
}

/// RACP of the body with every face in stick; the assembled A is given back once S̃_u is there.
fn prepare(settings: Racp, problem: &ContactProblem<'_>) -> Result<Inverse, LinearFailure> {
    let direct = match settings.inner {
        InnerChoice::Exact { backend } => backend,
        _ => DirectChoice::default(),
    };
    let unit = problem.saddle().unit();
    let blocks = problem.stick_blocks()?.into_traction_unit(unit);
    let c = settings
        .augmentation
        .compute(&blocks, direct.solver()?.as_ref())?
        .matrix;
    let s_u = settings.inner.prepare(&blocks, &c)?.inverse;
    Ok(RacpInverse::with_operator(
        problem.saddle().coupling().clone(),
        c,
        s_u,
    ))
}
