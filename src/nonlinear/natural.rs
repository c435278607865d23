//! Newton on Coulomb's law of all faces at once, where rounds of fixed states do not settle.

use super::linear::Linear;
use super::newton::{Attempt, DECREASE, Iterate};
use super::record::count;
use super::springs::law::SpringLaw;
use super::{ContactProblem, Evaluation, Failure, LinearRecord, Load, Start};
use crate::contact::ContactState;
use crate::mesh::FractureFace;
use fracas_operators::sparse::Csr;
use fracas_solvers::{Observer, Step};

/// Largest residual of a linear solve, relative to its right-hand side. Unit: 1.
const FORCING: f64 = 1e-4;

/// The same relative to the loads: what is left is no equilibrium of the rock. Unit: 1.
const EQUILIBRIUM: f64 = 1e-6;

/// κ times the compliance of a face and of what H lets through it. Unit: 1.
const STIFFNESS: f64 = 10.0;

/// Halvings of a step that the line search tries.
const HALVINGS: usize = 12;

/// Steps in a row that lower nothing, after which the merit is taken to be at a minimum that is no solution.
const STUCK: usize = 3;

/// Share of the merit that a step takes off lest it creeps. Unit: 1.
const CREEP: f64 = 0.05;

/// Steps in a row that creep, after which the merit is taken to lead nowhere.
const CREEPING: usize = 10;

/// √m over `√(Σ_f A_f ‖t‖²/κ)` from which on rounds may finish. Unit: 1.
const CLOSE: f64 = 1e-5;

/// Relative residual that is rounding. Unit: 1.
const ROUNDING: f64 = 1e-12;

/// Steps at most.
const MOST: usize = 80;

/// Newton steps on the natural map with H held,
/// ```text
/// f − A u − B t = 0      t − P(t + κ (g(u) − H t*/A_f)) = 0        m(u, t) = Σ_f A_f ‖t − P(·)‖²/κ
/// ```
/// every face in the state of its trial traction. The first step, with closed faces in stick, is taken in full and meets equilibrium,
/// which is linear; the steps after it keep it and are halved until m falls (Armijo). Rounds of fixed states have no such measure: with steep friction beside rock of
/// strong contrast a face that slips alone may ask for tractions that no later round takes back.
///
/// # Source
/// P. Alart, A. Curnier, CMAME 92 (1991) 353–375 (the map); L. Qi, J. Sun, Math. Program. 58 (1993) 353–367 (semi-smooth Newton).
pub(super) struct Natural<'s> {
    attempt: &'s Attempt<'s>,
    /// κ per face [Pa/m].
    stiffness: Vec<f64>,
    /// States of the first step.
    held: Option<Vec<ContactState>>,
    correction: Vec<f64>,
    /// Steps in a row that lowered nothing.
    stuck: usize,
    /// Steps, and those in a row that lowered little.
    steps: usize,
    creeping: usize,
    /// Share of the friction of every face.
    share: f64,
    /// √m over that of the tractions.
    distance: f64,
    /// Relative residual that the last step began with.
    left: f64,
}

impl<'s> Natural<'s> {
    /// With this H and share of the friction of every face, the first step in the states `held` or in those of trial tractions.
    pub(super) fn new(
        attempt: &'s Attempt<'s>,
        h: Option<&Csr<f64>>,
        share: f64,
        held: Option<Vec<ContactState>>,
    ) -> Self {
        let problem = attempt.problem;
        let s = problem.saddle().unit();
        let stiffness = |(f, face): (usize, &FractureFace)| {
            let diagonal = |i: usize| h.and_then(|h| h.matrix().get(i, i)).copied();
            let let_through = (3 * f..3 * f + 3).filter_map(diagonal).sum::<f64>() / 3.0;
            STIFFNESS / (problem.compliance()[f] + let_through / (s * s * face.area))
        };
        let stiffness: Vec<f64> = problem.faces().iter().enumerate().map(stiffness).collect();
        Self {
            attempt,
            stiffness,
            held,
            correction: vec![0.0; problem.saddle().layout().len()],
            stuck: 0,
            steps: 0,
            creeping: 0,
            share,
            distance: f64::INFINITY,
            left: f64::INFINITY,
        }
    }

    /// True where m does not go down any more, or has not led to a solution.
    pub(super) fn is_over(&self) -> bool {
        self.stuck == STUCK || self.steps == MOST
    }

    /// True where m goes down slowly.
    pub(super) fn creeps(&self) -> bool {
        self.creeping >= CREEPING
    }

    /// True where the last step led to a solution, or nearly.
    pub(super) fn is_close(&self) -> bool {
        self.distance <= CLOSE
    }

    /// True where the last step began with no more than rounding in the equations: where no face bears anything m is rounding, too.
    pub(super) fn is_solved(&self) -> bool {
        self.left <= ROUNDING
    }

    /// True with the whole friction of every face.
    pub(super) fn is_whole(&self) -> bool {
        self.share == 1.0
    }

    /// One step with this H; the states by trial tractions there.
    pub(super) fn iterate(
        &mut self,
        h: Option<&Csr<f64>>,
        round: usize,
        x: &mut Iterate,
        records: &mut Vec<LinearRecord>,
        (linear, observer): (&mut Linear, &mut dyn Observer),
    ) -> Result<Vec<ContactState>, Failure> {
        let (attempt, problem) = (self.attempt, self.attempt.problem);
        let (here, residual) = self.begin(h, x)?;
        let step = Step::Newton {
            iteration: 0,
            residual,
        };
        if observer.observe(&step).is_break() {
            return Err(Failure::Stopped);
        }
        let forcing = forcing(residual);
        // J δ = −r
        let jacobian = problem.jacobian(&here.states, h, &here.at, false);
        let solved = linear.solve(
            problem,
            (&jacobian, &here.states),
            &here.at.residual,
            forcing,
            &mut self.correction,
            observer,
        )?;
        if solved.stopped {
            return Err(Failure::Stopped);
        }
        let (states, length) = self.descend(h, x, &here);
        self.left = residual;
        let faces = count(&here.states);
        let record = attempt.record([round, 0], faces, forcing, residual);
        records.push(record.solved(&solved, length));
        Ok(states)
    }

    fn at(&self, h: Option<&Csr<f64>>, x: &Iterate) -> NaturalPoint {
        let (attempt, with) = (self.attempt, (h, &self.stiffness[..], self.share));
        let at = [&x.u[..], &x.t];
        (attempt.problem).natural(with, at, attempt.start, attempt.load)
    }

    /// Where a step begins, and the relative residual there.
    fn begin(&mut self, h: Option<&Csr<f64>>, x: &Iterate) -> Result<(NaturalPoint, f64), Failure> {
        let here = match self.held.take() {
            Some(held) => NaturalPoint {
                at: self.attempt.evaluate(&held, h, x),
                states: held,
                merit: f64::INFINITY,
                size: 0.0,
            },
            None => self.at(h, x),
        };
        let residual = self.attempt.relative(&here.at);
        match residual.is_finite() {
            true => Ok((here, residual)),
            false => {
                let what = "the residual";
                Err(Failure::NotFinite { what })
            }
        }
    }

    /// As much of the correction as lowers m: the states by trial tractions there, and how much it is.
    fn descend(
        &mut self,
        h: Option<&Csr<f64>>,
        x: &mut Iterate,
        here: &NaturalPoint,
    ) -> (Vec<ContactState>, f64) {
        let layout = self.attempt.problem.saddle().layout();
        let (from, mut length) = (x.clone(), 1.0);
        let mut halvings = 0;
        let there = loop {
            x.step(&from, length, &layout, &self.correction);
            let there = self.at(h, x);
            let lowered = there.merit <= (1.0 - 2.0 * DECREASE * length) * here.merit;
            if lowered {
                self.stuck = 0;
                break there;
            }
            if halvings == HALVINGS {
                self.stuck += 1;
                break there;
            }
            halvings += 1;
            length *= 0.5;
        };
        self.steps += 1;
        self.creeping = match there.merit < (1.0 - CREEP) * here.merit {
            true => 0,
            false => self.creeping + 1,
        };
        self.distance = (there.merit / there.size).sqrt();
        (there.states, length)
    }
}

/// Accuracy of a linear system, by the relative residual of the equations. Unit: 1.
fn forcing(residual: f64) -> f64 {
    FORCING.min(EQUILIBRIUM / residual)
}

/// Where the natural map stands.
struct NaturalPoint {
    /// Of trial tractions.
    states: Vec<ContactState>,
    /// `Σ_f A_f ‖t − P(t + κ g)‖²/κ` [J].
    merit: f64,
    /// `Σ_f A_f ‖t‖²/κ` [J].
    size: f64,
    at: Evaluation,
}

impl ContactProblem<'_> {
    /// The equations of the natural map at (u, t) with κ = `stiffness` per face [Pa/m], every face in the state of its trial traction.
    fn natural(
        &self,
        (h, stiffness, share): (Option<&Csr<f64>>, &[f64], f64),
        [u, t]: [&[f64]; 2],
        start: &Start,
        load: &Load,
    ) -> NaturalPoint {
        let (mut states, mut merit, mut size) = (Vec::new(), 0.0, 0.0);
        let at = self.evaluate_rows(h, [u, t], start, load, |effective| {
            let row = |f: usize| {
                let (law, point) = self.face(f, t, effective, start);
                let spring = SpringLaw {
                    stiffness: stiffness[f],
                    multiplier: point.traction,
                    friction: law.friction.share(share),
                    keeps: 1.0,
                };
                let spring = spring.at(point.jump, point.start, None);
                let squares = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>();
                let weight = self.faces()[f].area / stiffness[f];
                let t = point.traction;
                merit += weight * squares(std::array::from_fn(|k| t[k] - spring.traction[k]));
                size += weight * squares(t);
                states.push(spring.state);
                spring.rows(&law, &point, stiffness[f])
            };
            ((0..self.faces().len()).map(row).collect(), None)
        });
        NaturalPoint {
            states,
            merit,
            size,
            at,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::contact::Friction;
    use crate::scene::Profile;
    use crate::scene::sample::{Sample, rock};
    use fracas_operators::LinearOperator;
    use fracas_operators::random::{Random, signed};
    use fracas_operators::vector::{axpy, norm2};
    use fracas_solvers::direct::{DirectChoice, Kind};
    use fracas_solvers::saddle::{T, U};

    fn crossing() -> Sample {
        Sample::crossing([8, 4, 8], [0.0; 2], 4.0)
    }

    /// `−J δ` is the change of the residual to second order wherever no face changes its state.
    #[test]
    fn the_jacobian_is_the_derivative_of_the_rows() {
        let body = crossing().body();
        let problem = ContactProblem::new(&body).unwrap();
        let faces = problem.faces().len();
        let (start, load) = (problem.at_rest(), problem.loads().at(0.0, 1.0));
        let h = problem.stabilization(&vec![ContactState::Stick; faces]);
        let kappa: Vec<f64> = problem.compliance().iter().map(|w| 3.0 / w).collect();
        let mut slips = 0;
        for seed in 0..5u64 {
            let random = |i: usize, scale: f64| scale * signed(1000 * seed + i as u64);
            let u: Vec<f64> = (0..body.constraints.free_len())
                .map(|i| random(i, 1e-4))
                .collect();
            let t: Vec<f64> = (0..3 * faces).map(|i| random(i + 77, 1e7)).collect();
            let layout = problem.saddle().layout();
            let d: Vec<f64> = (0..layout.len())
                .map(|i| norm2(&u) * random(i + 7, 1e-7))
                .collect();
            let moved = |share: f64| {
                let ([d_u, d_t], mut u, mut t) = (layout.split([U, T], &d), u.clone(), t.clone());
                axpy(share, d_u, &mut u);
                axpy(share * layout.unit(T), d_t, &mut t);
                problem.natural((h.as_ref(), &kappa, 1.0), [&u, &t], &start, &load)
            };
            let (plus, here, minus) = (moved(1.0), moved(0.0), moved(-1.0));
            slips += count(&here.states)[2];
            let mut product = vec![0.0; d.len()];
            let j = problem.jacobian(&here.states, h.as_ref(), &here.at, false);
            j.apply_add(1.0, &d, &mut product, &mut vec![0.0; j.work_len()]);
            let [p_t] = layout.split([T], &product);
            let scale = p_t.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            for (f, state) in here.states.iter().enumerate() {
                if plus.states[f] != *state || minus.states[f] != *state {
                    continue;
                }
                for i in 3 * f..3 * f + 3 {
                    let of = |point: &NaturalPoint| layout.split([T], &point.at.residual)[0][i];
                    let difference = 0.5 * (of(&minus) - of(&plus));
                    let error = (difference - p_t[i]).abs() / scale;
                    assert!(error < 1e-5, "seed {seed}, face {f}, {state:?}: {error:e}");
                }
            }
        }
        assert!(slips > 5, "{slips}");
    }

    /// From any tractions, with friction that many faces cannot hold: m falls to a solution of Coulomb's law in equilibrium.
    #[test]
    fn the_merit_falls_to_tractions_of_the_law() {
        let random = &mut Random::new(5);
        for seed in 0u64..6 {
            let (angle, ratio) = (random.between(10.0, 70.0), random.scale(1e-3, 1e3));
            let mut sample = crossing();
            sample.rocks = vec![rock(10e9 * ratio)];
            let mut body = sample.body();
            body.friction[0] = Some(Profile::constant(Friction {
                angle: angle.to_radians(),
                ..Friction::NONE
            }));
            let problem = ContactProblem::new(&body).unwrap();
            let faces = problem.faces().len();
            let (start, load) = (problem.at_rest(), problem.loads().at(0.0, 1.0));
            let attempt = Attempt {
                problem: &problem,
                start: &start,
                load: &load,
                scale: norm2(&load.force),
                traction: 1e7,
                size: problem.saddle().layout().values(0.0),
                held: None,
                flow: None,
                holds: false,
                step: 0,
                attempt: 0,
            };
            let mut x = Iterate {
                u: vec![0.0; body.constraints.free_len()],
                t: (0..3 * faces)
                    .map(|i| 1e7 * signed(1000 * seed + i as u64))
                    .collect(),
                p: Vec::new(),
                wells: Vec::new(),
            };
            let stick = vec![ContactState::Stick; faces];
            let h = problem.stabilization(&stick);
            let mut natural = Natural::new(&attempt, h.as_ref(), 1.0, Some(stick));
            let mut distances = Vec::new();
            while !natural.is_over() && natural.distance > 1e-9 {
                let (here, residual) = natural.begin(h.as_ref(), &x).unwrap();
                // as far from J⁻¹(−r) as an iteration may leave it
                let mut rhs = here.at.residual.clone();
                let left: Vec<f64> = rhs.iter().map(|_| random.between(-1.0, 1.0)).collect();
                axpy(
                    forcing(residual) * norm2(&rhs) / norm2(&left),
                    &left,
                    &mut rhs,
                );
                let unit = problem.saddle().unit();
                let stick = problem.stick_blocks().unwrap().into_traction_unit(unit);
                let with = (&here.states[..], h.as_ref());
                let blocks = problem.linearized((stick, unit), with.0, with.1, &here.at, false);
                let j = blocks.assembled();
                let solver = DirectChoice::default().solver().unwrap();
                let factors = solver.analyze(&j, Kind::General).unwrap();
                let factors = factors.factor(&j).unwrap();
                let mut work = vec![0.0; factors.work_len()];
                factors.solve(&rhs, &mut natural.correction, &mut work);
                natural.descend(h.as_ref(), &mut x, &here);
                distances.push(natural.distance);
            }
            assert!(natural.is_close(), "seed {seed}: {distances:?}");
            let jumps = problem.jumps(&x.u, &load);
            let through = problem.let_through(h.as_ref(), &x.t, &start);
            let largest = x.t.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
            for f in 0..faces {
                let t = &x.t[3 * f..][..3];
                let gap = jumps[3 * f] - through[3 * f];
                let limit = problem.friction(f).limit(t[0], 0.0);
                let omega = problem.compliance()[f];
                assert!(t[0] < 1e-6 * largest && gap > -1e-6 * largest * omega);
                assert!(t[0] * gap > -1e-6 * largest * largest * omega);
                assert!(
                    t[1].hypot(t[2]) <= limit + 1e-6 * largest,
                    "seed {seed}, {f}"
                );
            }
            let at = attempt.evaluate(&vec![ContactState::Stick; faces], h.as_ref(), &x);
            let [r_u] = problem.saddle().layout().split([U], &at.residual);
            assert!(norm2(r_u) <= 1e-4 * attempt.scale);
        }
    }
}
