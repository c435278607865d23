//! A register of nodes along x, on a line and on the line above it: from values at nodes to modes along x and z, and back.

use super::brick::{Face, low_and_high, sum_and_difference};
use fracas_operators::Real;
use fracas_operators::simd::{Lanes, MAX_WIDTH};

/// Modes along x and z of `WIDTH` consecutive elements, from their `WIDTH + 1` nodes on the low and the high line.
#[inline(always)]
pub(super) fn read<R: Real, L: Lanes<R>>(low: &[R], high: &[R]) -> Face<L> {
    let w = L::WIDTH;
    let (low, high) = (&low[..3 * w + 3], &high[..3 * w + 3]);
    let ([a, b, c], [d, e, f]) = (triples::<R, L>(low), triples::<R, L>(high));
    let sums = L::deinterleave([a + d, b + e, c + f]);
    let differences = L::deinterleave([d - a, e - b, f - c]);
    // The node to the right of the last element is in the last three lanes.
    let last = sum_and_difference(L::load(&low[2 * w + 3..]), L::load(&high[2 * w + 3..]));
    let mut face = [[[L::splat(R::zero()); 2]; 2]; 3];
    for c in 0..3 {
        for (z, left) in [sums[c], differences[c]].into_iter().enumerate() {
            let right = left.lowered(last[z], w - 3 + c);
            face[c][z] = sum_and_difference(left, right);
        }
    }
    face
}

/// The adjoint, added with a factor: `y += α F` at the `WIDTH` left nodes of the elements; `carried` are the forces that
/// the elements before put on their right nodes, `[component][along z]`, and become those of these elements.
#[inline(always)]
pub(super) fn add<R: Real, L: Lanes<R>>(
    face: &Face<L>,
    carried: &mut [[L; 2]; 3],
    alpha: R,
    low: &mut [R],
    high: &mut [R],
) {
    let zero = L::splat(R::zero());
    let (mut down, mut up) = ([zero; 3], [zero; 3]);
    for c in 0..3 {
        let mut modes = [zero; 2];
        for z in 0..2 {
            let [left, right] = low_and_high(face[c][z]);
            modes[z] = left + right.shifted(carried[c][z]);
            carried[c][z] = right;
        }
        [down[c], up[c]] = low_and_high(modes);
    }
    let alpha = L::splat(alpha);
    for (forces, y) in [(down, low), (up, high)] {
        let y = &mut y[..3 * L::WIDTH];
        let forces = L::interleave(forces);
        let values = triples::<R, L>(y);
        for v in 0..3 {
            alpha
                .mul_add(forces[v], values[v])
                .store(&mut y[L::WIDTH * v..]);
        }
    }
}

/// The last lane.
#[inline(always)]
pub(super) fn last<R: Real, L: Lanes<R>>(lanes: L) -> R {
    let mut all = [R::zero(); MAX_WIDTH];
    lanes.store(&mut all);
    all[L::WIDTH - 1]
}

/// Three registers of interleaved triples.
#[inline(always)]
fn triples<R: Real, L: Lanes<R>>(from: &[R]) -> [L; 3] {
    let w = L::WIDTH;
    [L::load(from), L::load(&from[w..]), L::load(&from[2 * w..])]
}
