//! Closed sets of the complex plane that hold eigenvalues.

use serde::{Deserialize, Serialize};

/// Where an eigenvalue fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Inside.
    Inside,
    /// A real eigenvalue outside its interval.
    Real,
    /// The real part of a non-real eigenvalue outside its interval.
    RealPart,
    /// An imaginary part too large.
    ImaginaryPart,
    /// Outside every disc of a statement.
    Disc,
}

/// An imaginary part below this times max(1, |λ|) is rounding: a double real eigenvalue splits by √ε.
pub const REAL_TOLERANCE: f64 = 1e-7;

/// True for an eigenvalue that counts as non-real.
pub fn is_non_real(re: f64, im: f64) -> bool {
    im.abs() > REAL_TOLERANCE * re.hypot(im).max(1.0)
}

/// `c₂|λ|² − 2c₁ Re λ + c₀ ≤ 0`: a disc with its centre on the real axis, what lies outside of one, or a half plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// c₂, c₁, c₀. Unit: 1.
    coefficients: [f64; 3],
}

impl Circle {
    /// From its coefficients.
    pub fn new(c_2: f64, c_1: f64, c_0: f64) -> Self {
        Self {
            coefficients: [c_2, c_1, c_0],
        }
    }

    /// `|λ − center| ≤ radius`.
    pub fn disc(center: f64, radius: f64) -> Self {
        Self::new(1.0, center, center * center - radius * radius)
    }

    /// How far λ lies outside, to first order; negative inside.
    pub fn distance(&self, re: f64, im: f64) -> f64 {
        let [c_2, c_1, c_0] = self.coefficients;
        let value = c_2 * (re * re + im * im) - 2.0 * c_1 * re + c_0;
        let gradient = 2.0 * (c_2 * re - c_1).hypot(c_2 * im);
        // the centre of a disc lies inside, the centre of a hole outside
        if value <= 0.0 {
            return value;
        }
        match self.ends() {
            (Some((low, high)), false) => (re - 0.5 * (low + high)).hypot(im) - 0.5 * (high - low),
            _ => value / gradient.max(f64::MIN_POSITIVE),
        }
    }

    /// Where its boundary crosses the real axis, and whether it is what lies outside; `None` for a half plane.
    fn ends(&self) -> (Option<(f64, f64)>, bool) {
        let [c_2, c_1, c_0] = self.coefficients;
        if c_2.abs() < 1e-9 * c_1.abs() {
            return (None, false);
        }
        let root = (c_1 * c_1 - c_2 * c_0).max(0.0).sqrt();
        let (p, q) = ((c_1 - root) / c_2, (c_1 + root) / c_2);
        (Some((p.min(q), p.max(q))), c_2 < 0.0)
    }

    /// True where every point of this disc lies in `other`, a disc too.
    fn lies_in(&self, other: &Self) -> bool {
        match (self.ends(), other.ends()) {
            ((Some(a), false), (Some(b), false)) => a.0 >= b.0 && a.1 <= b.1,
            // holes: the larger set has the smaller hole
            ((Some(a), true), (Some(b), true)) => a.0 <= b.0 && a.1 >= b.1,
            ((Some(a), false), (Some(b), true)) => a.0 >= b.1 || a.1 <= b.0,
            _ => false,
        }
    }

    fn part(&self) -> Part {
        let [_, c_1, c_0] = self.coefficients;
        match self.ends() {
            (Some((low, high)), false) => Part::Disc { low, high },
            (Some((low, high)), true) => Part::OutsideDisc { low, high },
            (None, _) => Part::HalfPlane {
                low: 0.5 * c_0 / c_1,
            },
        }
    }
}

/// A part of a [`Region`], as other tools read it. Discs have their centre on the real axis, which they cut at `low` and `high`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Part {
    /// Real eigenvalues.
    Interval {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Non-real eigenvalues.
    Box {
        /// Least Re λ.
        re_low: f64,
        /// Largest Re λ.
        re_high: f64,
        /// Largest |Im λ|; 0 where none is non-real.
        im_max: f64,
    },
    /// Non-real eigenvalues.
    Disc {
        /// Left end.
        low: f64,
        /// Right end.
        high: f64,
    },
    /// Non-real eigenvalues lie outside of this disc.
    OutsideDisc {
        /// Left end.
        low: f64,
        /// Right end.
        high: f64,
    },
    /// Non-real eigenvalues: Re λ is not below this.
    HalfPlane {
        /// Least Re λ.
        low: f64,
    },
    /// Non-real eigenvalues lie in one of these at least.
    AnyOf {
        /// Discs, outsides, half planes.
        parts: Vec<Part>,
    },
}

/// What is proved of a spectrum: an eigenvalue has to satisfy every statement about its kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// Real eigenvalues.
    pub real: Option<(f64, f64)>,
    /// Real parts of non-real eigenvalues.
    pub re: Option<(f64, f64)>,
    /// |Im λ| of non-real eigenvalues.
    pub im_max: Option<f64>,
    /// Non-real eigenvalues lie in one circle at least of every list.
    pub circles: Vec<Vec<Circle>>,
}

impl Region {
    /// Also in one of these circles; those inside another one are left out, and the box shrinks to what they reach.
    #[must_use]
    pub fn within(mut self, circles: &[Circle]) -> Self {
        let mut kept: Vec<Circle> = Vec::new();
        for circle in circles {
            if !kept.iter().any(|k| circle.lies_in(k)) {
                kept.retain(|k| !k.lies_in(circle));
                kept.push(*circle);
            }
        }
        let discs: Option<Vec<(f64, f64)>> = (kept.iter())
            .map(|circle| match circle.ends() {
                (Some(ends), false) => Some(ends),
                _ => None,
            })
            .collect();
        if let Some(ends) = discs.filter(|ends| !ends.is_empty()) {
            let low = ends.iter().fold(f64::INFINITY, |m, e| m.min(e.0));
            let high = ends.iter().fold(f64::NEG_INFINITY, |m, e| m.max(e.1));
            let radius = ends.iter().fold(0.0f64, |m, e| m.max(0.5 * (e.1 - e.0)));
            let re = self.re.unwrap_or((low, high));
            self.re = Some((re.0.max(low), re.1.min(high)));
            self.im_max = Some(self.im_max.unwrap_or(radius).min(radius));
        }
        if !kept.is_empty() {
            self.circles.push(kept);
        }
        self.closed()
    }

    /// The same; where nothing is left for non-real eigenvalues, there is none.
    #[must_use]
    pub fn closed(mut self) -> Self {
        if self.im_max == Some(0.0) || self.re.is_some_and(|(low, high)| low > high) {
            self.im_max = Some(0.0);
            self.re = self.real;
            self.circles.clear();
        }
        self
    }

    /// The statements one by one.
    pub fn parts(&self) -> Vec<Part> {
        let interval = self.real.map(|(low, high)| Part::Interval { low, high });
        let rectangle = self.re.zip(self.im_max);
        let rectangle = rectangle.map(|((re_low, re_high), im_max)| Part::Box {
            re_low,
            re_high,
            im_max,
        });
        let circles = self.circles.iter().map(|circles| match &circles[..] {
            [one] => one.part(),
            several => Part::AnyOf {
                parts: several.iter().map(Circle::part).collect(),
            },
        });
        interval
            .into_iter()
            .chain(rectangle)
            .chain(circles)
            .collect()
    }

    /// Judges one eigenvalue; `tolerance` is relative to max(1, |λ|).
    pub fn verdict(&self, re: f64, im: f64, tolerance: f64) -> Verdict {
        let slack = tolerance * re.hypot(im).max(1.0);
        let within = |interval: Option<(f64, f64)>, value: f64| {
            interval.is_none_or(|(low, high)| value >= low - slack && value <= high + slack)
        };
        if !is_non_real(re, im) {
            return if within(self.real, re) {
                Verdict::Inside
            } else {
                Verdict::Real
            };
        }
        let in_one = |circles: &Vec<Circle>| circles.iter().any(|c| c.distance(re, im) <= slack);
        if !within(self.re, re) {
            Verdict::RealPart
        } else if self.im_max.is_some_and(|limit| im.abs() > limit + slack) {
            Verdict::ImaginaryPart
        } else if !self.circles.iter().all(in_one) {
            Verdict::Disc
        } else {
            Verdict::Inside
        }
    }

    /// True when the region holds λ up to `tolerance`.
    pub fn contains(&self, re: f64, im: f64, tolerance: f64) -> bool {
        self.verdict(re, im, tolerance) == Verdict::Inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_are_discs_holes_and_half_planes() {
        let disc = Circle::disc(0.5, 0.5);
        assert_eq!(
            disc.part(),
            Part::Disc {
                low: 0.0,
                high: 1.0
            }
        );
        assert!(disc.distance(0.5, 0.5).abs() < 1e-15);
        assert!((disc.distance(0.5, 1.5) - 1.0).abs() < 1e-15);
        // |λ|² ≥ 1
        let hole = Circle::new(-1.0, 0.0, 1.0);
        assert_eq!(
            hole.part(),
            Part::OutsideDisc {
                low: -1.0,
                high: 1.0
            }
        );
        assert!(hole.distance(0.0, 0.0) > 0.9 && hole.distance(0.0, 2.0) < 0.0);
        let plane = Circle::new(0.0, 1.0, 2.0);
        assert_eq!(plane.part(), Part::HalfPlane { low: 1.0 });
        assert!((plane.distance(0.0, 7.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_lies_in_another_circle_is_left_out_and_an_empty_box_leaves_no_eigenvalue() {
        let region = Region {
            real: Some((0.1, 1.0)),
            re: Some((0.2, 3.0)),
            im_max: Some(2.0),
            ..Region::default()
        };
        let whole = [Circle::disc(0.5, 0.5), Circle::disc(0.7, 0.3)];
        let within = region.clone().within(&whole);
        assert_eq!(within.circles, [[whole[0]]]);
        assert_eq!((within.re, within.im_max), (Some((0.2, 1.0)), Some(0.5)));
        let none = within.within(&[Circle::disc(-1.0, 0.5)]);
        assert_eq!(none.im_max, Some(0.0));
        assert_eq!(none.verdict(0.5, 0.1, 1e-8), Verdict::ImaginaryPart);
        assert_eq!(none.verdict(0.5, 0.0, 1e-8), Verdict::Inside);
        assert_eq!(none.verdict(0.05, 0.0, 1e-8), Verdict::Real);
    }
}
