//! The linear systems of Newton: one preconditioner for as long as it serves.

use super::face_rules::FaceRule;
use super::jacobian::FaceTangent;
use super::state_inverse::StateInverse;
use super::{ContactJacobian, ContactProblem, LinearFailure, State};
use crate::contact::ContactState;
use crate::matrix_free::{MatrixFreeError, MatrixFreeRacp};
use crate::scene::RunInner;
use fracas_operators::Preconditioner;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Breakdown, Criteria, KrylovChoice, Outcome, Sqmr, System};
use fracas_solvers::saddle::{AugmentationChoice, AugmentationMatrix, InnerChoice, Racp};
use fracas_solvers::{Observer, Step};

/// Displacements up to which S_u is factorized when the scene does not choose. Unit: 1.
const FACTORIZED: usize = 5_000;

/// Iterations per digit, over those of the first all-stick system, from which a preconditioner of the present states is
/// wanted. Unit: 1.
const SLOW: f64 = 1.5;

/// What a preconditioner is built from.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunPreconditioner {
    /// RACP around an assembled A, which is given back once S̃_u is there.
    Assembled(Racp),
    /// RACP around geometric multigrid, nothing assembled.
    MatrixFree(MatrixFreeRacp),
}

/// A preconditioner and the states that it was built for.
struct Ready {
    states: Vec<ContactState>,
    inverse: StateInverse,
}

/// Solves Jacobians with RACP.
///
/// The preconditioner of the all-stick body, `M = [A B; Bᵀ −C]`, is built once for the whole run; slipping and open faces
/// have `ωA_f` on their diagonal, which is 0.5 to 1.4 times C, so that it serves them too. Where it takes more than 1.5 times
/// its iterations, one for the states at hand is built, at most once per step, and kept as long as it is nearer.
pub(super) struct Linear {
    settings: RunPreconditioner,
    max_krylov: usize,
    /// Diagonal of C for faces in stick.
    c: Vec<f64>,
    stick: Option<Ready>,
    present: Option<Ready>,
    /// Iterations per digit of the first all-stick system.
    reference: Option<f64>,
    slow: bool,
    /// States of a preconditioner that a restart has to build again.
    owed: Option<Vec<ContactState>>,
    /// A preconditioner for its states has been built in this step.
    built: bool,
    work: Vec<f64>,
}

/// A solved system.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved {
    pub(super) krylov: &'static str,
    /// Those with a preconditioner that was then dropped included.
    pub(super) iterations: usize,
    /// True, recomputed.
    pub(super) relative_residual: f64,
    /// The observer wants to stop.
    pub(super) stopped: bool,
    pub(super) setup: bool,
}

/// Relative residual up to which a system that rounding keeps from its tolerance is taken: Newton corrects it. Unit: 1.
pub(super) const USEFUL: f64 = 1e-2;

impl Linear {
    pub(super) fn new(problem: &ContactProblem<'_>) -> Self {
        Self {
            settings: chosen(problem),
            max_krylov: problem.body().solver.max_krylov,
            c: Vec::new(),
            stick: None,
            present: None,
            reference: None,
            slow: false,
            owed: None,
            built: false,
            work: Vec::new(),
        }
    }

    /// Settings in use.
    pub(super) fn settings(&self) -> RunPreconditioner {
        self.settings
    }

    /// A step begins. What is kept from the step before is what a restart from `state` can build again: a preconditioner
    /// for slip depends on the slip, one for stick and open faces on their states alone.
    pub(super) fn begin_step(&mut self, state: &State) {
        self.built = false;
        self.slow = false;
        self.reference = (state.krylov > 0.0).then_some(state.krylov);
        self.owed = None;
        let kept = self.present.as_ref().map(|ready| &ready.states);
        if kept != state.prepared.as_ref() {
            self.present = None;
            self.owed.clone_from(&state.prepared);
        }
    }

    /// What the next step finds: iterations per digit of the first system, and the states of the preconditioner to keep.
    pub(super) fn carried(&self) -> (f64, Option<Vec<ContactState>>) {
        let slips = |s: &ContactState| matches!(s, ContactState::NewSlip | ContactState::Slip);
        let present = self
            .present
            .as_ref()
            .map(|ready| &ready.states)
            .or(self.owed.as_ref());
        let kept = present.filter(|states| !states.iter().any(slips)).cloned();
        (self.reference.unwrap_or(0.0), kept)
    }

    /// `x ← J⁻¹ b` to a relative residual; short recurrences where J is symmetric.
    pub(super) fn solve(
        &mut self,
        problem: &ContactProblem<'_>,
        (jacobian, states): (&ContactJacobian<'_>, &[ContactState]),
        rhs: &[f64],
        tolerance: f64,
        x: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<Solved, LinearFailure> {
        let setup = self.prepare(problem, jacobian, states, observer)?;
        let far = |ready: &Option<Ready>| match ready {
            Some(ready) => distance(&ready.states, states),
            None => usize::MAX,
        };
        let nearest = match far(&self.present) < far(&self.stick) {
            true => &self.present,
            false => &self.stick,
        };
        let Some(Ready { inverse, .. }) = nearest else {
            unreachable!("prepared above");
        };
        let symmetric = jacobian.is_symmetric() && inverse.is_linear() && !inverse.is_single();
        let system = System {
            operator: jacobian,
            preconditioner: inverse,
            rhs,
        };
        let criteria = Criteria {
            relative_tolerance: tolerance,
            max_iterations: self.max_krylov,
        };
        let general = KrylovChoice::default().flexible_for(inverse as &dyn Preconditioner<f64>);
        let mut solve = |krylov: KrylovChoice, x: &mut [f64]| {
            let method = krylov.method::<f64>();
            let needed = method.work_len(&system, &criteria);
            if self.work.len() < needed {
                self.work.resize(needed, 0.0);
            }
            x.fill(0.0);
            method.solve_in(&system, &criteria, x, observer, &mut self.work[..needed])
        };
        let mut krylov = if symmetric {
            KrylovChoice::Sqmr(Sqmr {})
        } else {
            general
        };
        let mut outcome = solve(krylov, x);
        if symmetric && outcome.is_err() {
            // a short recurrence may end early where GMRES does not
            krylov = general;
            outcome = solve(krylov, x);
        }
        let krylov = krylov.name();
        let (iterations, relative_residual, stopped) = match outcome {
            Ok(report) if report.outcome == Outcome::IterationLimit => {
                return Err(LinearFailure::IterationLimit {
                    krylov,
                    iterations: report.iterations,
                    residual: report.relative_residual,
                    tolerance,
                });
            }
            Ok(report) => (
                report.iterations,
                report.relative_residual,
                report.outcome == Outcome::Stopped,
            ),
            Err(Breakdown::Stagnation {
                iteration,
                relative_residual,
                ..
            }) if relative_residual <= USEFUL => (iteration, relative_residual, false),
            Err(breakdown) => return Err(breakdown.into()),
        };
        let digits = -relative_residual.max(f64::EPSILON).log10();
        let rate = iterations as f64 / digits.max(1.0);
        let reference = *self.reference.get_or_insert(rate);
        self.slow = rate > SLOW * reference;
        Ok(Solved {
            krylov,
            iterations,
            relative_residual,
            stopped,
            setup,
        })
    }

    /// The preconditioner of the all-stick body at first; that of the present states when the last system was slow. True
    /// where one is built.
    fn prepare(
        &mut self,
        problem: &ContactProblem<'_>,
        jacobian: &ContactJacobian<'_>,
        states: &[ContactState],
        observer: &mut dyn Observer,
    ) -> Result<bool, LinearFailure> {
        let first = self.stick.is_none();
        if first {
            let all_stick = vec![ContactState::Stick; states.len()];
            let stick = FaceTangent::STICK;
            self.stick = Some(self.build(problem, &all_stick, |_| stick, observer)?);
        }
        if let Some(owed) = self.owed.take() {
            let tangent = |f: usize| match owed[f] {
                ContactState::Open => FaceTangent::open(problem.law_entry(f)),
                _ => FaceTangent::STICK,
            };
            self.present = Some(self.build(problem, &owed, tangent, observer)?);
        }
        let new = |ready: &Option<Ready>| ready.as_ref().is_none_or(|r| r.states != states);
        let wanted = self.slow && !self.built && new(&self.stick) && new(&self.present);
        if let (true, Some(faces)) = (wanted, &jacobian.faces) {
            // the memory of the one before is given back first
            self.present = None;
            self.present = Some(self.build(problem, states, |f| faces[f], observer)?);
            self.built = true;
            return Ok(true);
        }
        Ok(first)
    }

    /// C, S̃_u and the rules of the faces for these states.
    fn build(
        &mut self,
        problem: &ContactProblem<'_>,
        states: &[ContactState],
        tangent: impl Fn(usize) -> FaceTangent,
        observer: &mut dyn Observer,
    ) -> Result<Ready, LinearFailure> {
        let (unit, faces) = (problem.saddle().unit(), states.len());
        let rules = |c: &[f64]| -> Vec<FaceRule> {
            (0..faces)
                .map(|f| FaceRule::new(&tangent(f), [c[3 * f], c[3 * f + 1], c[3 * f + 2]]))
                .collect()
        };
        let blocks_of = |rules: &[FaceRule]| {
            AugmentationMatrix::from_face_blocks(rules.iter().map(|rule| rule.c).collect())
        };
        let mut stage = "preconditioner";
        let (rules, s_u): (Vec<FaceRule>, Box<dyn Preconditioner<f64>>) = match self.settings {
            RunPreconditioner::Assembled(racp) => {
                let direct = match racp.inner {
                    InnerChoice::Exact { backend } => backend,
                    _ => DirectChoice::default(),
                };
                let blocks = problem.stick_blocks()?.into_traction_unit(unit);
                if self.c.is_empty() {
                    let c = racp
                        .augmentation
                        .compute(&blocks, direct.solver()?.as_ref())?;
                    self.c = c.matrix.diagonal_entries();
                }
                let rules = rules(&self.c);
                let s_u = racp.inner.prepare(&blocks, &blocks_of(&rules)?)?.inverse;
                (rules, s_u)
            }
            RunPreconditioner::MatrixFree(racp) => {
                let system = problem.stick_system();
                if self.c.is_empty() {
                    let c = problem.saddle().augmentation(&system, racp.augmentation);
                    self.c = c.map_err(MatrixFreeError::from)?.matrix.diagonal_entries();
                }
                let rules = rules(&self.c);
                let in_pascal = blocks_of(&rules)?.scaled(1.0 / (unit * unit));
                let s_u = racp
                    .inner
                    .build(&system, &in_pascal)
                    .map_err(MatrixFreeError::from)?;
                if s_u.lost().is_some() {
                    stage = "preconditioner, in f64 because f32 would lose it";
                }
                (rules, Box::new(s_u))
            }
        };
        let step = Step::Progress {
            stage,
            done: 1,
            total: 1,
        };
        if observer.observe(&step).is_break() {
            return Err(MatrixFreeError::Stopped.into());
        }
        Ok(Ready {
            states: states.to_vec(),
            inverse: StateInverse::new(problem.saddle().coupling().clone(), rules, s_u),
        })
    }
}

/// Faces whose rows differ: slip and new-slip count as one.
fn distance(a: &[ContactState], b: &[ContactState]) -> usize {
    let differ = |(a, b): &(&ContactState, &ContactState)| a.constrained() != b.constrained();
    a.iter().zip(b).filter(differ).count()
}

/// The preconditioner that the scene asks for, or that its size suggests.
fn chosen(problem: &ContactProblem<'_>) -> RunPreconditioner {
    let body = problem.body();
    let assembled = |inner| {
        RunPreconditioner::Assembled(Racp {
            augmentation: AugmentationChoice::LocalH,
            inner,
        })
    };
    let amg = InnerChoice::Amg(Default::default());
    let small = body.constraints.free_len() <= FACTORIZED;
    match (body.solver.racp, body.solver.inner) {
        (Some(racp), _) => RunPreconditioner::Assembled(racp),
        (None, RunInner::Exact) => assembled(InnerChoice::default()),
        (None, RunInner::Auto) if small => assembled(InnerChoice::default()),
        (None, RunInner::Auto) if body.mesh.grid.is_none() => assembled(amg),
        (None, RunInner::Amg) => assembled(amg),
        (None, RunInner::Auto | RunInner::Geometric) => {
            RunPreconditioner::MatrixFree(MatrixFreeRacp::default())
        }
    }
}
