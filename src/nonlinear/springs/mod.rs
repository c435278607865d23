//! The alternatives to Lagrange multipliers: springs in the faces, alone or around multipliers.
//!
//! | method | tractions | what it costs |
//! |---|---|---|
//! | penalty | `t = P(λ + κ g)`, λ those of the initial stress and of the start of the step | faces overlap and give by O(1/κ); `A + B κ Bᵀ` has a condition number O(κ) |
//! | augmented Lagrangian | the same, `λ ← t` until the overlap vanishes (Uzawa), κ larger where that is slow | one non-linear problem per update |
//!
//! P is the return to Coulomb's cone. One traction per face, as for multipliers, but no jump stabilization: springs leave
//! no traction without stiffness.

pub(super) mod law;
pub(super) mod linear;
mod newton;
mod operator;

use super::accuracy::Accuracy;
use super::active_set::{Log, Settled};
use super::judge::{or_closing, slip_violation};
use super::newton::{Attempt, Iterate};
use super::stability::{AtLimits, Holding, SOLVED};
use super::workspace::Resources;
use super::{ContactProblem, Failure, Prepared};
use crate::contact::ContactState;
use crate::scene::{AugmentedLagrangian, Method};
use fracas_solvers::saddle::Racp;
use fracas_solvers::{Observer, Step};
use law::Spring;
use linear::SpringLinear;
use newton::{Solution, Springs, newton};

/// Share of the error that an update may leave without stiffer springs. Unit: 1.
///
/// # Source
/// A. R. Conn, N. I. M. Gould, Ph. L. Toint, LANCELOT, Springer 1992, §3.4 (a quarter, and κ ten times as large).
const SHRINKS: f64 = 0.25;

/// Largest growth of κ within an attempt: springs beyond 1e6/ω lose digits of the tractions. Unit: 1.
const GROWN: f64 = 1e4;

/// Steps of a body whose faces are held by springs.
pub(super) struct SpringMethod {
    /// κ per face [Pa/m].
    stiffness: Vec<f64>,
    /// Updates of the multipliers; `None` for a penalty.
    max_updates: Option<usize>,
    linear: SpringLinear,
    pub(super) resources: Resources,
}

impl SpringMethod {
    /// What the scene asks for, `None` for Lagrange multipliers; the inner solver of the preconditioner is that of rock and
    /// springs.
    pub(super) fn new(problem: &ContactProblem<'_>, preconditioner: Racp) -> Option<Self> {
        let solver = problem.body().solver;
        let (factor, max_updates) = match solver.method {
            Method::Lagrange => return None,
            Method::Penalty(penalty) => (penalty.factor, None),
            Method::AugmentedLagrangian(AugmentedLagrangian {
                factor,
                max_updates,
            }) => (factor, Some(max_updates)),
        };
        let compliance = problem.compliance().iter();
        Some(Self {
            stiffness: compliance.map(|omega| factor / omega).collect(),
            max_updates,
            linear: SpringLinear::new(preconditioner, solver.max_krylov),
            resources: Resources::default(),
        })
    }

    /// A step begins, with the preconditioner that was kept for it.
    pub(super) fn begin_step(&mut self, prepared: Option<&Prepared>) {
        self.linear.begin_step(prepared);
    }

    /// A is another one: nothing that was made of it serves.
    pub(super) fn forget(&mut self) {
        self.linear.forget();
        self.resources.fallbacks.forget();
    }

    /// What the preconditioner that the next step finds was made for.
    pub(super) fn carried(&self) -> Option<Prepared> {
        self.linear.carried()
    }
}

/// Overlap or slip error `‖t − λ‖/κ` per face, over what a face in stick may have.
fn errors(attempt: &Attempt<'_>, faces: Springs<'_>, t: &[f64], traction: f64) -> Vec<f64> {
    let problem = attempt.problem;
    let zero = problem.body().solver.state_tolerance * traction;
    let error = |f: usize| {
        let d = |k: usize| t[3 * f + k] - faces.multiplier[3 * f + k];
        let error = d(0).abs().max(d(1).hypot(d(2))) / faces.stiffness[f];
        let may = zero * problem.compliance()[f];
        if error > may { error / may } else { 0.0 }
    };
    (0..problem.faces().len()).map(error).collect()
}

impl Holding for SpringMethod {
    fn settle(
        &mut self,
        attempt: &Attempt<'_>,
        mut states: Vec<ContactState>,
        Iterate { mut u, t, p, wells }: Iterate,
        log: &mut Log,
        observer: &mut dyn Observer,
    ) -> Result<Settled, Failure> {
        // a penalty counts the overlap from the unloaded body, slip from the start of the step
        let mut multiplier = match self.max_updates {
            None => attempt.start.t.clone(),
            Some(_) => t,
        };
        let mut traction = attempt.traction;
        let compliance = attempt.problem.compliance();
        let mut accuracy = Accuracy::of_springs(attempt);
        let mut stiffness = self.stiffness.clone();
        let (mut update, mut before) = (0, f64::INFINITY);
        loop {
            log.rounds += 1;
            let faces = Springs {
                stiffness: &stiffness,
                multiplier: &multiplier,
                keeps: 1.0,
            };
            let linear = (&mut self.linear, update);
            let Solution { at, error } = newton(
                attempt,
                faces,
                linear,
                (&states, &mut accuracy),
                &mut u,
                log,
                (&mut self.resources, observer),
            )?;
            states = at.states();
            let t = at.tractions();
            // iterates of stiff springs bear tractions of no scale
            traction = traction.max(at.largest_traction());
            let errors = match self.max_updates {
                None => Vec::new(),
                Some(_) => {
                    let largest = or_closing(traction, &at.jumps, compliance);
                    errors(attempt, faces, &t, largest)
                }
            };
            let wrong: Vec<usize> = (0..errors.len()).filter(|f| errors[*f] > 0.0).collect();
            let step = Step::Round {
                round: update + 1,
                changed: wrong.len(),
            };
            if observer.observe(&step).is_break() {
                return Err(Failure::Stopped);
            }
            if wrong.is_empty() {
                let scale = (traction, &at.jumps[..]);
                let slip_violation = slip_violation(attempt, &states, [&t, &at.jumps], scale);
                return Ok(Settled {
                    states,
                    x: Iterate { u, t, p, wells },
                    force: attempt.scale,
                    traction,
                    effective: at.jumps,
                    slip_violation,
                    size: accuracy.map_or(attempt.size, |accuracy| accuracy.size),
                    error,
                    unstable: None,
                    flow: None,
                    joined: Vec::new(),
                    released: Vec::new(),
                    torn: attempt.start.torn.clone(),
                    wells: Vec::new(),
                });
            }
            if self.max_updates.is_some_and(|most| update + 1 >= most) {
                return Err(Failure::ActiveSet {
                    rounds: update + 1,
                    faces: wrong,
                });
            }
            multiplier = t;
            update += 1;
            // κ ← 10 κ where an update leaves more than a quarter
            let largest = errors.iter().fold(0.0, |m: f64, e| m.max(*e));
            if largest > SHRINKS * before && stiffness[0] < GROWN * self.stiffness[0] {
                stiffness.iter_mut().for_each(|kappa| *kappa *= 10.0);
            }
            before = largest;
        }
    }

    fn at_limits<'a>(
        &'a mut self,
        attempt: &'a Attempt<'_>,
        (states, x): (&'a [ContactState], &Iterate),
    ) -> AtLimits<'a> {
        let problem = attempt.problem;
        let spring = |(f, state): (usize, &ContactState)| {
            let t = [0, 1, 2].map(|k| x.t[3 * f + k]);
            let friction = problem.friction_in(f, attempt.start);
            let slip = problem.so_far(f, attempt.start).slip();
            let by_normal = friction.by_normal(t[0], slip);
            Spring::at_limit(*state, self.stiffness[f], t, by_normal)
        };
        let springs: Vec<Spring> = states.iter().enumerate().map(spring).collect();
        let mut solved = vec![0.0; x.u.len()];
        Box::new(move |faces, drop, observer| {
            let (mut t, mut rhs) = (vec![0.0; 3 * springs.len()], vec![0.0; solved.len()]);
            for (face, drop) in faces.iter().zip(drop) {
                (0..2).for_each(|k| t[3 * face.face + 1 + k] = drop * face.direction[k]);
            }
            problem.add_forces(1.0, &t, &mut rhs);
            let done = self.linear.solve(
                problem,
                (&springs, &self.stiffness),
                &rhs,
                SOLVED,
                &mut solved,
                (&mut self.resources, &mut *observer),
            )?;
            match done.stopped {
                true => Err(Failure::Stopped),
                false => Ok(solved.clone()),
            }
        })
    }
}
