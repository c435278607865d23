//! The linear systems of Newton: one preconditioner for as long as it serves.

use super::active_set::{Log, Settled, active_set};
use super::assembled::Assembled;
use super::jacobian::FaceTangent;
use super::kept::{Kept, Ready};
use super::krylov::{self, Asked, Solved};
use super::newton::{Attempt, Iterate};
use super::pressed::PressureSolver;
use super::stability::{AtLimits, Holding, SOLVED};
use super::state_c::{StickC, c_of};
use super::workspace::Resources;
use super::{
    ContactJacobian, ContactProblem, Failure, LinearFailure, NewtonSystem, Prepared, State,
    digits_of,
};
use crate::contact::ContactState;
use crate::matrix_free::MatrixFreeError;
use crate::scene::RunInner;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::krylov::{KrylovChoice, Sqmr, System, least};
use fracas_solvers::saddle::{Block, InnerChoice, Racp, RacpInverse, SaddleBlocks, T, U};
use fracas_solvers::{Observer, Step};

/// Jumps per face by which states differ from those of S̃_u where, with flow, one of their own is built. Unit: 1.
const FAR: f64 = 0.1;

/// Solves Jacobians with RACP.
///
/// The rows of the faces are taken in their present states; S̃_u is that of the all-stick body, built once for the whole run.
/// With `C ≈ λ` of the laws of slipping and open rows l the eigenvalues beside 1 are then those of `C (C + B_lᵀS_u⁻¹B_l)⁻¹`
/// for the S_u of the present states: few are small, so that it serves them too. Where it takes more than 1.3 times its
/// iterations, one for the states at hand is built and kept, also over steps, as long as it is nearer: once per step, and again where
/// what systems take beyond that has cost as many iterations as a set-up.
///
/// Without slip J is symmetric on the x that meet the laws of open faces, and RACP maps them into themselves: SQMR does.
pub(super) struct Linear {
    pub(super) settings: Racp,
    max_krylov: usize,
    c: StickC,
    pub(super) stick: Option<Ready>,
    /// That of some states, beside it.
    pub(super) present: Kept,
    /// Iterations per digit of the first all-stick system.
    pub(super) reference: Option<f64>,
    pub(super) slow: bool,
    /// Iterations beyond those that are not slow, since a preconditioner was last built in this step.
    pub(super) beyond: f64,
    /// Ritz value nearest to zero of the systems since states last changed: one of them alone may take too few iterations to
    /// see it.
    pub(super) smallest_ritz: Option<f64>,
    /// Smaller ones have been looked for.
    pub(super) probed: bool,
    /// So have those at jumps that are free since M was made.
    pub(super) looked: bool,
    /// A preconditioner for its states has been built in this step.
    built: bool,
    /// Preconditioners built.
    pub(super) builds: usize,
    /// One was built while errors were judged: the next system tells of it.
    pub(super) untold: bool,
    pub(super) resources: Resources,
    assembled: Assembled,
    /// With every face in stick, tractions in the balanced unit: what the systems of rock and flow are made of.
    pub(super) stick_blocks: Option<SaddleBlocks>,
    /// B, and S_p⁻¹, where something flows.
    pub(super) normal_coupling: Option<SparseMatrix<f64>>,
    pub(super) pressures: PressureSolver,
    /// Number of the system of a step to stop at, and that system.
    pub(super) wanted: Option<usize>,
    pub(super) found: Option<NewtonSystem>,
}

impl Linear {
    pub(super) fn new(problem: &ContactProblem<'_>) -> Self {
        Self {
            settings: problem.body().preconditioner(),
            max_krylov: problem.body().solver.max_krylov,
            c: StickC::default(),
            stick: None,
            present: Kept::default(),
            reference: None,
            slow: false,
            beyond: 0.0,
            smallest_ritz: None,
            probed: false,
            looked: false,
            built: false,
            builds: 0,
            untold: false,
            resources: Resources::default(),
            assembled: Assembled::default(),
            stick_blocks: None,
            normal_coupling: None,
            pressures: PressureSolver::default(),
            wanted: None,
            found: None,
        }
    }

    /// Settings in use.
    pub(super) fn settings(&self) -> Racp {
        self.settings
    }

    /// A step begins, with the preconditioner that `state` tells of.
    pub(super) fn begin_step(&mut self, state: &State) {
        self.built = false;
        self.slow = false;
        self.beyond = 0.0;
        self.reference = (state.krylov > 0.0).then_some(state.krylov);
        self.present.begin_step(state.prepared.as_ref());
    }

    /// A is another one: nothing that was made of it serves, and what gave way is tried again, as a restart does.
    pub(super) fn forget(&mut self, problem: &ContactProblem<'_>) {
        let mut resources = std::mem::take(&mut self.resources);
        resources.fallbacks.forget();
        let new = Self::new(problem);
        *self = Self {
            wanted: self.wanted,
            // an inner solver that got nowhere with one A does not with the next
            settings: [new.settings, self.settings][usize::from(resources.fallbacks.has_stalled())],
            resources,
            ..new
        };
    }

    /// Ritz value nearest to zero since states last changed.
    pub(super) fn smallest_ritz(&self) -> Option<f64> {
        self.smallest_ritz
    }

    /// Systems are those of other states from now on.
    pub(super) fn other_states(&mut self) {
        (self.smallest_ritz, self.probed, self.looked) = (None, false, false);
    }

    /// What the next step finds: iterations per digit of the first system, and what the preconditioner beside the all-stick
    /// one was built for.
    pub(super) fn carried(&self) -> (f64, Option<Prepared>) {
        (self.reference.unwrap_or(0.0), self.present.carried())
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
        let layout = problem.saddle().layout();
        let max_iterations = self.max_krylov;
        let at = (jacobian, states);
        let meet_laws = |x: &mut [f64]| {
            let open = |f: &usize| states[*f] == ContactState::Open;
            let ([x_t], [b_t]) = (layout.split_mut([T], x), layout.split([T], rhs));
            for f in (0..states.len()).filter(open) {
                for i in 3 * f..3 * f + 3 {
                    x_t[i] = -b_t[i] / problem.law_entry(f);
                }
            }
        };
        let solved = self.around(
            problem,
            at,
            observer,
            |inverse, gives_way, work, observer| {
                // laws of open faces are met at the start, and every iterate keeps them
                x.fill(0.0);
                if jacobian.is_symmetric() {
                    meet_laws(x);
                }
                let system = System {
                    operator: jacobian,
                    preconditioner: &inverse,
                    rhs,
                };
                let asked = Asked {
                    short: (jacobian.is_symmetric()).then_some(KrylovChoice::Sqmr(Sqmr {})),
                    tolerance,
                    max_iterations,
                    patience: None,
                    gives_way,
                };
                krylov::solve(&system, asked, x, observer, work)
            },
        );
        let solved = solved.or_else(|failure| self.factorize_contact(problem, at, rhs, x, failure));
        // GMRES keeps them to rounding
        if jacobian.is_symmetric() {
            meet_laws(x);
        }
        solved
    }

    /// Whether a preconditioner for the states at hand is worth its set-up.
    pub(super) fn judge_speed(&mut self, problem: &ContactProblem<'_>, solved: &Solved) {
        self.smallest_ritz = least([self.smallest_ritz, solved.smallest_ritz]);
        let digits = digits_of(solved.relative_residual).max(1.0);
        let iterations = solved.iterations as f64;
        let reference = *self.reference.get_or_insert(iterations / digits);
        let served = problem.body().solver.rounds.slow * reference * digits;
        self.slow = iterations > served;
        self.beyond += (iterations - served).max(0.0);
    }

    /// True where systems of rock and flow are factorized as a whole: the scene asks for a factorization.
    pub(super) fn is_direct(&self, problem: &ContactProblem<'_>) -> bool {
        let solver = &problem.body().solver;
        solver.racp.is_none() && solver.inner == RunInner::Exact
    }

    /// RACP around the S̃_u made for the states nearest to these.
    pub(super) fn inverse<'s>(
        &'s self,
        problem: &'s ContactProblem<'_>,
        jacobian: &'s ContactJacobian<'_>,
        states: &[ContactState],
    ) -> Result<RacpInverse<'s>, LinearFailure> {
        let Some(Ready { inverse: s_u, .. }) = self.nearest(states) else {
            unreachable!("prepared before");
        };
        let tangent = |f: usize| match &jacobian.faces {
            Some(faces) => faces[f],
            None => FaceTangent::STICK,
        };
        let rows = self.c.rows(tangent, jacobian.h)?;
        let b = problem.saddle().coupling().as_ref();
        let inverse = RacpInverse::with_parts(b, rows, s_u.as_ref());
        Ok(match jacobian.h {
            Some(h) => inverse.relaxed(Box::new(h), self.settings.relaxation),
            None => inverse,
        })
    }

    /// The preconditioner of the all-stick body at first; that of the present states when the last system was slow. True
    /// where one is built.
    pub(super) fn prepare(
        &mut self,
        problem: &ContactProblem<'_>,
        jacobian: &ContactJacobian<'_>,
        states: &[ContactState],
        observer: &mut dyn Observer,
    ) -> Result<bool, LinearFailure> {
        let faces = states.len();
        let first = self.stick.is_none();
        if first {
            self.prepare_stick(problem, observer)?;
        }
        if let Some(Prepared { states, c }) = self.present.pending.take() {
            self.present.ready = Some(self.build(problem, states, |_| c.clone(), observer)?);
        }
        if jacobian.faces.is_some() && self.c.lacks_free() {
            self.compute_free(problem)?;
        }
        // with flow an iteration costs two applications, and rounds lead through many states
        let flows = problem.balance().is_some();
        let costly = !flows && self.beyond >= problem.body().solver.rounds.rebuild;
        let far = |ready: &Option<Ready>| {
            let jumps = ready.as_ref().map(|ready| ready.distance(states));
            jumps.is_none_or(|jumps| jumps as f64 > FAR * faces as f64)
        };
        let slow = match flows {
            true => self.slow || far(&self.stick) && far(&self.present.ready),
            false => self.slow && (!self.built || costly),
        };
        // the tangents of slipping faces change beside states that stay
        let wanted = slow && (costly || self.is_of_others(states));
        let is_built = wanted && self.build_own(problem, jacobian, states, observer)?;
        Ok(std::mem::take(&mut self.untold) || first || is_built)
    }

    /// S̃_u for these states in the place of that for others; false with every face in stick.
    pub(super) fn build_own(
        &mut self,
        problem: &ContactProblem<'_>,
        jacobian: &ContactJacobian<'_>,
        states: &[ContactState],
        observer: &mut dyn Observer,
    ) -> Result<bool, LinearFailure> {
        let Some(tangents) = &jacobian.faces else {
            return Ok(false);
        };
        // the memory of the one before is given back first
        self.present.ready = None;
        let c = |c: &StickC| c_of(&c.rules(|f| tangents[f], jacobian.h));
        self.present.ready = Some(self.build(problem, states.to_vec(), c, observer)?);
        (self.built, self.beyond) = (true, 0.0);
        Ok(true)
    }

    /// C of H = 0, where the rule for C looks at single faces; else that of stick serves.
    fn compute_free(&mut self, problem: &ContactProblem<'_>) -> Result<(), LinearFailure> {
        let rule = self.settings.augmentation;
        if rule.is_local() {
            let unit = problem.saddle().unit();
            let free = problem.stick_system().augmentation(rule, unit, None);
            self.c
                .know_free(&free.map_err(MatrixFreeError::from)?.matrix);
        }
        Ok(())
    }

    /// S̃_u for C per face, which follows from that in stick.
    pub(super) fn build(
        &mut self,
        problem: &ContactProblem<'_>,
        states: Vec<ContactState>,
        c: impl Fn(&StickC) -> Vec<Block>,
        observer: &mut dyn Observer,
    ) -> Result<Ready, LinearFailure> {
        let (mut settings, served) = (self.settings, self.stick.is_some());
        let mut left = (self.resources.fallbacks.others(problem, settings)).into_iter();
        let (c, inverse, stage) = loop {
            match self.attempt(problem, settings, &c) {
                Ok(built) => break built,
                Err(failure) => {
                    let tried = (self.settings, served);
                    settings = (self.resources.fallbacks).instead(&mut left, tried, failure)?
                }
            }
        };
        if self.stick.is_none() {
            // a restart builds the all-stick one first, too: it decides the same
            self.settings = self.resources.fallbacks.effective(settings);
        }
        let step = Step::Progress {
            stage,
            done: 1,
            total: 1,
        };
        if observer.observe(&step).is_break() {
            return Err(MatrixFreeError::Stopped.into());
        }
        self.builds += 1;
        let of = Prepared { states, c };
        Ok(Ready { of, inverse })
    }

    /// C and S̃_u by these settings, and what is told of them.
    #[allow(clippy::type_complexity)]
    fn attempt(
        &mut self,
        problem: &ContactProblem<'_>,
        racp: Racp,
        c: &impl Fn(&StickC) -> Vec<Block>,
    ) -> Result<(Vec<Block>, Box<dyn Preconditioner<f64>>, &'static str), LinearFailure> {
        let unit = problem.saddle().unit();
        let before = self.resources.fallbacks.count;
        let (c, inverse): (_, Box<dyn Preconditioner<f64>>) = match racp.inner {
            InnerChoice::Geometric(geometric) => {
                let system = problem.stick_system();
                if self.c.is_empty() {
                    let c = problem.saddle().augmentation(&system, racp.augmentation);
                    self.c = StickC::new(c.map_err(MatrixFreeError::from)?.matrix);
                }
                let c = c(&self.c);
                let matrix = self.c.of_schur(self.stick.is_none(), &c)?;
                let in_pascal = matrix.scaled(1.0 / (unit * unit));
                let fallbacks = &mut self.resources.fallbacks;
                let s_u = fallbacks.build(problem, geometric, &in_pascal)?;
                (c, Box::new(s_u))
            }
            _ => {
                let blocks = problem.stick_blocks()?.into_traction_unit(unit);
                if self.c.is_empty() {
                    let direct = racp.inner.backend().solver()?;
                    let c = racp.augmentation.compute(&blocks, direct.as_ref())?;
                    self.c = StickC::new(c.matrix);
                }
                let c = c(&self.c);
                let matrix = self.c.of_schur(self.stick.is_none(), &c)?;
                let fallbacks = &mut self.resources.fallbacks;
                let inverse = self
                    .assembled
                    .build(racp.inner, &blocks, &matrix, fallbacks)?;
                (c, inverse)
            }
        };
        let stage = match self.resources.fallbacks.count > before {
            true => IN_DOUBLE,
            false => "preconditioner",
        };
        Ok((c, inverse, stage))
    }
}

impl Holding for Linear {
    fn settle(
        &mut self,
        attempt: &Attempt<'_>,
        states: Vec<ContactState>,
        x: Iterate,
        log: &mut Log,
        observer: &mut dyn Observer,
    ) -> Result<Settled, Failure> {
        active_set(attempt, states, x, self, log, observer)
    }

    fn at_limits<'a>(
        &'a mut self,
        attempt: &'a Attempt<'_>,
        (states, x): (&'a [ContactState], &Iterate),
    ) -> AtLimits<'a> {
        let problem = attempt.problem;
        let h = problem.stabilization(states);
        let point = [&x.u[..], &x.t];
        let at = problem.evaluate(states, h.as_ref(), point, attempt.start, attempt.load);
        let layout = problem.saddle().layout();
        let mut rhs = vec![0.0; layout.len()];
        let mut solved = vec![0.0; rhs.len()];
        Box::new(move |faces, drop, observer| {
            let jacobian = problem.jacobian(states, h.as_ref(), &at, true);
            rhs.fill(0.0);
            let [rhs_t] = layout.split_mut([T], &mut rhs);
            for (face, drop) in faces.iter().zip(drop) {
                let scale = layout.unit(T)
                    * problem.compliance()[face.face]
                    * problem.faces()[face.face].area;
                let row = 3 * face.face + 1;
                (0..2).for_each(|k| rhs_t[row + k] = scale * drop * face.direction[k]);
            }
            let at = (&jacobian, states);
            let done = self.solve(problem, at, &rhs, SOLVED, &mut solved, observer)?;
            match done.stopped {
                true => Err(Failure::Stopped),
                false => Ok(layout.split([U], &solved)[0].to_vec()),
            }
        })
    }
}

/// What is told of a preconditioner that gave way.
const IN_DOUBLE: &str = "preconditioner, in f64 because f32 would lose it";
