//! Vector registers: one generic kernel, compiled for AVX-512, for AVX2 with FMA and for any machine, chosen at run time.
//!
//! A kernel is a [`Kernel`] whose `run` is generic in its [`Lanes`]; [`Level::run`] calls the best compiled version. A
//! [`Level`] exists only where the machine has its instructions, so the methods of [`Lanes`] are safe.
#![allow(unsafe_code, reason = "instructions that the processor was asked for")]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod dispatch;
mod portable;
#[cfg(target_arch = "x86_64")]
mod registers;

#[cfg(target_arch = "x86_64")]
pub(crate) use dispatch::Dispatch;

/// Runs on the registers of any machine, whatever the scalar.
#[cfg(target_arch = "x86_64")]
pub(crate) fn run_portable<R: Real>(kernel: impl Kernel<R>) {
    kernel.run::<portable::Array<R>>();
}

use crate::Real;
use std::ops::{Add, Div, Mul, Sub};
use std::sync::OnceLock;

/// Largest [`Lanes::WIDTH`] of any level and scalar: paddings of this length suit all of them.
pub const MAX_WIDTH: usize = 16;

/// A vector register of [`WIDTH`](Self::WIDTH) scalars. `WIDTH` is a power of two.
pub trait Lanes<R>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Scalars per register.
    const WIDTH: usize;

    /// All lanes equal to `value`.
    fn splat(value: R) -> Self;

    /// The first `WIDTH` entries.
    fn load(from: &[R]) -> Self;

    /// Writes the first `WIDTH` entries.
    fn store(self, to: &mut [R]);

    /// `self · factor + term`, fused where the machine fuses.
    fn mul_add(self, factor: Self, term: Self) -> Self;

    /// `self − a·b`, fused where the machine fuses.
    fn minus_product(self, a: Self, b: Self) -> Self;

    /// Lanes moved up by one place, the last lane of `before` entering at the bottom.
    fn shifted(self, before: Self) -> Self;

    /// Lanes moved down by one place, lane `lane` of `after` entering at the top.
    fn lowered(self, after: Self, lane: usize) -> Self;

    /// Three registers of interleaved triples `x y z x y z …` as `[x, y, z]`.
    fn deinterleave(triples: [Self; 3]) -> [Self; 3];

    /// The inverse of [`deinterleave`](Self::deinterleave).
    fn interleave(components: [Self; 3]) -> [Self; 3];

    /// The first three entries over and over: lane p holds `from[(start + p) mod 3]`.
    fn repeat(from: &[R], start: usize) -> Self;
}

/// Bytes that memory moves at once.
pub const CACHE_LINE: usize = 64;

/// Asks for the cache line of `data[index]`, which may lie behind the end; changes nothing but time.
#[inline(always)]
pub fn prefetch<T>(data: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch never faults.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(data.as_ptr().wrapping_add(index).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (data, index);
}

/// Work that runs on vector registers. Mark `run` and whatever it calls `#[inline(always)]`, and keep lanes out of
/// closures (`map`, `fold`): instructions beyond the baseline are generated only inside the body that [`Level::run`]
/// compiles for them.
pub trait Kernel<R> {
    /// Runs on registers `L`.
    fn run<L: Lanes<R>>(self);
}

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Portable,
}

/// What all of this process use.
static BEST: OnceLock<Level> = OnceLock::new();

impl Level {
    /// Instruction sets of this machine, best first.
    pub fn supported() -> impl Iterator<Item = Self> {
        let mut sets = [None; 3];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") {
                sets[0] = Some(Self(Set::Avx512));
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets[1] = Some(Self(Set::Avx2));
            }
        }
        sets[2] = Some(Self(Set::Portable));
        sets.into_iter().flatten()
    }

    /// The best instruction set of this machine, or the one that was [preferred](Self::prefer).
    pub fn best() -> Self {
        *BEST.get_or_init(|| Self::supported().next().unwrap_or(Self(Set::Portable)))
    }

    /// Takes this instruction set for all that follows in this process: sums are rounded as on a machine that has no better one. False
    /// where another one is in use already.
    pub fn prefer(self) -> bool {
        *BEST.get_or_init(|| self) == self
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2 fma",
            Set::Portable => "portable",
        }
    }

    /// [`Lanes::WIDTH`] of its registers.
    pub fn width<R: Real>(self) -> usize {
        struct Width<'a>(&'a mut usize);
        impl<R: Real> Kernel<R> for Width<'_> {
            #[inline(always)]
            fn run<L: Lanes<R>>(self) {
                *self.0 = L::WIDTH;
            }
        }
        let mut width = 0;
        self.run::<R>(Width(&mut width));
        width
    }

    /// Runs `kernel` with this instruction set.
    #[inline]
    pub fn run<R: Real>(self, kernel: impl Kernel<R>) {
        match self.0 {
            // SAFETY: a `Level` with this set exists only if the machine has it.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { R::run_avx512(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { R::run_avx2(kernel) },
            Set::Portable => kernel.run::<portable::Array<R>>(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks every operation against scalars.
    struct Laws;

    impl<R: Real> Kernel<R> for Laws {
        #[inline(always)]
        fn run<L: Lanes<R>>(self) {
            let w = L::WIDTH;
            assert!(w.is_power_of_two() && w <= MAX_WIDTH);
            let data: Vec<R> = (0..3 * w).map(|i| R::of((i * i + 1) as f64)).collect();
            let read = |lanes: L| {
                let mut out = vec![R::nan(); w];
                lanes.store(&mut out);
                out
            };
            let (a, b, c) = (L::load(&data), L::load(&data[w..]), L::load(&data[2 * w..]));
            for i in 0..w {
                let (x, y, z) = (data[i], data[w + i], data[2 * w + i]);
                assert_eq!(read(a + b)[i], x + y);
                assert_eq!(read(a - b)[i], x - y);
                assert_eq!(read(a * b)[i], x * y);
                assert_eq!(read(a.mul_add(b, c))[i], x * y + z);
                assert_eq!(read(c.minus_product(a, b))[i], z - x * y);
                assert_eq!(read(a / b)[i], x / y);
                assert_eq!(read(L::splat(y))[i], y);
                assert_eq!(read(b.shifted(a))[i], data[w + i - 1]);
                for lane in 0..w {
                    let entering = data[2 * w + lane];
                    let expected = if i + 1 < w { data[w + i + 1] } else { entering };
                    assert_eq!(read(b.lowered(c, lane))[i], expected);
                }
            }
            for start in 0..3 {
                for (p, value) in read(L::repeat(&data[w..w + 3], start))
                    .into_iter()
                    .enumerate()
                {
                    assert_eq!(value, data[w + (start + p) % 3]);
                }
            }
            let split = L::deinterleave([a, b, c]);
            for (component, lanes) in split.iter().enumerate() {
                for (k, value) in read(*lanes).into_iter().enumerate() {
                    assert_eq!(value, data[3 * k + component]);
                }
            }
            let joined: Vec<R> = L::interleave(split).into_iter().flat_map(read).collect();
            assert_eq!(joined, data);
        }
    }

    #[test]
    fn registers_of_every_level_agree_with_scalars() {
        for level in Level::supported() {
            level.run::<f64>(Laws);
            level.run::<f32>(Laws);
        }
    }
}
