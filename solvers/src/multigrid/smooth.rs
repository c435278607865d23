//! What smooths a level.

use super::level::Correction;
use fracas_operators::{LinearOperator, Real};

/// What a cycle has in hand on a level.
pub struct Hand<'v, R> {
    /// b; what the first smoothing leaves there is for the second.
    pub b: &'v mut [R],
    /// x.
    pub x: &'v mut [R],
    /// Memory that the cycle keeps between both smoothings.
    pub own: &'v mut [R],
    /// Scratch of products.
    pub work: &'v mut [R],
}

/// Smooths `A x = b` on a level around its coarse correction: by S before it, by the adjoint of S after it.
pub trait Smooth<R: Real>: Send + Sync {
    /// A.
    fn operator(&self) -> &dyn LinearOperator<R>;

    /// Entries of memory between both smoothings.
    fn own_len(&self) -> usize;

    /// `x ← S b`; gives the residual `b − A x`, which stands in b or in `own`.
    fn before<'v>(&self, hand: &'v mut Hand<'_, R>) -> &'v mut [R];

    /// `x ← x + P x_c`, then `x ← x + Sᵀ(b − A x)`. b leaves as `b − A x` if `residual`, else destroyed.
    fn after(&self, correction: &Correction<'_, R>, hand: &mut Hand<'_, R>, residual: bool);

    /// `z ← D⁻¹ r`, D the 3×3 diagonal blocks, zero in fixed components.
    fn divide_by_diagonal(&self, r: &[R], z: &mut [R]);

    /// Flops of both smoothings and the residual between them.
    fn flops(&self) -> u64;

    /// Bytes held, those of A included.
    fn bytes(&self) -> usize;
}
