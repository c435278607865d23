//! Grid lines from cell sizes that grow away from where something happens.

use super::MeshError;
use super::error::AXES;

/// Cells of one size in zones, growing away from them:
/// ```text
/// h(x) = min(size + s dist(x, zones), largest)        s = ln growth
/// ```
/// Lines lie at equal steps of ξ, dξ = dx/h, between the ends of the zones and the points of `through`, which are lines themselves; the
/// steps are rounded down, so that no cell is larger than h nor, away from `through`, grows faster than asked. A zone may be a point.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeField {
    /// Start [m].
    pub from: f64,
    /// End [m].
    pub to: f64,
    /// Where cells are finest, [from, to] each [m].
    pub zones: Vec<[f64; 2]>,
    /// Points that are lines, though cells are no finer there [m].
    pub through: Vec<f64>,
    /// Cell size in zones [m].
    pub size: f64,
    /// Size of a cell over that of its finer neighbour away from the zones, at least 1.
    pub growth: f64,
    /// Size that no cell exceeds, or infinite [m].
    pub largest: f64,
}

/// How the size of cells depends on the distance d from the nearest zone: h(d) = min(size + slope d, largest).
#[derive(Clone, Copy, Debug)]
struct Law {
    size: f64,
    /// ln growth, or 0 inside a zone.
    slope: f64,
    largest: f64,
}

impl Law {
    /// Distance at which cells have become the largest.
    fn grown(self) -> f64 {
        (self.largest - self.size) / self.slope
    }

    /// ξ(d) = ∫₀ᵈ ds/h.
    fn steps(self, d: f64) -> f64 {
        if self.slope == 0.0 {
            return d / self.size;
        }
        let growing = d.min(self.grown());
        (self.slope * (growing / self.size)).ln_1p() / self.slope + (d - growing) / self.largest
    }

    /// d at which ξ(d) = ξ.
    fn distance(self, xi: f64) -> f64 {
        if self.slope == 0.0 {
            return self.size * xi;
        }
        let grown = self.grown();
        match grown.is_finite() && xi > self.steps(grown) {
            true => grown + self.largest * (xi - self.steps(grown)),
            false => self.size * (self.slope * xi).exp_m1() / self.slope,
        }
    }
}

/// A stretch between neighbouring ends of zones or of the axis, cut by lines that have to be there.
#[derive(Clone, Debug)]
struct Stretch {
    from: f64,
    to: f64,
    /// Its ends are ends of zones; at least one is.
    fine: [bool; 2],
    law: Law,
    /// Points inside that are lines, increasing.
    cuts: Vec<f64>,
}

impl Stretch {
    /// ∫ dx/h over the stretch.
    fn steps(&self) -> f64 {
        let length = self.to - self.from;
        match self.fine {
            [true, true] => 2.0 * self.law.steps(0.5 * length),
            _ => self.law.steps(length),
        }
    }

    /// ∫ dx/h from its start to x.
    fn steps_to(&self, x: f64) -> f64 {
        let (before, after) = (x - self.from, self.to - x);
        match self.fine {
            [true, true] if before <= after => self.law.steps(before),
            [_, true] => self.steps() - self.law.steps(after),
            _ => self.law.steps(before),
        }
    }

    /// The point after `done` steps, where `left` steps are left.
    fn point(&self, done: f64, left: f64) -> f64 {
        match self.fine {
            [true, true] if done <= left => self.from + self.law.distance(done),
            [_, true] => self.to - self.law.distance(left),
            _ => self.from + self.law.distance(done),
        }
    }

    /// Its pieces between cuts: end, steps before, steps inside, number of cells; 1e-6 of one is rounding.
    fn pieces(&self) -> impl Iterator<Item = (f64, f64, f64, f64)> {
        let total = self.steps();
        let ends = self.cuts.iter().copied().chain([self.to]);
        let mut before = 0.0;
        ends.map(move |end| {
            let until = match end == self.to {
                true => total,
                false => self.steps_to(end),
            };
            let start = std::mem::replace(&mut before, until);
            let inside = until - start;
            (end, start, inside, (inside - 1e-6).ceil().max(1.0))
        })
    }

    /// Number of cells.
    fn cells(&self) -> f64 {
        self.pieces().map(|(.., cells)| cells).sum()
    }

    /// Its lines without the first.
    fn lines(&self) -> impl Iterator<Item = f64> {
        let total = self.steps();
        self.pieces().flat_map(move |(end, start, inside, cells)| {
            let n = cells as usize;
            let part = move |k: usize| inside * k as f64 / n as f64;
            (1..=n).map(move |k| match k == n {
                true => end,
                false => self.point(start + part(k), (total - start - inside) + part(n - k)),
            })
        })
    }
}

impl SizeField {
    /// Stretches from start to end.
    fn stretches(&self, axis: char) -> Result<Vec<Stretch>, MeshError> {
        let bad = |parameter, value, requirement| MeshError::SizeField {
            axis,
            parameter,
            value,
            requirement,
        };
        if !(self.to > self.from && (self.to - self.from).is_finite()) {
            return Err(MeshError::EmptyAxis {
                axis,
                from: self.from,
                to: self.to,
            });
        }
        if !(self.size > 0.0 && self.size.is_finite()) {
            return Err(bad("size", self.size, "positive"));
        }
        if !(self.growth >= 1.0 && self.growth.is_finite()) {
            return Err(bad("growth", self.growth, "at least 1"));
        }
        if self.largest.is_nan() || self.largest < self.size {
            return Err(bad("largest", self.largest, "at least `size`"));
        }
        let outside = |value: &f64| !(self.from..=self.to).contains(value);
        let mut through = self.through.clone();
        if let Some(value) = through.iter().copied().find(outside) {
            return Err(bad("through", value, "inside the axis"));
        }
        through.sort_by(f64::total_cmp);
        through.dedup();
        let mut zones = self.zones.clone();
        zones.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let stretch = |from: f64, to: f64, fine, slope| Stretch {
            from,
            to,
            fine,
            law: Law {
                size: self.size,
                slope,
                largest: self.largest,
            },
            cuts: (through.iter().copied())
                .filter(|x| from < *x && *x < to)
                .collect(),
        };
        let slope = self.growth.ln();
        let (mut stretches, mut end, mut fine) = (Vec::new(), self.from, false);
        for [from, to] in zones {
            if let Some(value) = [from, to].into_iter().find(outside) {
                return Err(bad("near", value, "inside the axis"));
            }
            if from < end || to < from {
                return Err(bad("near", from, "beyond the zone before it"));
            }
            if from > end {
                stretches.push(stretch(end, from, [fine, true], slope));
            }
            if to > from {
                stretches.push(stretch(from, to, [true; 2], 0.0));
            }
            (end, fine) = (to, true);
        }
        if !fine {
            return Err(bad("near", f64::NAN, "given at least once"));
        }
        if self.to > end {
            stretches.push(stretch(end, self.to, [true, false], slope));
        }
        Ok(stretches)
    }

    /// Number of cells, without making them.
    ///
    /// # Errors
    /// [`MeshError`] for an empty axis, a size or growth that makes no sense, zones outside or overlapping.
    pub fn cells(&self, index: usize) -> Result<f64, MeshError> {
        let stretches = self.stretches(AXES[index])?;
        Ok(stretches.iter().map(Stretch::cells).sum())
    }

    /// Grid lines, increasing [m]; `index` (0–2) names the axis in errors.
    ///
    /// # Errors
    /// As [`SizeField::cells`].
    pub fn lines(&self, index: usize) -> Result<Vec<f64>, MeshError> {
        let mut lines = vec![self.from];
        for stretch in self.stretches(AXES[index])? {
            lines.extend(stretch.lines());
        }
        Ok(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(lines: &[f64]) -> Vec<f64> {
        lines.windows(2).map(|p| p[1] - p[0]).collect()
    }

    fn crack() -> SizeField {
        SizeField {
            from: -40.0,
            to: 40.0,
            zones: vec![[1.0, 1.0], [-1.0, -1.0]],
            through: Vec::new(),
            size: 0.02,
            growth: 1.2,
            largest: f64::INFINITY,
        }
    }

    #[test]
    fn points_are_lines_with_the_smallest_cells_and_growth_is_kept() {
        let lines = crack().lines(0).unwrap();
        assert_eq!((lines[0], lines[lines.len() - 1]), (-40.0, 40.0));
        for at in [-1.0, 1.0] {
            let i = lines.iter().position(|x| *x == at).unwrap();
            let h = sizes(&lines);
            for near in [h[i - 1], h[i]] {
                assert!(near <= 0.0222 && near > 0.017, "{near}");
            }
        }
        for pair in sizes(&lines).windows(2) {
            let ratio = pair[0] / pair[1];
            assert!((1.0 / 1.2001..=1.2001).contains(&ratio), "{ratio}");
        }
        // both halves mirror each other
        let mirrored: Vec<f64> = lines.iter().rev().map(|x| -x).collect();
        for (a, b) in lines.iter().zip(mirrored) {
            assert!((a - b).abs() < 1e-13);
        }
        assert_eq!(crack().cells(0).unwrap(), (lines.len() - 1) as f64);
    }

    #[test]
    fn a_zone_has_equal_cells() {
        let field = SizeField {
            zones: vec![[-1.25, 1.25]],
            size: 0.25,
            ..crack()
        };
        let lines = field.lines(0).unwrap();
        let inside: Vec<f64> = lines.iter().copied().filter(|x| x.abs() < 1.26).collect();
        assert_eq!(inside.len(), 11);
        assert!(sizes(&inside).iter().all(|h| (h - 0.25).abs() < 1e-14));
    }

    #[test]
    fn growth_one_is_uniform() {
        let field = SizeField {
            from: 0.0,
            to: 3.0,
            zones: vec![[0.0, 0.0]],
            size: 0.25,
            growth: 1.0,
            ..crack()
        };
        let lines = field.lines(2).unwrap();
        assert_eq!(lines.len(), 13);
        assert!(sizes(&lines).iter().all(|h| (h - 0.25).abs() < 1e-14));
    }

    /// Points that have to be lines are, no cell is larger than the law allows, and elsewhere lines stay where they were.
    #[test]
    fn lines_go_through_points_and_cells_stay_below_the_largest() {
        for case in 0..200u64 {
            let uniform = |k: u64| 0.5 * (1.0 + fracas_operators::random::signed(8 * case + k));
            let field = SizeField {
                zones: vec![[-3.0 - uniform(0), -2.0], [1.0, 1.0 + uniform(1)]],
                through: vec![-40.0 * uniform(2), 40.0 * uniform(3), 1.0, 40.0],
                size: 0.02 + uniform(4),
                growth: 1.0 + 0.5 * uniform(5),
                largest: 1.1 + 4.0 * uniform(6),
                ..crack()
            };
            let lines = field.lines(0).unwrap();
            assert_eq!(field.cells(0).unwrap(), (lines.len() - 1) as f64);
            for point in &field.through {
                assert!(lines.contains(point), "case {case}: {point}");
            }
            let distance = |x: f64| {
                let to = |[a, b]: &[f64; 2]| (a - x).max(x - b).max(0.0);
                field.zones.iter().map(to).fold(f64::INFINITY, f64::min)
            };
            let size = |x: f64| (field.size + field.growth.ln() * distance(x)).min(field.largest);
            for pair in lines.windows(2) {
                let h = pair[1] - pair[0];
                // ∫ dx/h ≤ 1 over a cell, in which h changes by ln growth per length
                let largest = size(0.5 * (pair[0] + pair[1])) + 0.5 * h * field.growth.ln();
                assert!(
                    h > 0.0 && h <= largest * (1.0 + 1e-5),
                    "case {case}: {h} {largest}"
                );
            }
            let free = SizeField {
                through: Vec::new(),
                largest: f64::INFINITY,
                ..field.clone()
            };
            let ends = field.zones.iter().flatten();
            let own = free.lines(0).unwrap();
            assert!(ends.copied().all(|end| own.contains(&end)));
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let refused = |change: &dyn Fn(&mut SizeField)| {
            let mut field = crack();
            change(&mut field);
            field.lines(2).unwrap_err().to_string()
        };
        assert_eq!(
            refused(&|f| f.size = 0.0),
            "axis z: size is 0; it must be positive"
        );
        assert_eq!(
            refused(&|f| f.growth = 0.9),
            "axis z: growth is 0.9; it must be at least 1"
        );
        assert_eq!(
            refused(&|f| f.zones[0] = [41.0, 41.0]),
            "axis z: near is 41; it must be inside the axis"
        );
        assert_eq!(
            refused(&|f| f.zones[0] = [-3.0, 0.0]),
            "axis z: near is -1; it must be beyond the zone before it"
        );
        assert!(refused(&|f| f.zones.clear()).contains("given at least once"));
        assert_eq!(
            refused(&|f| f.largest = 0.01),
            "axis z: largest is 0.01; it must be at least `size`"
        );
        assert!(refused(&|f| f.through = vec![41.0]).contains("through is 41; it must be inside"));
        assert!(refused(&|f| f.to = -40.0).contains("is empty"));
    }
}
