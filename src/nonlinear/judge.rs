//! Whether the faces agree with their states.

use super::newton::{Attempt, Iterate, relative};
use super::{Evaluation, Start};
use crate::contact::{ContactState, Thresholds, next_state};

/// Slip in a step, of what its limit lets through, up to which a face has not slipped: a tenth of the tolerance of a run. Unit: 1.
const BLOCKED: f64 = 1e-9;

/// Change of its shear in the step, of its limit, from which on that is no matter of loads that stand still. Unit: 1.
const LOADED: f64 = 1e-3;

/// Judges faces.
#[derive(Clone)]
pub(super) struct Judge<'s> {
    attempt: &'s Attempt<'s>,
    /// How often rounds of this attempt have opened a face: it closes in slip then, where a fluid flows from the second time on.
    opened: Vec<u8>,
    /// Largest traction that counts [Pa].
    pub(super) traction: f64,
}

impl<'s> Judge<'s> {
    pub(super) fn new(attempt: &'s Attempt<'s>, faces: usize) -> Self {
        Self {
            attempt,
            opened: vec![0; faces],
            traction: attempt.traction,
        }
    }

    /// Faces that take another state, and which. What counts as zero is `zero` times the largest traction of all rounds so
    /// far (the first one, with every closed face in stick, shows what the loads could do); of jumps, and of trial tractions of slipping faces, of
    /// which jumps are a part, times the one that would close the largest jump at hand, where that is larger. Beside a flow the largest traction is
    /// that of steps before and of this round: fluid in a fracture that has yet to open has pressures of 3e11 Pa where the solution has 2e7 Pa. `start` tells which faces are torn.
    pub(super) fn changes(
        &mut self,
        start: &Start,
        states: &[ContactState],
        x: &Iterate,
        at: &Evaluation,
        zero: f64,
    ) -> Vec<(usize, ContactState)> {
        let problem = self.attempt.problem;
        let compliance = problem.compliance();
        let largest = x.t.iter().chain(&x.p);
        let largest = largest.fold(0.0, |m: f64, t| m.max(t.abs()));
        let before = match self.attempt.flow {
            None => self.traction,
            Some(_) => self.attempt.traction,
        };
        self.traction = before.max(largest);
        // jumps are known relative to the largest of them; beside a face that opens wide in stiff rock that is no measure of tractions
        let closing = or_closing(self.traction, &at.jumps, compliance);
        let spared = u8::from(self.attempt.flow.is_some());
        let mut changes = Vec::new();
        for (f, state) in states.iter().enumerate() {
            // an H of more than the states constrain holds no fluid out of an open face
            let jumps = match (self.attempt.flow, state) {
                (Some(_), ContactState::Open) => &at.jumps,
                _ => &at.effective,
            };
            let measure = problem.measure(f, *state, &x.t, jumps, start);
            let thresholds = Thresholds {
                jump: zero * closing * compliance[f],
                traction: zero * self.traction,
                slip: zero * closing,
            };
            let next = match next_state(*state, &measure, &thresholds) {
                // in stick it would carry again what tore it open, unless a fluid did that came no farther
                ContactState::Stick if *state == ContactState::Open && self.opened[f] > spared => {
                    ContactState::Slip
                }
                next => next,
            };
            if next != *state {
                self.opened[f] =
                    (self.opened[f]).saturating_add(u8::from(next == ContactState::Open));
                changes.push((f, next));
            }
        }
        changes
    }

    /// Faces at their limit that stand still though the loads change: neighbours that stick hold all nodes they move with. The direction of
    /// their shear is left open by the laws of the faces; H would determine it, but acts along the normal alone where faces slip. Tractions
    /// were off by 3e-5 with errors of 1e-10 said, beside an eigenvalue of 5e-11.
    pub(super) fn blocked(
        &self,
        start: &Start,
        states: &[ContactState],
        x: &Iterate,
        at: &Evaluation,
    ) -> Vec<usize> {
        let is_blocked = |f: usize| {
            let (law, point) = self.attempt.problem.face(f, &x.t, &at.effective, start);
            let limit = law.measure(&point).limit;
            let loaded =
                (x.t[3 * f + 1] - start.t[3 * f + 1]).hypot(x.t[3 * f + 2] - start.t[3 * f + 2]);
            let slip = point.jump[1].hypot(point.jump[2]);
            limit > 0.0 && slip <= BLOCKED * law.compliance * limit && loaded > LOADED * limit
        };
        let slips = |f: &usize| states[*f].constrained() == 1;
        (0..states.len())
            .filter(slips)
            .filter(|f| is_blocked(*f))
            .collect()
    }
}

/// Largest `‖t_T − P(t_T + Δg_T/ω)‖` of a slipping face, P onto the disc of radius τ_L: what slip against the traction is worth, and
/// 0 where slip follows it. It is relative to what faces are judged by, [`or_closing`] of the largest traction and of `jumps`.
pub(super) fn slip_violation(
    attempt: &Attempt<'_>,
    states: &[ContactState],
    fields: [&[f64]; 2],
    scale: (f64, &[f64]),
) -> f64 {
    let faces = slip_violations(attempt, states, fields, scale);
    faces.fold(0.0, |most, (_, violation)| most.max(violation))
}

/// That of every slipping face; of its tractions and jumps, and the largest traction and all jumps.
pub(super) fn slip_violations(
    attempt: &Attempt<'_>,
    states: &[ContactState],
    [t, effective]: [&[f64]; 2],
    (traction, jumps): (f64, &[f64]),
) -> impl Iterator<Item = (usize, f64)> {
    let scale = or_closing(traction, jumps, attempt.problem.compliance());
    let slips = |(_, s): &(usize, &ContactState)| s.constrained() == 1;
    let short = move |(f, state): (usize, &ContactState)| {
        let face = (attempt.problem).measure(f, *state, t, effective, attempt.start);
        (f, relative((face.limit - face.trial).max(0.0), scale))
    };
    states.iter().enumerate().filter(slips).map(short)
}

/// A traction, or the one that would close the largest normal jump [Pa].
pub(super) fn or_closing(traction: f64, jumps: &[f64], compliance: &[f64]) -> f64 {
    let gaps = jumps.iter().step_by(3).zip(compliance);
    gaps.fold(traction, |m, (g, c)| m.max(g.abs() / c))
}
