//! The active set: states change until every face agrees with its own.

use super::cycling::Rounds;
use super::linear::Linear;
use super::newton::{Attempt, Iterate, newton};
use super::{Evaluation, Event, Failure, LinearRecord, Remedy};
use crate::contact::{ContactState, FaceMeasure, Thresholds, next_state};
use fracas_solvers::{Observer, Step};

/// Residual up to which Newton is solved while states still change, and what then counts as zero. Unit: 1.
const LOOSE: f64 = 1e-4;

/// What an attempt found.
pub(super) struct Settled {
    pub(super) states: Vec<ContactState>,
    pub(super) x: Iterate,
}

/// What an attempt costs and tells, also when it fails.
#[derive(Default)]
pub(super) struct Log {
    pub(super) rounds: usize,
    pub(super) linear: Vec<LinearRecord>,
    pub(super) events: Vec<Event>,
}

/// Rounds of Newton and new states. While states change, Newton is solved to 1e-4 only and only violations beyond that
/// count; the last round is solved and judged to the tolerances asked.
pub(super) fn active_set(
    attempt: &Attempt<'_>,
    mut states: Vec<ContactState>,
    mut x: Iterate,
    linear: &mut Linear,
    log: &mut Log,
    observer: &mut dyn Observer,
) -> Result<Settled, Failure> {
    let settings = attempt.problem.body().solver;
    let mut judge = Judge::new(attempt, states.len());
    let (mut rounds, mut tight) = (Rounds::default(), false);
    let mut h = attempt.problem.stabilization(&states);
    let _ = rounds.enter(&states);
    for round in 0..settings.max_active {
        log.rounds += 1;
        let residual = if tight {
            settings.tolerance
        } else {
            settings.tolerance.max(LOOSE)
        };
        let at = newton(
            attempt,
            &states,
            h.as_ref(),
            residual,
            (linear, round),
            &mut x,
            &mut log.linear,
            observer,
        )?;
        let zero = if tight {
            settings.state_tolerance
        } else {
            settings.state_tolerance.max(LOOSE)
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
            if tight {
                return Ok(Settled { states, x });
            }
            tight = true;
            continue;
        }
        tight = false;
        for (f, state) in &changes {
            states[*f] = *state;
        }
        h = attempt.problem.stabilization(&states);
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
        if round + 1 == settings.max_active {
            return Err(Failure::ActiveSet {
                rounds: settings.max_active,
                faces: changes.into_iter().map(|(f, _)| f).collect(),
            });
        }
    }
    Err(Failure::ActiveSet {
        rounds: settings.max_active,
        faces: Vec::new(),
    })
}

/// Judges faces, those of a cycle by stricter rules.
struct Judge<'s> {
    attempt: &'s Attempt<'s>,
    /// Remedy per face.
    treated: Vec<Option<Remedy>>,
}

impl<'s> Judge<'s> {
    fn new(attempt: &'s Attempt<'s>, faces: usize) -> Self {
        Self {
            attempt,
            treated: vec![None; faces],
        }
    }

    fn treat(&mut self, faces: &[usize], remedy: Remedy) {
        faces.iter().for_each(|f| self.treated[*f] = Some(remedy));
    }

    /// Faces that take another state, and which. What counts as zero is `zero` times the largest traction, or times the
    /// traction that would close the largest jump, whichever is more.
    fn changes(
        &self,
        states: &[ContactState],
        x: &Iterate,
        at: &Evaluation,
        zero: f64,
    ) -> Vec<(usize, ContactState)> {
        let problem = self.attempt.problem;
        let hysteresis = problem.body().solver.hysteresis;
        let compliance = problem.compliance();
        let traction = traction_scale(x, at, compliance);
        let mut changes = Vec::new();
        let mut worst: Option<(f64, usize, ContactState)> = None;
        for (f, state) in states.iter().enumerate() {
            let measure = problem.measure(f, &x.t, &at.jumps, self.attempt.start);
            let thresholds = Thresholds {
                jump: zero * traction * compliance[f],
                traction: zero * traction,
                hysteresis: if self.treated[f].is_some() {
                    hysteresis
                } else {
                    0.0
                },
            };
            let next = next_state(*state, &measure, &thresholds);
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
        changes
    }
}

/// How far a face is from its state, as a traction [Pa].
fn violation(state: ContactState, face: &FaceMeasure, compliance: f64) -> f64 {
    match state {
        ContactState::Open => -face.gap / compliance,
        _ => face
            .t_n
            .max((face.shear - face.limit).abs())
            .max(-face.advance / compliance),
    }
}

/// The largest traction, or the traction that would close the largest jump over the step [Pa].
pub(super) fn traction_scale(x: &Iterate, at: &Evaluation, compliance: &[f64]) -> f64 {
    let t = x.t.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    let gaps = at.jumps.iter().step_by(3).zip(compliance);
    gaps.fold(t, |m, (g, c)| m.max(g.abs() / c))
}
