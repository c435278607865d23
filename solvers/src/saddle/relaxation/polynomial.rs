//! Polynomials that stand for `1/√x` away from zero and for one at zero.

/// `p(x) = 1 + c₁ x + … + c_d x^d` with `½ ≤ x p(x)² ≤ 1` on [0.63, end], the end as far out as the degree allows.
///
/// `x p²` touches its bounds in turn at d + 2 points, so p is the best approximation of its degree to `1/√x` there, in relative terms
/// and up to a factor (Chebyshev); the factor is such that p(0) = 1. On (0, end] p is between zero and
/// one; from zero to 0.63, `x p² ≤ ½`. The first is 1 − 4x/27.
#[derive(Debug)]
pub struct Polynomial {
    /// Unit: 1.
    pub end: f64,
    /// c₁, …, c_d. Unit: 1.
    pub coefficients: &'static [f64],
}

/// Degrees one to four. Source: derived here, from the d + 2 conditions above by Newton's method in 40 digits; tested.
pub const POLYNOMIALS: [Polynomial; 4] = [
    Polynomial {
        end: 4.5,
        coefficients: &[-4.0 / 27.0],
    },
    Polynomial {
        end: 11.222_811_207_869_6,
        coefficients: &[-0.171_302_027_741_427_5, 0.009_694_157_862_554_314],
    },
    Polynomial {
        end: 21.264_885_768_623_43,
        coefficients: &[
            -0.178_458_169_993_403_4,
            0.013_256_308_211_676_45,
            -3.167_893_486_143_846e-4,
        ],
    },
    Polynomial {
        end: 34.642_953_161_428_54,
        coefficients: &[
            -0.181_520_261_352_871,
            0.014_863_613_137_884_44,
            -5.081_154_030_341_738e-4,
            6.071_885_651_551_406e-6,
        ],
    },
];

impl Polynomial {
    /// The lowest degree whose end is not below `end`, otherwise the last.
    pub fn up_to(end: f64) -> &'static Self {
        let last = &POLYNOMIALS[POLYNOMIALS.len() - 1];
        POLYNOMIALS.iter().find(|p| p.end >= end).unwrap_or(last)
    }

    /// p(x).
    pub fn at(&self, x: f64) -> f64 {
        1.0 + x * self.coefficients.iter().rev().fold(0.0, |v, c| c + x * v)
    }

    /// d.
    pub fn degree(&self) -> usize {
        self.coefficients.len()
    }
}
