//! One system by rows over the ranks of `mpirun`: the iteration, the norms and the judge of errors are those of one memory.
//!
//! | file | what |
//! |---|---|
//! | `body` | rows of a scene, from the elements around the nodes of a rank |
//! | `blocks` | rows of a system folder |
//! | `strain` | the strain of a rank's elements, where displacements are prescribed |
//! | `times` | what a product, an M⁻¹ and a message take |

mod blocks;
mod body;
mod strain;
mod times;

use super::solver::{Equations, Names, Solver};
use super::{
    Finding, InnerRule, OverRanks, Problem, RightHandSide, Sizes, Solve, SolveError, Solved, Times,
};
use crate::memory;
use blocks::BlockRows;
use body::BodyRows;
use fracas_operators::Layout;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::Observer;
use fracas_solvers::distributed::{
    Contact, Nodes, Numbering, PartStrain, Ranks, SpreadSaddle, prepare, takes,
};
use fracas_solvers::petsc::Gamg;
use fracas_solvers::saddle::{InnerChoice, Racp, SaddleMethod, SaddleSystem, T, U};
use std::time::Instant;

/// Everything but A, on every rank.
struct Replicated {
    nodes: Nodes,
    contact: Contact,
    /// Right-hand side of the contact rows.
    rhs_t: Vec<f64>,
    /// Of the tractions.
    unit: f64,
    findings: Vec<Finding>,
}

/// Where rows of A come from.
enum Source {
    Body(BodyRows),
    Blocks(Box<BlockRows>),
}

impl Source {
    /// Part of every node.
    fn divided(&self, nodes: &Nodes, parts: usize) -> Result<Vec<u32>, SolveError> {
        match self {
            Self::Body(body) => body.divided(parts),
            Self::Blocks(blocks) => Ok(nodes.divided(blocks.a(), parts)?),
        }
    }

    /// The own rows of A with the columns of all, and of the right-hand side.
    fn rows(&self, numbering: &Numbering) -> Result<(SparseMatrix<f64>, Vec<f64>), SolveError> {
        match self {
            Self::Body(body) => body.rows(numbering),
            Self::Blocks(blocks) => Ok(blocks.rows(numbering)),
        }
    }

    fn strain(&self, saddle: &SpreadSaddle) -> Result<Option<PartStrain>, SolveError> {
        match self {
            Self::Body(body) => body.strain(saddle),
            Self::Blocks(_) => Ok(None),
        }
    }
}

impl Solve {
    /// As [`solve`](Solve::solve), by all ranks together: RACP around PETSc's S̃_u⁻¹, each rank with its rows. The solution is on the
    /// first rank; the others have all numbers of it and no entries.
    ///
    /// # Errors
    /// [`SolveError`], the same one on all ranks, whichever failed.
    pub fn solve_over(
        &self,
        ranks: Ranks,
        problem: &Problem,
        observer: &mut dyn Observer,
    ) -> Result<Solved, SolveError> {
        let agree = |result: Result<_, SolveError>| ranks.agree(result.map_err(|e| e.in_full()));
        let racp = agree(self.racp_over_ranks(problem))?;
        let start = Instant::now();
        let loaded = match problem {
            Problem::Body(stuck) => BodyRows::new(self, &racp, stuck, ranks, observer)
                .map(|(body, replicated)| (Source::Body(body), replicated)),
            _ => BlockRows::new(self, &racp, problem, observer)
                .map(|(blocks, replicated)| (Source::Blocks(blocks.into()), replicated)),
        };
        let (source, replicated) = ranks.agree(loaded.map_err(|e| e.in_full()))?;
        let Replicated {
            nodes,
            contact,
            rhs_t,
            unit,
            mut findings,
        } = replicated;
        let [n_u, n_t] = [contact.b.rows(), contact.b.cols()];
        observer.say(&Sizes::of(&Layout::new([(U, n_u), (T, n_t)])));
        let part = match ranks.is_first() {
            true => source.divided(&nodes, ranks.size()),
            false => Ok(vec![0; nodes.count]),
        };
        let mut part = ranks.agree(part.map_err(|e| e.in_full()))?;
        ranks.tell(&mut part);
        let numbering = Numbering::new(ranks, &nodes, &part, &contact.b);
        drop(part);
        let partition_s = start.elapsed().as_secs_f64();
        observer.say(&format_args!("assembling on {} ranks", ranks.size()));
        let start = Instant::now();
        let rows = source.rows(&numbering).map_err(|e| e.in_full());
        let (a, mut own) = ranks.agree(rows)?;
        own.extend(numbering.own_t().iter().map(|k| rhs_t[*k as usize]));
        let (rhs, b) = self.own_rhs(own, &numbering, observer);
        let assembly_s = start.elapsed().as_secs_f64();
        observer.say(&"setting up");
        let start = Instant::now();
        let (saddle, ready) = prepare(&racp, &nodes, numbering, a, contact)?;
        let strain = source.strain(&saddle).map_err(|e| e.in_full());
        let saddle = saddle.with_strain(ranks.agree(strain)?);
        drop((source, nodes));
        let setup_s = start.elapsed().as_secs_f64();
        let method = SaddleMethod::Racp(racp);
        let mut settings = Solve {
            explain: false,
            ..self.clone()
        };
        if settings.krylov.is_none() {
            let vectors = memory::vectors_beside(saddle.operator(), &*ready.inverse);
            // what there is is shared, and what the fullest rank has room for counts
            let vectors = -ranks.max(-(vectors as f64 / ranks.beside() as f64));
            let fitted = memory::krylov_of(vectors as usize, &*ready.inverse, true);
            let fitted = ranks.agree(fitted)?;
            findings.extend(fitted.reason.map(|reason| Finding::Krylov { reason }));
            settings.krylov = Some(fitted.choice);
        }
        let mut solver = Solver {
            settings,
            otherwise: Vec::new(),
            gives_way: false,
            problem: problem.clone(),
            names: Names::of(&method),
            double: None,
            method,
            equations: Equations::Spread(Box::new(saddle)),
            ready,
            rhs,
            b,
            unit,
            row_unit: 1.0,
            setup_s,
            findings,
            fallbacks: 0,
            replaced: 0,
        };
        let solved = solver.solve(observer).map_err(|e| e.in_full());
        let mut solved = ranks.agree(solved)?;
        let Equations::Spread(saddle) = &solver.equations else {
            unreachable!("as just made");
        };
        solved.x = saddle.numbering().whole(&solved.x);
        let peak = memory::peak_bytes().unwrap_or(0);
        let here = [solved.n_u as f64, saddle.ghosts().len() as f64, peak as f64];
        let all = ranks.gather(&here);
        let of = |k: usize| all.iter().skip(k).step_by(here.len());
        let counts = |k: usize| of(k).map(|n| *n as usize).collect();
        solved.engine = Some(OverRanks {
            name: "petsc",
            ranks: ranks.size(),
            n_u: counts(0),
            ghosts: counts(1),
            peak_memory_bytes: of(2).map(|n| *n as u64).collect(),
            partition_s,
            assembly_s,
            times: (self.explain)
                .then(|| Times::of(ranks, saddle.operator(), &*solver.ready.inverse)),
        });
        [solved.n_u, solved.n_t] = [n_u, n_t];
        Ok(solved)
    }

    /// RACP around what PETSc has over ranks; GAMG where nothing is asked for.
    fn racp_over_ranks(&self, problem: &Problem) -> Result<Racp, SolveError> {
        let not = |what, instead| Err(SolveError::NotOverRanks { what, instead });
        self.route(problem)?;
        let SaddleMethod::Racp(racp) = self.method else {
            return not(
                "this method",
                "take method = \"racp\", or leave the engine out",
            );
        };
        if matches!(problem, Problem::Body(_)) && !racp.augmentation.is_local() {
            return not(
                "a C that needs all of A",
                "take augmentation = \"fitted_h\" (or local, local_h, half_h, face_block)",
            );
        }
        let racp = match self.inner {
            InnerRule::Auto => Racp {
                inner: InnerChoice::Gamg(Gamg::default()),
                ..racp
            },
            _ => racp,
        };
        match takes(racp.inner) {
            true => Ok(racp),
            false => not(
                "this inner solver, which works in one memory",
                "take inner = \"gamg\" (or boomeramg, or mumps)",
            ),
        }
    }

    /// Own entries of the right-hand side that was asked for, by their numbers among all.
    fn own_rhs(
        &self,
        own: Vec<f64>,
        numbering: &Numbering,
        observer: &mut dyn Observer,
    ) -> (RightHandSide, Vec<f64>) {
        let mut nonzero = [own.iter().filter(|b| **b != 0.0).count() as f64];
        numbering.ranks().sum(&mut nonzero);
        let has_rhs = nonzero[0] > 0.0;
        let chosen = self.rhs.unwrap_or(match has_rhs {
            true => RightHandSide::System,
            false => RightHandSide::Sin,
        });
        if self.rhs.is_none() && !has_rhs {
            observer.say(&"the system has no right-hand side: taking b_i = sin(i), i = 1…n");
        }
        let own = match chosen {
            RightHandSide::System | RightHandSide::Given => own,
            other => numbering.own(&other.entries(vec![0.0; numbering.n_u() + numbering.n_t()])),
        };
        (chosen, own)
    }
}
