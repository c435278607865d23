//! Registers of any machine: arrays of four, multiply and add rounded separately.

use super::Lanes;
use crate::Real;
use std::ops::{Add, Div, Mul, Sub};

const WIDTH: usize = 4;

/// Four scalars.
#[derive(Clone, Copy)]
pub(super) struct Array<R>([R; WIDTH]);

macro_rules! operation {
    ($trait:ident, $method:ident) => {
        impl<R: Real> $trait for Array<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for i in 0..WIDTH {
                    self.0[i] = self.0[i].$method(other.0[i]);
                }
                self
            }
        }
    };
}
operation!(Add, add);
operation!(Sub, sub);
operation!(Mul, mul);
operation!(Div, div);

impl<R: Real> Array<R> {
    #[inline(always)]
    fn flat(parts: [Self; 3]) -> [R; 3 * WIDTH] {
        let mut all = [R::zero(); 3 * WIDTH];
        for (chunk, part) in all.chunks_exact_mut(WIDTH).zip(parts) {
            chunk.copy_from_slice(&part.0);
        }
        all
    }
}

impl<R: Real> Lanes<R> for Array<R> {
    const WIDTH: usize = WIDTH;

    #[inline(always)]
    fn splat(value: R) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    fn load(from: &[R]) -> Self {
        let mut lanes = [R::zero(); WIDTH];
        lanes.copy_from_slice(&from[..WIDTH]);
        Self(lanes)
    }

    #[inline(always)]
    fn store(self, to: &mut [R]) {
        to[..WIDTH].copy_from_slice(&self.0);
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        self - a * b
    }

    #[inline(always)]
    fn shifted(self, before: Self) -> Self {
        let a = self.0;
        Self([before.0[WIDTH - 1], a[0], a[1], a[2]])
    }

    #[inline(always)]
    fn lowered(self, after: Self, lane: usize) -> Self {
        let a = self.0;
        Self([a[1], a[2], a[3], after.0[lane]])
    }

    #[inline(always)]
    fn deinterleave(triples: [Self; 3]) -> [Self; 3] {
        let t = Self::flat(triples);
        [0, 1, 2].map(|c| Self([t[c], t[3 + c], t[6 + c], t[9 + c]]))
    }

    #[inline(always)]
    fn interleave(components: [Self; 3]) -> [Self; 3] {
        let [x, y, z] = components.map(|c| c.0);
        [
            Self([x[0], y[0], z[0], x[1]]),
            Self([y[1], z[1], x[2], y[2]]),
            Self([z[2], x[3], y[3], z[3]]),
        ]
    }

    #[inline(always)]
    fn repeat(from: &[R], start: usize) -> Self {
        let mut lanes = [R::zero(); WIDTH];
        for (p, lane) in lanes.iter_mut().enumerate() {
            *lane = from[(start + p) % 3];
        }
        Self(lanes)
    }
}
