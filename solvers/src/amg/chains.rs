//! Where Gauss–Seidel by nodes smooths badly.

use super::Amg;
use super::matrix::NodeMatrix;
use super::reach::Reach;
use crate::multigrid::{Smoother, Smoothing};
use fracas_operators::Real;
use fracas_operators::small::norm_squared;
use rayon::prelude::*;

/// `‖A_ij‖_F / √(‖A_ii‖_F ‖A_jj‖_F)` from which a neighbour counts as a link of a chain. Unit: 1.
///
/// A chain of nodes that are coupled to nothing else has 1/2: half of the diagonal on either side. Cubes of Q1 elements
/// have 0.20 (ν = 0.25), cells of 1:3, 1:5, 1:10, 1:50 have 0.41, 0.46, 0.49, 0.50 (limit: the chains across the layers);
/// cubes with ν = 0.40, 0.45, 0.47, 0.49, 0.499 have 0.31, 0.39, 0.42, 0.47, 0.50 (along diagonals of faces).
const LINK: f64 = 0.45;

/// `‖A_ij‖_F / |tr A_ij|` from which a link resists changes of volume above all: `√(2 + r²)/(2 + r)` across flat cells with
/// `r = (λ+2G)/G`, which is 0.66, 0.77, 0.85, 0.96 for ν = 0.25, 0.40, 0.45, 0.49, and 1 along diagonals. Unit: 1.
///
/// Below it the links of a node that has far neighbours do not count: aggregates follow them, and Gauss–Seidel smooths along them. Flat
/// cells of 1:2.5, 1:4, 1:8 with ν = 0.49 take 82, 59, 64 iterations by Gauss–Seidel, 33, 33, 29 by FSAI.
const VOLUME: f64 = 0.8;

/// What the settings say, or what the finest matrix asks for; no positions where they are not known, or where coarsening does not
/// heed them.
///
/// # Cost
/// Under [`Smoother::Auto`] one pass over the blocks.
pub(super) fn smoothing<R: Real>(
    settings: &Amg,
    finest: &NodeMatrix<R>,
    positions: &[[f64; 3]],
) -> Smoothing {
    if settings.smoother != Smoother::Auto {
        return Smoothing {
            smoother: settings.smoother,
            chained: None,
        };
    }
    let chained = chained(finest, &Reach::new(finest, None, positions, 1));
    Smoothing {
        smoother: if chained >= Smoothing::CHAINED {
            Smoother::Fsai
        } else {
            Smoother::GaussSeidel
        },
        chained: Some(chained),
    }
}

/// Share of the nodes with a neighbour that is a link.
fn chained<R: Real>(a: &NodeMatrix<R>, reach: &Reach<'_>) -> f64 {
    let sizes: Vec<f64> = (0..a.rows())
        .into_par_iter()
        .map(|i| norm_squared(a.diagonal(i)))
        .collect();
    let is_link = |i: usize| {
        let flat = reach.has_far(a, i);
        a.row(i).any(|(j, block)| {
            // squares on both sides
            let limit = LINK.powi(4) * sizes[i] * sizes[j];
            let size = norm_squared(block);
            let trace = block[0][0] + block[1][1] + block[2][2];
            let volume = size >= (VOLUME * trace.to_f64_exact()).powi(2);
            j != i && size * size >= limit && (volume || !flat)
        })
    };
    let links = (0..a.rows())
        .into_par_iter()
        .filter(|i| is_link(*i))
        .count();
    links as f64 / a.rows().max(1) as f64
}
