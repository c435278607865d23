//! The active set: states change until every face agrees with its own.

use super::accuracy::{Accuracy, Standing};
use super::cycling::Rounds;
use super::judge::{Judge, or_closing, slip_violation};
use super::linear::Linear;
use super::newton::{Attempt, Iterate, Until, newton, relative};
use super::proximal::Proximal;
use super::{Evaluation, Event, Failure, Instability, LinearRecord};
use crate::contact::ContactState;
use fracas_operators::sparse::Csr;
use fracas_operators::vector::norm2;
use fracas_solvers::{Observer, Step};

/// Residual up to which Newton is solved while states still change, and what then counts as zero. Unit: 1.
const LOOSE: f64 = 1e-4;

/// Newton steps that a round may take while states still change.
const LOOSE_STEPS: usize = 3;

/// Newton steps that a round may take while the limit of the iterate before stands for weakening.
const LAGGED_STEPS: usize = 60;

/// Rounds after which proximal iterations take over though no states have returned.
const PATIENCE: usize = 20;

/// Proximal iterations after which states that did not settle are tried again.
const AGAIN: usize = 10;

/// Traction that would close the widest jump, over the largest traction, beyond which a body is taken to fly away. Unit: 1.
const AWAY: f64 = 1e5;

/// Rounds with which an attempt to finish may do after proximal iterations.
const FINISHING: usize = 8;

/// What an attempt found.
pub(super) struct Settled {
    pub(super) states: Vec<ContactState>,
    pub(super) x: Iterate,
    /// Largest force and traction so far.
    pub(super) force: f64,
    pub(super) traction: f64,
    /// Jumps that the laws of the faces see, three per face [m].
    pub(super) effective: Vec<f64>,
    /// [`slip_violation`](super::judge::slip_violation()).
    pub(super) slip_violation: f64,
    /// Largest norms of u and t so far.
    pub(super) size: [f64; 2],
    /// Errors of u and t relative to them; NaN where only residuals are judged.
    pub(super) error: [f64; 2],
    /// What ran away on the way there.
    pub(super) unstable: Option<Box<Instability>>,
}

/// What an attempt costs and tells, also when it fails.
#[derive(Default)]
pub(super) struct Log {
    pub(super) rounds: usize,
    pub(super) linear: Vec<LinearRecord>,
    pub(super) events: Vec<Event>,
    /// States of the last round.
    pub(super) states: Vec<ContactState>,
    /// Faces that changed in the last round in which some did.
    pub(super) changing: Vec<usize>,
}

impl Log {
    /// A round failed: proximal iterations take over, or go on.
    fn failed(&mut self, round: usize, failure: &Failure) {
        self.events.push(Event::Projection {
            round: round + 1,
            reason: failure.to_string(),
        });
    }
}

/// Rounds of Newton and new states; where states return, still change after [`PATIENCE`] rounds, or Newton fails at those at
/// hand, proximal iterations towards tractions in Coulomb's cones, after whose states the rounds go on.
///
/// There H does not lose what it had: it acts on every jump that a state since then constrained. Rounds return where H of
/// a face that opens drops out of its neighbours' rows, so that it is in slight tension when closed and overlaps when open.
pub(super) fn active_set(
    attempt: &Attempt<'_>,
    states: Vec<ContactState>,
    mut x: Iterate,
    linear: &mut Linear,
    log: &mut Log,
    observer: &mut dyn Observer,
) -> Result<Settled, Failure> {
    let problem = attempt.problem;
    let most = problem.body().solver.max_active;
    let mut judge = Judge::new(attempt, states.len());
    let mut search = Search {
        attempt,
        judge: &mut judge,
        accuracy: Accuracy::new(attempt),
        linear,
        observer,
    };
    let from = x.clone();
    let patience = PATIENCE.min(most);
    let (mut form, why) = match search.rounds(states, &mut x, None, patience, log)? {
        Ended::Settled(found) => return Ok(search.settled(*found, x)),
        // linear equations that cannot be solved are no matter of states
        Ended::Not(_, Some(why)) if log.states.iter().all(|s| s.is_linear()) => return Err(why),
        Ended::Not(form, why) => (form, why),
    };
    // an iterate that Newton left is no better than the start
    if !x.u.iter().chain(&x.t).all(|v| v.is_finite()) {
        x = from;
    }
    let mut proximal = Proximal::new(attempt, search.linear, &mut x);
    let mut h = problem.stabilization(&form);
    let (mut before, mut tried, mut since) = (Vec::new(), Vec::new(), 0);
    let last = log.rounds + most - patience;
    while log.rounds < last {
        let round = log.rounds;
        log.rounds += 1;
        let found =
            proximal.iterate(h.as_ref(), round, &mut x, &mut log.linear, search.observer)?;
        let changed = count_changes(&found, &before);
        log.states.clone_from(&found);
        let step = Step::Round {
            round: round + 1,
            changed,
        };
        if search.observer.observe(&step).is_break() {
            return Err(Failure::Stopped);
        }
        let jumps = problem.jumps(&x.u, attempt.load);
        if or_closing(0.0, &jumps, problem.compliance()) > AWAY * search.judge.traction {
            break;
        }
        let grown = grow(&mut form, &found);
        if grown {
            h = problem.stabilization(&form);
        }
        since += 1;
        let again = changed == 0 && !grown && (found != tried || since >= AGAIN);
        before = found;
        if !again {
            continue;
        }
        tried.clone_from(&before);
        since = 0;
        let mut y = x.clone();
        let fixed = Some(h.as_ref());
        match search.rounds(before.clone(), &mut y, fixed, FINISHING, log)? {
            // H acts on all that these states constrain
            Ended::Settled(found) if !grow(&mut form, &found.states) => {
                return Ok(search.settled(*found, y));
            }
            Ended::Settled(..) => h = problem.stabilization(&form),
            Ended::Not(..) => {}
        }
    }
    Err(why.unwrap_or_else(|| Failure::ActiveSet {
        rounds: log.rounds,
        faces: log.changing.clone(),
    }))
}

/// Faces whose states differ; all where there was none before.
fn count_changes(states: &[ContactState], before: &[ContactState]) -> usize {
    match before.len() == states.len() {
        true => states.iter().zip(before).filter(|(a, b)| a != b).count(),
        false => states.len(),
    }
}

/// `form` then constrains what `states` constrain, too; true where it did not.
fn grow(form: &mut [ContactState], states: &[ContactState]) -> bool {
    let mut grown = false;
    for (form, state) in form.iter_mut().zip(states) {
        if state.constrained() > form.constrained() {
            *form = *state;
            grown = true;
        }
    }
    grown
}

/// How rounds ended.
enum Ended {
    /// No face changes.
    Settled(Box<Found>),
    /// Not settled: per face the state of those at hand, or of the rounds that returned, that constrains most; and what failed.
    Not(Vec<ContactState>, Option<Failure>),
}

/// States that no face changes, and the equations there.
struct Found {
    states: Vec<ContactState>,
    at: Evaluation,
    /// `None` where only residuals are judged.
    standing: Option<Standing>,
}

/// What rounds need.
struct Search<'a, 's> {
    attempt: &'s Attempt<'s>,
    judge: &'a mut Judge<'s>,
    accuracy: Option<Accuracy<'s>>,
    linear: &'a mut Linear,
    observer: &'a mut dyn Observer,
}

impl Search<'_, '_> {
    fn settled(&self, found: Found, x: Iterate) -> Settled {
        let Found {
            states,
            at,
            standing,
        } = found;
        let traction = self.judge.traction;
        let (size, error) = match standing {
            Some(Standing { size, judged }) => (size, judged.error),
            None => (self.attempt.size, [f64::NAN; 2]),
        };
        let slip_violation = slip_violation(self.attempt, &states, [&x.t, &at.effective], traction);
        Settled {
            states,
            x,
            force: self.attempt.scale,
            traction,
            effective: at.effective,
            slip_violation,
            size,
            error,
            unstable: None,
        }
    }

    /// At most `most` rounds, H that of the states or the given one.
    ///
    /// While states change, Newton takes at most three steps and stops at 1e-4, and only violations beyond that count; once no
    /// face changes it is solved, and the faces are judged, to the tolerances asked. Then the errors of u and t are judged, and
    /// Newton goes on until they are below the tolerance, too, or rounding leaves no more to gain.
    fn rounds(
        &mut self,
        mut states: Vec<ContactState>,
        x: &mut Iterate,
        fixed: Option<Option<&Csr<f64>>>,
        most: usize,
        log: &mut Log,
    ) -> Result<Ended, Failure> {
        let (attempt, problem) = (self.attempt, self.attempt.problem);
        let settings = problem.body().solver;
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
        // where the errors of u and t stood last
        let mut standing: Option<Standing> = None;
        let weakens = problem.weakens();
        let mut rounds = Rounds::default();
        let mut h = match fixed {
            None => problem.stabilization(&states),
            Some(_) => None,
        };
        let _ = rounds.enter(&states);
        if let Some(accuracy) = &mut self.accuracy {
            accuracy.begin();
        }
        // limits that proximal iterations found are those of the iterate before, too
        let mut until = match fixed.is_some() && weakens {
            true => lagging,
            false => loose,
        };
        for _ in 0..most {
            let round = log.rounds;
            log.rounds += 1;
            log.states.clone_from(&states);
            let solved = newton(
                attempt,
                (&states, fixed.unwrap_or(h.as_ref())),
                until,
                (self.linear, round),
                x,
                &mut log.linear,
                self.observer,
            );
            let (at, residual) = match solved {
                Ok(found) => found,
                // the residual has been small enough: what is left is rounding
                Err(Failure::Linear(_)) if standing.is_some() => {
                    let h = fixed.unwrap_or(h.as_ref());
                    let at =
                        problem.evaluate(&states, h, [&x.u, &x.t], attempt.start, attempt.load);
                    let residual = relative(norm2(&at.residual), attempt.scale);
                    (at, residual)
                }
                Err(failure) if failure.may_be_projected() => {
                    log.failed(round, &failure);
                    return Ok(Ended::Not(states, Some(failure)));
                }
                Err(failure) => return Err(failure),
            };
            let zero = match until == loose {
                true => settings.state_tolerance.max(LOOSE),
                false => settings.state_tolerance,
            };
            let changes = self.judge.changes(&states, x, &at, zero);
            let step = Step::Round {
                round: round + 1,
                changed: changes.len(),
            };
            if self.observer.observe(&step).is_break() {
                return Err(Failure::Stopped);
            }
            if changes.is_empty() {
                let converged = residual <= until.residual;
                let solved = converged && until != loose || standing.is_some();
                if solved {
                    let h = fixed.unwrap_or(h.as_ref());
                    let stands = (&states[..], h);
                    let last = match self.accurate(stands, (x, &at), &mut standing)? {
                        Some(step) if converged => step,
                        Some(_) | None => {
                            self.accepts(&standing, residual, log)?;
                            return Ok(Ended::Settled(Box::new(Found {
                                states,
                                at,
                                standing,
                            })));
                        }
                    };
                    until.residual = last * residual;
                    continue;
                }
                until = match converged {
                    true => tight,
                    false if until == tight && weakens => lagging,
                    false if until == loose && weakens => lagging,
                    false if until == loose => tight,
                    false => {
                        let failure = Failure::Newton {
                            residual,
                            iterations: until.steps,
                            tolerance: until.residual,
                        };
                        log.failed(round, &failure);
                        return Ok(Ended::Not(states, Some(failure)));
                    }
                };
                continue;
            }
            standing = None;
            if let Some(accuracy) = &mut self.accuracy {
                accuracy.other_states(x);
            }
            until = loose;
            // new-slip to slip leaves H as it is
            let other_h = |(f, state): &(usize, ContactState)| {
                state.constrained() != states[*f].constrained()
            };
            let other_h = changes.iter().any(other_h);
            for (f, state) in &changes {
                states[*f] = *state;
            }
            log.changing = changes.into_iter().map(|(f, _)| f).collect();
            if other_h && fixed.is_none() {
                h = problem.stabilization(&states);
            }
            if let Some(cycle) = rounds.enter(&states) {
                log.events.push(Event::Cycle {
                    round: round + 1,
                    period: cycle.period,
                    faces: cycle.faces,
                });
                return Ok(Ended::Not(cycle.most_constrained, None));
            }
        }
        Ok(Ended::Not(states, None))
    }

    /// By how much the residual is still to be lowered for errors below the tolerance; `None` where they are, or where rounding
    /// leaves no more to gain. `standing` is where they stand.
    fn accurate(
        &mut self,
        stands: (&[ContactState], Option<&Csr<f64>>),
        at: (&Iterate, &Evaluation),
        standing: &mut Option<Standing>,
    ) -> Result<Option<f64>, Failure> {
        let tolerance = self.attempt.problem.body().solver.tolerance;
        let Some(accuracy) = &mut self.accuracy else {
            return Ok(None);
        };
        let found = accuracy.of(stands, at, self.linear, self.observer)?;
        let judged = found.judged;
        *standing = Some(found);
        let enough = judged.worst() <= tolerance || judged.stands;
        Ok((!enough && judged.estimate.is_finite()).then(|| judged.step(tolerance)))
    }

    /// Errors that rounding leaves are told; beyond what states are judged by they are a failure.
    fn accepts(
        &self,
        standing: &Option<Standing>,
        residual: f64,
        log: &mut Log,
    ) -> Result<(), Failure> {
        let settings = self.attempt.problem.body().solver;
        let Some(Standing { judged, .. }) = standing else {
            return Ok(());
        };
        let (part, error) = (judged.part(), judged.worst());
        let most = settings.tolerance.max(settings.state_tolerance);
        if error <= most {
            if error > settings.tolerance {
                log.events.push(Event::Rounding { part, error });
            }
            return Ok(());
        }
        Err(Failure::Inaccurate {
            part,
            error,
            tolerance: most,
            residual,
        })
    }
}
