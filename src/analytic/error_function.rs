//! The complementary error function and its integrals.

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

/// Argument from which on the continued fraction is taken. Unit: 1.
const FAR: f64 = 2.0;

/// Argument at which `erfc` is less than the smallest number. Unit: 1.
const NOTHING: f64 = 27.3;

/// Depth of the continued fraction: at [`FAR`] its rest is below the last digit.
const DEPTH: u32 = 120;

/// `erfc x` for x ≥ 0, to a few units in the last digit of 1.
fn erfc(x: f64) -> f64 {
    if x >= NOTHING {
        return 0.0;
    }
    if x >= FAR {
        // √π e^(x²) erfc x = 1/(x + ½/(x + 1/(x + 3/2/(x + …))))
        let tail = (1..=DEPTH)
            .rev()
            .fold(0.0, |rest, k| 0.5 * f64::from(k) / (x + rest));
        return (-x * x).exp() / (PI.sqrt() * (x + tail));
    }
    // erf x = 2/√π e^(−x²) Σ 2^k x^(2k+1)/(1·3·…·(2k+1))
    let (mut term, mut sum, mut odd) = (x, x, 1.0);
    while term > f64::EPSILON * 1e-3 * sum {
        odd += 2.0;
        term *= 2.0 * x * x / odd;
        sum += term;
    }
    1.0 - FRAC_2_SQRT_PI * (-x * x).exp() * sum
}

/// `i^n erfc x` for n = 0 to 3 and x ≥ 0: each is the integral of the one before from x on.
///
/// # Source
/// H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 2nd ed., Oxford 1959, appendix II.
pub(super) fn integrals_of_erfc(x: f64) -> [f64; 4] {
    let zeroth = erfc(x);
    let first = 0.5 * FRAC_2_SQRT_PI * (-x * x).exp() - x * zeroth;
    let second = 0.25 * (zeroth - 2.0 * x * first);
    let third = (first - 2.0 * x * second) / 6.0;
    [zeroth, first, second, third]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_tables() {
        for (x, expected) in [
            (0.0, 1.0),
            (0.5, 0.479_500_122_186_953_5),
            (1.0, 0.157_299_207_050_285_13),
            (2.0, 4.677_734_981_047_266e-3),
            (3.0, 2.209_049_699_858_544e-5),
            (5.0, 1.537_459_794_428_035e-12),
        ] {
            let [found, ..] = integrals_of_erfc(x);
            assert!(
                (found - expected).abs() <= 4e-16 + 1e-13 * expected,
                "erfc {x}: {found} {expected}"
            );
        }
    }

    #[test]
    fn each_is_the_integral_of_the_one_before() {
        // Simpson's rule, far beyond where anything is left
        let (n, end) = (40_000, 9.0);
        for x in [0.0, 0.3, 1.1, 1.9, 2.1, 3.0] {
            let h = (end - x) / f64::from(n);
            let mut sums = [0.0; 3];
            for k in 0..=n {
                let weight = match k {
                    0 => 1.0,
                    k if k == n => 1.0,
                    k if k % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                let at = integrals_of_erfc(x + h * f64::from(k));
                (0..3).for_each(|i| sums[i] += weight * h / 3.0 * at[i]);
            }
            let own = integrals_of_erfc(x);
            for i in 0..3 {
                assert!(
                    (sums[i] - own[i + 1]).abs() < 1e-13,
                    "{x}, {i}: {:e}",
                    sums[i] - own[i + 1]
                );
            }
        }
    }
}
