//! 3×3 blocks: one per face.

use super::matrix::ZERO_PIVOT;
use fracas_operators::small::{Matrix3, cholesky, gram, lower_inverse, times};

/// A 3×3 block by rows.
pub type Block = Matrix3<f64>;

/// L⁻¹ of an SPD block `L Lᵀ`, or the row of the first pivot that vanishes.
pub(super) fn inverse_factor(c: &Block) -> Result<Block, usize> {
    cholesky(c, ZERO_PIVOT).map(lower_inverse)
}

/// C⁻¹ of an SPD block; of one that is not, NaN.
pub(super) fn inverse3(c: &Block) -> Block {
    inverse_factor(c).map_or([[f64::NAN; 3]; 3], gram)
}

/// `y ← y + α diag(blocks) x`.
pub(super) fn blocks_add(blocks: &[Block], alpha: f64, x: &[f64], y: &mut [f64]) {
    let (x, y) = (x.as_chunks().0, y.as_chunks_mut::<3>().0);
    for ((b, x), y) in blocks.iter().zip(x).zip(y) {
        let image = times(b, x);
        (0..3).for_each(|i| y[i] += alpha * image[i]);
    }
}
