//! Sums and differences of the eight corner values of a brick, in which its stiffness falls into blocks of at most 3×3.
//!
//! Along each axis a pair (u_0, u_1) becomes the sum p = u_0 + u_1 and the difference d = u_1 − u_0. Mode m of a
//! component has a difference along x, y, z where bit 0, 1, 2 of m is set: `D_X = 1` stretches along x and is constant
//! in the other axes, `D_X | D_Y` varies along both. On a brick all products of modes of different bits vanish, except
//! those that one strain couples.

use fracas_operators::Real;
use fracas_operators::simd::Lanes;

/// Difference along x.
pub(super) const D_X: usize = 1;
/// Difference along y.
pub(super) const D_Y: usize = 2;
/// Difference along z.
pub(super) const D_Z: usize = 4;

/// Eight modes of the three components.
pub(super) type Modes<L> = [[L; 8]; 3];

/// Corner a of an element (VTK order) in the order x fastest.
pub(super) const LEXICOGRAPHIC: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// `(u_0, u_1) → (u_0 + u_1, u_1 − u_0)` along all axes; corners in lexicographic order become modes.
#[inline(always)]
pub(super) fn to_modes<R: Real, L: Lanes<R>>(corners: Modes<L>) -> Modes<L> {
    let mut u = corners;
    for component in &mut u {
        for bit in [D_X, D_Y, D_Z] {
            for m in 0..8 {
                if m & bit == 0 {
                    let (low, high) = (component[m], component[m | bit]);
                    (component[m], component[m | bit]) = (low + high, high - low);
                }
            }
        }
    }
    u
}

/// The adjoint: `(F_p, F_d) → (F_p − F_d, F_p + F_d)` along all axes.
#[inline(always)]
pub(super) fn to_corners<R: Real, L: Lanes<R>>(modes: Modes<L>) -> Modes<L> {
    let mut f = modes;
    for component in &mut f {
        for bit in [D_X, D_Y, D_Z] {
            for m in 0..8 {
                if m & bit == 0 {
                    let (sum, difference) = (component[m], component[m | bit]);
                    (component[m], component[m | bit]) = (sum - difference, sum + difference);
                }
            }
        }
    }
    f
}

/// Geometry and material of a brick.
#[derive(Clone, Copy)]
pub(super) struct Brick<L> {
    /// 1/h along x, y, z [1/m].
    pub(super) inverse: [L; 3],
    /// λ V/16 [N·m].
    pub(super) lambda: L,
    /// G V/16 [N·m].
    pub(super) shear: L,
}

/// Forces dual to the modes: `F = ∂/∂u ½ ∫ λ (tr ε)² + 2G ε:ε`.
///
/// A factor per axis comes from ∫ over the unit interval: 1/4 for a sum (its square is four times the mean's), 1/12 for
/// a difference, hence the weights 1/16, 1/48 and 1/144 of modes with one, two and three differences.
#[inline(always)]
pub(super) fn forces<R: Real, L: Lanes<R>>(u: &Modes<L>, brick: Brick<L>) -> Modes<L> {
    let [r, s, t] = brick.inverse;
    let (lambda, shear) = (brick.lambda, brick.shear);
    let third = L::splat(R::of(1.0 / 3.0));
    let (lambda3, shear3) = (lambda * third, shear * third);
    let zero = L::splat(R::zero());
    let mut f = [[zero; 8]; 3];

    // Stretches: σ_ii = λ tr ε + 2G ε_ii.
    let (e_x, e_y, e_z) = (r * u[0][D_X], s * u[1][D_Y], t * u[2][D_Z]);
    let p = lambda * (e_x + e_y + e_z);
    let shear_twice = shear + shear;
    f[0][D_X] = r * shear_twice.mul_add(e_x, p);
    f[1][D_Y] = s * shear_twice.mul_add(e_y, p);
    f[2][D_Z] = t * shear_twice.mul_add(e_z, p);

    // Uniform shears: σ_ij = G (∂_j u_i + ∂_i u_j).
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let (d_i, d_j) = (1 << i, 1 << j);
        let (a, b) = (brick.inverse[i], brick.inverse[j]);
        let tau = shear * b.mul_add(u[i][d_j], a * u[j][d_i]);
        f[i][d_j] = b * tau;
        f[j][d_i] = a * tau;
    }

    // Twists: shears that vary along the axis which is in neither direction.
    let (x, y, z) = (u[0][D_Y | D_Z], u[1][D_X | D_Z], u[2][D_X | D_Y]);
    let tau_xy = shear3 * s.mul_add(x, r * y);
    let tau_xz = shear3 * t.mul_add(x, r * z);
    let tau_yz = shear3 * t.mul_add(y, s * z);
    f[0][D_Y | D_Z] = s.mul_add(tau_xy, t * tau_xz);
    f[1][D_X | D_Z] = r.mul_add(tau_xy, t * tau_yz);
    f[2][D_X | D_Y] = r.mul_add(tau_xz, s * tau_yz);

    // Bendings: stretches along i and k that vary along j, and the shears that vary along i (of u_i) or k (of u_k).
    let shear3_twice = shear3 + shear3;
    for (i, j, k) in [(0, 1, 2), (0, 2, 1), (1, 0, 2)] {
        let (d_i, d_j, d_k) = (1 << i, 1 << j, 1 << k);
        let (a, b, c) = (brick.inverse[i], brick.inverse[j], brick.inverse[k]);
        let (u_i, u_k) = (u[i][d_i | d_j], u[k][d_k | d_j]);
        let (e_i, e_k) = (a * u_i, c * u_k);
        let p = lambda3 * (e_i + e_k);
        let stiff = shear3 * (b * b);
        f[i][d_i | d_j] = stiff.mul_add(u_i, a * shear3_twice.mul_add(e_i, p));
        f[k][d_k | d_j] = stiff.mul_add(u_k, c * shear3_twice.mul_add(e_k, p));
    }

    // The mode that varies along all three: no coupling left.
    let (r2, s2, t2) = (r * r, s * s, t * t);
    let lambda9 = third * (lambda3 + shear3);
    let common = third * shear3 * (r2 + s2 + t2);
    f[0][7] = lambda9.mul_add(r2, common) * u[0][7];
    f[1][7] = lambda9.mul_add(s2, common) * u[1][7];
    f[2][7] = lambda9.mul_add(t2, common) * u[2][7];
    f
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elasticity::Elastic;
    use crate::elasticity::element::{CORNERS, Geometry};
    use fracas_operators::laws::probe;
    use fracas_operators::simd::{Kernel, Level};

    struct Agree;

    impl Kernel<f64> for Agree {
        #[inline(always)]
        fn run<L: Lanes<f64>>(self) {
            let rock = Elastic {
                young: 2.0,
                poisson: 0.3,
            };
            let size = [0.5, 1.7, 3.0];
            let k = Geometry::Brick(size).stiffness(rock);
            let u: Vec<f64> = probe(24, 4);
            let scale = size[0] * size[1] * size[2] / 16.0;
            let brick = Brick {
                inverse: size.map(|h| L::splat(1.0 / h)),
                lambda: L::splat(rock.lambda() * scale),
                shear: L::splat(rock.shear() * scale),
            };
            let corners = [0, 1, 2].map(|i| LEXICOGRAPHIC.map(|a| L::splat(u[3 * a + i])));
            let f = to_corners(forces(&to_modes(corners), brick));
            let mut lanes = vec![0.0; L::WIDTH];
            for i in 0..3 {
                for (m, a) in LEXICOGRAPHIC.into_iter().enumerate() {
                    let row = &k[3 * a + i];
                    let expected: f64 = row.iter().zip(&u).map(|(k, u)| k * u).sum();
                    f[i][m].store(&mut lanes);
                    assert!(
                        (lanes[0] - expected).abs() < 1e-13,
                        "corner {:?}",
                        CORNERS[a]
                    );
                }
            }
        }
    }

    #[test]
    fn forces_of_modes_agree_with_the_element_matrix() {
        for level in Level::supported() {
            level.run::<f64>(Agree);
        }
    }
}
