//! One method on one system: counts that do not depend on the machine, times that do, and the reason where it fails.

use crate::measure::TOLERANCE;
use crate::report::{Cell, Level};
use fracas::contact::JumpStabilization;
use fracas::matrix_free::{MatrixFreeSystem, RacpParts};
use fracas::memory;
use fracas::scene::{Body, Scene};
use fracas::solve::RightHandSide;
use fracas_operators::LinearOperator;
use fracas_solvers::krylov::{Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::saddle::{Cost, Iterated, Ready, SaddleBlocks, SaddleMethod, SaddleOperator};
use fracas_solvers::{Observer, Silent};
use std::fmt;
use std::time::Instant;

/// A body with every face in stick, and its blocks in a balanced unit of tractions.
pub struct Problem {
    /// The body.
    pub body: Body,
    /// 𝒜 and b.
    pub blocks: SaddleBlocks,
}

impl Problem {
    /// Meshes and assembles `scene`, with jump stabilization.
    ///
    /// # Errors
    /// As the scene.
    pub fn new(scene: &Scene) -> anyhow::Result<Self> {
        let body = scene.build()?;
        let blocks = body.saddle_blocks(Some(JumpStabilization::PUBLISHED))?;
        let unit = blocks.traction_unit();
        let blocks = blocks.into_traction_unit(unit);
        Ok(Self { body, blocks })
    }

    /// M⁻¹ from the assembled blocks; around geometric multigrid C, B and S̃_u come from the body.
    fn ready(&self, method: &SaddleMethod) -> anyhow::Result<Ready> {
        let Some(racp) = method.matrix_free() else {
            return Ok(method.ready(&self.blocks)?);
        };
        let system = self.body.stick_system(Some(JumpStabilization::PUBLISHED));
        let saddle = MatrixFreeSystem::new(&system, None)?.saddle;
        Ok(RacpParts::new(&racp, &saddle, &system, &mut Silent)?.into())
    }
}

/// A method with the iteration around it.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// In tables.
    pub name: &'static str,
    /// The preconditioner.
    pub method: SaddleMethod,
    /// The iteration that is asked for.
    pub krylov: KrylovChoice,
}

/// Right-hand sides of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// Of the scene.
    Physical,
    /// `b_i = sin(i)`, i = 1…n: every scale at once.
    Sine,
}

impl fmt::Display for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Physical => "load",
            Self::Sine => "sin(i)",
        })
    }
}

impl Load {
    /// b.
    pub fn of(self, blocks: &SaddleBlocks) -> Vec<f64> {
        match self {
            Self::Physical => blocks.rhs(),
            Self::Sine => RightHandSide::Sin.entries(blocks.rhs()),
        }
    }
}

/// What bounds a trial.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Most iterations.
    pub iterations: usize,
    /// Most products, preconditioner included: C_s at which an iteration is given up. A bound of time that does not
    /// depend on the machine.
    pub cost: f64,
}

impl Budget {
    /// Most iterations of a method whose M⁻¹ costs c_app products.
    pub fn most(self, c_app: f64) -> usize {
        // C_s = n_it (1 + c_app)
        let affordable = (self.cost / (1.0 + c_app)).min(1e9) as usize;
        self.iterations.min(affordable)
    }
}

/// What one method did with one right-hand side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trial {
    /// The iteration that ran, where one did: GMRES may have become FGMRES.
    pub krylov: Option<KrylovChoice>,
    /// n_it, where the true residual met the tolerance.
    pub iterations: Option<usize>,
    /// c_app, where there is a preconditioner.
    pub c_app: Option<f64>,
    /// `C_s = n_it (1 + c_app)`.
    pub cost: Option<f64>,
    /// Operator complexity of a multigrid hierarchy.
    pub complexity: Option<f64>,
    /// Set-up of the preconditioner [s].
    pub setup: Option<f64>,
    /// Iteration [s].
    pub solve: Option<f64>,
    /// High-water mark of the process over set-up and iteration, blocks included [bytes].
    pub memory: Option<u64>,
    /// Why there is no n_it.
    pub failure: Option<Failure>,
}

/// Why a method gave no solution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// In the table.
    pub word: &'static str,
    /// In full.
    pub reason: String,
}

impl Failure {
    fn new(word: &'static str, reason: impl ToString) -> Self {
        Self {
            word,
            reason: reason.to_string(),
        }
    }
}

impl Trial {
    /// A method that was not tried.
    pub fn not_run(reason: impl ToString) -> Self {
        Self {
            failure: Some(Failure::new("not tried", reason)),
            ..Self::default()
        }
    }

    /// The iteration that ran as a cell; the one that was asked for where none did.
    pub fn krylov_cell(&self, candidate: &Candidate) -> Cell {
        self.krylov.unwrap_or(candidate.krylov).to_string().into()
    }

    /// n_it for checks: infinite where the method failed.
    pub fn count(&self) -> f64 {
        self.iterations.map_or(f64::INFINITY, |n| n as f64)
    }

    /// C_s for checks: infinite where the method failed.
    pub fn cost_or_infinite(&self) -> f64 {
        self.cost.unwrap_or(f64::INFINITY)
    }

    /// `n_it, c_app, C_s, complexity, set-up [s], solve [s], memory [MiB], end`; clock and memory at paper level only, so that equal
    /// runs of the smoke level give equal bytes.
    pub fn cells(&self, level: Level) -> [Cell; 8] {
        // what was not tried did not fail
        let none = match self.setup {
            Some(_) => Cell::Failed,
            None => Cell::Missing,
        };
        let or_none = |value: Option<Cell>| value.unwrap_or_else(|| none.clone());
        let measured = |value: Option<f64>| match level {
            Level::Paper => value.into(),
            Level::Smoke => Cell::Missing,
        };
        let mebibytes = self.memory.map(|bytes| bytes as f64 / f64::from(1 << 20));
        [
            or_none(self.iterations.map(Cell::from)),
            self.c_app.into(),
            or_none(self.cost.map(Cell::from)),
            self.complexity.into(),
            measured(self.setup),
            measured(self.solve),
            measured(mebibytes),
            self.failure.as_ref().map_or("converged", |f| f.word).into(),
        ]
    }
}

/// Headings of [`Trial::cells`].
pub const HEADINGS: [&str; 8] = [
    "n_it",
    "c_app",
    "C_s",
    "complexity",
    "set-up [s]",
    "solve [s]",
    "memory [MiB]",
    "end",
];

/// Sets the method up once and iterates on the assembled 𝒜 for every load; what fails is a trial with its reason.
pub fn trials(
    problem: &Problem,
    candidate: &Candidate,
    loads: &[Load],
    budget: Budget,
    observer: &mut dyn Observer,
) -> Vec<Trial> {
    memory::reset_peak();
    let start = Instant::now();
    let blocks = &problem.blocks;
    let ready = problem.ready(&candidate.method);
    let setup = Some(start.elapsed().as_secs_f64());
    let Ready {
        inverse, hierarchy, ..
    } = match ready {
        Ok(ready) => ready,
        Err(error) => {
            let failed = Trial {
                setup,
                failure: Some(Failure::new("no set-up", error)),
                ..Trial::default()
            };
            return vec![failed; loads.len()];
        }
    };
    let operator = SaddleOperator::new(blocks);
    let c_app = Cost::new(&operator, inverse.as_ref()).c_app();
    let criteria = Criteria {
        relative_tolerance: TOLERANCE,
        max_iterations: budget.most(c_app),
    };
    let mut iterate = |load: &Load| {
        let rhs = load.of(blocks);
        let system = System {
            operator: &operator as &dyn LinearOperator<f64>,
            preconditioner: inverse.as_ref(),
            rhs: &rhs,
        };
        let mut x = vec![0.0; rhs.len()];
        let iterated = Iterated::new(&system, candidate.krylov, &criteria, &mut x, observer);
        Trial {
            krylov: Some(iterated.krylov),
            iterations: iterated.iterations(),
            c_app: Some(c_app),
            cost: iterated.c_s(),
            complexity: hierarchy.as_ref().map(|h| h.operator_complexity),
            setup,
            solve: Some(iterated.solve_s),
            memory: memory::peak_bytes(),
            failure: match iterated.result {
                Ok(report) => match report.outcome {
                    Outcome::Converged => None,
                    Outcome::IterationLimit => Some(given_up(&criteria, budget)),
                    Outcome::Stopped => Some(Failure::new("stopped", "stopped on request")),
                },
                Err(breakdown) => Some(Failure::new("breakdown", breakdown)),
            },
        }
    };
    loads.iter().map(&mut iterate).collect()
}

fn given_up(criteria: &Criteria, budget: Budget) -> Failure {
    let limit = criteria.max_iterations;
    if limit < budget.iterations {
        let reason = format!(
            "given up after {limit} iterations: C_s above {}",
            budget.cost
        );
        Failure::new("cost limit", reason)
    } else {
        Failure::new(
            "iteration limit",
            format!("not converged in {limit} iterations"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas::scene::named;
    use fracas_solvers::saddle::{BlockDiagonal, InnerChoice, Racp};

    fn problem(scene: &str) -> Problem {
        Problem::new(&named(scene).unwrap().small_scene().unwrap()).unwrap()
    }

    fn tried(scene: &str, method: SaddleMethod, budget: Budget) -> Trial {
        let candidate = Candidate {
            name: "",
            method,
            krylov: KrylovChoice::default(),
        };
        let loads = [Load::Physical];
        trials(&problem(scene), &candidate, &loads, budget, &mut Silent).remove(0)
    }

    #[test]
    fn cost_bounds_the_iterations_and_the_reason_says_so() {
        let most = Budget {
            iterations: 1000,
            cost: f64::INFINITY,
        };
        let free = tried("clamped", SaddleMethod::default(), most);
        let (n, c_s) = (free.iterations.unwrap(), free.cost.unwrap());
        assert!((c_s - n as f64 * (1.0 + free.c_app.unwrap())).abs() < 1e-9 * c_s);
        let enough = Budget {
            cost: 1.001 * c_s,
            ..most
        };
        assert_eq!(
            tried("clamped", SaddleMethod::default(), enough).iterations,
            Some(n)
        );
        let short = Budget {
            cost: 0.999 * c_s,
            ..most
        };
        let failed = tried("clamped", SaddleMethod::default(), short);
        assert_eq!(failed.iterations, None);
        assert!(failed.failure.unwrap().reason.contains("given up after"));
    }

    #[test]
    fn failed_and_not_tried_are_told_apart() {
        let budget = Budget {
            iterations: 1000,
            cost: f64::INFINITY,
        };
        // three blocks are held by fractures alone, and this method inverts A
        let method = SaddleMethod::BlockDiagonal(BlockDiagonal {
            inner: InnerChoice::default(),
            ..BlockDiagonal::default()
        });
        let failed = tried("analogue_a", method, budget);
        assert!(failed.failure.as_ref().unwrap().reason.contains("block A"));
        assert_eq!(failed.cells(Level::Smoke)[0], Cell::Failed);
        let not_run = Trial::not_run("too large");
        assert_eq!(not_run.cells(Level::Smoke)[0], Cell::Missing);
        assert_eq!(not_run.count(), f64::INFINITY);
    }

    #[test]
    fn a_method_made_from_the_body_solves_the_assembled_system() {
        let most = Budget {
            iterations: 100,
            cost: f64::INFINITY,
        };
        let trial = tried("clamped", SaddleMethod::Racp(Racp::geometric()), most);
        assert!(trial.iterations.is_some(), "{:?}", trial.failure);
        assert!(trial.complexity.is_some() && trial.cost.is_some());
    }
}
