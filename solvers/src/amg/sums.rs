//! Row sums of 3×3 blocks in registers.

use fracas_operators::Real;
use fracas_operators::simd::{Lanes, MAX_WIDTH};

/// Nine products of each block, summed lane by lane: `b_{rc} x_c` in lane 3r + c.
pub(super) struct Sums<L, R> {
    low: L,
    high: L,
    last: R,
}

impl<R: Real, L: Lanes<R>> Sums<L, R> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self {
            low: L::splat(R::zero()),
            high: L::splat(R::zero()),
            last: R::zero(),
        }
    }

    /// Adds the products of the block at `values[at..]` with x.
    #[inline(always)]
    pub(super) fn add(&mut self, values: &[R], at: usize, x: &[R]) {
        self.low = L::load(&values[at..]).mul_add(L::repeat(x, 0), self.low);
        if L::WIDTH == 4 {
            self.high = L::load(&values[at + 4..]).mul_add(L::repeat(x, 1), self.high);
        }
        if L::WIDTH <= 8 {
            self.last += values[at + 8] * x[2];
        }
    }

    /// Row sums.
    #[inline(always)]
    pub(super) fn finish(self) -> [R; 3] {
        let mut lanes = [R::zero(); 2 * MAX_WIDTH];
        self.low.store(&mut lanes);
        if L::WIDTH == 4 {
            self.high.store(&mut lanes[4..]);
        }
        if L::WIDTH <= 8 {
            lanes[8] = self.last;
        }
        [
            lanes[0] + lanes[1] + lanes[2],
            lanes[3] + lanes[4] + lanes[5],
            lanes[6] + lanes[7] + lanes[8],
        ]
    }
}
