//! Inverses of symmetric 3×3 blocks.

/// Pivot of a block with unit diagonal below which it counts as singular. Unit: 1.
const SINGULAR: f64 = 1e-12;

/// `B⁻¹` of a symmetric positive definite row-major block, or the row (0–2) whose pivot is not positive.
///
/// The block is scaled to a unit diagonal first, so units and contrast inside it do not matter.
pub(super) fn inverse(b: &[f64; 9]) -> Result<[f64; 9], usize> {
    let mut scale = [0.0; 3];
    for (k, s) in scale.iter_mut().enumerate() {
        let diagonal = b[4 * k];
        if diagonal.is_nan() || diagonal <= 0.0 {
            return Err(k);
        }
        *s = 1.0 / diagonal.sqrt();
    }
    // L Lᵀ of the scaled block, then W = L⁻¹ row by row
    let mut l = [[0.0_f64; 3]; 3];
    let mut w = [[0.0_f64; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let mut v = b[3 * i + j] * scale[i] * scale[j];
            (0..j).for_each(|k| v -= l[i][k] * l[j][k]);
            if i > j {
                l[i][j] = v / l[j][j];
            } else if v > SINGULAR {
                l[i][i] = v.sqrt();
            } else {
                return Err(i);
            }
        }
        w[i][i] = 1.0 / l[i][i];
        for j in 0..i {
            w[i][j] = -(j..i).map(|k| l[i][k] * w[k][j]).sum::<f64>() / l[i][i];
        }
    }
    // S Wᵀ W S
    Ok(std::array::from_fn(|k| {
        let (i, j) = (k / 3, k % 3);
        scale[i] * scale[j] * (i.max(j)..3).map(|r| w[r][i] * w[r][j]).sum::<f64>()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverts_and_names_the_row_that_is_not_positive() {
        let b = [4.0, 1.0, -2.0, 1.0, 3e8, 0.5, -2.0, 0.5, 5.0];
        let inverse_b = inverse(&b).unwrap();
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| b[3 * i + k] * inverse_b[3 * k + j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9);
            }
        }
        let negative = [1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(inverse(&negative), Err(1));
        assert_eq!(inverse(&[1.0; 9]), Err(1));
    }
}
