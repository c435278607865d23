//! Tractions where the active set does not settle: a convex problem per limit of friction, whose energy goes down.

use super::linear::Linear;
use super::newton::{Attempt, BACKTRACKS, DECREASE, Iterate, relative};
use super::record::count;
use super::springs::law::Spring;
use super::springs::linear::SpringLinear;
use super::turns::Turns;
use super::workspace::Resources;
use super::{Failure, LinearRecord};
use crate::contact::ContactState;
use fracas_operators::LinearOperator;
use fracas_operators::sparse::Csr;
use fracas_operators::vector::{axpy, dot, norm2};
use fracas_solvers::{Observer, Step};

/// Least c of a face, times `ω A_f`. Unit: 1.
const LOCAL: f64 = 0.25;

/// Stiffness, times κ, that Newton's matrix gives a direction without any: a block that every iterate lets go has one then.
/// The energy and its derivative do not know of it. Unit: 1.
const LOOSE_SPRING: f64 = 1e-6;

/// Newton steps at fixed limits and proximal point.
const STEPS: usize = 12;

/// Residual that they leave, relative to the one that they find; and to the scale of the attempt. Unit: 1.
const LEFT: (f64, f64) = (1e-2, 1e-7);

/// Largest relative residual of a linear solve. Unit: 1.
const FORCING: f64 = 1e-3;

/// Iterations from which limits take half of a change.
const DAMPED: usize = 20;

/// Proximal iterations towards a traction in Coulomb's cones:
/// ```text
/// t' = arg min Φ(t) + ½ ‖t − t_k‖²_{C−H}  over  t_N ≤ 0, ‖t_T‖ ≤ τ        Φ(t) = ½ tᵀ(S + H) t − bᵀt,  S = BᵀA⁻¹B
///    = P(t_k + C⁻¹(A_f g(u) − H t_k*))        u = arg min E(u) = ½ uᵀA u − fᵀu + Σ_f A_f (‖w‖² − ‖w − P w‖²)/(2κ)
/// C = A_f/κ per face, κ so soft that every row of C − H is dominated by its diagonal;   τ ← τ_L(t'_N, ‖g_T‖)
/// ```
/// E is convex with a continuous derivative `A u − f + B t'`, so that Newton's method with Armijo's rule lowers it from anywhere.
/// C ⪰ H makes `Φ(t') + ½ ‖t' − t_k‖²_{C−H} ≤ Φ(t_k)`: while the limits stay Φ goes down, steps go to nothing, and what is left
/// fixed is the one solution at these limits (Φ is convex). Whatever the limits, `Δg_T = ω'(w − t')` follows t', so that no face
/// gains energy by slip. The limits are those of the iterate before (a fixed point of problems with given limits).
///
/// # Source
/// R. T. Rockafellar, SIAM J. Control Optim. 14 (1976) 877–898 (proximal points); J. C. Simo, T. A. Laursen, Comput. Struct. 42
/// (1992) 97–116 (limits held within an update).
pub(super) struct Proximal<'s> {
    attempt: &'s Attempt<'s>,
    linear: SpringLinear,
    /// κ per face [Pa/m].
    stiffness: Vec<f64>,
    /// τ per face [Pa].
    limit: Vec<f64>,
    turns: Turns,
    iterations: usize,
}

impl<'s> Proximal<'s> {
    /// From these tractions, those outside the cones brought back.
    pub(super) fn new(attempt: &'s Attempt<'s>, linear: &Linear, x: &mut Iterate) -> Self {
        let problem = attempt.problem;
        let faces = problem.faces().len();
        let mut limit = vec![0.0; faces];
        for (f, t) in x.t.chunks_exact_mut(3).enumerate() {
            t[0] = t[0].min(0.0);
            let slip = attempt.start.slip[2 * f].hypot(attempt.start.slip[2 * f + 1]);
            limit[f] = limit_of(attempt, f, t[0], slip);
            let shear = t[1].hypot(t[2]);
            if shear > limit[f] {
                t[1..].iter_mut().for_each(|t| *t *= limit[f] / shear);
            }
        }
        Self {
            attempt,
            linear: SpringLinear::new(linear.settings(), problem.body().solver.max_krylov),
            stiffness: vec![0.0; faces],
            limit,
            turns: Turns::new(faces),
            iterations: 0,
        }
    }

    /// One iteration with this H; the states of its springs.
    pub(super) fn iterate(
        &mut self,
        h: Option<&Csr<f64>>,
        round: usize,
        x: &mut Iterate,
        records: &mut Vec<LinearRecord>,
        resources: &mut Resources,
        observer: &mut dyn Observer,
    ) -> Result<Vec<ContactState>, Failure> {
        let (attempt, problem) = (self.attempt, self.attempt.problem);
        self.soften(h);
        // λ = t − κ H t*/A_f
        let through = problem.let_through(h, &x.t, attempt.start);
        let kappa = |i: usize| self.stiffness[i / 3];
        let moved = x.t.iter().zip(&through).enumerate();
        let multiplier: Vec<f64> = moved.map(|(i, (t, g))| t - kappa(i) * g).collect();
        let springs =
            self.minimize(&multiplier, round, &mut x.u, records, (resources, observer))?;
        let jumps = problem.jumps(&x.u, attempt.load);
        let share = if self.iterations < DAMPED { 1.0 } else { 0.5 };
        for (f, spring) in springs.iter().enumerate() {
            x.t[3 * f..][..3].copy_from_slice(&spring.traction);
            // γ + (w − t')/κ
            let slip: [f64; 2] = std::array::from_fn(|k| {
                let i = 3 * f + 1 + k;
                let moved = jumps[i] - attempt.start.jump[i];
                let held = (multiplier[i] - spring.traction[1 + k]) / self.stiffness[f];
                attempt.start.slip[2 * f + k] + moved + held
            });
            let limit = match spring.state {
                ContactState::Open => 0.0,
                _ => limit_of(attempt, f, spring.traction[0], slip[0].hypot(slip[1])),
            };
            self.limit[f] += share * (limit - self.limit[f]);
        }
        self.iterations += 1;
        self.turns.see(springs.iter().map(|spring| spring.state));
        Ok(springs.iter().map(|s| s.state).collect())
    }

    /// [`Turns::torn`].
    pub(super) fn torn(&self) -> Vec<usize> {
        self.turns.torn(self.attempt)
    }

    /// `1/κ = max(¼ ω, Σ_j |H_ij|/A_f)` over the rows of a face.
    fn soften(&mut self, h: Option<&Csr<f64>>) {
        let problem = self.attempt.problem;
        let s = problem.saddle().unit();
        for (f, face) in problem.faces().iter().enumerate() {
            let row = |i: usize| -> f64 {
                let row = h.and_then(|h| h.matrix().outer_view(i));
                let sum: f64 = row.iter().flat_map(|r| r.data()).map(|v| v.abs()).sum();
                sum / (s * s * face.area)
            };
            let rows = (3 * f..3 * f + 3).map(row).fold(0.0, f64::max);
            self.stiffness[f] = 1.0 / rows.max(LOCAL * problem.compliance()[f]);
        }
    }

    /// `u ← arg min E(u)` by Newton's method with Armijo's rule.
    fn minimize(
        &mut self,
        multiplier: &[f64],
        round: usize,
        u: &mut [f64],
        records: &mut Vec<LinearRecord>,
        (resources, observer): (&mut Resources, &mut dyn Observer),
    ) -> Result<Vec<Spring>, Failure> {
        let attempt = self.attempt;
        let mut at = self.evaluate(multiplier, u);
        let first = norm2(&at.residual);
        let enough = (LEFT.0 * first).max(LEFT.1 * attempt.scale);
        let mut correction = vec![0.0; u.len()];
        for iteration in 0..STEPS {
            let size = norm2(&at.residual);
            let residual = relative(size, attempt.scale);
            if !residual.is_finite() {
                let what = "the residual";
                return Err(Failure::NotFinite { what });
            }
            if size <= enough {
                break;
            }
            let step = Step::Newton {
                iteration,
                residual,
            };
            if observer.observe(&step).is_break() {
                return Err(Failure::Stopped);
            }
            let forcing = FORCING.max(0.3 * enough / size).min(0.1);
            let solved = self.linear.solve(
                attempt.problem,
                (&at.springs, &self.stiffness),
                &at.residual,
                forcing,
                &mut correction,
                (resources, observer),
            )?;
            if solved.stopped {
                return Err(Failure::Stopped);
            }
            let states: Vec<ContactState> = at.springs.iter().map(|s| s.state).collect();
            let (from, mut length) = (u.to_vec(), 1.0);
            // φ(α) = E(u + α δ), φ'(0) = −r·δ
            let slope = -dot(&at.residual, &correction);
            for backtrack in 0..=2 * BACKTRACKS {
                u.copy_from_slice(&from);
                axpy(length, &correction, u);
                let new = self.evaluate(multiplier, u);
                let done = -dot(&new.residual, &correction) <= 0.0
                    || self.lowered(&at, &new, u, &from) <= DECREASE * length * slope
                    || backtrack == 2 * BACKTRACKS;
                if done {
                    at = new;
                    break;
                }
                length *= 0.5;
            }
            let record = attempt.record([round, iteration], count(&states), forcing, residual);
            records.push(record.solved(&solved, length));
        }
        Ok(at.springs)
    }

    /// `f − A u − B P(λ + κ g)` and the springs.
    fn evaluate(&self, multiplier: &[f64], u: &[f64]) -> Point {
        let (attempt, problem) = (self.attempt, self.attempt.problem);
        let jumps = problem.jumps(u, attempt.load);
        let mut trial = multiplier.to_vec();
        for (i, w) in trial.iter_mut().enumerate() {
            let from = if i % 3 == 0 {
                0.0
            } else {
                attempt.start.jump[i]
            };
            *w += self.stiffness[i / 3] * (jumps[i] - from);
        }
        let spring = |(f, w): (usize, &[f64])| {
            let w = [w[0], w[1], w[2]];
            Spring::projected(self.stiffness[f], w, self.limit[f], LOOSE_SPRING)
        };
        let springs: Vec<Spring> = trial.chunks_exact(3).enumerate().map(spring).collect();
        let t: Vec<f64> = springs.iter().flat_map(|s| s.traction).collect();
        let saddle = problem.saddle();
        let (a, b) = (saddle.stiffness(), saddle.coupling());
        let mut work = vec![0.0; a.work_len().max(b.work_len())];
        let mut internal = vec![0.0; u.len()];
        a.apply_add(1.0, u, &mut internal, &mut work);
        let mut residual = attempt.load.force.clone();
        axpy(-1.0, &internal, &mut residual);
        b.apply_add(-1.0 / saddle.unit(), &t, &mut residual, &mut work);
        Point {
            residual,
            internal,
            trial,
            springs,
        }
    }

    /// E there less E here.
    fn lowered(&self, here: &Point, there: &Point, u: &[f64], from: &[f64]) -> f64 {
        let force = &self.attempt.load.force;
        let mut change = 0.0;
        for (i, (to, from)) in u.iter().zip(from).enumerate() {
            let mean = 0.5 * (here.internal[i] + there.internal[i]);
            change += (mean - force[i]) * (to - from);
        }
        let faces = self.attempt.problem.faces().iter().zip(&self.stiffness);
        for (f, (face, kappa)) in faces.enumerate() {
            // e = (t·w − ½ t·t)/κ
            let e = |at: &Point| -> f64 {
                let (t, w) = (at.springs[f].traction, &at.trial[3 * f..][..3]);
                (0..3).map(|k| t[k] * (w[k] - 0.5 * t[k])).sum()
            };
            change += face.area * (e(there) - e(here)) / kappa;
        }
        change
    }
}

/// The equations at u.
struct Point {
    residual: Vec<f64>,
    internal: Vec<f64>,
    /// w [Pa].
    trial: Vec<f64>,
    springs: Vec<Spring>,
}

/// τ_L of a face [Pa].
fn limit_of(attempt: &Attempt<'_>, f: usize, t_n: f64, slip: f64) -> f64 {
    attempt
        .problem
        .friction_in(f, attempt.start)
        .limit(t_n, slip)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::nonlinear::{ContactProblem, Start};
    use crate::scene::named;
    use fracas_operators::random::signed;
    use fracas_solvers::Silent;

    /// Φ(t) = ½ uᵀA u − jᵀt + ½ t*ᵀH t*, u in equilibrium with t, j the jump of the loads.
    fn dual_energy(attempt: &Attempt<'_>, h: Option<&Csr<f64>>, x: &Iterate) -> f64 {
        let problem = attempt.problem;
        let a = problem.saddle().stiffness();
        let mut internal = vec![0.0; x.u.len()];
        a.apply_add(1.0, &x.u, &mut internal, &mut vec![0.0; a.work_len()]);
        let through = problem.let_through(h, &x.t, attempt.start);
        let mut phi = 0.5 * dot(&x.u, &internal) - dot(&attempt.load.jump, &x.t);
        for (i, (t, g)) in x.t.iter().zip(&through).enumerate() {
            phi += 0.5 * problem.faces()[i / 3].area * (t - attempt.start.t[i]) * g;
        }
        phi
    }

    #[test]
    fn while_limits_stay_the_dual_energy_goes_down_to_tractions_that_do_not_change() {
        let overrides: [&[&str]; 2] = [&[], &["fracture.0.at=1 m", "material.0.poisson=0.4"]];
        for (seed, overrides) in (0u64..).zip(overrides) {
            let scene = named("crossing").unwrap().small_scene().unwrap();
            let body = scene.with_overrides(overrides).unwrap().build().unwrap();
            let problem = ContactProblem::new(&body).unwrap();
            let faces = problem.faces().len();
            let load = problem.loads().at(0.0, 1.0);
            let start = Start {
                jump: vec![0.0; 3 * faces],
                slip: vec![0.0; 2 * faces],
                t: vec![0.0; 3 * faces],
                torn: Vec::new(),
            };
            let attempt = Attempt {
                problem: &problem,
                start: &start,
                load: &load,
                scale: norm2(&load.force),
                traction: 1e7,
                size: problem.saddle().layout().values(0.0),
                held: None,
                flow: None,
                step: 0,
                attempt: 0,
            };
            let random = |i: usize| 1e7 * signed(1000 * seed + i as u64);
            let mut x = Iterate {
                u: vec![0.0; body.constraints.free_len()],
                t: (0..3 * faces).map(random).collect(),
                p: Vec::new(),
            };
            let h = problem.stabilization(&vec![ContactState::Stick; faces]);
            let mut proximal = Proximal::new(&attempt, &Linear::new(&problem), &mut x);
            let limit: Vec<f64> = (0..faces)
                .map(|f| 4e6 * (1.0 + signed(77 + f as u64)))
                .collect();
            let (mut records, mut before) = (Vec::new(), f64::INFINITY);
            let mut changes = Vec::new();
            for round in 0..25 {
                proximal.limit.clone_from(&limit);
                let old = x.t.clone();
                proximal
                    .iterate(
                        h.as_ref(),
                        round,
                        &mut x,
                        &mut records,
                        &mut Resources::default(),
                        &mut Silent,
                    )
                    .unwrap();
                let moved = x.t.iter().zip(&old).map(|(a, b)| (a - b).abs());
                changes.push(moved.fold(0.0, f64::max));
                let phi = dual_energy(&attempt, h.as_ref(), &x);
                // u is in equilibrium up to 1e-7
                assert!(
                    phi <= before + 1e-6 * phi.abs(),
                    "seed {seed}, {round}: {phi} after {before}"
                );
                before = phi;
            }
            assert!(changes[0] > 1e6, "{changes:?}");
            assert!(changes[24] < 1e-4 * changes[0], "{changes:?}");
            let slips = (0..faces).filter(|f| {
                let shear = x.t[3 * f + 1].hypot(x.t[3 * f + 2]);
                shear >= limit[*f] * (1.0 - 1e-9)
            });
            assert!(slips.count() > 0, "nothing slips");
        }
    }
}
