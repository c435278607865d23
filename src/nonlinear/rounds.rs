//! Rounds of Newton and new states until no face changes and the errors are small.

use super::accuracy::{Accuracy, Standing};
use super::active_set::{Log, Settled};
use super::cycling::Rounds;
use super::judge::{Judge, slip_violation};
use super::linear::Linear;
use super::newton::{Attempt, Iterate, Until, newton, relative};
use super::{Evaluation, Event, Failure};
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
    standing: Option<Standing>,
}

/// What rounds need.
pub(super) struct Search<'a, 's> {
    pub(super) attempt: &'s Attempt<'s>,
    pub(super) judge: &'a mut Judge<'s>,
    pub(super) accuracy: Option<Accuracy<'s>>,
    pub(super) linear: &'a mut Linear,
    pub(super) observer: &'a mut dyn Observer,
}

impl Search<'_, '_> {
    pub(super) fn settled(&self, found: Found, x: Iterate) -> Settled {
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
    pub(super) fn rounds(
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
            self.linear.smallest_ritz = None;
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
            // linear equations that steps do not solve are not solved by other states
            if residual > until.residual
                && states.iter().all(|s| s.is_linear())
                && standing.is_none()
            {
                let failure = Failure::Newton {
                    residual,
                    iterations: until.steps,
                    tolerance: until.residual,
                };
                log.failed(round, &failure);
                return Ok(Ended::Not(states, Some(failure)));
            }
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
                    // steps that rounding keeps from it are few
                    until = Until {
                        residual: last * residual,
                        steps: LOOSE_STEPS.min(settings.max_newton),
                        ..until
                    };
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
                self.linear.smallest_ritz = None;
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
