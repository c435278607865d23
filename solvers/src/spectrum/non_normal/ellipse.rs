//! Ellipses with foci on the real line, and polynomials that are small on them and 1 at zero.

use std::f64::consts::PI;

/// `{z : |z − c − f| + |z − c + f| = 2a}`: on it `|T_k((z − c)/f)| ≤ (R^k + R^−k)/2`, `R = (a + b)/f`, `b² = a² − f²`. f = 0 is a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    center: f64,
    focus: f64,
    /// a.
    half_axis: f64,
}

/// A piece of the upper half of an ellipse.
pub(super) struct Arc {
    from: f64,
    to: f64,
}

impl Arc {
    /// The upper half in an even number of pieces.
    pub(super) fn upper_half(pieces: usize) -> Vec<Self> {
        let end = |k: usize| PI * k as f64 / pieces as f64;
        (0..pieces)
            .map(|k| Self {
                from: end(k),
                to: end(k + 1),
            })
            .collect()
    }

    /// Both halves.
    pub(super) fn halves(&self) -> [Self; 2] {
        let (from, to) = (self.from, self.to);
        let middle = 0.5 * (from + to);
        [Self { from, to: middle }, Self { from: middle, to }]
    }
}

impl Ellipse {
    /// Half the sum of the distances to the foci: a of the ellipse through a point.
    fn level(center: f64, focus: f64, [x, y]: [f64; 2]) -> f64 {
        0.5 * ((x - center - focus).hypot(y) + (x - center + focus).hypot(y))
    }

    fn half_height(&self) -> f64 {
        (self.half_axis * self.half_axis - self.focus * self.focus)
            .max(0.0)
            .sqrt()
    }

    /// a + b.
    fn sum(&self) -> f64 {
        self.half_axis + self.half_height()
    }

    /// The confocal one through zero.
    fn through_zero(&self) -> Self {
        Self {
            half_axis: self.center.abs(),
            ..*self
        }
    }

    /// How much the best Chebyshev polynomial of a high degree gains per degree: below 1 where zero lies outside.
    fn rate(&self) -> f64 {
        match self.through_zero() {
            zero if self.center.abs() > self.focus => self.sum() / zero.sum(),
            _ => f64::INFINITY,
        }
    }

    /// For a few shares of focal distance to extent, the ellipse around these points of the least rate; none holds zero.
    pub(super) fn around(points: &[[f64; 2]]) -> Vec<Self> {
        /// f over half the extent along the real axis.
        const FOCI: [f64; 5] = [0.0, 0.5, 0.8, 0.95, 1.0];
        const CENTERS: usize = 81;
        let low = points.iter().fold(f64::INFINITY, |m, p| m.min(p[0]));
        let high = points.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[0]));
        let top = points.iter().fold(0.0, |m: f64, p| m.max(p[1].abs()));
        let (extent, size) = (0.5 * (high - low), high.abs().max(low.abs()));
        let reach = extent + 2.0 * top + 0.1 * size;
        let best = |share: &f64| {
            let focus = share * extent;
            let candidates = (0..CENTERS).map(|k| {
                let place = 2.0 * k as f64 / (CENTERS - 1) as f64 - 1.0;
                let center = 0.5 * (low + high) + place * reach;
                let level = |p: &[f64; 2]| Self::level(center, focus, *p);
                Self {
                    center,
                    focus,
                    half_axis: points.iter().map(level).fold(focus, f64::max),
                }
            });
            candidates.min_by(|a, b| a.rate().total_cmp(&b.rate()))
        };
        let found = FOCI.iter().filter_map(best);
        found.filter(|ellipse| ellipse.rate() < 1.0).collect()
    }

    /// The confocal one that lies at this share of the way, in logarithms of a + b, from itself to the one through zero.
    pub(super) fn toward_zero(&self, share: f64) -> Self {
        let end = self.through_zero().sum();
        // a cluster in a point has no extent to start from
        let start = self.sum().max(1e-3 * end).max(self.focus);
        let sum = start * (end / start).powf(share);
        Self {
            half_axis: 0.5 * (sum + self.focus * self.focus / sum),
            ..*self
        }
    }

    /// Most that `T_k((z − c)/f)/T_k(−c/f)` is inside.
    pub(super) fn polynomial(&self, k: usize) -> f64 {
        let (sum, zero) = (self.sum(), self.through_zero().sum());
        let k = i32::try_from(k).unwrap_or(i32::MAX);
        let correction = |sum: f64| match self.focus {
            0.0 => 1.0,
            focus => 1.0 + (focus / sum).powi(2).powi(k),
        };
        (sum / zero).powi(k) * correction(sum) / correction(zero)
    }

    pub(super) fn is_circle(&self) -> bool {
        self.focus == 0.0
    }

    /// A point of an arc and a length that no part of the arc exceeds.
    pub(super) fn arc(&self, arc: &Arc) -> ([f64; 2], f64) {
        let (a, b) = (self.half_axis, self.half_height());
        let middle = 0.5 * (arc.from + arc.to);
        // no arc holds a multiple of π/2 inside, so that sine and cosine are largest at an end
        let largest = |f: fn(f64) -> f64| f(arc.from).abs().max(f(arc.to).abs());
        let speed = (a * largest(f64::sin)).hypot(b * largest(f64::cos));
        let point = [self.center + a * middle.cos(), b * middle.sin()];
        (point, speed * (arc.to - arc.from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chebyshev_polynomials_stay_below_what_is_said_of_them_and_are_one_at_zero() {
        let ellipse = Ellipse {
            center: 2.0,
            focus: 0.8,
            half_axis: 1.3,
        };
        // T_k by its recurrence, complex
        let t = |k: usize, (re, im): (f64, f64)| {
            let (mut before, mut now) = ((1.0, 0.0), (re, im));
            for _ in 1..k {
                let next = (
                    2.0 * (re * now.0 - im * now.1) - before.0,
                    2.0 * (re * now.1 + im * now.0) - before.1,
                );
                (before, now) = (now, next);
            }
            now.0.hypot(now.1)
        };
        for k in 1..12 {
            let at_zero = t(k, (-2.0 / 0.8, 0.0));
            let mut most = 0.0_f64;
            for i in 0..400 {
                let angle = PI * f64::from(i) / 399.0;
                let point = (
                    ellipse.half_axis * angle.cos() / ellipse.focus,
                    ellipse.half_height() * angle.sin() / ellipse.focus,
                );
                most = most.max(t(k, point) / at_zero);
            }
            let bound = ellipse.polynomial(k);
            assert!(
                most <= bound * (1.0 + 1e-12) && most >= 0.99 * bound,
                "{k}: {most}, {bound}"
            );
        }
    }

    #[test]
    fn arcs_add_up_to_no_less_than_the_circumference_and_hold_the_points() {
        let circle = Ellipse {
            center: 3.0,
            focus: 0.0,
            half_axis: 2.0,
        };
        let length = |n| {
            Arc::upper_half(n)
                .iter()
                .map(|arc| circle.arc(arc).1)
                .sum::<f64>()
        };
        assert!(length(64) > 2.0 * PI && length(64) < 1.05 * 2.0 * PI);
        let points = [[0.5, 0.3], [1.4, -0.2], [1.0, 0.0]];
        let all = Ellipse::around(&points);
        assert_eq!(all.len(), 5);
        for ellipse in all {
            assert!(ellipse.rate() < 1.0);
            for p in points {
                assert!(Ellipse::level(ellipse.center, ellipse.focus, p) <= ellipse.half_axis);
            }
        }
        assert!(Ellipse::around(&[[-1.0, 0.0], [1.0, 0.0]]).is_empty());
    }
}
