//! Sums and differences of the eight corner values of an element.
//!
//! Along each axis a pair (u_0, u_1) becomes the sum p = u_0 + u_1 and the difference d = u_1 − u_0. Mode m of a
//! component has a difference along x, y, z where bit 0, 1, 2 of m is set: `D_X = 1` stretches along x and is constant
//! in the other axes, `D_X | D_Y` varies along both.

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
