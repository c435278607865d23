//! One brick in the parity basis, where its stiffness has 45 non-zero entries instead of 576.
//!
//! Along one axis of length h let `e = u₀ + u₁` (even) and `o = u₁ − u₀` (odd). Then
//! ```text
//! ∫ u v = h (e e/4 + o o/12)      ∫ u' v' = o o / h      ∫ u' v = o e / 2
//! ```
//! so every one-dimensional matrix of a trilinear brick is diagonal or a single entry, and with parities (a, b, c) along
//! x, y, z a displacement component couples to itself and to at most two partners.
//!
//! # Source
//! Derived here from the reflections of a brick; checked against the Gauss-integrated 24×24 matrix in the tests.

use fracas_operators::Real;
use fracas_operators::simd::Simd;

/// Bit of an odd parity along x, y, z in an index 0–7.
const X: usize = 1;
const Y: usize = 2;
const Z: usize = 4;

/// Parity coefficients of one displacement field: `[component][parity bits]`.
pub(super) type Parities<V> = [[V; 8]; 3];

/// The constants of one brick: material times geometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients<V> {
    /// `A_i = (λ + 2G) V / (16 h_i²)`.
    normal: [V; 3],
    /// `B_i = G V / (16 h_i²)`.
    shear: [V; 3],
    /// `L_i = λ h_i / 16`.
    lambda: [V; 3],
    /// `G_i = G h_i / 16`.
    cross: [V; 3],
}

impl<V: Copy> Coefficients<V> {
    /// From Lamé's λ and G, and per axis `α_i = V/(16 h_i²)` and `β_i = h_i/16`.
    #[inline(always)]
    pub(super) fn new<R>(lambda: V, shear: V, alpha: [V; 3], beta: [V; 3]) -> Self
    where
        V: Simd<R>,
    {
        let constrained = lambda.add(shear).add(shear);
        Self {
            normal: [
                constrained.mul(alpha[0]),
                constrained.mul(alpha[1]),
                constrained.mul(alpha[2]),
            ],
            shear: [
                shear.mul(alpha[0]),
                shear.mul(alpha[1]),
                shear.mul(alpha[2]),
            ],
            lambda: [
                lambda.mul(beta[0]),
                lambda.mul(beta[1]),
                lambda.mul(beta[2]),
            ],
            cross: [shear.mul(beta[0]), shear.mul(beta[1]), shear.mul(beta[2])],
        }
    }
}

/// Forces in the parity basis: `f = D u`, D the stiffness of the brick. `f[i][0] = 0`: a translation makes no force.
#[inline(always)]
pub(super) fn forces<R: Real, V: Simd<R>>(u: &Parities<V>, k: &Coefficients<V>) -> Parities<V> {
    let third = V::splat(R::of(1.0 / 3.0));
    let ninth = V::splat(R::of(1.0 / 9.0));
    let [
        [_, u1, u2, u3, u4, u5, u6, u7],
        [_, v1, v2, v3, v4, v5, v6, v7],
        [_, w1, w2, w3, w4, w5, w6, w7],
    ] = *u;
    let ([ax, ay, az], [bx, by, bz]) = (k.normal, k.shear);
    let ([lx, ly, lz], [gx, gy, gz]) = (k.lambda, k.cross);
    let (bxy, bxz, byz) = (bx.add(by), bx.add(bz), by.add(bz));
    let zero = V::splat(R::zero());
    let mut f = [[zero; 8]; 3];
    f[0][X] = ax.mul_add(u1, lz.mul_add(v2, ly.mul(w4)));
    f[0][Y] = by.mul_add(u2, gz.mul(v1));
    f[0][Z] = bz.mul_add(u4, gy.mul(w1));
    f[0][X | Y] = third.mul(ax.add(by).mul_add(u3, ly.mul(w6)));
    f[0][X | Z] = third.mul(ax.add(bz).mul_add(u5, lz.mul(v6)));
    f[0][Y | Z] = third.mul(byz.mul_add(u6, gz.mul_add(v5, gy.mul(w3))));
    f[0][X | Y | Z] = ninth.mul(ax.add(byz).mul(u7));

    f[1][Y] = ay.mul_add(v2, lz.mul_add(u1, lx.mul(w4)));
    f[1][X] = bx.mul_add(v1, gz.mul(u2));
    f[1][Z] = bz.mul_add(v4, gx.mul(w2));
    f[1][X | Y] = third.mul(ay.add(bx).mul_add(v3, lx.mul(w5)));
    f[1][Y | Z] = third.mul(ay.add(bz).mul_add(v6, lz.mul(u5)));
    f[1][X | Z] = third.mul(bxz.mul_add(v5, gz.mul_add(u6, gx.mul(w3))));
    f[1][X | Y | Z] = ninth.mul(ay.add(bxz).mul(v7));

    f[2][Z] = az.mul_add(w4, ly.mul_add(u1, lx.mul(v2)));
    f[2][X] = bx.mul_add(w1, gy.mul(u4));
    f[2][Y] = by.mul_add(w2, gx.mul(v4));
    f[2][X | Z] = third.mul(az.add(bx).mul_add(w5, lx.mul(v3)));
    f[2][Y | Z] = third.mul(az.add(by).mul_add(w6, ly.mul(u3)));
    f[2][X | Y] = third.mul(bxy.mul_add(w3, gy.mul_add(u6, gx.mul(v5))));
    f[2][X | Y | Z] = ninth.mul(az.add(bxy).mul(w7));
    f
}

/// Node values (x fastest) to parities along all three axes, in place: 24 additions.
#[inline(always)]
pub(super) fn to_parities<R, V: Simd<R>>(u: &mut [V; 8]) {
    for axis in [X, Y, Z] {
        for low in 0..8 {
            if low & axis == 0 {
                let (a, b) = (u[low], u[low | axis]);
                u[low] = a.add(b);
                u[low | axis] = b.sub(a);
            }
        }
    }
}

/// The transpose of [`to_parities`]: parity forces to node forces.
#[inline(always)]
pub(super) fn to_nodes<R, V: Simd<R>>(f: &mut [V; 8]) {
    for axis in [X, Y, Z] {
        for low in 0..8 {
            if low & axis == 0 {
                let (even, odd) = (f[low], f[low | axis]);
                f[low] = even.sub(odd);
                f[low | axis] = even.add(odd);
            }
        }
    }
}
