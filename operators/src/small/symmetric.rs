//! Symmetric 3×3 blocks by six numbers.

use super::Matrix3;
use crate::Real;

/// A symmetric 3×3 block by its upper part: xx, xy, xz, yy, yz, zz.
pub type Symmetric<R> = [R; 6];

/// Where the upper part of a symmetric block keeps the entry (i, j).
pub const PLACE: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

/// The upper part of a block.
#[inline(always)]
pub fn upper<R: Real>(m: &Matrix3<R>) -> Symmetric<R> {
    [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]]
}

/// `S v`.
#[inline(always)]
pub fn symmetric_times<R: Real>(s: &Symmetric<R>, v: &[R; 3]) -> [R; 3] {
    super::times(&PLACE.map(|row| row.map(|k| s[k])), v)
}
