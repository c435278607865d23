//! Forces of any hexahedron from the modes of its displacement and of its shape, at 2×2×2 Gauss points.

use super::modes::{D_X, D_Y, D_Z};
use crate::mesh::jacobian::GAUSS;
use fracas_operators::Real;
use fracas_operators::simd::Lanes;

/// Modes with at least one difference: 1–7.
pub(super) const VARYING: usize = 7;

/// Factor of mode m in a derivative at Gauss points, but for ⅛: on [−1, 1]³ a field is
/// `⅛ Σ_m u_m ξ^(m & 1) η^(m>>1 & 1) ζ^(m>>2)`, so `∂/∂ξ` at `(±g, ±g)` weighs mode m by `⅛ g^(bits − 1)`, with g = 1/√3.
pub(super) const fn weight(m: usize) -> f64 {
    match m.count_ones() {
        0 => 0.0,
        1 => 1.0,
        2 => GAUSS,
        _ => 1.0 / 3.0,
    }
}

/// `∂/∂ξ_j` of one component: `[j][signs of the two other axes, lower axis first]`.
pub(super) type Derivatives<L> = [[L; 4]; 3];

/// Signs of the two axes other than j at Gauss point q (bit set = positive).
const fn face(j: usize, q: usize) -> usize {
    match j {
        0 => q >> 1,
        1 => q & 1 | (q >> 2) << 1,
        _ => q & 3,
    }
}

/// `[m_a − m_b, m_a + m_b]`.
#[inline(always)]
fn pair<R: Real, L: Lanes<R>>(a: L, b: L) -> [L; 2] {
    [a - b, a + b]
}

/// Derivatives along the reference axes from weighted modes; mode 0 is not read.
#[inline(always)]
pub(super) fn derivatives<R: Real, L: Lanes<R>>(m: &[L; 8]) -> Derivatives<L> {
    // On the planes of low and high ζ the field is bilinear.
    let x = pair(m[D_X], m[D_X | D_Z]);
    let y = pair(m[D_Y], m[D_Y | D_Z]);
    let twist = pair(m[D_X | D_Y], m[7]);
    let mut d = [[m[1]; 4]; 3];
    for z in 0..2 {
        [d[0][2 * z], d[0][2 * z + 1]] = pair(x[z], twist[z]);
        [d[1][2 * z], d[1][2 * z + 1]] = pair(y[z], twist[z]);
    }
    let mean = pair(m[D_Z], m[D_Y | D_Z]);
    let slope = pair(m[D_X | D_Z], m[7]);
    for y in 0..2 {
        [d[2][2 * y], d[2][2 * y + 1]] = pair(mean[y], slope[y]);
    }
    d
}

/// The adjoint of [`derivatives`]; mode 0 is zero.
#[inline(always)]
pub(super) fn modes_of_derivatives<R: Real, L: Lanes<R>>(d: &Derivatives<L>) -> [L; 8] {
    let zero = L::splat(R::zero());
    let (mut x, mut y, mut twist) = ([zero; 2], [zero; 2], [zero; 2]);
    for z in 0..2 {
        let ([x_low, x_high], [y_low, y_high]) = (
            [d[0][2 * z], d[0][2 * z + 1]],
            [d[1][2 * z], d[1][2 * z + 1]],
        );
        x[z] = x_low + x_high;
        y[z] = y_low + y_high;
        twist[z] = (x_high - x_low) + (y_high - y_low);
    }
    let (mut mean, mut slope) = ([zero; 2], [zero; 2]);
    for y in 0..2 {
        [slope[y], mean[y]] = pair(d[2][2 * y + 1], d[2][2 * y]);
    }
    let mut m = [zero; 8];
    m[D_X] = x[0] + x[1];
    m[D_Y] = y[0] + y[1];
    m[D_Z] = mean[0] + mean[1];
    m[D_X | D_Y] = twist[0] + twist[1];
    m[D_X | D_Z] = (x[1] - x[0]) + (slope[0] + slope[1]);
    m[D_Y | D_Z] = (y[1] - y[0]) + (mean[1] - mean[0]);
    m[7] = (twist[1] - twist[0]) + (slope[1] - slope[0]);
    m
}

/// Forces of Gauss point Q dual to the derivatives `du`, those of
/// `½ det J G (λ/G (tr ε)² + 2 ε:ε)`; the first point at a derivative sets its force in `df`, the second adds to it.
#[inline(always)]
pub(super) fn point<R: Real, L: Lanes<R>, const Q: usize>(
    x: &[Derivatives<L>; 3],
    du: &[Derivatives<L>; 3],
    ratio: L,
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
            cofactor[i][j] =
                (x[i1][j1][f1] * x[i2][j2][f2]).minus_product(x[i1][j2][f2], x[i2][j1][f1]);
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
    let scale = shear / det;
    let p = ratio * (g[0][0] + g[1][1] + g[2][2]);
    let (xy, xz, yz) = (
        scale * (g[0][1] + g[1][0]),
        scale * (g[0][2] + g[2][0]),
        scale * (g[1][2] + g[2][1]),
    );
    let stress = [
        [scale * (p + (g[0][0] + g[0][0])), xy, xz],
        [xy, scale * (p + (g[1][1] + g[1][1])), yz],
        [xz, yz, scale * (p + (g[2][2] + g[2][2]))],
    ];
    for a in 0..3 {
        for j in 0..3 {
            let force = &mut df[a][j][face(j, Q)];
            let last = if Q >> j & 1 == 0 {
                stress[a][2] * cofactor[2][j]
            } else {
                stress[a][2].mul_add(cofactor[2][j], *force)
            };
            *force =
                stress[a][0].mul_add(cofactor[0][j], stress[a][1].mul_add(cofactor[1][j], last));
        }
    }
}
