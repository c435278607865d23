//! Why a solve took the iterations and the time that it took, in numbers and one sentence of advice.

mod advice;
mod domination;
mod outliers;

pub use domination::Domination;
pub use outliers::{Outlier, Place, Seen};

use crate::SetupError;
use crate::multigrid::Summary;
use crate::saddle::folder::rigid_motions;
use crate::saddle::{PartCost, REACH, SaddleBlocks, SaddleMethod};
use fracas_operators::Preconditioner;
use serde::Serialize;

/// A solve that is to be explained.
#[derive(Clone, Copy)]
pub struct Solved<'a> {
    /// 𝒜.
    pub blocks: &'a SaddleBlocks,
    /// Which M.
    pub method: &'a SaddleMethod,
    /// M⁻¹.
    pub preconditioner: &'a dyn Preconditioner<f64>,
    /// Levels of its multigrid.
    pub hierarchy: Option<&'a Summary>,
    /// What C and S̃_u cost.
    pub parts: Option<PartCost>,
    /// b.
    pub rhs: &'a [f64],
    /// Wall time of the whole set-up, in seconds.
    pub setup_s: f64,
    /// Wall time of the iterations, in seconds.
    pub solve_s: f64,
}

/// `C_ii / H_ii` that a method needs.
fn asked_of_c(method: &SaddleMethod) -> f64 {
    match method {
        // H ≤ 2 blkdiag H
        SaddleMethod::Racp(racp) if racp.relaxation > 0.0 => 2.0 / REACH,
        _ => 1.0,
    }
}

/// `‖A·r‖` for rigid-body motions r, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RigidBody {
    /// Rows where the three translations cost no force: no support is near.
    pub free_rows: usize,
    /// Rows that feel a support.
    pub held_rows: usize,
    /// Free rows where a rotation costs force: their coordinates do not fit A.
    pub wrong_rows: usize,
    /// Largest force of a rotation in a free row, relative to `Σ_j |a_ij| |x_j − x_i|`.
    pub worst: f64,
}

/// Where the time went.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeSplit {
    /// C, in seconds; null in a method other than RACP.
    pub c_s: Option<f64>,
    /// S̃_u, in seconds.
    pub inner_s: Option<f64>,
    /// The rest of the set-up, in seconds.
    pub other_setup_s: f64,
    /// Iterations, in seconds.
    pub iterations_s: f64,
}

/// What is known about one solve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// M⁻¹𝒜 on the Krylov space of M⁻¹b; null where M is no linear map.
    pub seen: Option<Seen>,
    /// Null without coordinates.
    pub rigid_body: Option<RigidBody>,
    /// C against H; null in a method without C, and without H.
    pub c_over_h: Option<Domination>,
    /// Levels of multigrid.
    pub amg_levels: Option<usize>,
    /// Its `Σ nnz / nnz` of the finest level.
    pub operator_complexity: Option<f64>,
    /// Flops of S̃_u⁻¹ / flops of M⁻¹; null in a method other than RACP.
    pub inner_share: Option<f64>,
    /// Where the time went.
    pub time: TimeSplit,
    /// One sentence, chosen by rule.
    pub advice: String,
}

impl Explanation {
    /// Measures and advises.
    ///
    /// # Cost
    /// C once more and, for a linear M, 40 products with M⁻¹𝒜 and as many vectors of memory.
    ///
    /// # Errors
    /// Those of C, and of the eigenvalues of a small dense matrix.
    pub fn new(solved: &Solved<'_>) -> Result<Self, SetupError> {
        let blocks = solved.blocks;
        let is_seen = solved.preconditioner.properties().linear;
        let seen = match is_seen {
            true => Some(Seen::new(blocks, solved.preconditioner, solved.rhs)?),
            false => None,
        };
        let rigid_body = blocks.coordinates.as_deref().map(|coordinates| {
            let found = rigid_motions(&blocks.a, coordinates);
            RigidBody {
                free_rows: found.free,
                held_rows: blocks.n_u() - found.free,
                wrong_rows: found.wrong,
                worst: found.worst,
            }
        });
        let c_over_h = match solved.method.augmentation() {
            Some(choice) => Domination::new(blocks, choice, asked_of_c(solved.method))?,
            None => None,
        };
        let flops = solved.preconditioner.flops().max(1) as f64;
        let parts = solved.parts;
        let in_parts = parts.map_or(0.0, |p| p.c_s + p.inner_s);
        let mut explanation = Self {
            seen,
            rigid_body,
            c_over_h,
            amg_levels: solved.hierarchy.map(|h| h.levels.len()),
            operator_complexity: solved.hierarchy.map(|h| h.operator_complexity),
            inner_share: parts.map(|p| p.inner_flops as f64 / flops),
            time: TimeSplit {
                c_s: parts.map(|p| p.c_s),
                inner_s: parts.map(|p| p.inner_s),
                other_setup_s: (solved.setup_s - in_parts).max(0.0),
                iterations_s: solved.solve_s,
            },
            advice: String::new(),
        };
        explanation.advice = advice::of(&explanation, solved.method);
        Ok(explanation)
    }
}
