//! Grid lines from cell sizes that grow away from where something happens.

use super::MeshError;
use super::error::AXES;

/// Cells of one size in zones, growing away from them:
/// ```text
/// h(x) = size + s dist(x, zones)        s = ln growth
/// ```
/// Lines lie at equal steps of ξ, dξ = dx/h, between the ends of the zones, which are lines themselves; the steps are
/// rounded down, so that no cell is larger than h nor grows faster than asked. A zone may be a point.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeField {
    /// Start [m].
    pub from: f64,
    /// End [m].
    pub to: f64,
    /// Where cells are finest, [from, to] each [m].
    pub zones: Vec<[f64; 2]>,
    /// Cell size there [m].
    pub size: f64,
    /// Size of a cell over that of its finer neighbour away from the zones, at least 1.
    pub growth: f64,
}

/// A stretch between neighbouring ends of zones or of the axis.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    from: f64,
    to: f64,
    /// Its ends are ends of zones; at least one is.
    fine: [bool; 2],
    /// ln growth, or 0 inside a zone.
    slope: f64,
}

impl Stretch {
    /// Length over which cells grow: all of it from one fine end, half of it from each of two.
    fn reach(self) -> f64 {
        let length = self.to - self.from;
        if self.fine == [true; 2] {
            0.5 * length
        } else {
            length
        }
    }

    /// ∫ dx/h over the stretch.
    fn steps(self, size: f64) -> f64 {
        let halves = if self.fine == [true; 2] { 2.0 } else { 1.0 };
        let relative = self.reach() / size;
        match self.slope > 0.0 {
            true => halves * (self.slope * relative).ln_1p() / self.slope,
            false => halves * relative,
        }
    }

    /// Distance from a fine end after ξ.
    fn distance(self, size: f64, xi: f64) -> f64 {
        match self.slope > 0.0 {
            true => size * (self.slope * xi).exp_m1() / self.slope,
            false => size * xi,
        }
    }

    /// Number of cells; 1e-6 of one is rounding.
    fn cells(self, size: f64) -> f64 {
        (self.steps(size) - 1e-6).ceil().max(1.0)
    }

    /// Its lines without the first.
    fn lines(self, size: f64) -> impl Iterator<Item = f64> {
        let (steps, n) = (self.steps(size), self.cells(size) as usize);
        let xi = move |k: usize| steps * k as f64 / n as f64;
        (1..=n).map(move |k| match (k == n, self.fine) {
            (true, _) => self.to,
            (_, [true, true]) if 2 * k <= n => self.from + self.distance(size, xi(k)),
            (_, [_, true]) => self.to - self.distance(size, xi(n - k)),
            _ => self.from + self.distance(size, xi(k)),
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
        let mut zones = self.zones.clone();
        zones.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let slope = self.growth.ln();
        let (mut stretches, mut end, mut fine) = (Vec::new(), self.from, false);
        for [from, to] in zones {
            for value in [from, to] {
                if !(self.from..=self.to).contains(&value) {
                    return Err(bad("near", value, "inside the axis"));
                }
            }
            if from < end || to < from {
                return Err(bad("near", from, "beyond the zone before it"));
            }
            if from > end {
                stretches.push(Stretch {
                    from: end,
                    to: from,
                    fine: [fine, true],
                    slope,
                });
            }
            if to > from {
                stretches.push(Stretch {
                    from,
                    to,
                    fine: [true; 2],
                    slope: 0.0,
                });
            }
            (end, fine) = (to, true);
        }
        if !fine {
            return Err(bad("near", f64::NAN, "given at least once"));
        }
        if self.to > end {
            stretches.push(Stretch {
                from: end,
                to: self.to,
                fine: [true, false],
                slope,
            });
        }
        Ok(stretches)
    }

    /// Number of cells, without making them.
    ///
    /// # Errors
    /// [`MeshError`] for an empty axis, a size or growth that makes no sense, zones outside or overlapping.
    pub fn cells(&self, index: usize) -> Result<f64, MeshError> {
        let stretches = self.stretches(AXES[index])?;
        Ok(stretches.iter().map(|s| s.cells(self.size)).sum())
    }

    /// Grid lines, increasing [m]; `index` (0–2) names the axis in errors.
    ///
    /// # Errors
    /// As [`SizeField::cells`].
    pub fn lines(&self, index: usize) -> Result<Vec<f64>, MeshError> {
        let mut lines = vec![self.from];
        for stretch in self.stretches(AXES[index])? {
            lines.extend(stretch.lines(self.size));
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
            size: 0.02,
            growth: 1.2,
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
        };
        let lines = field.lines(2).unwrap();
        assert_eq!(lines.len(), 13);
        assert!(sizes(&lines).iter().all(|h| (h - 0.25).abs() < 1e-14));
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
        assert!(refused(&|f| f.to = -40.0).contains("is empty"));
    }
}
