//! A method made from assembled blocks.

use super::precision;
use super::set_up::SetUp;
use super::solver::{Equations, Names, Solver};
use super::{Finding, Loaded, Problem, RightHandSide, Rounding, SolveError};
use crate::elasticity::FreeStiffness;
use crate::scene::Body;
use crate::undetermined::blamed;
use fracas_solvers::saddle::{HalvedBlocks, InnerChoice, Ready, SaddleBlocks, SaddleMethod, T};
use fracas_solvers::{SetupError, Silent};
use std::sync::Arc;
use std::time::Instant;

/// M⁻¹ of assembled blocks, and what f32 lost.
pub(super) type Set = (Ready, Option<Rounding>);

impl SetUp<'_> {
    /// From assembled blocks.
    pub(super) fn assembled(mut self, method: SaddleMethod) -> Result<Solver, SolveError> {
        let loaded = self.problem.load(self.observer)?;
        self.observer.say(&loaded.sizes());
        let own = loaded.traction_unit(self.settings.measure);
        let unit = self.settings.traction_unit.unwrap_or(own);
        let Loaded {
            blocks,
            has_rhs,
            mut findings,
            body,
            is_ours,
        } = loaded;
        let blocks = in_unit(blocks, unit);
        let (rhs, mut b) = self.right_hand_side(has_rhs, blocks.rhs());
        // rows of another code, and entries that are given by a rule, are in its units, unless another one is asked for
        let is_asked = self.settings.traction_unit.is_some();
        let row_unit = if is_ours || is_asked { 1.0 } else { unit };
        if rhs != RightHandSide::System {
            let [b_t] = blocks.layout().split_mut([T], &mut b);
            b_t.iter_mut().for_each(|b| *b *= row_unit);
        }
        let start = Instant::now();
        self.observer.say(&"setting up");
        let stiffness = match &body {
            Some(body) => body.displaced_stiffness()?,
            None => None,
        };
        let mut equations = self.equations(&method, blocks, stiffness)?;
        let name = match self.problem {
            Problem::Body(body) => Some(body.name.as_str()),
            _ => None,
        };
        let blame = (name, body.as_deref());
        let (method, ready) = self.until_ready(method, (&mut equations, unit), Some(blame))?;
        let Some((ready, lost)) = ready else {
            drop(equations);
            return self.by(method);
        };
        findings.append(&mut self.findings);
        self.findings = findings;
        let in_f64 = lost.is_some();
        if let Some(lost) = lost {
            self.found(Finding::Precision(lost));
        }
        Ok(Solver {
            gives_way: self.gives_way(),
            otherwise: self.otherwise.collect(),
            problem: self.problem.clone(),
            names: Names::of_ready(&method, in_f64),
            double: precision::in_double(&method),
            method,
            equations,
            ready,
            rhs,
            b,
            unit,
            row_unit,
            setup_s: start.elapsed().as_secs_f64(),
            findings: self.findings,
            fallbacks: usize::from(in_f64),
            replaced: self.replaced,
            settings: self.settings.clone(),
        })
    }

    /// The method, or what takes its place, ready for these equations, and what f32 lost; one without an assembled A is handed back as it is.
    ///
    /// # Errors
    /// The failure of the last one, where nothing takes its place; `blame` is the scene and its body.
    pub(super) fn until_ready(
        &mut self,
        mut method: SaddleMethod,
        (equations, unit): (&mut Equations, f64),
        blame: Option<(Option<&str>, Option<&Body>)>,
    ) -> Result<(SaddleMethod, Option<Set>), SolveError> {
        loop {
            let needs_all = !matches!(method.inner(), Some(InnerChoice::Amg(_)));
            if let (Equations::Halved { .. }, true) = (&*equations, needs_all) {
                let blocks = in_unit(self.problem.load(&mut Silent)?.blocks, unit);
                *equations = Equations::Assembled {
                    blocks,
                    stiffness: None,
                };
            }
            let error = match precision::ready(&method, equations) {
                Ok(ready) => return Ok((method, Some(ready))),
                Err(error) => error,
            };
            let (name, body) = blame.unwrap_or_default();
            method = self.instead(blamed(error, name, body).into())?;
            if method.matrix_free().is_some() {
                return Ok((method, None));
            }
        }
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
