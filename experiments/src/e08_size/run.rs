//! One run: mesh, set-up, solve, on so many threads.

use crate::measure::{LIMIT, TOLERANCE};
use anyhow::Context;
use fracas::contact::JumpStabilization;
use fracas::matrix_free::{MatrixFreeSystem, RacpParts};
use fracas::memory::{self, Work};
use fracas::scene::{Body, named};
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::Silent;
use fracas_solvers::amg::Amg;
use fracas_solvers::krylov::{Criteria, System};
use fracas_solvers::saddle::{InnerChoice, Iterated, Racp, SaddleMethod, SaddleOperator, T, U};
use std::time::Instant;

/// S̃_u⁻¹.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Inner {
    /// Without an assembled A.
    Geometric,
    /// From the assembled matrix.
    Algebraic,
}

impl Inner {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Geometric => "geometric",
            Self::Algebraic => "amg",
        }
    }

    fn memory(self) -> Work {
        match self {
            Self::Geometric => memory::MATRIX_FREE,
            Self::Algebraic => memory::BLOCKS,
        }
    }
}

/// What is run.
pub(super) struct Run {
    pub(super) scene: &'static str,
    pub(super) overrides: Vec<String>,
    pub(super) inner: Inner,
    pub(super) threads: usize,
}

/// What it took.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) n_u: usize,
    pub(super) n_t: usize,
    pub(super) krylov: String,
    /// n_it, where the true residual met the tolerance.
    pub(super) iterations: Option<usize>,
    /// Meshing and loads [s].
    pub(super) mesh: f64,
    /// Assembly, where there is one, C and S̃_u [s].
    pub(super) setup: f64,
    /// Iteration [s].
    pub(super) solve: f64,
    /// High-water mark over all of it [bytes].
    pub(super) memory: Option<u64>,
    /// Every bit of the solution, folded per 1024 entries.
    digest: Vec<u64>,
}

impl Row {
    pub(super) fn n(&self) -> usize {
        self.n_u + self.n_t
    }

    /// n_it for checks: infinite where it failed.
    pub(super) fn count(&self) -> f64 {
        self.iterations.map_or(f64::INFINITY, |n| n as f64)
    }

    /// Set-up and solve over the number of unknowns [s].
    pub(super) fn per_unknown(&self) -> f64 {
        (self.setup + self.solve) / self.n() as f64
    }

    /// Groups of 1024 entries whose bits differ.
    pub(super) fn differences(&self, other: &Self) -> usize {
        let pairs = self.digest.iter().zip(&other.digest);
        pairs.filter(|(a, b)| a != b).count() + self.digest.len().abs_diff(other.digest.len())
    }
}

/// FNV-1a over the bits of every 1024 entries.
fn digest(x: &[f64]) -> Vec<u64> {
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    x.chunks(1024)
        .map(|part| {
            part.iter()
                .fold(BASIS, |hash, v| (hash ^ v.to_bits()).wrapping_mul(PRIME))
        })
        .collect()
}

/// A system that is ready, in whichever form.
struct Equations<'a> {
    operator: &'a dyn LinearOperator<f64>,
    inverse: &'a dyn Preconditioner<f64>,
    b: &'a [f64],
    symmetric: bool,
}

impl Run {
    pub(super) fn is(&self, inner: Inner, threads: usize) -> bool {
        self.inner == inner && self.threads == threads
    }

    /// Runs on a pool of its own; the inner error says why it did not fit.
    pub(super) fn measure(&self) -> anyhow::Result<Result<Row, anyhow::Error>> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .build()?;
        let scene = named(self.scene).with_context(|| format!("no scene {}", self.scene))?;
        let scene = scene.scene()?.with_overrides(&self.overrides)?;
        if let Err(reason) = memory::room_for(self.scene, &scene, self.inner.memory()) {
            return Ok(Err(reason.into()));
        }
        pool.install(|| {
            memory::reset_peak();
            let start = Instant::now();
            let body = scene.build()?;
            let mesh = start.elapsed().as_secs_f64();
            match self.inner {
                Inner::Geometric => matrix_free(body, mesh).map(Ok),
                Inner::Algebraic => assembled(body, mesh).map(Ok),
            }
        })
    }
}

fn matrix_free(body: Body, mesh: f64) -> anyhow::Result<Row> {
    let start = Instant::now();
    let force = body.forces()?;
    let system = body.stick_system(Some(JumpStabilization::PUBLISHED));
    let saddle = MatrixFreeSystem::new(&system, None)?.saddle;
    let b = saddle.rhs(&system, &force);
    drop(force);
    let racp = Racp::geometric();
    let inverse = RacpParts::new(&racp, &saddle, &system, &mut Silent)?.inverse;
    let [n_u, n_t] = [U, T].map(|field| saddle.layout().length(field));
    drop(body);
    let setup = start.elapsed().as_secs_f64();
    let equations = Equations {
        operator: &saddle,
        inverse: &inverse,
        b: &b,
        symmetric: true,
    };
    equations.solve([n_u, n_t], mesh, setup)
}

fn assembled(body: Body, mesh: f64) -> anyhow::Result<Row> {
    let start = Instant::now();
    let blocks = body.saddle_blocks(Some(JumpStabilization::PUBLISHED))?;
    drop(body);
    let unit = blocks.traction_unit();
    let blocks = blocks.into_traction_unit(unit);
    let racp = SaddleMethod::Racp(Racp {
        inner: InnerChoice::Amg(Amg::default()),
        ..Racp::default()
    });
    let inverse = racp.ready(&blocks)?.inverse;
    let operator = SaddleOperator::new(&blocks);
    let b = blocks.rhs();
    let setup = start.elapsed().as_secs_f64();
    let equations = Equations {
        operator: &operator,
        inverse: &*inverse,
        b: &b,
        symmetric: false,
    };
    equations.solve([blocks.n_u(), blocks.n_t()], mesh, setup)
}

impl Equations<'_> {
    fn solve(&self, [n_u, n_t]: [usize; 2], mesh: f64, setup: f64) -> anyhow::Result<Row> {
        let krylov = memory::krylov_that_fits(self.operator, self.inverse, self.symmetric)?.choice;
        let system = System {
            operator: self.operator,
            preconditioner: self.inverse,
            rhs: self.b,
        };
        let criteria = Criteria {
            relative_tolerance: TOLERANCE,
            max_iterations: LIMIT,
        };
        let mut x = vec![0.0; self.b.len()];
        let iterated = Iterated::new(&system, krylov, &criteria, &mut x, &mut Silent);
        Ok(Row {
            n_u,
            n_t,
            krylov: krylov.to_string(),
            iterations: iterated.iterations(),
            mesh,
            setup,
            solve: iterated.solve_s,
            memory: memory::peak_bytes(),
            digest: digest(&x),
        })
    }
}
