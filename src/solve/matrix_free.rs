//! A body without an assembled A: RACP around geometric multigrid.

use super::precision;
use super::set_up::SetUp;
use super::solver::{Equations, Names, Solver};
use super::{Finding, Rounding, Sizes, SolveError, StuckBody};
use crate::matrix_free::{MatrixFreeError, MatrixFreeSystem, RacpParts};
use crate::memory;
use fracas_solvers::saddle::{Racp, SaddleMethod, SaddleSystem};
use std::time::Instant;

impl SetUp<'_> {
    /// Nothing is assembled but H, C and the coarse levels.
    pub(super) fn matrix_free(
        mut self,
        stuck: &StuckBody,
        racp: Racp,
    ) -> Result<Solver, SolveError> {
        // an explanation reads entries when the solution is there
        let work = match self.settings.explain {
            true => memory::EXPLAINED,
            false => memory::MATRIX_FREE,
        };
        let body = stuck.mesh(work, self.observer)?;
        let failed = |source| SolveError::Body {
            name: stuck.name.clone(),
            source,
        };
        let system = body.stick_system(stuck.stabilization(&body));
        let force = body.forces().map_err(failed)?;
        let equations =
            MatrixFreeSystem::new(&system, self.settings.traction_unit).map_err(failed)?;
        let saddle = &equations.saddle;
        let own = saddle.rhs(&system, &force);
        drop(force);
        self.observer.say(&Sizes::of(&equations.layout()));
        let has_rhs = own.iter().any(|b| *b != 0.0);
        let (rhs, b) = self.right_hand_side(has_rhs, own);
        let start = Instant::now();
        self.observer.say(&"setting up");
        let parts = match RacpParts::new(&racp, saddle, &system, self.observer) {
            Ok(parts) => parts,
            Err(error @ MatrixFreeError::Stopped) => return Err(error.into()),
            Err(error) => {
                let method = self.instead(error.into())?;
                drop(equations);
                return self.by(method);
            }
        };
        if let Some(lost) = parts.lost {
            self.found(Finding::Precision(Rounding::Hierarchy(lost)));
        }
        // the operators carry what they need: the mesh has done its work
        drop(body);
        Ok(Solver {
            gives_way: self.gives_way(),
            otherwise: self.otherwise.collect(),
            problem: self.problem.clone(),
            names: Names {
                method: "racp".into(),
                augmentation: Some(racp.augmentation.to_string()),
                inner: Some(match parts.lost {
                    None => racp.inner.to_string(),
                    Some(_) => racp.in_double().inner.to_string(),
                }),
            },
            double: precision::in_double(&SaddleMethod::Racp(racp)),
            method: SaddleMethod::Racp(racp),
            fallbacks: usize::from(parts.lost.is_some()),
            ready: parts.into(),
            rhs,
            b,
            unit: saddle.unit(),
            row_unit: 1.0,
            equations: Equations::MatrixFree {
                system: Box::new(equations),
                stuck: stuck.clone(),
                racp,
            },
            setup_s: start.elapsed().as_secs_f64(),
            findings: self.findings,
            replaced: self.replaced,
            settings: self.settings.clone(),
        })
    }
}
