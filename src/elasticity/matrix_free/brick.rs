//! The stiffness of a brick between its two faces across y, in sums and differences along x and z.
//!
//! On a brick all products of modes vanish except those that one strain couples, so the modes fall into four groups that
//! share none: on each face three pairs (component; sum or difference along x and along z). A group is small enough for
//! the registers, from the displacements of both faces to the forces on them.

use fracas_operators::Real;
use fracas_operators::simd::Lanes;

/// Values on a face y = const of an element: `[component][along z][along x]`, 0 the sum, 1 the difference.
pub(super) type Face<L> = [[[L; 2]; 2]; 3];

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

/// `(u_0, u_1) → (u_0 + u_1, u_1 − u_0)`.
#[inline(always)]
pub(super) fn sum_and_difference<R: Real, L: Lanes<R>>(low: L, high: L) -> [L; 2] {
    [low + high, high - low]
}

/// The adjoint: `(F_p, F_d) → (F_p − F_d, F_p + F_d)`.
#[inline(always)]
pub(super) fn low_and_high<R: Real, L: Lanes<R>>([sum, difference]: [L; 2]) -> [L; 2] {
    [sum - difference, sum + difference]
}

/// The modes of each group, as their places `[component, along z, along x]` on a face.
pub(super) const GROUPS: [[[usize; 3]; 3]; 4] = [
    [[0, 0, 1], [1, 0, 0], [2, 1, 0]],
    [[0, 1, 0], [1, 1, 1], [2, 0, 1]],
    [[0, 0, 0], [1, 0, 1], [2, 1, 1]],
    [[0, 1, 1], [1, 1, 0], [2, 0, 0]],
];

/// The modes of a group on a face, by component.
pub(super) type Triple<L> = [L; 3];

/// A group of a face.
#[inline(always)]
pub(super) fn taken<L: Copy>(face: &Face<L>, group: usize) -> Triple<L> {
    let [[a, b, c], [d, e, f], [g, h, i]] = GROUPS[group];
    [face[a][b][c], face[d][e][f], face[g][h][i]]
}

/// Writes a group of a face.
#[inline(always)]
pub(super) fn put<L: Copy>(face: &mut Face<L>, group: usize, values: Triple<L>) {
    for (value, [c, z, x]) in values.into_iter().zip(GROUPS[group]) {
        face[c][z][x] = value;
    }
}

/// Forces `∂/∂u ½ ∫ λ (tr ε)² + 2G ε:ε` of one group: those on the face at low y added to `waiting`, those on the face at
/// high y.
///
/// Below `u v w` are the components of the displacement and `f g h` their forces; letters after the underscore name the
/// axes along which a mode is a difference, none where it is a sum. A factor per axis comes from ∫ over the unit
/// interval: 1/4 for a sum (its square is four times the mean's), 1/12 for a difference, hence the weights 1/16, 1/48
/// and 1/144 of modes with one, two and three differences. Means cost no force.
#[inline(always)]
pub(super) fn forces<R: Real, L: Lanes<R>>(
    group: usize,
    low: Triple<L>,
    high: Triple<L>,
    brick: Brick<L>,
    waiting: Triple<L>,
) -> [Triple<L>; 2] {
    let [r, s, t] = brick.inverse;
    let (lambda, shear) = (brick.lambda, brick.shear);
    let third = L::splat(R::of(1.0 / 3.0));
    let (lambda3, shear3) = (lambda * third, shear * third);
    let (shear_twice, shear3_twice) = (shear + shear, shear3 + shear3);
    let (r2, s2, t2) = (r * r, s * s, t * t);
    // Modes that vary along all axes: λ/9 + G/9 times the own axis, G/9 times all.
    let own = third * (lambda3 + shear3);
    let all = third * shear3 * ((r2 + t2) + s2);
    let [below_u, below_v, below_w] = waiting;
    match group {
        // Stretches of all axes, and those along x and z that bend along y.
        0 => {
            let [u_x, u_xy] = sum_and_difference(low[0], high[0]);
            let v_y = high[1] - low[1];
            let [w_z, w_yz] = sum_and_difference(low[2], high[2]);
            let (e_x, e_y, e_z) = (r * u_x, s * v_y, t * w_z);
            let p = lambda * (e_x + e_y + e_z);
            let (sigma_x, sigma_z) = (shear_twice.mul_add(e_x, p), shear_twice.mul_add(e_z, p));
            let g = s * shear_twice.mul_add(e_y, p);
            let (e_x, e_z) = (r * u_xy, t * w_yz);
            let p = lambda3 * (e_x + e_z);
            let stiff = shear3 * s2;
            let f_xy = stiff.mul_add(u_xy, r * shear3_twice.mul_add(e_x, p));
            let h_yz = stiff.mul_add(w_yz, t * shear3_twice.mul_add(e_z, p));
            [
                [
                    r.mul_add(sigma_x, below_u) - f_xy,
                    below_v - g,
                    t.mul_add(sigma_z, below_w) - h_yz,
                ],
                [r.mul_add(sigma_x, f_xy), g, t.mul_add(sigma_z, h_yz)],
            ]
        }
        // The shear of x and z; twists: shears that vary along the axis in neither direction; v along all axes.
        1 => {
            let [u_z, u_yz] = sum_and_difference(low[0], high[0]);
            let [v_xz, v_xyz] = sum_and_difference(low[1], high[1]);
            let [w_x, w_xy] = sum_and_difference(low[2], high[2]);
            let tau = shear * t.mul_add(u_z, r * w_x);
            let tau_xy = shear3 * s.mul_add(u_yz, r * v_xz);
            let tau_xz = shear3 * t.mul_add(u_yz, r * w_xy);
            let tau_yz = shear3 * t.mul_add(v_xz, s * w_xy);
            let f_yz = s.mul_add(tau_xy, t * tau_xz);
            let g_xz = r.mul_add(tau_xy, t * tau_yz);
            let h_xy = r.mul_add(tau_xz, s * tau_yz);
            let k = own.mul_add(s2, all);
            [
                [
                    t.mul_add(tau, below_u) - f_yz,
                    (below_v + g_xz).minus_product(k, v_xyz),
                    r.mul_add(tau, below_w) - h_xy,
                ],
                [
                    t.mul_add(tau, f_yz),
                    k.mul_add(v_xyz, g_xz),
                    r.mul_add(tau, h_xy),
                ],
            ]
        }
        // The shear of x and y; stretches along y and z that bend along x; w along all axes.
        2 => {
            let u_y = high[0] - low[0];
            let [v_x, v_xy] = sum_and_difference(low[1], high[1]);
            let [w_xz, w_xyz] = sum_and_difference(low[2], high[2]);
            let tau = shear * s.mul_add(u_y, r * v_x);
            let (e_y, e_z) = (s * v_xy, t * w_xz);
            let p = lambda3 * (e_y + e_z);
            let stiff = shear3 * r2;
            let f = s * tau;
            let g_xy = stiff.mul_add(v_xy, s * shear3_twice.mul_add(e_y, p));
            let h_xz = stiff.mul_add(w_xz, t * shear3_twice.mul_add(e_z, p));
            let k = own.mul_add(t2, all);
            [
                [
                    below_u - f,
                    r.mul_add(tau, below_v) - g_xy,
                    (below_w + h_xz).minus_product(k, w_xyz),
                ],
                [f, r.mul_add(tau, g_xy), k.mul_add(w_xyz, h_xz)],
            ]
        }
        // The shear of y and z; stretches along x and y that bend along z; u along all axes.
        _ => {
            let [u_xz, u_xyz] = sum_and_difference(low[0], high[0]);
            let [v_z, v_yz] = sum_and_difference(low[1], high[1]);
            let w_y = high[2] - low[2];
            let tau = shear * s.mul_add(w_y, t * v_z);
            let (e_x, e_y) = (r * u_xz, s * v_yz);
            let p = lambda3 * (e_x + e_y);
            let stiff = shear3 * t2;
            let f_xz = stiff.mul_add(u_xz, r * shear3_twice.mul_add(e_x, p));
            let g_yz = stiff.mul_add(v_yz, s * shear3_twice.mul_add(e_y, p));
            let h = s * tau;
            let k = own.mul_add(r2, all);
            [
                [
                    (below_u + f_xz).minus_product(k, u_xyz),
                    t.mul_add(tau, below_v) - g_yz,
                    below_w - h,
                ],
                [k.mul_add(u_xyz, f_xz), t.mul_add(tau, g_yz), h],
            ]
        }
    }
}

/// Forces of all groups on both faces.
#[inline(always)]
pub(super) fn all_forces<R: Real, L: Lanes<R>>(
    low: &Face<L>,
    high: &Face<L>,
    brick: Brick<L>,
) -> [Face<L>; 2] {
    let zero = L::splat(R::zero());
    let [mut near, mut far] = [[[[zero; 2]; 2]; 3]; 2];
    for group in 0..4 {
        let (u, v) = (taken(low, group), taken(high, group));
        let [f, g] = forces(group, u, v, brick, [zero; 3]);
        put(&mut near, group, f);
        put(&mut far, group, g);
    }
    [near, far]
}

/// Displacements of the corners of a face, `[component][x + 2z]`, as its modes.
#[inline(always)]
pub(super) fn to_face<R: Real, L: Lanes<R>>(corners: &[[L; 4]; 3]) -> Face<L> {
    let mut face = [[[L::splat(R::zero()); 2]; 2]; 3];
    for c in 0..3 {
        let [low_left, low_right, high_left, high_right] = corners[c];
        let left = sum_and_difference(low_left, high_left);
        let right = sum_and_difference(low_right, high_right);
        for z in 0..2 {
            face[c][z] = sum_and_difference(left[z], right[z]);
        }
    }
    face
}

/// The adjoint of [`to_face`]: forces on the corners.
#[inline(always)]
pub(super) fn to_corners<R: Real, L: Lanes<R>>(face: &Face<L>) -> [[L; 4]; 3] {
    let mut corners = [[L::splat(R::zero()); 4]; 3];
    for c in 0..3 {
        let (sums, differences) = (low_and_high(face[c][0]), low_and_high(face[c][1]));
        for x in 0..2 {
            [corners[c][x], corners[c][x + 2]] = low_and_high([sums[x], differences[x]]);
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elasticity::Elastic;
    use crate::elasticity::element::Geometry;
    use crate::elasticity::matrix_free::modes::LEXICOGRAPHIC;
    use crate::mesh::jacobian::CORNERS;
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
            let corners = |y: usize| {
                [0, 1, 2]
                    .map(|i| [0, 1, 4, 5].map(|m| L::splat(u[3 * LEXICOGRAPHIC[m + 2 * y] + i])))
            };
            let (low, high) = (to_face(&corners(0)), to_face(&corners(1)));
            let [near, far] = all_forces(&low, &high, brick);
            let f = [to_corners(&near), to_corners(&far)];
            let mut lanes = vec![0.0; L::WIDTH];
            for i in 0..3 {
                for (m, a) in LEXICOGRAPHIC.into_iter().enumerate() {
                    let row = &k[3 * a + i];
                    let expected: f64 = row.iter().zip(&u).map(|(k, u)| k * u).sum();
                    f[m / 2 % 2][i][m % 2 + m / 4 * 2].store(&mut lanes);
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
