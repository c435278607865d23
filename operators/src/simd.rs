//! Vectors of scalars for hot kernels, and which of them the processor has: asked once, at run time, so that the default
//! build is fast.
//!
//! A kernel is written once, generic over [`Simd`], inlined into one wrapper per instruction set
//! (`#[target_feature(enable = "avx512f")]`, …), and called through [`instruction_set`]. Only there do the methods below
//! become single instructions.

use crate::Real;
use std::sync::OnceLock;

/// Instruction sets that kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    /// 512-bit vectors with fused multiply-add.
    Avx512,
    /// 256-bit vectors with fused multiply-add.
    Avx2,
    /// What every processor of the target has.
    Baseline,
}

impl InstructionSet {
    /// True when this processor has it.
    pub fn is_available(self) -> bool {
        match (self, instruction_set()) {
            (Self::Baseline, _) | (_, Self::Avx512) => true,
            (wanted, best) => wanted == best,
        }
    }
}

/// The best instruction set of this processor.
pub fn instruction_set() -> InstructionSet {
    static FOUND: OnceLock<InstructionSet> = OnceLock::new();
    *FOUND.get_or_init(|| {
        #[cfg(target_arch = "x86_64")]
        {
            let fused = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if fused && is_x86_feature_detected!("avx512f") {
                return InstructionSet::Avx512;
            }
            if fused {
                return InstructionSet::Avx2;
            }
        }
        InstructionSet::Baseline
    })
}

/// A few scalars side by side.
pub trait Simd<R>: Copy {
    /// Scalars in one vector.
    const LANES: usize;

    /// The same scalar in every lane.
    fn splat(value: R) -> Self;
    /// The first [`LANES`](Self::LANES) entries of `from`, which must hold that many.
    fn load(from: &[R]) -> Self;
    /// Writes the lanes over the first entries of `to`, which must hold that many.
    fn store(self, to: &mut [R]);
    /// `self + other`.
    fn add(self, other: Self) -> Self;
    /// `self − other`.
    fn sub(self, other: Self) -> Self;
    /// `self · other`.
    fn mul(self, other: Self) -> Self;
    /// `self · factor + term`; one rounding where the instruction set has it.
    fn mul_add(self, factor: Self, term: Self) -> Self;
}

/// One lane, any processor: products and sums stay separate, since a fused one would be a library call.
#[derive(Clone, Copy, Debug)]
pub struct Scalar<R>(R);

impl<R: Real> Simd<R> for Scalar<R> {
    const LANES: usize = 1;
    #[inline(always)]
    fn splat(value: R) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn load(from: &[R]) -> Self {
        Self(from[0])
    }
    #[inline(always)]
    fn store(self, to: &mut [R]) {
        to[0] = self.0;
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0 * factor.0 + term.0)
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Simd;
    use std::arch::x86_64::*;

    macro_rules! vector {
        ($name:ident, $doc:literal, $scalar:ty, $lanes:literal, $raw:ty, $set1:ident, $load:ident, $store:ident,
         $add:ident, $sub:ident, $mul:ident, $fma:ident) => {
            #[doc = $doc]
            #[derive(Clone, Copy, Debug)]
            pub struct $name($raw);

            // SAFETY of every call below: values of this type are made only inside kernels that were entered after
            // `instruction_set` had found the instructions; lengths are asserted.
            impl Simd<$scalar> for $name {
                const LANES: usize = $lanes;
                #[inline(always)]
                fn splat(value: $scalar) -> Self {
                    Self(unsafe { $set1(value) })
                }
                #[inline(always)]
                fn load(from: &[$scalar]) -> Self {
                    assert!(from.len() >= $lanes);
                    Self(unsafe { $load(from.as_ptr()) })
                }
                #[inline(always)]
                fn store(self, to: &mut [$scalar]) {
                    assert!(to.len() >= $lanes);
                    unsafe { $store(to.as_mut_ptr(), self.0) }
                }
                #[inline(always)]
                fn add(self, other: Self) -> Self {
                    Self(unsafe { $add(self.0, other.0) })
                }
                #[inline(always)]
                fn sub(self, other: Self) -> Self {
                    Self(unsafe { $sub(self.0, other.0) })
                }
                #[inline(always)]
                fn mul(self, other: Self) -> Self {
                    Self(unsafe { $mul(self.0, other.0) })
                }
                #[inline(always)]
                fn mul_add(self, factor: Self, term: Self) -> Self {
                    Self(unsafe { $fma(self.0, factor.0, term.0) })
                }
            }
        };
    }

    vector!(
        F64x8,
        "Eight doubles (AVX-512).",
        f64,
        8,
        __m512d,
        _mm512_set1_pd,
        _mm512_loadu_pd,
        _mm512_storeu_pd,
        _mm512_add_pd,
        _mm512_sub_pd,
        _mm512_mul_pd,
        _mm512_fmadd_pd
    );
    vector!(
        F32x16,
        "Sixteen singles (AVX-512).",
        f32,
        16,
        __m512,
        _mm512_set1_ps,
        _mm512_loadu_ps,
        _mm512_storeu_ps,
        _mm512_add_ps,
        _mm512_sub_ps,
        _mm512_mul_ps,
        _mm512_fmadd_ps
    );
    vector!(
        F64x4,
        "Four doubles (AVX2).",
        f64,
        4,
        __m256d,
        _mm256_set1_pd,
        _mm256_loadu_pd,
        _mm256_storeu_pd,
        _mm256_add_pd,
        _mm256_sub_pd,
        _mm256_mul_pd,
        _mm256_fmadd_pd
    );
    vector!(
        F32x8,
        "Eight singles (AVX2).",
        f32,
        8,
        __m256,
        _mm256_set1_ps,
        _mm256_loadu_ps,
        _mm256_storeu_ps,
        _mm256_add_ps,
        _mm256_sub_ps,
        _mm256_mul_ps,
        _mm256_fmadd_ps
    );
}

#[cfg(target_arch = "x86_64")]
pub use x86::{F32x8, F32x16, F64x4, F64x8};
#[cfg(not(target_arch = "x86_64"))]
mod portable {
    use super::Scalar;
    /// One double where there is no wider vector.
    pub type F64x8 = Scalar<f64>;
    /// One double where there is no wider vector.
    pub type F64x4 = Scalar<f64>;
    /// One single where there is no wider vector.
    pub type F32x16 = Scalar<f32>;
    /// One single where there is no wider vector.
    pub type F32x8 = Scalar<f32>;
}
#[cfg(not(target_arch = "x86_64"))]
pub use portable::{F32x8, F32x16, F64x4, F64x8};
