//! e15: the non-linear solver in profile, and beside it the alternatives to Lagrange multipliers.

mod fault;
mod precision;
mod profile;
mod run;
mod weak;

use crate::report::{Experiment, Findings, Level};
use fracas_solvers::Observer;

/// What do the three cycles cost, and what would the alternatives?
#[derive(Debug)]
pub struct Nonlinear;

impl Experiment for Nonlinear {
    fn id(&self) -> &'static str {
        "e15"
    }

    fn title(&self) -> &'static str {
        "Non-linear profile, and the alternatives to multipliers"
    }

    fn question(&self) -> &'static str {
        "How many rounds, Newton steps and Krylov iterations does a step take, and what do penalty, augmented Lagrangian and a weak layer cost and miss?"
    }

    fn setup(&self) -> &'static str {
        "Three paths in time: `cycle`; a plate of 8 m with a fault of 4 m that is pressed and sheared forth and back; `crossing` with a dip of 60° and 15° of \
         friction, its side pressure falling and turning to tension. Precision: the plate, friction angle 20°, pressed by \
         1 mm and sheared by 2 mm in one step (16 cells across at smoke level, 32 at paper level), tolerance 1e-10. Springs per area of κ = factor/ω, \
         ω the local compliance of a face; their tangents are solved with a factorization (or AMG) of A + BκBᵀ that is made anew when it \
         has taken 40 iterations. The weak layer is linear elastic."
    }

    fn expect(&self) -> &'static str {
        "Multipliers: at most one set-up per step beside the first, Krylov iterations in slip at most 2.5 times those in stick. Penalty: errors fall as 1/κ down to the \
         error of the mesh while κ(A + BκBᵀ) grows with κ. Augmented Lagrangian: exact, with an update count that falls as κ grows. A weak \
         layer has no answer of its own: its slip depends on its stiffness and its sides overlap."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("level", level.word());
        profile::profile(level, &mut findings, observer)?;
        precision::precision(level, &mut findings, observer)?;
        weak::weak(level, &mut findings, observer)?;
        Ok(findings)
    }
}
