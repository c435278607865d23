//! Does C dominate H?

use crate::SetupError;
use crate::direct::DirectChoice;
use crate::saddle::{AugmentationChoice, Elimination, SaddleBlocks};
use serde::Serialize;

/// Relative difference that counts as rounding. Unit: 1.
const ROUNDING: f64 = 1e-12;

/// `C_ii / H_ii` over the rows with `H_ii > 0`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Domination {
    /// Smallest.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub max: f64,
    /// `C_ii / H_ii` that the method asks for: 1, or ½ where it relaxes H.
    pub asked: f64,
    /// Share of the rows below that.
    pub share_below: f64,
}

impl Domination {
    /// `None` where no `H_ii` is positive. Rows of slip and opening are eliminated, as the methods do.
    pub(super) fn new(
        blocks: &SaddleBlocks,
        choice: AugmentationChoice,
        asked: f64,
    ) -> Result<Option<Self>, SetupError> {
        let elimination = Elimination::new(blocks);
        let blocks = elimination.as_ref().map_or(blocks, Elimination::kept);
        let Some(h) = &blocks.h else { return Ok(None) };
        let h_ii = |i: usize| h.get(i, i).copied().filter(|h| *h > 0.0);
        if (0..blocks.n_t()).all(|i| h_ii(i).is_none()) {
            return Ok(None);
        }
        let direct = DirectChoice::default().solver()?;
        let c = choice.compute(blocks, direct.as_ref())?.matrix;
        let mut ratios: Vec<f64> = c
            .diagonal_entries()
            .iter()
            .enumerate()
            .filter_map(|(i, c)| h_ii(i).map(|h| c / h))
            .collect();
        ratios.sort_by(f64::total_cmp);
        let n = ratios.len();
        Ok(Some(Self {
            min: ratios[0],
            median: ratios[n / 2],
            max: ratios[n - 1],
            asked,
            share_below: ratios.partition_point(|r| *r < asked * (1.0 - ROUNDING)) as f64
                / n as f64,
        }))
    }
}
