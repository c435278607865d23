//! The rows of the table: RACP, the published rivals and others.

use crate::published::{Row, Test};
use crate::trial::{Candidate, Load};
use fracas_solvers::fsai::Fsai;
use fracas_solvers::krylov::{KrylovChoice, Minres, Sqmr};
use fracas_solvers::saddle::{
    AugmentationChoice, BlockDiagonal, BlockTriangular, Direct, InnerChoice, Mcp, Racp,
    SaddleMethod, Simple,
};

/// The method of the project, and the classical form of its rival.
pub(super) const REFERENCE: &str = "RACP, AMG";
pub(super) const CLASSICAL: &str = "MCP, γ = 0, AMG";

/// RACP around geometric multigrid.
pub(super) const GEOMETRIC: &str = "RACP, geometric";

const AMG: fn() -> InnerChoice = || InnerChoice::Amg(Default::default());

/// Which published row stands beside a method.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Beside {
    Racp,
    McpAmg,
    McpFsai,
    Nothing,
}

impl Beside {
    /// `None`: no such row is published; `Some(None)`: the published row is a failure.
    pub(super) fn row(self, test: &Test) -> Option<Option<Row>> {
        match self {
            Self::Racp => Some(Some(test.racp)),
            Self::McpAmg => Some(test.mcp_amg),
            Self::McpFsai => Some(test.mcp_fsai),
            Self::Nothing => None,
        }
    }
}

/// A row of the table: a method, what is published of it, what it is tried on.
pub(super) struct Entry {
    pub(super) candidate: Candidate,
    pub(super) beside: Beside,
    pub(super) loads: &'static [Load],
    /// Tests; all where empty.
    pub(super) tests: &'static [&'static str],
}

const LOAD: &[Load] = &[Load::Physical];
const BOTH: &[Load] = &[Load::Physical, Load::Sine];

pub(super) fn entries() -> Vec<Entry> {
    let gmres = KrylovChoice::default();
    let entry = |name, method: SaddleMethod, krylov, beside, loads| Entry {
        candidate: Candidate {
            name,
            method,
            krylov,
        },
        beside,
        loads,
        tests: &[],
    };
    let relaxed = SaddleMethod::Racp(Racp {
        inner: AMG(),
        ..Racp::default()
    });
    let published = |augmentation| {
        SaddleMethod::Racp(Racp {
            augmentation,
            ..Racp::published(AMG())
        })
    };
    let mcp = |gamma_factor, inner| {
        SaddleMethod::Mcp(Mcp {
            gamma_factor,
            inner,
            ..Mcp::default()
        })
    };
    let fsai = InnerChoice::Fsai(Fsai::default());
    let local_h = published(AugmentationChoice::LocalH);
    let face_block = published(AugmentationChoice::FaceBlock);
    let diagonal = SaddleMethod::BlockDiagonal(BlockDiagonal {
        inner: AMG(),
        ..BlockDiagonal::default()
    });
    let augmented = SaddleMethod::BlockDiagonal(BlockDiagonal {
        augmentation: Some(AugmentationChoice::LocalH),
        inner: AMG(),
    });
    let triangular = SaddleMethod::BlockTriangular(BlockTriangular { inner: AMG() });
    let simple = SaddleMethod::Simple(Simple {
        inner: AMG(),
        ..Simple::default()
    });
    let (sqmr, minres) = (KrylovChoice::Sqmr(Sqmr {}), KrylovChoice::Minres(Minres {}));
    let direct = SaddleMethod::Direct(Direct::default());
    vec![
        entry(REFERENCE, relaxed, gmres, Beside::Racp, BOTH),
        entry(REFERENCE, relaxed, sqmr, Beside::Racp, BOTH),
        entry(
            "RACP as published, local_h, AMG",
            local_h,
            gmres,
            Beside::Racp,
            BOTH,
        ),
        Entry {
            candidate: Candidate {
                name: GEOMETRIC,
                method: SaddleMethod::Racp(Racp::geometric()),
                krylov: gmres,
            },
            beside: Beside::Racp,
            loads: BOTH,
            tests: &[],
        },
        entry(
            "RACP as published, face_block, AMG",
            face_block,
            gmres,
            Beside::Racp,
            LOAD,
        ),
        entry("MCP, AMG", mcp(1.0, AMG()), gmres, Beside::McpAmg, BOTH),
        entry("MCP, FSAI", mcp(1.0, fsai), gmres, Beside::McpFsai, BOTH),
        Entry {
            tests: &["A"],
            ..entry(CLASSICAL, mcp(0.0, AMG()), gmres, Beside::McpAmg, LOAD)
        },
        entry(
            "block diagonal, AMG",
            diagonal,
            minres,
            Beside::Nothing,
            LOAD,
        ),
        entry(
            "block diagonal on S_u, AMG",
            augmented,
            minres,
            Beside::Nothing,
            LOAD,
        ),
        entry(
            "block triangular, AMG",
            triangular,
            gmres,
            Beside::Nothing,
            LOAD,
        ),
        entry("SIMPLE, AMG", simple, gmres, Beside::Nothing, LOAD),
        entry("sparse LU", direct, gmres, Beside::Nothing, LOAD),
    ]
}
