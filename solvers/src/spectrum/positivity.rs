//! Re λ > 0 where W relaxes H.

use super::bounds::Ingredients;
use crate::saddle::{RELAXATION, RelaxationSummary};

/// Largest Δ = λ_max(S̃_u⁻¹S_u) up to which no eigenvalue has a real part of zero or less, per degree of W. Unit: 1.
///
/// Degree 1 has `2q − a > 0`, so that the circles of [`discs`](super::discs) lie right of zero whatever S̃_u is. For the others: with
/// `μ_j = |w_j|²(q−a)²/|λ−a|²`, Σμ = 1, `u*Âu = Σμ_j φ_j ≥ 0` and `u*Σu = Σμ_j ψ_j ≤ Δ`,
/// ```text
/// (q−a)²φ = 2q² Re λ − (2q−a)|λ|² − q²a
/// (q−a)²ψ = (1−2q+a)|λ|² + 2(q²−a) Re λ + a² − q²a
/// ```
/// there is no eigenvalue λ = iy where some s ≥ 0 has `φ_j < s(ψ_j − Δ)` for every j. Eigenvalues that move with τH, which for small τ
/// lie right of the imaginary axis as x p(x) ≤ 2 there, would have to cross it. A subdivision of all x and y with error bounds (test) finds such an s everywhere.
/// By duality on a grid the limits are 2.414, 1.713 and 1.274: nothing more follows from δ, Δ and x alone.
const LIMITS: [f64; 4] = [f64::INFINITY, 2.4, 1.7, 1.26];

/// True where Re λ > 0 is proved for this W, γ being 4/27; without W the circles say it.
pub(super) fn holds(w: RelaxationSummary, i: &Ingredients) -> bool {
    let limit = w.degree.checked_sub(1).and_then(|d| LIMITS.get(d));
    limit.is_some_and(|limit| {
        w.gamma == RELAXATION && i.sigma.1 <= *limit && i.h.0 >= 0.0 && i.h.1 <= w.reach
    })
}

#[cfg(test)]
mod tests;
