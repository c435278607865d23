//! 3×3 blocks: one per face.

use super::matrix::ZERO_PIVOT;

/// A 3×3 block by rows.
pub type Block = [[f64; 3]; 3];

/// diag(d).
pub(super) fn diagonal_block(d: [f64; 3]) -> Block {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { d[i] } else { 0.0 }))
}

/// Lower factor of an SPD block, or the row of the first pivot that vanishes.
pub(super) fn cholesky3(b: &Block) -> Result<Block, usize> {
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let sum = b[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i == j {
                if !(sum > ZERO_PIVOT * b[i][i] && sum.is_finite()) {
                    return Err(i);
                }
                l[i][i] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    Ok(l)
}

/// L⁻ᵀ, upper.
pub(super) fn inverse_transpose(l: &Block) -> Block {
    let mut x = [[0.0; 3]; 3];
    for j in 0..3 {
        for i in j..3 {
            let e = if i == j { 1.0 } else { 0.0 };
            x[i][j] = (e - (j..i).map(|k| l[i][k] * x[k][j]).sum::<f64>()) / l[i][i];
        }
    }
    std::array::from_fn(|i| std::array::from_fn(|j| x[j][i]))
}

/// C⁻¹ of an SPD block; of one that is not, NaN.
pub(super) fn inverse3(c: &Block) -> Block {
    let l = cholesky3(c).unwrap_or([[f64::NAN; 3]; 3]);
    product_with_transpose(&inverse_transpose(&l))
}

/// F Fᵀ.
pub(super) fn product_with_transpose(f: &Block) -> Block {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| f[i][k] * f[j][k]).sum()))
}

/// `y ← y + α diag(blocks) x`.
pub(super) fn blocks_add(blocks: &[Block], alpha: f64, x: &[f64], y: &mut [f64]) {
    for ((b, x), y) in blocks
        .iter()
        .zip(x.chunks_exact(3))
        .zip(y.chunks_exact_mut(3))
    {
        for i in 0..3 {
            y[i] += alpha * (b[i][0] * x[0] + b[i][1] * x[1] + b[i][2] * x[2]);
        }
    }
}
