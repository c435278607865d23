//! Sums and differences of the eight corner values of an element.
//!
//! Along each axis a pair (u_0, u_1) becomes the sum p = u_0 + u_1 and the difference d = u_1 − u_0. Mode m of a
//! component has a difference along x, y, z where bit 0, 1, 2 of m is set: `D_X = 1` stretches along x and is constant
//! in the other axes, `D_X | D_Y` varies along both.

use super::brick::{Face, low_and_high, sum_and_difference};
use fracas_operators::Real;
use fracas_operators::simd::Lanes;

/// Difference along x.
pub(super) const D_X: usize = 1;
/// Difference along y.
pub(super) const D_Y: usize = 2;
/// Difference along z.
pub(super) const D_Z: usize = 4;

/// Corner a of an element (VTK order) in the order x fastest.
pub(super) const LEXICOGRAPHIC: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// Modes of component c from those along x and z on the faces at low and high y.
#[inline(always)]
pub(super) fn across<R: Real, L: Lanes<R>>([low, high]: &[Face<L>; 2], c: usize) -> [L; 8] {
    let mut modes = [L::splat(R::zero()); 8];
    for z in 0..2 {
        for x in 0..2 {
            let m = (x * D_X) | (z * D_Z);
            [modes[m], modes[m | D_Y]] = sum_and_difference(low[c][z][x], high[c][z][x]);
        }
    }
    modes
}

/// The adjoint of [`across`], written to component c of both faces.
#[inline(always)]
pub(super) fn to_both<R: Real, L: Lanes<R>>(
    modes: &[L; 8],
    [low, high]: &mut [Face<L>; 2],
    c: usize,
) {
    for z in 0..2 {
        for x in 0..2 {
            let m = (x * D_X) | (z * D_Z);
            [low[c][z][x], high[c][z][x]] = low_and_high([modes[m], modes[m | D_Y]]);
        }
    }
}
