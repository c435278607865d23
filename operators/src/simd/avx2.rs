//! 256-bit registers.

use super::registers::registers;
use std::arch::x86_64::*;

/// Four `f64`. Used only inside a kernel that `run_avx2` runs, on a machine that has AVX2 and FMA.
#[derive(Clone, Copy)]
pub(super) struct Doubles(__m256d);

/// Eight `f32`. Used only inside a kernel that `run_avx2` runs, on a machine that has AVX2 and FMA.
#[derive(Clone, Copy)]
pub(super) struct Singles(__m256);

registers!(
    Doubles,
    f64,
    4,
    _mm256_set1_pd,
    _mm256_loadu_pd,
    _mm256_storeu_pd,
    _mm256_add_pd,
    _mm256_sub_pd,
    _mm256_mul_pd,
    _mm256_fmadd_pd,
    _mm256_fnmadd_pd,
    _mm256_div_pd
);
registers!(
    Singles,
    f32,
    8,
    _mm256_set1_ps,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_fmadd_ps,
    _mm256_fnmadd_ps,
    _mm256_div_ps
);

impl Doubles {
    /// The three entries of `from`, then zeros.
    #[inline(always)]
    fn first_three(from: &[f64]) -> Self {
        const MASK: [i64; 4] = [-1, -1, -1, 0];
        let from = &from[..3];
        // SAFETY: see the type; three entries are read.
        unsafe {
            let mask = _mm256_loadu_si256(MASK.as_ptr().cast());
            Self(_mm256_maskload_pd(from.as_ptr(), mask))
        }
    }

    /// Lane p from the part v for which `takes(v, p)`.
    #[inline(always)]
    fn blend([a, b, c]: [Self; 3], takes: impl Fn(usize, usize) -> bool) -> Self {
        let mask = |v: usize| -> [i64; 4] { std::array::from_fn(|p| -i64::from(takes(v, p))) };
        let (from_b, from_c) = (mask(1), mask(2));
        // SAFETY: see the type; the arrays have 32 bytes.
        unsafe {
            let from_b = _mm256_castsi256_pd(_mm256_loadu_si256(from_b.as_ptr().cast()));
            let from_c = _mm256_castsi256_pd(_mm256_loadu_si256(from_c.as_ptr().cast()));
            Self(_mm256_blendv_pd(
                _mm256_blendv_pd(a.0, b.0, from_b),
                c.0,
                from_c,
            ))
        }
    }

    /// Lane p from lane `source(p)`.
    #[inline(always)]
    fn permuted(self, source: impl Fn(usize) -> usize) -> Self {
        let halves: [i32; 8] = std::array::from_fn(|h| (2 * source(h / 2) + h % 2) as i32);
        // SAFETY: see the type; the array has 32 bytes.
        unsafe {
            let halves = _mm256_loadu_si256(halves.as_ptr().cast());
            Self(_mm256_castps_pd(_mm256_permutevar8x32_ps(
                _mm256_castpd_ps(self.0),
                halves,
            )))
        }
    }

    /// `[before[3], self[0], self[1], self[2]]`.
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        // SAFETY: see the type.
        unsafe {
            let middle = _mm256_permute2f128_pd::<0x21>(before.0, self.0);
            Self(_mm256_shuffle_pd::<0b0101>(middle, self.0))
        }
    }
}

impl Singles {
    /// The three entries of `from`, then zeros.
    #[inline(always)]
    fn first_three(from: &[f32]) -> Self {
        const MASK: [i32; 8] = [-1, -1, -1, 0, 0, 0, 0, 0];
        let from = &from[..3];
        // SAFETY: see the type; three entries are read.
        unsafe {
            let mask = _mm256_loadu_si256(MASK.as_ptr().cast());
            Self(_mm256_maskload_ps(from.as_ptr(), mask))
        }
    }

    /// Lane p from the part v for which `takes(v, p)`.
    #[inline(always)]
    fn blend([a, b, c]: [Self; 3], takes: impl Fn(usize, usize) -> bool) -> Self {
        let mask = |v: usize| -> [i32; 8] { std::array::from_fn(|p| -i32::from(takes(v, p))) };
        let (from_b, from_c) = (mask(1), mask(2));
        // SAFETY: see the type; the arrays have 32 bytes.
        unsafe {
            let from_b = _mm256_castsi256_ps(_mm256_loadu_si256(from_b.as_ptr().cast()));
            let from_c = _mm256_castsi256_ps(_mm256_loadu_si256(from_c.as_ptr().cast()));
            Self(_mm256_blendv_ps(
                _mm256_blendv_ps(a.0, b.0, from_b),
                c.0,
                from_c,
            ))
        }
    }

    /// Lane p from lane `source(p)`.
    #[inline(always)]
    fn permuted(self, source: impl Fn(usize) -> usize) -> Self {
        let lanes: [i32; 8] = std::array::from_fn(|p| source(p) as i32);
        // SAFETY: see the type; the array has 32 bytes.
        unsafe {
            Self(_mm256_permutevar8x32_ps(
                self.0,
                _mm256_loadu_si256(lanes.as_ptr().cast()),
            ))
        }
    }

    /// `[before[7], self[0], …, self[6]]`.
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        // SAFETY: see the type.
        unsafe {
            let (low, high) = (_mm256_castps_si256(before.0), _mm256_castps_si256(self.0));
            let middle = _mm256_permute2x128_si256::<0x21>(low, high);
            Self(_mm256_castsi256_ps(_mm256_alignr_epi8::<12>(high, middle)))
        }
    }
}
