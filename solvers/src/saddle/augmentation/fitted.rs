//! An augmentation that takes less of H where cells are flat.

use super::super::SaddleBlocks;
use super::AugmentationMatrix;
use super::stabilized::{HALF, group, with_share};
use super::support::{Columns, for_restricted};
use fracas_operators::sparse::SparseMatrix;
use std::ops::Range;

/// `θ √ρ` in flat cells. Unit: 1. Measured on flat and long cells of 1:5 to 1:200, 48³: 1.5 takes one iteration fewer at 1:10 and
/// 1:20 and one more at 1:50, 3 up to four more.
const FITTED: f64 = 2.0;

/// Smallest share of H. Unit: 1. `λ_max(C⁻¹H) ≤ 30`: the relaxation of H is of degree four, its last. Reached at ρ = 900, cells
/// of about 1:50.
const LEAST: f64 = 1.0 / 15.0;

/// A fracture whose nodes A ties to each other by less than this share of its diagonal lies along flat cells. Unit: 1. Found: none along
/// cells of 1:3 and flatter, 0.05 along 1:2; 0.32 in cubes, 0.25 to 0.35 along long cells, 0.4 to 1.2 where the fracture contains the
/// thin side.
const TIED: f64 = 0.05;

/// What C of a face depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    /// θ by ρ alone.
    theta: f64,
    /// `2 Σ max(−A_lj, 0)`, l and j ≠ l in the support of one column of B.
    ties: f64,
    /// `Σ A_ll` over the same l.
    diagonal: f64,
}

/// θ by ρ, face by face, and what A is between the nodes of each.
///
/// # Cost
/// A pass over A on the supports of B.
pub(super) fn shares(blocks: &SaddleBlocks, columns: &Columns) -> Vec<Share> {
    let size = group(columns.len());
    let h_ii = |i: usize| (blocks.h.as_ref()).and_then(|h| h.get(i, i).copied());
    let share = |rows: Range<usize>| {
        let h: f64 = rows.clone().map(|i| h_ii(i).unwrap_or(0.0).abs()).sum();
        let (mut k, mut ties, mut diagonal) = (0.0, 0.0, 0.0);
        for i in rows {
            let support = columns.support(i);
            for_restricted(&blocks.a, support, |l, j, a_lj| match l == j {
                true => {
                    diagonal += a_lj;
                    k += columns.values(i)[l].powi(2) / a_lj;
                }
                false => ties += 2.0 * f64::max(-a_lj, 0.0),
            });
        }
        // nothing in H: any θ; nothing in B: ρ = ∞
        let theta = match h > 0.0 {
            true => (FITTED * (k / h).sqrt()).clamp(LEAST, HALF),
            false => HALF,
        };
        Share {
            theta,
            ties,
            diagonal,
        }
    };
    let faces = 0..columns.len() / size;
    faces.map(|f| share(size * f..size * (f + 1))).collect()
}

/// `C_f = C_local + θ_f |H_ff|`, `θ_f = 2/√ρ_f` in [1/15, ½], `ρ_f = tr H_ff / tr (Bᵀ diag(A)⁻¹ B)_ff`; `θ_f = ½` on fractures that lie
/// along flat cells, a fracture being faces that H couples.
///
/// H, formed of the springs V/h_j² of cells, is on flat cells far above what A does to jumps: ρ, two in cubes, grows with the
/// square of their sides. Where a fracture contains the thin direction, take a line of faces across it, k the mean of
/// `(Bᵀ diag(A)⁻¹ B)_ii` and μ in (0, 4] the eigenvalues of [−1 2 −1]: `h ≈ ρ k μ/4` and `s ≈ k/μ`, so that `s + h` has a minimum of
/// `√ρ k` between smooth and rough jumps. With half of H, c is `ρ k/2` and the eigenvalue (s + h)/(s + c) of M⁻¹𝒜 there falls like
/// 1/√ρ; with `c = 2 √ρ k` it does not (until θ ends at 1/15), and what h exceeds c by, √ρ at most, is for the
/// [`Relaxation`](super::super::Relaxation). Where the thin direction is normal to the fracture, smooth jumps meet thin sheets of
/// rock, s reaches `ρ k/μ`, and half of H is right. There A ties the nodes of a face to those across the sheet and not to each other.
///
/// # Source
/// Derived here.
pub(super) fn fitted_h(
    local: Vec<f64>,
    shares: &[Share],
    h: Option<&SparseMatrix<f64>>,
) -> AugmentationMatrix {
    let mut theta: Vec<f64> = shares.iter().map(|share| share.theta).collect();
    for fracture in h.map_or_else(Vec::new, |h| fractures(h, shares.len())) {
        let sum = |of: fn(&Share) -> f64| -> f64 { fracture.iter().map(|f| of(&shares[*f])).sum() };
        if sum(|s| s.ties) < TIED * sum(|s| s.diagonal) {
            fracture.iter().for_each(|f| theta[*f] = HALF);
        }
    }
    with_share(local, h, |face| theta[face])
}

/// Faces by the connected parts of H.
fn fractures(h: &SparseMatrix<f64>, faces: usize) -> Vec<Vec<usize>> {
    let size = h.rows() / faces.max(1);
    let mut is_known = vec![false; faces];
    let mut found = Vec::new();
    for first in 0..faces {
        if std::mem::replace(&mut is_known[first], true) {
            continue;
        }
        let mut part = vec![first];
        let mut next = 0;
        while let Some(&face) = part.get(next) {
            next += 1;
            for row in (size * face..size * (face + 1)).filter_map(|row| h.outer_view(row)) {
                for (column, _) in row.iter().filter(|(_, v)| **v != 0.0) {
                    if !std::mem::replace(&mut is_known[column / size], true) {
                        part.push(column / size);
                    }
                }
            }
        }
        found.push(part);
    }
    found
}
