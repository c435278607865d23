//! A scene from its first step to its last, by one method, counted.

use crate::clock::{REPETITIONS, try_fastest};
use crate::report::{Cell, Level};
use fracas::nonlinear::{Accepted, Simulation};
use fracas::scene::{Body, Scene};
use fracas_solvers::{Observer, Silent, Step};
use std::ops::ControlFlow;

/// How contact is enforced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Way {
    /// Lagrange multipliers.
    Lagrange,
    /// Springs of this factor.
    Penalty(f64),
    /// Springs of this factor around multipliers.
    Augmented(f64),
}

impl Way {
    /// Plain name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Lagrange => "Lagrange multipliers",
            Self::Penalty(_) => "penalty",
            Self::Augmented(_) => "augmented Lagrangian",
        }
    }

    /// κω, if any.
    pub(super) fn factor(self) -> Option<f64> {
        match self {
            Self::Lagrange => None,
            Self::Penalty(factor) | Self::Augmented(factor) => Some(factor),
        }
    }

    /// As an override of a scene.
    pub(super) fn setting(self) -> String {
        match self {
            Self::Lagrange => "solver.method=lagrange".into(),
            Self::Penalty(k) => format!("solver.method={{ penalty = {{ factor = {k:e} }} }}"),
            Self::Augmented(k) => {
                format!("solver.method={{ augmented_lagrangian = {{ factor = {k:e} }} }}")
            }
        }
    }
}

/// Iterations of a step or of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Rounds of the active set, or updates of the multipliers.
    pub(super) rounds: usize,
    pub(super) newton: usize,
    pub(super) krylov: usize,
    pub(super) setups: usize,
    pub(super) cuts: usize,
    /// Newton steps and Krylov iterations with a symmetric Jacobian, and with an unsymmetric one.
    symmetric: (usize, usize),
    unsymmetric: (usize, usize),
}

impl Counts {
    fn add(&mut self, step: &Accepted) {
        self.rounds += step.record.active_it;
        self.newton += step.record.newton_it;
        self.krylov += step.record.lin_it;
        self.setups += step.record.setups;
        self.cuts += step.record.cuts;
        for solve in &step.linear {
            let (newton, krylov) = match solve.krylov {
                "gmres" | "fgmres" => &mut self.unsymmetric,
                _ => &mut self.symmetric,
            };
            *newton += 1;
            *krylov += solve.iterations;
        }
    }

    /// Of one step.
    pub(super) fn of(step: &Accepted) -> Self {
        let mut counts = Self::default();
        counts.add(step);
        counts
    }

    /// Of all steps.
    pub(super) fn total(steps: &[Accepted]) -> Self {
        let mut counts = Self::default();
        steps.iter().for_each(|step| counts.add(step));
        counts
    }

    /// Krylov iterations per Newton step with a symmetric and with an unsymmetric Jacobian.
    pub(super) fn per_newton(&self) -> [Option<f64>; 2] {
        [self.symmetric, self.unsymmetric]
            .map(|(newton, krylov)| (newton > 0).then(|| krylov as f64 / newton as f64))
    }

    /// Headings of [`Self::cells`].
    pub(super) const HEADINGS: [&'static str; 8] = [
        "n_it rounds",
        "n_it Newton",
        "n_it Krylov",
        "n_it per Newton step, symmetric J",
        "n_it per Newton step, unsymmetric J",
        "n_it set-ups",
        "n_it reuses",
        "cuts",
    ];

    pub(super) fn cells(&self) -> [Cell; 8] {
        let [symmetric, unsymmetric] = self.per_newton();
        [
            self.rounds.into(),
            self.newton.into(),
            self.krylov.into(),
            symmetric.into(),
            unsymmetric.into(),
            self.setups.into(),
            (self.newton - self.setups).into(),
            self.cuts.into(),
        ]
    }
}

/// A run to the end.
pub(super) struct Run {
    pub(super) body: Body,
    pub(super) steps: Vec<Accepted>,
    /// Processor time of one thread, steps and set-ups, without the mesh; the least of the repetitions [s].
    pub(super) seconds: f64,
}

impl Run {
    /// Runs `scene` on one thread; the reason where a step fails is a value.
    ///
    /// # Errors
    /// A scene that cannot be built or simulated, and an observer that stops.
    pub(super) fn of(
        scene: &Scene,
        observer: &mut dyn Observer,
    ) -> anyhow::Result<Result<Self, String>> {
        Self::repeated(1, scene, observer)
    }

    /// [`Self::of`], repeated for its time where the level prints one.
    ///
    /// # Errors
    /// Those of [`Self::of`].
    pub(super) fn timed(
        level: Level,
        scene: &Scene,
        observer: &mut dyn Observer,
    ) -> anyhow::Result<Result<Self, String>> {
        let repetitions = match level {
            Level::Smoke => 1,
            Level::Paper => REPETITIONS,
        };
        Self::repeated(repetitions, scene, observer)
    }

    fn repeated(
        repetitions: usize,
        scene: &Scene,
        observer: &mut dyn Observer,
    ) -> anyhow::Result<Result<Self, String>> {
        let body = scene.build()?;
        let step = Step::Progress {
            stage: "run",
            done: 0,
            total: 1,
        };
        if observer.observe(&step) == ControlFlow::Break(()) {
            anyhow::bail!("stopped on request");
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        match pool.install(|| try_fastest(repetitions, || steps(&body))) {
            Ok((steps, seconds)) => Ok(Ok(Self {
                body,
                steps,
                seconds,
            })),
            Err(Halt::Step(reason)) => Ok(Err(reason)),
            Err(Halt::Other(error)) => Err(error),
        }
    }
}

/// Why a run ends early.
enum Halt {
    /// A step failed after every halving.
    Step(String),
    Other(anyhow::Error),
}

/// All steps.
fn steps(body: &Body) -> Result<Vec<Accepted>, Halt> {
    let mut simulation = Simulation::new(body).map_err(|error| Halt::Other(error.into()))?;
    let mut steps = Vec::new();
    let end = simulation.run(&mut Silent, |_, _, done| steps.push(done.clone()));
    end.map_err(|failure| Halt::Step(failure.to_string()))?;
    Ok(steps)
}
