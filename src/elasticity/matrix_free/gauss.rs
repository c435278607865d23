//! Forces of any hexahedron from the modes of its displacement and of its shape, at 2×2×2 Gauss points.

use super::modes::{D_X, D_Y, D_Z, Modes};
use crate::elasticity::element::GAUSS;
use fracas_operators::Real;
use fracas_operators::simd::Lanes;

/// Modes with at least one difference: 1–7.
pub(super) const VARYING: usize = 7;

/// Factor of mode m in a derivative at Gauss points: on [−1, 1]³ a field is `⅛ Σ_m u_m ξ^(m & 1) η^(m>>1 & 1) ζ^(m>>2)`,
/// so `∂/∂ξ` at `(±g, ±g)` weighs mode m by `⅛ g^(bits − 1)`, with g = 1/√3.
pub(super) const fn weight(m: usize) -> f64 {
    match m.count_ones() {
        0 => 0.0,
        1 => 0.125,
        2 => 0.125 * GAUSS,
        _ => 0.125 / 3.0,
    }
}

/// `∂/∂ξ_j` of one component: `[j][signs of the two other axes, lower axis first]`.
type Derivatives<L> = [[L; 4]; 3];

/// Signs of the two axes other than j at Gauss point q (bit set = positive).
const fn face(j: usize, q: usize) -> usize {
    match j {
        0 => q >> 1,
        1 => q & 1 | (q >> 2) << 1,
        _ => q & 3,
    }
}

/// Derivatives along the reference axes from weighted modes.
#[inline(always)]
fn derivatives<R: Real, L: Lanes<R>>(m: &[L; 8]) -> Derivatives<L> {
    let mut d = [[m[0]; 4]; 3];
    for j in 0..3 {
        let (low, high) = [(D_Y, D_Z), (D_X, D_Z), (D_X, D_Y)][j];
        let axis = 1 << j;
        let (plus, minus) = (m[axis] + m[axis | low], m[axis] - m[axis | low]);
        let (twist_plus, twist_minus) = (m[axis | high] + m[7], m[axis | high] - m[7]);
        d[j] = [
            minus - twist_minus,
            plus - twist_plus,
            minus + twist_minus,
            plus + twist_plus,
        ];
    }
    d
}

/// The adjoint of [`derivatives`].
#[inline(always)]
fn modes_of_derivatives<R: Real, L: Lanes<R>>(d: &Derivatives<L>) -> [L; 8] {
    let zero = L::splat(R::zero());
    let mut m = [zero; 8];
    for j in 0..3 {
        let (low, high) = [(D_Y, D_Z), (D_X, D_Z), (D_X, D_Y)][j];
        let axis = 1 << j;
        let [mm, pm, mp, pp] = d[j];
        let (plus, minus) = (pm + pp, mm + mp);
        let (twist_plus, twist_minus) = (pp - pm, mp - mm);
        m[axis] = plus + minus;
        m[axis | low] = m[axis | low] + (plus - minus);
        m[axis | high] = m[axis | high] + (twist_plus + twist_minus);
        m[7] = m[7] + (twist_plus - twist_minus);
    }
    m
}

/// Forces dual to the modes `u` of a hexahedron whose corner positions have the weighted modes `shape`:
/// `F = ∂/∂u ½ Σ_q det J (λ (tr ε)² + 2G ε:ε)`.
#[inline(always)]
pub(super) fn forces<R: Real, L: Lanes<R>>(
    u: &Modes<L>,
    shape: &Modes<L>,
    lambda: L,
    shear: L,
) -> Modes<L> {
    let zero = L::splat(R::zero());
    let mut x = [[[zero; 4]; 3]; 3];
    let mut du = [[[zero; 4]; 3]; 3];
    for c in 0..3 {
        x[c] = derivatives(&shape[c]);
        let mut weighted = u[c];
        for m in 1..8 {
            weighted[m] = weighted[m] * L::splat(R::of(weight(m)));
        }
        du[c] = derivatives(&weighted);
    }
    let mut df = [[[zero; 4]; 3]; 3];
    point::<R, L, 0>(&x, &du, lambda, shear, &mut df);
    point::<R, L, 1>(&x, &du, lambda, shear, &mut df);
    point::<R, L, 2>(&x, &du, lambda, shear, &mut df);
    point::<R, L, 3>(&x, &du, lambda, shear, &mut df);
    point::<R, L, 4>(&x, &du, lambda, shear, &mut df);
    point::<R, L, 5>(&x, &du, lambda, shear, &mut df);
    point::<R, L, 6>(&x, &du, lambda, shear, &mut df);
    point::<R, L, 7>(&x, &du, lambda, shear, &mut df);
    let mut f = [[zero; 8]; 3];
    for a in 0..3 {
        f[a] = modes_of_derivatives(&df[a]);
        for m in 1..8 {
            f[a][m] = f[a][m] * L::splat(R::of(weight(m)));
        }
    }
    f
}

/// Adds the forces of Gauss point Q, dual to the derivatives `du`, to `df`.
#[inline(always)]
fn point<R: Real, L: Lanes<R>, const Q: usize>(
    x: &[Derivatives<L>; 3],
    du: &[Derivatives<L>; 3],
    lambda: L,
    shear: L,
    df: &mut [Derivatives<L>; 3],
) {
    let zero = L::splat(R::zero());
    // cof J = det J · J⁻ᵀ, rows: space, columns: reference.
    let mut cofactor = [[zero; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            let (f1, f2) = (face(j1, Q), face(j2, Q));
            cofactor[i][j] = x[i1][j1][f1] * x[i2][j2][f2] - x[i1][j2][f2] * x[i2][j1][f1];
        }
    }
    let c = &cofactor[0];
    let det = x[0][0][face(0, Q)].mul_add(
        c[0],
        x[0][1][face(1, Q)].mul_add(c[1], x[0][2][face(2, Q)] * c[2]),
    );
    // g = det J · ∇u; the force dual to ∂u/∂ξ is σ(∇u) cof J = σ(g)/det J · cof J.
    let mut g = [[zero; 3]; 3];
    for a in 0..3 {
        for i in 0..3 {
            let row = &cofactor[i];
            g[a][i] = row[0].mul_add(
                du[a][0][face(0, Q)],
                row[1].mul_add(du[a][1][face(1, Q)], row[2] * du[a][2][face(2, Q)]),
            );
        }
    }
    let inverse = det.reciprocal();
    let (lambda, shear) = (lambda * inverse, shear * inverse);
    let p = lambda * (g[0][0] + g[1][1] + g[2][2]);
    let twice = shear + shear;
    let (xy, xz, yz) = (
        shear * (g[0][1] + g[1][0]),
        shear * (g[0][2] + g[2][0]),
        shear * (g[1][2] + g[2][1]),
    );
    let stress = [
        [twice.mul_add(g[0][0], p), xy, xz],
        [xy, twice.mul_add(g[1][1], p), yz],
        [xz, yz, twice.mul_add(g[2][2], p)],
    ];
    for a in 0..3 {
        for j in 0..3 {
            let sum = &mut df[a][j][face(j, Q)];
            *sum = stress[a][0].mul_add(
                cofactor[0][j],
                stress[a][1].mul_add(cofactor[1][j], stress[a][2].mul_add(cofactor[2][j], *sum)),
            );
        }
    }
}
