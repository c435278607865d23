//! 512-bit registers.

use super::registers::registers;
use std::arch::x86_64::*;

/// Eight `f64`. Used only inside a kernel that `run_avx512` runs, on a machine that has AVX-512F.
#[derive(Clone, Copy)]
pub(super) struct Doubles(__m512d);

/// Sixteen `f32`. Used only inside a kernel that `run_avx512` runs, on a machine that has AVX-512F.
#[derive(Clone, Copy)]
pub(super) struct Singles(__m512);

registers!(
    Doubles,
    f64,
    8,
    _mm512_set1_pd,
    _mm512_loadu_pd,
    _mm512_storeu_pd,
    _mm512_add_pd,
    _mm512_sub_pd,
    _mm512_mul_pd,
    _mm512_fmadd_pd,
    _mm512_fnmadd_pd,
    _mm512_div_pd
);
registers!(
    Singles,
    f32,
    16,
    _mm512_set1_ps,
    _mm512_loadu_ps,
    _mm512_storeu_ps,
    _mm512_add_ps,
    _mm512_sub_ps,
    _mm512_mul_ps,
    _mm512_fmadd_ps,
    _mm512_fnmadd_ps,
    _mm512_div_ps
);

impl Doubles {
    /// The three entries of `from`, then zeros.
    #[inline(always)]
    fn first_three(from: &[f64]) -> Self {
        let from = &from[..3];
        // SAFETY: see the type; three entries are read.
        unsafe { Self(_mm512_maskz_loadu_pd(0b111, from.as_ptr())) }
    }

    /// Lane p from the part v for which `takes(v, p)`.
    #[inline(always)]
    fn blend([a, b, c]: [Self; 3], takes: impl Fn(usize, usize) -> bool) -> Self {
        let mask = |v: usize| (0..8).fold(0, |m, p| m | u8::from(takes(v, p)) << p);
        // SAFETY: see the type.
        unsafe {
            let ab = _mm512_mask_blend_pd(mask(1), a.0, b.0);
            Self(_mm512_mask_blend_pd(mask(2), ab, c.0))
        }
    }

    /// Lane p from lane `source(p)`.
    #[inline(always)]
    fn permuted(self, source: impl Fn(usize) -> usize) -> Self {
        let lanes: [i64; 8] = std::array::from_fn(|p| source(p) as i64);
        // SAFETY: see the type; the array has 64 bytes.
        unsafe {
            Self(_mm512_permutexvar_pd(
                _mm512_loadu_si512(lanes.as_ptr().cast()),
                self.0,
            ))
        }
    }

    /// `[before[7], self[0], …, self[6]]`.
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        // SAFETY: see the type.
        unsafe {
            let (low, high) = (_mm512_castpd_si512(before.0), _mm512_castpd_si512(self.0));
            Self(_mm512_castsi512_pd(_mm512_alignr_epi64::<7>(high, low)))
        }
    }
}

impl Singles {
    /// The three entries of `from`, then zeros.
    #[inline(always)]
    fn first_three(from: &[f32]) -> Self {
        let from = &from[..3];
        // SAFETY: see the type; three entries are read.
        unsafe { Self(_mm512_maskz_loadu_ps(0b111, from.as_ptr())) }
    }

    /// Lane p from the part v for which `takes(v, p)`.
    #[inline(always)]
    fn blend([a, b, c]: [Self; 3], takes: impl Fn(usize, usize) -> bool) -> Self {
        let mask = |v: usize| (0..16).fold(0, |m, p| m | u16::from(takes(v, p)) << p);
        // SAFETY: see the type.
        unsafe {
            let ab = _mm512_mask_blend_ps(mask(1), a.0, b.0);
            Self(_mm512_mask_blend_ps(mask(2), ab, c.0))
        }
    }

    /// Lane p from lane `source(p)`.
    #[inline(always)]
    fn permuted(self, source: impl Fn(usize) -> usize) -> Self {
        let lanes: [i32; 16] = std::array::from_fn(|p| source(p) as i32);
        // SAFETY: see the type; the array has 64 bytes.
        unsafe {
            Self(_mm512_permutexvar_ps(
                _mm512_loadu_si512(lanes.as_ptr().cast()),
                self.0,
            ))
        }
    }

    /// `[before[15], self[0], …, self[14]]`.
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        // SAFETY: see the type.
        unsafe {
            let (low, high) = (_mm512_castps_si512(before.0), _mm512_castps_si512(self.0));
            Self(_mm512_castsi512_ps(_mm512_alignr_epi32::<15>(high, low)))
        }
    }
}
