//! Symmetric 3×3 blocks by six numbers.

use super::Matrix3;
use crate::Real;

/// A symmetric 3×3 block by its upper part: xx, xy, xz, yy, yz, zz.
pub type Symmetric<R> = [R; 6];

/// The upper part of a block.
#[inline(always)]
pub fn upper<R: Real>(m: &Matrix3<R>) -> Symmetric<R> {
    [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]]
}

/// The block of an upper part.
#[inline(always)]
pub fn full<R: Real>(s: &Symmetric<R>) -> Matrix3<R> {
    let [xx, xy, xz, yy, yz, zz] = *s;
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}
