//! The active set: states change until every face agrees with its own.

use super::cycling::Rounds;
use super::linear::Linear;
use super::newton::{Attempt, Iterate, Until, newton};
use super::{Evaluation, Event, Failure, LinearRecord, Remedy};
use crate::contact::{ContactState, FaceMeasure, Thresholds, next_state};
use fracas_solvers::{Observer, Step};

/// Residual up to which Newton is solved while states still change, and what then counts as zero. Unit: 1.
const LOOSE: f64 = 1e-4;

/// Newton steps that a round may take while states still change.
const LOOSE_STEPS: usize = 3;

/// Newton steps that a round may take while the limit of the iterate before stands for weakening.
const LAGGED_STEPS: usize = 60;

/// What an attempt found.
pub(super) struct Settled {
    pub(super) states: Vec<ContactState>,
    pub(super) x: Iterate,
    /// Largest force and traction so far.
    pub(super) force: f64,
    pub(super) traction: f64,
}

/// What an attempt costs and tells, also when it fails.
#[derive(Default)]
pub(super) struct Log {
    pub(super) rounds: usize,
    pub(super) linear: Vec<LinearRecord>,
    pub(super) events: Vec<Event>,
    /// States of the last round.
    pub(super) states: Vec<ContactState>,
}

/// Rounds of Newton and new states.
///
/// While states change, Newton takes at most three steps and stops at 1e-4, and only violations beyond that count; once no
/// face changes it is solved, and the faces are judged, to the tolerances asked.
pub(super) fn active_set(
    attempt: &Attempt<'_>,
    mut states: Vec<ContactState>,
    mut x: Iterate,
    linear: &mut Linear,
    log: &mut Log,
    observer: &mut dyn Observer,
) -> Result<Settled, Failure> {
    let settings = attempt.problem.body().solver;
    let loose = Until {
        residual: settings.tolerance.max(LOOSE),
        steps: LOOSE_STEPS.min(settings.max_newton),
        lagged: false,
    };
    let tight = Until {
        residual: settings.tolerance,
        steps: settings.max_newton,
        lagged: false,
    };
    // what the lag of weakening takes: it converges by a factor a step
    let lagging = Until {
        steps: LAGGED_STEPS,
        lagged: true,
        ..tight
    };
    let weakens = attempt.problem.weakens();
    let mut judge = Judge::new(attempt, states.len());
    let mut rounds = Rounds::default();
    let mut h = attempt.problem.stabilization(&states);
    let _ = rounds.enter(&states);
    let mut until = loose;
    let mut changing = Vec::new();
    for round in 0..settings.max_active {
        log.rounds += 1;
        log.states.clone_from(&states);
        let (at, residual) = newton(
            attempt,
            (&states, h.as_ref()),
            until,
            (linear, round),
            &mut x,
            &mut log.linear,
            observer,
        )?;
        let zero = match until == loose {
            true => settings.state_tolerance.max(LOOSE),
            false => settings.state_tolerance,
        };
        let changes = judge.changes(&states, &x, &at, zero);
        let step = Step::Round {
            round: round + 1,
            changed: changes.len(),
        };
        if observer.observe(&step).is_break() {
            return Err(Failure::Stopped);
        }
        if changes.is_empty() {
            let converged = residual <= until.residual;
            until = match converged {
                true if until == loose => tight,
                true => {
                    return Ok(Settled {
                        states,
                        x,
                        force: attempt.scale,
                        traction: judge.traction,
                    });
                }
                false if until == tight && weakens => lagging,
                false if until == loose && weakens => lagging,
                false if until == loose => tight,
                false => {
                    return Err(Failure::Newton {
                        residual,
                        iterations: until.steps,
                        tolerance: until.residual,
                    });
                }
            };
            continue;
        }
        until = loose;
        // new-slip to slip leaves H as it is
        let other_h =
            |(f, state): &(usize, ContactState)| state.constrained() != states[*f].constrained();
        let other_h = changes.iter().any(other_h);
        for (f, state) in &changes {
            states[*f] = *state;
        }
        changing = changes.into_iter().map(|(f, _)| f).collect();
        if other_h {
            h = attempt.problem.stabilization(&states);
        }
        if let Some(cycle) = rounds.enter(&states) {
            let Some(remedy) = cycle.remedy else {
                return Err(Failure::Cycle {
                    period: cycle.period,
                    faces: cycle.faces,
                });
            };
            judge.treat(&cycle.faces, remedy);
            log.events.push(Event::Cycle {
                round: round + 1,
                period: cycle.period,
                faces: cycle.faces,
                remedy,
            });
        }
    }
    Err(Failure::ActiveSet {
        rounds: settings.max_active,
        faces: changing,
    })
}

/// Judges faces, those of a cycle by stricter rules.
struct Judge<'s> {
    attempt: &'s Attempt<'s>,
    /// Remedy per face.
    treated: Vec<Option<Remedy>>,
    /// Faces that a round of this attempt has opened: they close in slip.
    opened: Vec<bool>,
    /// Largest traction so far [Pa].
    traction: f64,
}

impl<'s> Judge<'s> {
    fn new(attempt: &'s Attempt<'s>, faces: usize) -> Self {
        Self {
            attempt,
            treated: vec![None; faces],
            opened: vec![false; faces],
            traction: attempt.traction,
        }
    }

    fn treat(&mut self, faces: &[usize], remedy: Remedy) {
        faces.iter().for_each(|f| self.treated[*f] = Some(remedy));
    }

    /// Faces that take another state, and which. What counts as zero is `zero` times the largest traction of all rounds so
    /// far (the first one, with every closed face in stick, shows what the loads could do), or the one that would close the largest
    /// jump at hand.
    fn changes(
        &mut self,
        states: &[ContactState],
        x: &Iterate,
        at: &Evaluation,
        zero: f64,
    ) -> Vec<(usize, ContactState)> {
        let problem = self.attempt.problem;
        let hysteresis = problem.body().solver.hysteresis;
        let compliance = problem.compliance();
        let largest = x.t.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        self.traction = self.traction.max(largest);
        // jumps are known relative to the largest of them
        let traction = or_closing(self.traction, &at.jumps, compliance);
        let mut changes = Vec::new();
        let mut worst: Option<(f64, usize, ContactState)> = None;
        for (f, state) in states.iter().enumerate() {
            let measure = problem.measure(f, *state, &x.t, &at.jumps, self.attempt.start);
            let zero = match self.treated[f] {
                Some(Remedy::Keep) => hysteresis.max(zero),
                _ => zero,
            };
            let thresholds = Thresholds {
                jump: zero * traction * compliance[f],
                traction: zero * traction,
                hysteresis: if self.treated[f].is_some() {
                    hysteresis
                } else {
                    0.0
                },
            };
            let next = match next_state(*state, &measure, &thresholds) {
                // in stick it would carry again what tore it open
                ContactState::Stick
                    if *state == ContactState::Open
                        && (self.opened[f] || self.treated[f].is_some()) =>
                {
                    ContactState::Slip
                }
                next => next,
            };
            if next == *state {
                continue;
            }
            // from new-slip to slip nothing is violated
            let held = self.treated[f] == Some(Remedy::OneFace) && next != ContactState::Slip;
            if !held {
                changes.push((f, next));
                continue;
            }
            let violation = violation(*state, &measure, compliance[f]);
            if worst.is_none_or(|(most, ..)| violation > most) {
                worst = Some((violation, f, next));
            }
        }
        changes.extend(worst.map(|(_, f, next)| (f, next)));
        for (f, next) in &changes {
            self.opened[*f] |= *next == ContactState::Open;
        }
        changes
    }
}

/// How far a face is from its state, as a traction [Pa].
fn violation(state: ContactState, face: &FaceMeasure, compliance: f64) -> f64 {
    match state {
        ContactState::Open => -face.gap / compliance,
        _ => face.t_n.max((face.trial - face.limit).abs()),
    }
}

/// A traction, or the one that would close the largest normal jump [Pa].
pub(super) fn or_closing(traction: f64, jumps: &[f64], compliance: &[f64]) -> f64 {
    let gaps = jumps.iter().step_by(3).zip(compliance);
    gaps.fold(traction, |m, (g, c)| m.max(g.abs() / c))
}
