//! Newton's method for rock and springs: states follow the springs within it.

use super::law::{Spring, SpringLaw};
use super::linear::SpringLinear;
use crate::contact::ContactState;
use crate::nonlinear::accuracy::{Accuracy, Estimate};
use crate::nonlinear::active_set::Log;
use crate::nonlinear::damping::Damping;
use crate::nonlinear::newton::{Attempt, BACKTRACKS, DECREASE, Iterate, relative};
use crate::nonlinear::record::count;
use crate::nonlinear::turns::Turns;
use crate::nonlinear::workspace::Resources;
use crate::nonlinear::{Failure, LinearFailure, LinearRecord};
use fracas_operators::Fields;
use fracas_operators::vector::{axpy, norm2};
use fracas_solvers::saddle::Judged;
use fracas_solvers::{Observer, Step};

/// Steps that are taken in full where a face changes its state or reverses its slip.
const FULL: usize = 12;

/// Steps that errors take at most from one judgement to the next.
const EXTRA: usize = 4;

/// The same with [`Damping`], which converges by a factor a step.
const EXTRA_LAGGED: usize = 60;

/// Largest relative residual of a linear solve, and share of the asked residual for the last one. Unit: 1.
///
/// Stiff springs make false slip of small errors: with 1e-2 instead of 1e-4 springs of κω = 1e4 lose their way.
const FORCING: (f64, f64) = (1e-4, 0.3);

/// The equations `f − A u − B t(u) = 0` at a point.
pub(super) struct Evaluation {
    pub(super) residual: Vec<f64>,
    /// Mean jump (n, t1, t2) per face [m].
    pub(super) jumps: Vec<f64>,
    pub(super) springs: Vec<Spring>,
}

impl Evaluation {
    /// Tractions (t_N, t_1, t_2) per face [Pa].
    pub(super) fn tractions(&self) -> Vec<f64> {
        self.springs.iter().flat_map(|s| s.traction).collect()
    }

    /// (u, t) at these displacements.
    fn iterate(&self, u: &[f64]) -> Iterate {
        Iterate::new([u, &self.tractions(), &[]], None)
    }

    /// Pa.
    pub(super) fn largest_traction(&self) -> f64 {
        let t = self.springs.iter().flat_map(|s| s.traction);
        t.fold(0.0, |m: f64, t| m.max(t.abs()))
    }

    /// State per face.
    pub(super) fn states(&self) -> Vec<ContactState> {
        self.springs.iter().map(|s| s.state).collect()
    }
}

/// The last iterate that was judged.
struct Judgement {
    errors: Judged,
    residual: f64,
    u: Vec<f64>,
}

/// Where Newton ended.
pub(super) struct Solution {
    pub(super) at: Evaluation,
    /// Errors of u and t; NaN where only residuals are judged.
    pub(super) error: Fields<f64>,
}

/// Springs of stiffness κ per face [Pa/m] around multipliers, three per face [Pa].
#[derive(Clone, Copy)]
pub(super) struct Springs<'s> {
    pub(super) stiffness: &'s [f64],
    pub(super) multiplier: &'s [f64],
    /// Share of the derivative of weakening that their tangents keep. Unit: 1.
    pub(super) keeps: f64,
}

/// Back to the iterate that was judged last, with what is told of its errors.
fn back_to(
    judged: &Judgement,
    (attempt, faces): (&Attempt<'_>, Springs<'_>),
    accuracy: &Accuracy<'_>,
    u: &mut [f64],
    log: &mut Log,
) -> Result<Evaluation, Failure> {
    u.copy_from_slice(&judged.u);
    let told = accuracy.accepts(judged.errors, judged.residual)?;
    log.events.extend(told);
    Ok(evaluate(attempt, faces, u, &[]))
}

/// Forces and springs at displacements u, faces that stick or are open held so where `held` says it.
fn evaluate(
    attempt: &Attempt<'_>,
    faces: Springs<'_>,
    u: &[f64],
    held: &[Option<ContactState>],
) -> Evaluation {
    let problem = attempt.problem;
    let jumps = problem.jumps(u, attempt.load);
    let spring = |(f, g): (usize, &[f64])| {
        let from = [1, 2].map(|k| attempt.start.jump[3 * f + k]);
        let law = SpringLaw {
            stiffness: faces.stiffness[f],
            multiplier: std::array::from_fn(|k| faces.multiplier[3 * f + k]),
            friction: problem.friction_in(f, attempt.start),
            keeps: faces.keeps,
        };
        let held = held.get(f).copied().flatten();
        let so_far = problem.so_far(f, attempt.start);
        law.at([g[0], g[1] - from[0], g[2] - from[1]], so_far, held)
    };
    let springs = jumps.chunks_exact(3).enumerate().map(spring).collect();
    let mut at = Evaluation {
        residual: attempt.load.force.clone(),
        jumps,
        springs,
    };
    problem.subtract_stiffness(u, &mut at.residual);
    problem.add_forces(-1.0, &at.tractions(), &mut at.residual);
    at
}

/// Solves `A u + B t(u) = f` from and to `u`.
///
/// `(A + B D Bᵀ) δ = r`, D the derivative of the tractions (semi-smooth Newton). The first step holds faces that stick or are
/// open in `states`. It and the next dozen where a face changes its state are taken in full, and a face that reversed its slip
/// is held in stick for the next one, as the active set would have it; after that, backtracking lowers ‖r‖. Where that fails
/// under weakening, steps are those of [`Damping`], taken in full. Below the tolerance the errors of u and t
/// are judged, and steps go on until they are below it, too, or rounding leaves no more to gain.
///
/// # Errors
/// [`Failure::Springs`] when `max_active` steps do not reach the tolerance, [`Failure::Torn`], [`Failure::Inaccurate`], and the
/// failures of linear systems.
pub(super) fn newton(
    attempt: &Attempt<'_>,
    mut faces: Springs<'_>,
    (linear, update): (&mut SpringLinear, usize),
    (states, accuracy): (&[ContactState], &mut Option<Accuracy<'_>>),
    u: &mut [f64],
    log: &mut Log,
    (resources, observer): (&mut Resources, &mut dyn Observer),
) -> Result<Solution, Failure> {
    let settings = attempt.problem.body().solver;
    let mut correction = vec![0.0; u.len()];
    let (mut at, mut before) = (evaluate(attempt, faces, u, &[]), f64::INFINITY);
    let mut held: Vec<Option<ContactState>> = states.iter().copied().map(Some).collect();
    let mut judged: Option<Judgement> = None;
    let (mut asked, mut since) = (settings.tolerance, 0);
    if let Some(accuracy) = accuracy {
        accuracy.begin();
    }
    let weakens = attempt.problem.weakens();
    let mut damping: Option<Damping> = None;
    let mut turns = Turns::new(states.len());
    for iteration in 0.. {
        log.tries(attempt, &at.states());
        turns.see(log.states.iter().copied());
        let torn = turns.torn(attempt);
        if !torn.is_empty() {
            return Err(Failure::Torn { faces: torn });
        }
        let size = norm2(&at.residual);
        let residual = relative(size, attempt.scale);
        if !residual.is_finite() {
            let what = "the residual";
            return Err(Failure::NotFinite { what });
        }
        since += 1;
        let most = if damping.is_some() {
            EXTRA_LAGGED
        } else {
            EXTRA
        };
        // steps that rounding stops are few
        let stops = since == most && residual <= settings.tolerance;
        if residual <= asked || stops && judged.is_some() {
            let Some(accuracy) = accuracy else { break };
            let (now, parts) = (at.iterate(u), (&at.springs[..], faces.stiffness));
            let errors = accuracy.of(&now, at.residual.clone(), |r, (norms, _)| {
                let told = (&mut *resources, &mut *observer as &mut dyn Observer);
                let found = linear.error_of(attempt.problem, parts, (r, norms), told);
                found.map(Estimate::from)
            })?;
            let mut now = Judgement {
                errors,
                residual,
                u: now.u,
            };
            let better = judged.take_if(|best| best.errors.worst() <= errors.worst());
            let left = match better {
                Some(best) => {
                    u.copy_from_slice(&best.u);
                    at = evaluate(attempt, faces, u, &[]);
                    now = best;
                    None
                }
                None => accuracy.left(errors),
            };
            let Judgement {
                errors, residual, ..
            } = now;
            judged = Some(now);
            match left {
                Some(step) => (asked, since) = (step * residual, 0),
                // a preconditioner of other springs says too little of the errors
                None if !accuracy.is_enough(errors)
                    && linear.renews(attempt.problem, (&at.springs, faces.stiffness)) =>
                {
                    accuracy.begin();
                    (judged, asked, since) = (None, settings.tolerance, 0);
                    continue;
                }
                None => {
                    log.events.extend(accuracy.accepts(errors, residual)?);
                    break;
                }
            }
        } else if residual > settings.tolerance {
            // steps that lead to other states are few, too
            if let (Some(accuracy), Some(last)) = (accuracy.as_mut(), judged.take()) {
                if accuracy.is_enough(last.errors) {
                    at = back_to(&last, (attempt, faces), accuracy, u, log)?;
                    judged = Some(last);
                    break;
                }
                accuracy.begin();
                asked = settings.tolerance;
            }
        }
        if iteration == settings.max_active {
            return Err(Failure::Springs {
                residual,
                iterations: iteration,
                tolerance: settings.tolerance,
            });
        }
        let step = Step::Newton {
            iteration,
            residual,
        };
        if observer.observe(&step).is_break() {
            return Err(Failure::Stopped);
        }
        let holds = held.iter().any(Option::is_some);
        if holds {
            at = evaluate(attempt, faces, u, &held);
        }
        let last = FORCING.1 * asked / residual;
        let forcing = (size / before).powi(2).min(FORCING.0).max(last);
        let solved = linear.solve(
            attempt.problem,
            (&at.springs, faces.stiffness),
            &at.residual,
            forcing,
            &mut correction,
            (resources, observer),
        );
        let record = attempt.record([update, iteration], count(&at.states()), forcing, residual);
        let solved = match (solved, accuracy.as_ref().zip(judged.as_ref())) {
            // the residual has been small enough: what is left is rounding
            (
                Err(LinearFailure::Breakdown(_) | LinearFailure::IterationLimit { .. }),
                Some((accuracy, last)),
            ) => {
                at = back_to(last, (attempt, faces), accuracy, u, log)?;
                break;
            }
            // an indefinite tangent
            (Err(LinearFailure::Breakdown(breakdown)), _) if weakens && damping.is_none() => {
                log.linear.push(LinearRecord {
                    iterations: breakdown.iteration(),
                    ..record
                });
                damping = Some(Damping::default());
                faces.keeps = 0.0;
                at = evaluate(attempt, faces, u, &[]);
                continue;
            }
            (solved, _) => solved?,
        };
        if solved.stopped {
            return Err(Failure::Stopped);
        }
        if let Some(damping) = &mut damping {
            let takes = damping.takes(&correction);
            faces.keeps = damping.share();
            if !takes {
                log.linear.push(record.solved(&solved, 0.0));
                at = evaluate(attempt, faces, u, &[]);
                continue;
            }
        }
        let (from, old_springs, mut length) = (u.to_vec(), std::mem::take(&mut at.springs), 1.0);
        let changed = |at: &Evaluation| {
            let mut pairs = at.springs.iter().zip(&old_springs);
            pairs.any(|(new, old)| new.state != old.state || new.reverses(old))
        };
        for backtrack in 0..=BACKTRACKS {
            u.copy_from_slice(&from);
            axpy(length, &correction, u);
            at = evaluate(attempt, faces, u, &[]);
            let lowered = norm2(&at.residual) <= (1.0 - DECREASE * length) * size;
            let full = holds || damping.is_some() || iteration < FULL && changed(&at);
            if lowered || full {
                break;
            }
            if backtrack == BACKTRACKS {
                if weakens && damping.is_none() {
                    damping = Some(Damping::default());
                    faces.keeps = 0.0;
                    at = evaluate(attempt, faces, u, &[]);
                }
                break;
            }
            length *= 0.5;
        }
        if changed(&at) {
            linear.other_springs();
        }
        let hold = |(new, old): (&Spring, &Spring)| {
            (iteration < FULL && new.reverses(old)).then_some(ContactState::Stick)
        };
        if let (0, Some(accuracy)) = (iteration, accuracy.as_mut()) {
            accuracy.first(&at.iterate(u));
        }
        held = at.springs.iter().zip(&old_springs).map(hold).collect();
        before = size;
        log.linear.push(record.solved(&solved, length));
    }
    Ok(Solution {
        at,
        error: judged.map_or(attempt.unjudged(), |last| last.errors.error),
    })
}
