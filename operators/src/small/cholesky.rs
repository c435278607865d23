//! Cholesky factors and inverses of symmetric positive definite matrices.

use crate::Real;

/// `A = L Lᵀ` in the place of the lower triangle of an n×n matrix.
#[inline(always)]
fn factor<R: Real>(a: &mut [R], n: usize, least: R) -> Result<(), usize> {
    for i in 0..n {
        for j in 0..=i {
            let mut rest = a[i * n + j];
            (0..j).for_each(|k| rest -= a[i * n + k] * a[j * n + k]);
            a[i * n + j] = if i > j {
                rest / a[j * n + j]
            } else if rest > least * a[i * n + i] && rest.is_finite() {
                rest.sqrt()
            } else {
                return Err(i);
            };
        }
    }
    Ok(())
}

/// `L ← L⁻¹` in the place of a lower triangle.
#[inline(always)]
fn invert_lower<R: Real>(l: &mut [R], n: usize) {
    for i in 0..n {
        let pivot = l[i * n + i];
        for j in 0..i {
            let known: R = (j..i).map(|k| l[i * n + k] * l[k * n + j]).sum();
            l[i * n + j] = -known / pivot;
        }
        l[i * n + i] = pivot.recip();
    }
}

/// `WᵀW` in the place of a lower triangle W, both triangles.
#[inline(always)]
fn gram_in_place<R: Real>(w: &mut [R], n: usize) {
    for i in 0..n {
        for j in i..n {
            // columns before i are not read any more, and those from i on only below row j
            w[i * n + j] = (j..n).map(|k| w[k * n + i] * w[k * n + j]).sum();
        }
        (0..i).for_each(|j| w[i * n + j] = w[j * n + i]);
    }
}

/// L of `A = L Lᵀ`, from the lower triangle.
///
/// # Errors
/// The first row whose pivot is no more than `least` of its diagonal entry, or no number.
pub fn cholesky<R: Real, const N: usize>(a: &[[R; N]; N], least: R) -> Result<[[R; N]; N], usize> {
    let mut l = *a;
    factor(l.as_flattened_mut(), N, least)?;
    (0..N).for_each(|i| l[i][i + 1..].fill(R::zero()));
    Ok(l)
}

/// `W = L⁻¹` of a lower triangle.
pub fn lower_inverse<R: Real, const N: usize>(mut l: [[R; N]; N]) -> [[R; N]; N] {
    invert_lower(l.as_flattened_mut(), N);
    l
}

/// `WᵀW` of a lower triangle: the inverse of `L Lᵀ` for `W = L⁻¹`.
pub fn gram<R: Real, const N: usize>(mut w: [[R; N]; N]) -> [[R; N]; N] {
    gram_in_place(w.as_flattened_mut(), N);
    w
}

/// `A⁻¹` over the components whose `scale` comes as 1, zero in those where it comes as 0; A is scaled to a unit diagonal first, so that
/// neither units nor contrast inside it matter, and `scale` leaves as the factors. Symmetric to the last bit.
///
/// # Errors
/// The first row whose diagonal entry is not positive, else whose pivot of the scaled matrix is no more than `least`.
#[inline(always)]
pub fn invert_equilibrated<R: Real>(a: &mut [R], scale: &mut [R], least: R) -> Result<(), usize> {
    let n = scale.len();
    for (i, s) in scale.iter_mut().enumerate() {
        if *s == R::zero() {
            continue;
        }
        let diagonal = a[i * n + i];
        if !(diagonal > R::zero() && diagonal.is_finite()) {
            return Err(i);
        }
        *s = diagonal.sqrt().recip();
    }
    for i in 0..n {
        (0..=i).for_each(|j| a[i * n + j] = a[i * n + j] * scale[i] * scale[j]);
        if scale[i] == R::zero() {
            a[i * n + i] = R::one();
        }
    }
    factor(a, n, least)?;
    invert_lower(a, n);
    gram_in_place(a, n);
    for i in 0..n {
        (0..n).for_each(|j| a[i * n + j] = scale[i] * scale[j] * a[i * n + j]);
    }
    Ok(())
}

/// `A⁻¹` over the components that are free, zero elsewhere, as [`invert_equilibrated`].
///
/// # Errors
/// As there.
#[inline(always)]
pub fn equilibrated_inverse<R: Real, const N: usize>(
    mut a: [[R; N]; N],
    free: [bool; N],
    least: R,
) -> Result<[[R; N]; N], usize> {
    let mut scale = free.map(|free| if free { R::one() } else { R::zero() });
    invert_equilibrated(a.as_flattened_mut(), &mut scale, least)?;
    Ok(a)
}

#[cfg(test)]
mod tests {
    use super::super::{add_product, diagonal};
    use super::*;

    const B: [[f64; 3]; 3] = [[4.0, 1.0, -2.0], [1.0, 3e8, 0.5], [-2.0, 0.5, 5.0]];

    fn is_identity(m: [[f64; 3]; 3], free: [bool; 3]) {
        for (i, row) in m.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                let expected = f64::from(u8::from(i == j && free[i]));
                assert!((v - expected).abs() < 1e-9, "{m:?}");
            }
        }
    }

    #[test]
    fn factors_reproduce_and_inverses_invert() {
        let l = cholesky(&B, 1e-13).unwrap();
        assert_eq!([l[0][1], l[0][2], l[1][2]], [0.0; 3]);
        let mut product = [[0.0; 3]; 3];
        let transposed = std::array::from_fn(|i| std::array::from_fn(|j| l[j][i]));
        add_product(&mut product, &l, &transposed);
        for (found, exact) in product.iter().flatten().zip(B.iter().flatten()) {
            assert!((found - exact).abs() <= 1e-15 * exact.abs().max(1.0));
        }
        for inverse in [
            gram(lower_inverse(l)),
            equilibrated_inverse(B, [true; 3], 1e-12).unwrap(),
        ] {
            let mut product = [[0.0; 3]; 3];
            add_product(&mut product, &B, &inverse);
            is_identity(product, [true; 3]);
            (0..9).for_each(|k| assert_eq!(inverse[k / 3][k % 3], inverse[k % 3][k / 3]));
        }
    }

    #[test]
    fn components_that_are_not_free_are_left_out() {
        let free = [true, false, true];
        let inverse = equilibrated_inverse(B, free, 1e-12).unwrap();
        let mut kept = B;
        (0..3).for_each(|k| (kept[1][k], kept[k][1]) = (0.0, 0.0));
        let mut product = [[0.0; 3]; 3];
        add_product(&mut product, &kept, &inverse);
        is_identity(product, free);
        assert!((0..3).all(|k| inverse[1][k] == 0.0 && inverse[k][1] == 0.0));
    }

    #[test]
    fn the_row_that_is_not_positive_is_named() {
        let negative = diagonal([1.0, -1.0, 1.0]);
        assert_eq!(equilibrated_inverse(negative, [true; 3], 1e-12), Err(1));
        assert_eq!(
            equilibrated_inverse([[1.0; 3]; 3], [true; 3], 1e-12),
            Err(1)
        );
        assert_eq!(cholesky(&[[1.0, 2.0], [2.0, 4.0]], 1e-13), Err(1));
        assert_eq!(cholesky(&[[f64::NAN]], 0.0), Err(0));
    }
}
