//! Newton's method at fixed contact states.

use super::damping::{Damping, WANDERS};
use super::krylov::Solved;
use super::linear::Linear;
use super::record::count;
use super::{
    ContactProblem, Evaluation, Failure, LinearFailure, LinearRecord, Load, NewtonSystem, Start,
};
use crate::contact::ContactState;
use crate::elasticity::Constraints;
use crate::flow::{Control, FlowStep};
use fracas_operators::sparse::Csr;
use fracas_operators::vector::{axpy, norm2};
use fracas_operators::{Fields, Layout};
use fracas_solvers::saddle::{P, T, U};
use fracas_solvers::{Observer, Step};

/// Halvings of a correction that the line search tries.
pub(super) const BACKTRACKS: usize = 6;

/// Least relative decrease of the residual for a share of the correction (Armijo). Unit: 1.
pub(super) const DECREASE: f64 = 1e-4;

/// Where the iteration stands; tractions and pressures in Pa.
#[derive(Clone, Debug)]
pub(super) struct Iterate {
    pub(super) u: Vec<f64>,
    pub(super) t: Vec<f64>,
    /// Empty where nothing flows.
    pub(super) p: Vec<f64>,
    /// What holds of every well.
    pub(super) wells: Vec<Control>,
}

impl Iterate {
    /// At u, t and p, wells as they begin a step.
    pub(super) fn new([u, t, p]: [&[f64]; 3], flow: Option<&FlowStep>) -> Self {
        Self {
            u: u.to_vec(),
            t: t.to_vec(),
            p: p.to_vec(),
            wells: flow.map_or(Vec::new(), FlowStep::controls),
        }
    }

    /// `x ← y + α δ` in the fields of `layout`, which δ has; others stay as they are.
    pub(super) fn step(&mut self, from: &Self, alpha: f64, layout: &Layout, correction: &[f64]) {
        let fields = [
            (U, &mut self.u, &from.u),
            (T, &mut self.t, &from.t),
            (P, &mut self.p, &from.p),
        ];
        let moved = layout.values(());
        for (field, x, y) in fields {
            if moved.get(field).is_some() {
                x.copy_from_slice(y);
                let [delta] = layout.split([field], correction);
                axpy(alpha * layout.unit(field), delta, x);
            }
        }
    }
}

/// One attempt at a step: what does not change within it.
#[derive(Clone)]
pub(super) struct Attempt<'s> {
    pub(super) problem: &'s ContactProblem<'s>,
    pub(super) start: &'s Start,
    pub(super) load: &'s Load,
    /// ‖·‖₂ of loads and internal forces, the largest so far, tractions in the balanced unit [N].
    pub(super) scale: f64,
    /// Largest traction so far [Pa].
    pub(super) traction: f64,
    /// Largest norm of every field so far.
    pub(super) size: Fields<f64>,
    /// What prescribes displacements that are not 0, if anything does.
    pub(super) held: Option<Constraints>,
    /// What is given of the flow, where there is one and time passes.
    pub(super) flow: Option<&'s FlowStep>,
    /// H of faces that return beside a flow is that of their most constrained state ([`Returning`](super::returning::Returning)).
    pub(super) holds: bool,
    pub(super) step: usize,
    pub(super) attempt: usize,
}

impl Attempt<'_> {
    /// Errors that nobody judges.
    pub(super) fn unjudged(&self) -> Fields<f64> {
        self.size.map(|_, _| f64::NAN)
    }

    /// A linear system in this round and step of Newton, not solved yet.
    pub(super) fn record(
        &self,
        [active, newton]: [usize; 2],
        faces: [usize; 4],
        tolerance: f64,
        residual: f64,
    ) -> LinearRecord {
        LinearRecord {
            step: self.step,
            attempt: self.attempt,
            active,
            newton,
            faces,
            krylov: "",
            iterations: 0,
            tolerance,
            relative_residual: f64::NAN,
            residual,
            step_length: 0.0,
            setup: false,
        }
    }
}

impl LinearRecord {
    /// The same, solved, with this share of the correction taken.
    pub(super) fn solved(self, solved: &Solved, step_length: f64) -> Self {
        Self {
            krylov: solved.krylov,
            iterations: solved.iterations,
            relative_residual: solved.relative_residual,
            step_length,
            setup: solved.setup,
            ..self
        }
    }
}

/// When Newton stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Until {
    /// Residual relative to the scale of the attempt.
    pub(super) residual: f64,
    /// Most steps.
    pub(super) steps: usize,
    /// Steps are those of [`Damping`].
    pub(super) lagged: bool,
}

impl Until {
    /// It has not been reached: this residual is left after so many steps.
    pub(super) fn missed(&self, residual: f64, iterations: usize) -> Failure {
        Failure::Newton {
            residual,
            iterations,
            tolerance: self.residual,
        }
    }
}

/// Solves the equations at fixed `states`, from and to `x`; returns the last evaluation and its relative residual, which may
/// be larger than asked when the steps run out.
///
/// `J δ = −r` to `η = max(last asked/‖r‖, min(forcing, ‖r‖²/‖r_before‖²))` (Eisenstat and Walker, choice 2), with
/// backtracking on ‖r‖, or in full with [`Damping`] as long as that leads somewhere. With stick and open alone the equations are linear, and one solve does it.
pub(super) fn newton(
    attempt: &Attempt<'_>,
    (states, h): (&[ContactState], Option<&Csr<f64>>),
    until: Until,
    (linear, round): (&mut Linear, usize),
    x: &mut Iterate,
    records: &mut Vec<LinearRecord>,
    observer: &mut dyn Observer,
) -> Result<(Evaluation, f64), Failure> {
    let problem = attempt.problem;
    let rounds = problem.body().solver.rounds;
    let layout = attempt.layout();
    let evaluate = |x: &Iterate| attempt.evaluate(states, h, x);
    let is_linear = attempt.is_linear(states);
    // damped continuation may have to pass a larger residual
    let mut damping = (until.lagged && problem.weakens()).then(Damping::default);
    let mut correction = vec![0.0; layout.len()];
    let (mut at, _) = attempt.controlled((states, h), evaluate(x), x, false);
    let (mut before, mut switches) = (f64::INFINITY, attempt.switches());
    let mut iteration = 0;
    // the lowest residual so far, and the step that it came before
    let mut lowest = (f64::INFINITY, 0);
    loop {
        let size = norm2(&at.residual);
        let residual = attempt.relative(&at);
        if !residual.is_finite() {
            return Err(Failure::NotFinite {
                what: "the residual",
            });
        }
        if residual < lowest.0 {
            lowest = (residual, iteration);
        }
        let wanders = damping.is_some() && iteration - lowest.1 == WANDERS;
        if residual <= until.residual || iteration == until.steps || wanders {
            return Ok((at, residual));
        }
        if observer
            .observe(&Step::Newton {
                iteration,
                residual,
            })
            .is_break()
        {
            return Err(Failure::Stopped);
        }
        let last = rounds.last * until.residual / residual;
        let forcing = match is_linear {
            true => last,
            false => (size / before).powi(2).min(rounds.forcing).max(last),
        };
        if linear.wanted.is_some_and(|wanted| wanted <= records.len()) {
            let blocks = attempt.assembled(states, (h, x), &at, until.lagged);
            linear.found = Some(NewtonSystem {
                blocks: blocks.map_err(LinearFailure::from)?,
                states: states.to_vec(),
                attempt: attempt.attempt,
                round,
                newton: iteration,
            });
            return Err(Failure::Stopped);
        }
        if let Some(damping) = &damping {
            at.keep(damping.share());
        }
        // J δ = −r
        let solved = match attempt.flow {
            Some(_) => {
                let place = (states, h, until.lagged);
                linear.solve_coupled(attempt, place, (x, &at), forcing, &mut correction, observer)
            }
            None => {
                let jacobian = problem.jacobian(states, h, &at, until.lagged);
                linear.solve(
                    problem,
                    (&jacobian, states),
                    &at.residual,
                    forcing,
                    &mut correction,
                    observer,
                )
            }
        };
        let record = attempt.record([round, iteration], count(states), forcing, residual);
        let solved = solved.inspect_err(|failure| {
            if let LinearFailure::IterationLimit {
                krylov,
                iterations,
                residual,
                ..
            } = failure
            {
                records.push(LinearRecord {
                    krylov,
                    iterations: *iterations,
                    relative_residual: *residual,
                    ..record
                });
            }
        })?;
        if solved.stopped {
            return Err(Failure::Stopped);
        }
        let takes = damping
            .as_mut()
            .is_none_or(|damping| damping.takes(&correction));
        if !takes {
            records.push(record.solved(&solved, 0.0));
            iteration += 1;
            at = evaluate(x);
            continue;
        }
        let from_size = linear.size_of(attempt, &at.residual);
        // x ← x + α δ with the largest α = 1, ½, … that lowers the residual
        let (from, mut length) = (x.clone(), attempt.first_length(states, &at, &correction));
        for backtrack in 0..=BACKTRACKS {
            x.step(&from, length, &layout, &correction);
            at = evaluate(x);
            let new = linear.size_of(attempt, &at.residual);
            let lowered = new <= (1.0 - DECREASE * length) * from_size;
            if is_linear || damping.is_some() || lowered || backtrack == BACKTRACKS {
                break;
            }
            length *= 0.5;
        }
        before = size;
        records.push(record.solved(&solved, length));
        let switched;
        let alone = 2 * switches < attempt.switches();
        (at, switched) = attempt.controlled((states, h), at, x, alone);
        match switched && switches > 0 {
            true => (before, switches) = (f64::INFINITY, switches - 1),
            false => iteration += 1,
        }
    }
}

/// `size/scale`, 0 where both are.
pub(super) fn relative(size: f64, scale: f64) -> f64 {
    if size == 0.0 { 0.0 } else { size / scale }
}
