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

    /// Three vectors that hold x y z x y z … to the vectors of all x, all y, all z.
    fn deinterleave(xyz: [Self; 3]) -> [Self; 3];
    /// The inverse of [`deinterleave`](Self::deinterleave).
    fn interleave(components: [Self; 3]) -> [Self; 3];
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
    #[inline(always)]
    fn deinterleave(xyz: [Self; 3]) -> [Self; 3] {
        xyz
    }
    #[inline(always)]
    fn interleave(components: [Self; 3]) -> [Self; 3] {
        components
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Simd;
    use std::arch::x86_64::*;

    macro_rules! vector {
        ($name:ident, $doc:literal, $scalar:ty, $lanes:literal, $raw:ty, $set1:ident, $load:ident, $store:ident,
         $add:ident, $sub:ident, $mul:ident, $fma:ident, { $($shuffles:tt)* }) => {
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
                $($shuffles)*
            }
        };
    }

    /// Lane `l` of component `c` comes from entry `3 l + c` of the three vectors; two permutations per component: the first
    /// takes what the first two vectors hold, the second adds what the third holds.
    macro_rules! permuted {
        ($lanes:literal, $index:ty, $load_index:ident, $permute:ident) => {
            #[inline(always)]
            fn deinterleave(xyz: [Self; 3]) -> [Self; 3] {
                const L: usize = $lanes;
                const fn table(c: usize, second: bool) -> [$index; L] {
                    let mut t = [0; L];
                    let mut l = 0;
                    while l < L {
                        let entry = 3 * l + c;
                        t[l] = if second {
                            if entry < 2 * L {
                                l as $index
                            } else {
                                (entry - 2 * L + L) as $index
                            }
                        } else if entry < 2 * L {
                            entry as $index
                        } else {
                            0
                        };
                        l += 1;
                    }
                    t
                }
                const FIRST: [[$index; L]; 3] = [table(0, false), table(1, false), table(2, false)];
                const SECOND: [[$index; L]; 3] = [table(0, true), table(1, true), table(2, true)];
                std::array::from_fn(|c| unsafe {
                    let first = $load_index(FIRST[c].as_ptr().cast());
                    let second = $load_index(SECOND[c].as_ptr().cast());
                    let low = $permute(xyz[0].0, first, xyz[1].0);
                    Self($permute(low, second, xyz[2].0))
                })
            }
            #[inline(always)]
            fn interleave(components: [Self; 3]) -> [Self; 3] {
                const L: usize = $lanes;
                const fn table(v: usize, second: bool) -> [$index; L] {
                    let mut t = [0; L];
                    let mut l = 0;
                    while l < L {
                        let (lane, c) = ((v * L + l) / 3, (v * L + l) % 3);
                        t[l] = if second {
                            if c < 2 {
                                l as $index
                            } else {
                                (lane + L) as $index
                            }
                        } else if c < 2 {
                            (lane + c * L) as $index
                        } else {
                            0
                        };
                        l += 1;
                    }
                    t
                }
                const FIRST: [[$index; L]; 3] = [table(0, false), table(1, false), table(2, false)];
                const SECOND: [[$index; L]; 3] = [table(0, true), table(1, true), table(2, true)];
                std::array::from_fn(|v| unsafe {
                    let first = $load_index(FIRST[v].as_ptr().cast());
                    let second = $load_index(SECOND[v].as_ptr().cast());
                    let low = $permute(components[0].0, first, components[1].0);
                    Self($permute(low, second, components[2].0))
                })
            }
        };
    }

    /// The same through memory, where the instruction set has no permutation of two vectors.
    macro_rules! copied {
        ($scalar:ty, $lanes:literal) => {
            #[inline(always)]
            fn deinterleave(xyz: [Self; 3]) -> [Self; 3] {
                let mut flat = [0.0; 3 * $lanes];
                for (v, part) in xyz.into_iter().zip(flat.chunks_exact_mut($lanes)) {
                    v.store(part);
                }
                std::array::from_fn(|c| {
                    let lanes: [$scalar; $lanes] = std::array::from_fn(|l| flat[3 * l + c]);
                    Self::load(&lanes)
                })
            }
            #[inline(always)]
            fn interleave(components: [Self; 3]) -> [Self; 3] {
                let mut flat = [[0.0; $lanes]; 3];
                for (v, part) in components.into_iter().zip(&mut flat) {
                    v.store(part);
                }
                std::array::from_fn(|v| {
                    let lanes: [$scalar; $lanes] =
                        std::array::from_fn(|l| flat[(v * $lanes + l) % 3][(v * $lanes + l) / 3]);
                    Self::load(&lanes)
                })
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
        _mm512_fmadd_pd,
        {
            permuted!(8, i64, _mm512_loadu_epi64, _mm512_permutex2var_pd);
        }
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
        _mm512_fmadd_ps,
        {
            permuted!(16, i32, _mm512_loadu_epi32, _mm512_permutex2var_ps);
        }
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
        _mm256_fmadd_pd,
        {
            copied!(f64, 4);
        }
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
        _mm256_fmadd_ps,
        {
            copied!(f32, 8);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn shuffles<R: Real, V: Simd<R>>() {
        let entries: Vec<R> = (0..3 * V::LANES).map(|i| R::of(i as f64)).collect();
        let xyz = [0, 1, 2].map(|v| V::load(&entries[v * V::LANES..]));
        let mut lanes = vec![R::zero(); V::LANES];
        for (c, component) in V::deinterleave(xyz).into_iter().enumerate() {
            component.store(&mut lanes);
            for (l, value) in lanes.iter().enumerate() {
                assert_eq!(*value, R::of((3 * l + c) as f64));
            }
        }
        let back = V::interleave(V::deinterleave(xyz));
        for (v, vector) in back.into_iter().enumerate() {
            vector.store(&mut lanes);
            assert_eq!(lanes, entries[v * V::LANES..(v + 1) * V::LANES]);
        }
    }

    #[test]
    fn shuffles_separate_and_join_components() {
        shuffles::<f64, Scalar<f64>>();
        if InstructionSet::Avx2.is_available() {
            shuffles::<f64, F64x4>();
            shuffles::<f32, F32x8>();
        }
        if InstructionSet::Avx512.is_available() {
            shuffles::<f64, F64x8>();
            shuffles::<f32, F32x16>();
        }
    }
}
