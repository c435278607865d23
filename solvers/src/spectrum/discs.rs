//! Discs that hold the non-real eigenvalues, whatever approximates S_u.
//!
//! With `h_j = eig(C⁻¹H)`, `q_j = p(h_j)` of the relaxation W = p(C⁻¹H) (q = 1 without) and `a_j = h_j q_j²`: every non-real
//! eigenvalue satisfies, for some j,
//! ```text
//! (2q_j − a_j)|λ|² − 2q_j² Re λ + q_j² a_j ≤ 0
//! ```
//! the circle that cuts the real axis at q_j and at `q_j a_j/(2q_j − a_j)`. Without relaxation that is the disc between 1 and
//! h/(2−h) for h < 2; those of all h < 1 lie in the one of the smallest h, those of h > 1 in the one of the largest.
//!
//! Proof (A ⪰ 0, B2 = B1ᵀ, C and S̃_u SPD): let (u, t) be an eigenvector in the scales of S̃_u and C, ‖u‖ = 1, w = Gᵀu in the
//! eigenvectors of Ĥ. Row 2 reads `(q−λ)w = (a−λ)t`, so that row 1 times u* becomes
//! `λ = u*Âu + Σ|w_j|² ((2q−a)λ − q²)/(λ−a)`. Its imaginary part is `1 = Σ|w_j|²(q−a)²/|λ−a|²`; with that,
//! `u*Âu = Σ |w_j|²/|λ−a|² · (2q² Re λ − (2q−a)|λ|² − q²a) ≥ 0`, and one term at least is not negative.
//!
//! Where `η ≤ 1` and `S_u ⪰ δ S̃_u`, also `|λ − 1|² ≤ (1−δ)(1−h_min)`: q = 1 leaves `u*Âu + ‖w‖² = 1 − |1−λ|² Σ μ_j/(1−h_j)` with
//! `μ_j = |w_j|²(1−h_j)²/|λ−h_j|²`, Σμ = 1, and the left side is not below δ. So the non-real part shrinks to the point 1 as S̃_u
//! becomes exact. This one asks nothing of A.

use super::region::Circle;

/// An eigenvalue h of C⁻¹H and what the relaxation makes of it: (h, p(h)).
pub(super) type Mode = (f64, f64);

/// `h q²`: the eigenvalue of the relaxed H.
pub(super) fn relaxed((h, q): Mode) -> f64 {
    h * q * q
}

/// The circle of a mode.
pub(super) fn of_mode(mode: Mode) -> Circle {
    let (q, a) = (mode.1, relaxed(mode));
    Circle::new(2.0 * q - a, q * q, q * q * a)
}

/// The circles of all modes; of those without relaxation two are enough.
pub(super) fn of_modes(modes: &[Mode]) -> Vec<Circle> {
    let is_relaxed = modes.iter().any(|m| m.1 != 1.0);
    if is_relaxed {
        // a mode with q = a, as h = 1 without relaxation, is no eigenvalue's
        return modes.iter().copied().map(of_mode).collect();
    }
    let low = modes.iter().map(|m| m.0).fold(f64::INFINITY, f64::min);
    let high = modes.iter().map(|m| m.0).fold(f64::NEG_INFINITY, f64::max);
    let mut circles = Vec::new();
    if low < 1.0 {
        circles.push(of_mode((low, 1.0)));
    }
    if high > 1.0 {
        circles.push(of_mode((high, 1.0)));
    }
    circles
}

/// `|λ − 1| ≤ √((1−δ)(1−h_min))` for η ≤ 1 without relaxation; `None` where it says nothing.
pub(super) fn around_one(delta: f64, modes: &[Mode]) -> Option<Circle> {
    let low = modes.iter().map(|m| m.0).fold(1.0, f64::min);
    let holds = modes.iter().all(|m| m.1 == 1.0 && m.0 <= 1.0);
    let square = (1.0 - delta).max(0.0) * (1.0 - low);
    (holds && square < 1.0).then(|| Circle::disc(1.0, square.sqrt()))
}
