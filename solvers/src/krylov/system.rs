//! What is asked of a Krylov method, and what it answers.

use fracas_operators::vector;
use fracas_operators::{LinearOperator, Preconditioner, Real};
use serde::{Deserialize, Serialize};

/// `A x = b` with a preconditioner M.
#[derive(Clone, Copy)]
pub struct System<'a, R> {
    /// A.
    pub operator: &'a dyn LinearOperator<R>,
    /// M⁻¹.
    pub preconditioner: &'a dyn Preconditioner<R>,
    /// b.
    pub rhs: &'a [R],
}

impl<R: Real> System<'_, R> {
    /// Unknowns here: all of them, or the part of this rank.
    pub fn size(&self) -> usize {
        self.rhs.len()
    }

    /// `M⁻¹(b − A x)` with scratch of the larger `work_len` of both: the term after x of `A⁻¹b = Σ (I − M⁻¹A)ᵏ M⁻¹b` where x is the sum before.
    ///
    /// # Cost
    /// A product with A and a solve with M.
    pub fn correction(&self, x: &[R], work: &mut [R]) -> Vec<R> {
        let mut r = self.rhs.to_vec();
        self.operator.apply_add(-R::one(), x, &mut r, work);
        let mut z = vec![R::zero(); x.len()];
        self.preconditioner.solve(&r, &mut z, work);
        z
    }

    /// Unknowns of all parts.
    pub fn whole_size(&self) -> usize {
        self.sum(R::of(self.size() as f64)).to_f64_exact() as usize
    }

    /// `xᵀy` over all parts of the vectors.
    pub fn dot(&self, x: &[R], y: &[R]) -> R {
        self.sum(vector::dot(x, y))
    }

    /// `‖x‖₂` over all parts.
    pub fn norm2(&self, x: &[R]) -> R {
        self.dot(x, x).sqrt()
    }

    /// True where it is `here`, or in another part.
    pub fn is_anywhere(&self, here: bool) -> bool {
        self.sum(if here { R::one() } else { R::zero() }) > R::zero()
    }

    fn sum(&self, here: R) -> R {
        let mut sum = [here];
        self.operator.sum_over_parts(&mut sum);
        sum[0]
    }

    /// Scratch entries that one product or one preconditioner solve needs.
    pub(super) fn scratch_len(&self) -> usize {
        self.operator.work_len().max(self.preconditioner.work_len())
    }

    /// Stops with the numbers when A, M, b and x do not fit together.
    pub(super) fn assert_fits(&self, x: &[R]) {
        let (shape, n) = (self.operator.shape(), self.rhs.len());
        assert!(
            shape.is_square() && shape.rows == n && self.preconditioner.size() == n && x.len() == n,
            "a {shape} operator, a preconditioner of size {}, b of length {n} and x of length {}",
            self.preconditioner.size(),
            x.len()
        );
    }
}

/// When to stop: `‖b − A x‖₂ ≤ relative_tolerance · ‖b‖₂`, or after `max_iterations`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Criteria {
    /// Relative to ‖b‖₂.
    pub relative_tolerance: f64,
    /// Iterations over all restarts.
    pub max_iterations: usize,
}

/// How an iteration ended; not converging is a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The true residual meets the tolerance.
    Converged,
    /// `max_iterations` were not enough.
    IterationLimit,
    /// The observer said so.
    Stopped,
}

/// What an iteration did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// How it ended.
    pub outcome: Outcome,
    /// Iterations over all restarts.
    pub iterations: usize,
    /// `‖b − A x‖₂ / ‖b‖₂`, recomputed from the returned x (0 for b = 0).
    pub relative_residual: f64,
    /// The same as the recurrence believed it to be at its last iteration.
    pub estimated_residual: f64,
    /// Products with A, those for true residuals included.
    pub products: u64,
    /// Solves with M.
    pub preconditioner_solves: u64,
    /// Modulus of the Ritz value of A M⁻¹ nearest to zero, over all cycles; `None` where the method knows none. The error may
    /// be larger than M⁻¹r by its inverse.
    pub smallest_ritz: Option<f64>,
}
