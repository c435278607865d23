//! An augmentation that takes less of H where cells are flat.

use super::super::SaddleBlocks;
use super::AugmentationMatrix;
use super::stabilized::with_share;
use super::support::Columns;
use crate::SetupError;
use std::ops::Range;

/// Share of H in cubes. Unit: 1. `H ≤ 2 blkdiag H`: the relaxation of H is of degree one.
const CUBES: f64 = 0.5;

/// `θ √ρ` in flat cells. Unit: 1. Measured on cells of 1:5 to 1:200, both flat and long, fractures across and along them:
/// 1.5 takes up to three iterations fewer at 1:10 and 1:20 and one or two more at 1:50, 3 up to four more.
const FITTED: f64 = 2.0;

/// Smallest share of H. Unit: 1. `λ_max(C⁻¹H) ≤ 30`: the relaxation of H is of degree four, its last. Reached at ρ = 900, cells of about 1:50.
const LEAST: f64 = 1.0 / 15.0;

/// `C_f = C_local + θ_f |H_ff|`, `θ_f = 2/√ρ_f` in [1/15, ½], `ρ_f = tr H_ff / tr (Bᵀ diag(A)⁻¹ B)_ff`.
///
/// H, formed of the springs V/h_j² of cells, is on flat cells far above what A does to jumps: ρ, two in cubes, grows with the
/// square of their sides. On a line of faces across the thin direction, k the mean of `(Bᵀ diag(A)⁻¹ B)_ii` and μ in (0, 4] the
/// eigenvalues of [−1 2 −1], `h ≈ ρ k μ/4` and `s ≈ k/μ`, so that `s + h` has a minimum of `√ρ k` between smooth and rough jumps.
/// With half of H, c is `ρ k/2` and the eigenvalue (s + h)/(s + c) of M⁻¹𝒜 there falls like 1/√ρ; with `c = 2 √ρ k` it does not,
/// and what h exceeds c by, √ρ at most, is for the [`Relaxation`](super::super::Relaxation).
///
/// # Source
/// Derived here.
pub(super) fn fitted_h(
    blocks: &SaddleBlocks,
    columns: &Columns,
) -> Result<AugmentationMatrix, SetupError> {
    let a_ii = |row: usize| blocks.a.get(row, row).copied().unwrap_or(0.0);
    let h_ii = |i: usize| (blocks.h.as_ref()).and_then(|h| h.get(i, i).copied());
    // b_iᵀ diag(A)⁻¹ b_i
    let stiff = |i: usize| -> f64 {
        let entries = columns.support(i).iter().zip(columns.values(i));
        entries.map(|(row, b)| b * b / a_ii(*row)).sum()
    };
    let share = |rows: Range<usize>| {
        let h: f64 = rows.clone().map(|i| h_ii(i).unwrap_or(0.0).abs()).sum();
        let stiff: f64 = rows.map(stiff).sum();
        match h > 0.0 {
            // ρ = 0 where A has nothing on its diagonal, ∞ where B has nothing
            true => (FITTED / (h / stiff).sqrt()).clamp(LEAST, CUBES),
            false => CUBES,
        }
    };
    with_share(blocks, columns, share)
}
