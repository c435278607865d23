//! How contact states are searched for, in numbers.

use fracas_solvers::steering;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How contact states are searched for: rounds of Newton and new states, and Newton on the law of all faces at once where these do not
/// settle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Rounds {
    /// Residual up to which Newton is solved while states still change, and what then counts as zero. `cycle`, `crossing` and
    /// `inclined_crack` together take 394, 393, 384 Krylov iterations with half, this and double. Unit: 1.
    pub loose: f64,
    /// Newton steps that a round may take while states still change. Two in place of three: no change in the gallery. With flow it takes
    /// one.
    pub loose_steps: usize,
    /// Rounds after which Newton on all faces at once takes over though no states have returned. 10 and 40 change nothing in ten runs.
    pub patience: usize,
    /// Rounds with which an attempt to finish may do after Newton on all faces at once.
    pub finishing: usize,
    /// Largest relative residual of a linear solve. Half changes a random run by 0.2 %. Unit: 1.
    pub forcing: f64,
    /// Residual of the last linear solve over the one that Newton is asked for. The three scenes take 397, 393, 372 Krylov iterations with
    /// half, this and double. Unit: 1.
    pub last: f64,
    /// Iterations per digit, over those of the first all-stick system, from which a preconditioner of the present states is
    /// wanted. The three scenes take 376, 393, 640 Krylov iterations with 1, this and double; `cycle` 12, 8, 1 set-ups. Unit: 1.
    pub slow: f64,
    /// Iterations beyond those of `slow`, since one was built in the step, from which a preconditioner of the present states is built again
    /// in the same step: as many as a set-up costs. A network that weakens (9,936 displacements) takes 8,194, 9,784, 12,411 Krylov
    /// iterations and 190, 132, 101 set-ups in the same time with 0, 20, 50, and does not end in that time without.
    pub rebuild: f64,
}

impl Default for Rounds {
    fn default() -> Self {
        Self {
            loose: 1e-4,
            loose_steps: 3,
            patience: 20,
            finishing: 8,
            forcing: 1e-2,
            last: 0.3,
            slow: 1.3,
            rebuild: 50.0,
        }
    }
}

steering! {
    Rounds:
    loose [1e-15, 0.1],
    loose_steps [1.0, 1e6],
    patience [1.0, 1e6],
    finishing [1.0, 1e6],
    forcing [1e-15, 0.9],
    last [1e-6, 0.9],
    slow [1.0, 1e300],
    rebuild [0.0, 1e300],
}
