//! A method made from assembled blocks.

use super::precision;
use super::set_up::SetUp;
use super::solver::{Equations, Names, Solver};
use super::{Finding, Loaded, Problem, SolveError};
use crate::elasticity::FreeStiffness;
use crate::undetermined::blamed;
use fracas_solvers::saddle::{HalvedBlocks, SaddleBlocks, SaddleMethod};
use fracas_solvers::{SetupError, Silent};
use std::sync::Arc;
use std::time::Instant;

impl SetUp<'_> {
    /// From assembled blocks.
    pub(super) fn assembled(mut self, mut method: SaddleMethod) -> Result<Solver, SolveError> {
        let loaded = self.problem.load(self.observer)?;
        self.observer.say(&loaded.sizes());
        let Loaded {
            blocks,
            has_rhs,
            mut findings,
            body,
            is_ours,
        } = loaded;
        // a foreign system keeps its units, and its residual is measured in them
        let unit = self.settings.traction_unit.unwrap_or(match is_ours {
            true => blocks.traction_unit(),
            false => 1.0,
        });
        let blocks = in_unit(blocks, unit);
        let (rhs, b) = self.right_hand_side(has_rhs, blocks.rhs());
        let start = Instant::now();
        self.observer.say(&"setting up");
        let stiffness = match &body {
            Some(body) => body.displaced_stiffness()?,
            None => None,
        };
        let mut equations = self.equations(&method, blocks, stiffness)?;
        let (ready, lost) = loop {
            match precision::ready(&method, &equations) {
                Ok(ready) => break ready,
                Err(error) => {
                    let name = match self.problem {
                        Problem::Body(body) => Some(body.name.as_str()),
                        _ => None,
                    };
                    let error = blamed(error, name, body.as_deref());
                    method = self.instead(error.into())?;
                    if method.matrix_free().is_some() {
                        drop(equations);
                        return self.by(method);
                    }
                    if let Equations::Halved { .. } = equations {
                        drop(equations);
                        let blocks = in_unit(self.problem.load(&mut Silent)?.blocks, unit);
                        equations = Equations::Assembled {
                            blocks,
                            stiffness: None,
                        };
                    }
                }
            }
        };
        findings.append(&mut self.findings);
        self.findings = findings;
        let in_f64 = lost.is_some();
        if let Some(lost) = lost {
            self.found(Finding::Precision(lost));
        }
        Ok(Solver {
            names: match in_f64 {
                true => Names {
                    inner: precision::name_in_double(&method),
                    ..Names::of(&method)
                },
                false => Names::of(&method),
            },
            double: precision::in_double(&method),
            method,
            equations,
            ready,
            rhs,
            b,
            unit,
            setup_s: start.elapsed().as_secs_f64(),
            findings: self.findings,
            fallbacks: usize::from(in_f64),
            replaced: self.replaced,
            settings: self.settings.clone(),
        })
    }

    /// The blocks, those of a folder with half of A where the method needs no more.
    fn equations(
        &self,
        method: &SaddleMethod,
        blocks: Arc<SaddleBlocks>,
        stiffness: Option<FreeStiffness<f64>>,
    ) -> Result<Equations, SetupError> {
        let is_read = matches!(self.problem, Problem::Folder(_)) && !self.settings.explain;
        if !is_read || !HalvedBlocks::serves(&blocks, method) {
            return Ok(Equations::Assembled { blocks, stiffness });
        }
        Ok(Equations::Halved {
            blocks: Box::new(HalvedBlocks::new(Arc::unwrap_or_clone(blocks))?),
            problem: self.problem.clone(),
        })
    }
}

/// The blocks with tractions in this unit.
fn in_unit(blocks: Arc<SaddleBlocks>, unit: f64) -> Arc<SaddleBlocks> {
    match unit {
        1.0 => blocks,
        _ => Arc::unwrap_or_clone(blocks).into_traction_unit(unit).into(),
    }
}
