//! A step of Maxwell's law, exact for a constant rate of strain.

/// Ratio below which differences of exponentials are taken from their series. Unit: 1.
const SHORT: f64 = 0.5;

/// Terms of these series: the last one is below 1e-17 at [`SHORT`].
const TERMS: u32 = 20;

/// One step of `ṡ = 2G ė − s/τ`, e linear in time: with `x = Δt/τ`
/// ```text
/// s' = e^(−x) s + 2G φ Δe        φ = (1 − e^(−x))/x
/// ```
/// so that a step sees rock of shear modulus φ G and of its own bulk modulus. Order 2 where strain is not linear; stable and without
/// overshoot at any Δt: a body of springs and such rock takes `s'/s = 1 − (1 − e^(−x))/(1 + a φ)`, which lies between 0 and 1 for every
/// share a ≥ 0 of springs, and goes to backward Euler's `a/(a + x)` as x grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// x = Δt/τ. Unit: 1.
    ratio: f64,
}

impl Rule {
    /// For a step and a relaxation time τ = η/G [s].
    pub fn new(step: f64, relaxation: f64) -> Self {
        Self {
            ratio: step / relaxation,
        }
    }

    /// e^(−x): the share of s that is left where strain rests.
    pub fn kept(&self) -> f64 {
        (-self.ratio).exp()
    }

    /// 1 − e^(−x).
    pub fn lost(&self) -> f64 {
        -(-self.ratio).exp_m1()
    }

    /// φ: the share of G that a step sees; 1 where no time passes.
    pub fn stiffness(&self) -> f64 {
        match self.ratio {
            0.0 => 1.0,
            x => self.lost() / x,
        }
    }

    /// 1 − φ, without cancellation.
    pub fn flow(&self) -> f64 {
        match self.ratio {
            x if x < SHORT => series(1, |k| power(-x, k)),
            _ => 1.0 - self.stiffness(),
        }
    }

    /// `[∫a², ∫ab, ∫b²]` over the step, θ from 0 to 1, where `s(θ) = a s + b 2GΔe`, `a = e^(−xθ)`, `b = (1 − a)/x`.
    ///
    /// The energy that creep dissipates in the step is `Δt/(2η)` times `∫a² s:s + 2 ∫ab s:q + ∫b² q:q`, q = 2GΔe.
    pub fn squares(&self) -> [f64; 3] {
        let x = self.ratio;
        if x < SHORT {
            // φ(2x), (φ(x) − φ(2x))/x and (1 − 2φ(x) + φ(2x))/x², term by term
            let of = |k: u32| 2f64.powi(k as i32);
            let whole = 1.0 - series(1, |k| of(k) * power(-x, k));
            let mixed = series(1, |k| (of(k) - 1.0) * power(-x, k - 1));
            let late = series(2, |k| (of(k) - 2.0) * power(-x, k - 2));
            return [whole, -mixed, -late];
        }
        let (once, twice) = (self.stiffness(), Rule { ratio: 2.0 * x }.stiffness());
        [
            twice,
            (once - twice) / x,
            (1.0 - 2.0 * once + twice) / (x * x),
        ]
    }
}

/// `−Σ_{k ≥ from} c_k/(k+1)!`: terms of a series of φ(x) = Σ (−x)^k/(k+1)!, with their sign turned.
fn series(from: u32, c: impl Fn(u32) -> f64) -> f64 {
    let mut factorial: f64 = (1..=from).map(f64::from).product();
    let mut sum = 0.0;
    for k in from..from + TERMS {
        factorial *= f64::from(k + 1);
        sum -= c(k) / factorial;
    }
    sum
}

fn power(x: f64, k: u32) -> f64 {
    x.powi(k as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrals over the step by 4,000 midpoints.
    fn by_points(x: f64) -> [f64; 4] {
        let n = 4000;
        let mut sum = [0.0; 4];
        for i in 0..n {
            let theta = (f64::from(i) + 0.5) / f64::from(n);
            let a = (-x * theta).exp();
            let b = -(-x * theta).exp_m1() / x;
            for (s, v) in sum.iter_mut().zip([a * a, a * b, b * b, a]) {
                *s += v / f64::from(n);
            }
        }
        sum
    }

    #[test]
    fn integrals_are_those_of_the_path_on_both_sides_of_the_series() {
        for x in [1e-7, 1e-3, 0.1, 0.499_999, 0.5, 1.0, 4.85, 30.0] {
            let rule = Rule::new(x, 1.0);
            let exact = by_points(x);
            // the midpoint rule is wrong by x²/(24 n²)
            let close = 1e-7 * (1.0 + x * x);
            for (got, expected) in rule.squares().into_iter().zip(exact) {
                assert!(
                    (got - expected).abs() <= close * expected,
                    "{x}: {got} {expected}"
                );
            }
            assert!((rule.stiffness() - exact[3]).abs() <= close, "{x}");
            assert!((rule.flow() - (1.0 - rule.stiffness())).abs() <= 1e-15);
        }
    }

    #[test]
    fn the_series_meets_the_closed_form() {
        let [below, above] = [SHORT * (1.0 - 1e-15), SHORT].map(|x| Rule::new(x, 1.0));
        for (a, b) in below.squares().into_iter().zip(above.squares()) {
            assert!((a - b).abs() <= 1e-14 * a, "{a} {b}");
        }
        assert!((below.flow() - above.flow()).abs() <= 1e-15);
    }

    #[test]
    fn where_no_time_passes_rock_is_elastic() {
        let rule = Rule::new(0.0, 1.0);
        assert_eq!(
            (rule.kept(), rule.stiffness(), rule.flow()),
            (1.0, 1.0, 0.0)
        );
        assert_eq!(rule.squares()[0], 1.0);
    }
}
