//! Rounds of Newton and new states until no face changes and the errors are small.

use super::accuracy::{Accuracy, Estimate};
use super::active_set::{Log, Settled};
use super::cycling::Rounds;
use super::judge::{Judge, slip_violation, slip_violations};
use super::linear::Linear;
use super::newton::{Attempt, Iterate, Until, newton};
use super::returning::Returning;
use super::{Evaluation, Event, Failure};
use crate::contact::ContactState;
use fracas_operators::sparse::Csr;
use fracas_solvers::saddle::Judged;
use fracas_solvers::{Observer, Step};

/// Steps of damped continuation that a round may take.
const LAGGED_STEPS: usize = 100;

/// Length of Newton steps below which the iterate is lost: 1e-7 and less where the volume of an almost singular system was far too large,
/// 1e-2 and more elsewhere. Unit: 1.
const LOST: f64 = 1e-6;

/// How rounds ended.
pub(super) enum Ended {
    /// No face changes.
    Settled(Box<Found>),
    /// Not settled: per face the state of those at hand, or of the rounds that returned, that constrains most; and what failed.
    Not(Vec<ContactState>, Option<Failure>),
}

/// States that no face changes, and the equations there.
pub(super) struct Found {
    pub(super) states: Vec<ContactState>,
    at: Evaluation,
    /// `None` where only residuals are judged.
    judged: Option<Judged>,
}

impl Found {
    /// Faces whose slip goes against their shear by more than tractions may be off.
    pub(super) fn against_shear(&self, search: &Search<'_, '_>, x: &Iterate) -> Vec<usize> {
        let attempt = search.attempt;
        let fields = [&x.t[..], &self.at.effective];
        let scale = (search.judge.traction, &self.at.jumps[..]);
        let violations = slip_violations(attempt, &self.states, fields, scale);
        let most = attempt.problem.body().solver.tolerance;
        (violations.filter(|(_, violation)| *violation > most))
            .map(|(f, _)| f)
            .collect()
    }
}

/// What rounds need.
pub(super) struct Search<'a, 's> {
    pub(super) attempt: &'s Attempt<'s>,
    pub(super) judge: &'a mut Judge<'s>,
    pub(super) accuracy: Option<Accuracy<'s>>,
    pub(super) linear: &'a mut Linear,
    /// Newton with the whole of weakening has failed in this attempt.
    pub(super) damped: bool,
    /// Faces that return beside a flow, and what is held of them.
    pub(super) returning: Returning,
    /// What rounding kept from the tolerance beside the last solution of the natural map.
    pub(super) rounding: Option<Failure>,
    pub(super) observer: &'a mut dyn Observer,
}

impl Search<'_, '_> {
    pub(super) fn settled(&self, found: Found, x: Iterate) -> Settled {
        let Found { states, at, judged } = found;
        let traction = self.judge.traction;
        let size = (self.accuracy.as_ref()).map_or(self.attempt.size, |accuracy| accuracy.size);
        let scale = (traction, &at.jumps[..]);
        let kept = self.returning.kept(self.attempt);
        let attempt = &kept.attempt(self.attempt);
        let slip_violation = slip_violation(attempt, &states, [&x.t, &at.effective], scale);
        Settled {
            states,
            x,
            force: self.attempt.scale.max(at.pushed),
            traction,
            effective: at.effective,
            slip_violation,
            size,
            error: judged.map_or(self.attempt.unjudged(), |judged| judged.error),
            unstable: None,
            flow: None,
            joined: self.returning.joined.clone(),
            released: Vec::new(),
            torn: attempt.start.torn.clone(),
            wells: Vec::new(),
        }
    }

    /// At most `most` rounds, H that of the states or the given one.
    ///
    /// Where states return beside a flow, or a face opens and closes over and over, what changes with them is held ([`Returning`]).
    ///
    /// While states change, Newton takes at most `loose_steps` steps and stops at `loose`, and only violations beyond that count; once no
    /// face changes it is solved, and the faces are judged, to the tolerances asked. Then the errors of u and t are judged, and
    /// Newton goes on until they are below the tolerance, too, or rounding leaves no more to gain.
    pub(super) fn rounds(
        &mut self,
        states: Vec<ContactState>,
        x: &mut Iterate,
        fixed: Option<Option<&Csr<f64>>>,
        most: usize,
        log: &mut Log,
    ) -> Result<Ended, Failure> {
        self.returning.begin();
        self.rounds_holding(states, x, fixed, most, log)
    }

    /// The same with what is held by now.
    fn rounds_holding(
        &mut self,
        mut states: Vec<ContactState>,
        x: &mut Iterate,
        fixed: Option<Option<&Csr<f64>>>,
        most: usize,
        log: &mut Log,
    ) -> Result<Ended, Failure> {
        let kept = self.returning.kept(self.attempt);
        let attempt = &kept.attempt(self.attempt);
        let cohesive = |f: usize| attempt.has_cohesion(f);
        let problem = attempt.problem;
        let settings = problem.body().solver;
        let allowed = settings.rounds.loose_steps.min(settings.max_newton);
        let mut loose = Until {
            residual: settings.tolerance.max(settings.rounds.loose),
            steps: attempt.loose_steps(allowed, self.returning.holds()),
            lagged: self.damped,
        };
        let tight = Until {
            residual: settings.tolerance,
            steps: attempt.tight_steps(settings.max_newton),
            lagged: false,
        };
        // times that it may go on where a round of Newton was cut short to look at the faces
        let mut more = settings.max_newton.div_ceil(tight.steps) - 1;
        // damped continuation converges by a factor a step
        let lagging = Until {
            steps: LAGGED_STEPS,
            lagged: true,
            ..tight
        };
        // where the errors of u and t stood last
        let mut judged: Option<Judged> = None;
        let weakens = problem.weakens();
        // where an iterate beside a flow is lost, Newton begins once more here
        let mut begin = attempt.flow.map(|_| x.clone());
        let mut rounds = Rounds::default();
        let mut h = match fixed {
            None => problem.stabilization(&self.returning.form(&states)),
            Some(_) => None,
        };
        let _ = rounds.enter(&states);
        if let Some(accuracy) = &mut self.accuracy {
            accuracy.begin();
            self.linear.other_states();
        }
        // weakening beside an H that is held
        let mut until = match fixed.is_some() && weakens {
            true => lagging,
            false => loose,
        };
        for done in 0..most {
            let round = log.rounds;
            log.rounds += 1;
            log.tries(attempt, &states);
            // what is linear is solved at once
            let least = match attempt.is_linear(&states) {
                true => settings.rounds.loose_steps.min(settings.max_newton),
                false => 0,
            };
            let first = log.linear.len();
            let solved = newton(
                attempt,
                (&states, fixed.unwrap_or(h.as_ref())),
                Until {
                    steps: until.steps.max(least),
                    ..until
                },
                (self.linear, round),
                x,
                &mut log.linear,
                self.observer,
            );
            let (at, residual) = match solved {
                Ok(found) => found,
                // the residual has been small enough: what is left is rounding
                Err(Failure::Linear(_)) if judged.is_some() => {
                    let h = fixed.unwrap_or(h.as_ref());
                    let at = attempt.evaluate(&states, h, x);
                    let residual = attempt.relative(&at);
                    (at, residual)
                }
                Err(failure) if failure.may_be_projected() => {
                    log.failed(round, &failure);
                    return Ok(Ended::Not(states, Some(failure)));
                }
                Err(failure) => return Err(failure),
            };
            let taken = log.linear.len() - first;
            let is_lost = log.linear.get(first).is_some_and(|l| l.step_length < LOST);
            if let Some(begin) = begin.take_if(|_| is_lost && residual > until.residual) {
                *x = begin;
                continue;
            }
            // linear equations that steps do not solve are not solved by other states, and where damped continuation has led is no
            // place to look at faces; rounding may leave a residual, not an error
            let is_final = attempt.is_linear(&states) || until == lagging;
            if residual > until.residual && is_final && judged.is_none() {
                let stands = (&states[..], fixed.unwrap_or(h.as_ref()));
                judged = match self.enough(attempt, stands, (x, &at, residual))? {
                    Ok(judged) => Some(judged),
                    Err(failure) => {
                        let failure = failure.unwrap_or(until.missed(residual, taken));
                        return Ok(unsolved(states, failure, (log, round)));
                    }
                };
            }
            let zero = match until == loose {
                true => settings.state_tolerance.max(settings.rounds.loose),
                false => settings.state_tolerance,
            };
            let changes = (self.judge).changes(attempt.start, &states, x, &at, zero);
            let mut changes = attempt.with_openings(&states, changes)?;
            self.returning
                .spare(attempt, &states, (x, &at), &mut changes);
            // new-slip to slip leaves the equations as they are
            let renamed = |(f, state): &(usize, ContactState)| {
                states[*f] == ContactState::NewSlip && *state == ContactState::Slip
            };
            if weakens && changes.iter().all(renamed) {
                for (f, state) in changes.drain(..) {
                    states[f] = state;
                }
            }
            let step = Step::Round {
                round: round + 1,
                changed: changes.len(),
            };
            if self.observer.observe(&step).is_break() {
                return Err(Failure::Stopped);
            }
            if changes.is_empty() {
                let converged = residual <= until.residual;
                let solved = converged && until != loose || judged.is_some();
                if solved {
                    let h = fixed.unwrap_or(h.as_ref());
                    let stands = (&states[..], h);
                    let errors = self.judged(attempt, stands, (x, &at))?;
                    judged = errors.map(|(judged, _)| judged);
                    let is_renewed = (self.accuracy.as_ref()).is_some_and(Accuracy::is_renewed);
                    let last = match errors.and_then(|(_, left)| left) {
                        Some(step) if converged || is_renewed => step,
                        Some(_) | None if !attempt.keeps_fluid(&at) => {
                            let failure = until.missed(residual, taken);
                            return Ok(unsolved(states, failure, (log, round)));
                        }
                        Some(_) | None => {
                            let blocked = match fixed {
                                None => self.judge.blocked(attempt.start, &states, x, &at),
                                Some(_) => Vec::new(),
                            };
                            if !blocked.is_empty() {
                                let mut form = self.returning.form(&states);
                                blocked.iter().for_each(|f| form[*f] = ContactState::Stick);
                                return Ok(Ended::Not(form, None));
                            }
                            if let (Some(accuracy), Some(judged)) = (&self.accuracy, judged) {
                                log.events.extend(accuracy.accepts(judged, residual)?);
                            }
                            let found = Found { states, at, judged };
                            return Ok(Ended::Settled(Box::new(found)));
                        }
                    };
                    // steps that rounding keeps from it are few
                    until = Until {
                        residual: last * residual,
                        steps: settings.rounds.loose_steps.min(settings.max_newton),
                        lagged: false,
                    };
                    continue;
                }
                until = match converged {
                    true if self.damped => lagging,
                    true => tight,
                    false if until == tight && more > 0 => {
                        more -= 1;
                        tight
                    }
                    false if (until == tight || until == loose) && weakens => {
                        self.damped = true;
                        loose.lagged = true;
                        lagging
                    }
                    false if until == loose => tight,
                    false => {
                        let stands = (&states[..], fixed.unwrap_or(h.as_ref()));
                        match self.enough(attempt, stands, (x, &at, residual))? {
                            Ok(enough) => judged = Some(enough),
                            Err(failure) => {
                                let failure = failure.unwrap_or(until.missed(residual, taken));
                                return Ok(unsolved(states, failure, (log, round)));
                            }
                        }
                        until
                    }
                };
                continue;
            }
            judged = None;
            if let Some(accuracy) = &mut self.accuracy {
                accuracy.first(x);
                accuracy.begin();
                self.linear.other_states();
            }
            until = loose;
            // new-slip to slip leaves H as it is
            let other_h = |(f, state): &(usize, ContactState)| {
                state.constrained() != states[*f].constrained()
            };
            let other_h = changes.iter().any(other_h);
            let held = attempt.flow.is_some() && self.returning.see(&states, &changes, cohesive);
            for (f, state) in &changes {
                states[*f] = *state;
            }
            log.changing = changes.into_iter().map(|(f, _)| f).collect();
            if held {
                return self.rounds_holding(states, x, fixed, most - done - 1, log);
            }
            if other_h && fixed.is_none() {
                h = problem.stabilization(&self.returning.form(&states));
            }
            if let Some(cycle) = rounds.enter(&states) {
                log.events.push(Event::Cycle {
                    round: round + 1,
                    period: cycle.period,
                    faces: cycle.faces.clone(),
                });
                let goes_on = match attempt.flow {
                    Some(_) => self.returning.entered(&cycle, cohesive),
                    None => fixed.is_none() && self.returning.freed(&cycle),
                };
                if goes_on {
                    return self.rounds_holding(states, x, fixed, most - done - 1, log);
                }
                return Ok(Ended::Not(cycle.most_constrained, None));
            }
        }
        Ok(Ended::Not(states, None))
    }

    /// The errors of an iterate whose residual steps do not lower, where they are small enough; else what is to be told of them, where
    /// they are judged.
    fn enough(
        &mut self,
        attempt: &Attempt<'_>,
        stands: (&[ContactState], Option<&Csr<f64>>),
        (x, at, residual): (&Iterate, &Evaluation, f64),
    ) -> Result<Result<Judged, Option<Failure>>, Failure> {
        if !attempt.keeps_fluid(at) {
            return Ok(Err(None));
        }
        let errors = self.judged(attempt, stands, (x, at))?;
        Ok(match (&self.accuracy, errors) {
            (Some(accuracy), Some((judged, _))) => match accuracy.accepts(judged, residual) {
                Ok(_) => Ok(judged),
                // a large residual is not one that rounding leaves
                Err(failure) => {
                    let rounding = self.attempt.problem.body().solver.rounds.loose;
                    let is_small = residual <= rounding || attempt.is_linear(stands.0);
                    Err(Some(failure).filter(|_| is_small))
                }
            },
            _ => Err(None),
        })
    }

    /// The errors of an iterate, and by how much the residual is still to be lowered; `None` where only residuals are judged.
    fn judged(
        &mut self,
        attempt: &Attempt<'_>,
        (states, h): (&[ContactState], Option<&Csr<f64>>),
        (x, at): (&Iterate, &Evaluation),
    ) -> Result<Option<(Judged, Option<f64>)>, Failure> {
        let Some(accuracy) = &mut self.accuracy else {
            return Ok(None);
        };
        let linear = &mut *self.linear;
        let (problem, observer) = (attempt.problem, &mut *self.observer);
        let judged = accuracy.of(x, at.residual.clone(), |residual, judged| {
            if attempt.flow.is_some() {
                return linear
                    .error_of_coupled(attempt, (states, h), (x, at), residual, observer)
                    .map(Estimate::from);
            }
            let jacobian = problem.jacobian(states, h, at, false);
            linear.error_of(problem, (&jacobian, states), residual, judged, observer)
        })?;
        Ok(Some((judged, accuracy.left(judged))))
    }
}

/// The equations at these states are not solved: another remedy takes over.
fn unsolved(states: Vec<ContactState>, failure: Failure, (log, round): (&mut Log, usize)) -> Ended {
    log.failed(round, &failure);
    Ended::Not(states, Some(failure))
}
