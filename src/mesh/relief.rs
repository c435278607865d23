//! A height over x and y.

/// A height that is bilinear between the points of a lattice and constant beyond it.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Lines of the lattice across x and y, increasing, at least one each [m].
    lines: [Vec<f64>; 2],
    /// Heights, x first [m].
    heights: Vec<f64>,
}

impl Relief {
    /// The same height everywhere [m].
    pub fn level(height: f64) -> Self {
        Self {
            lines: [vec![0.0], vec![0.0]],
            heights: vec![height],
        }
    }

    /// Heights at the points of a lattice, x first [m].
    ///
    /// # Panics
    /// If lines do not increase, or if there is not one height per point.
    pub fn new(lines: [Vec<f64>; 2], heights: Vec<f64>) -> Self {
        let increase = |l: &Vec<f64>| l.windows(2).all(|pair| pair[0] < pair[1]);
        let points = lines[0].len() * lines[1].len();
        assert!(points > 0 && heights.len() == points && lines.iter().all(increase));
        Self { lines, heights }
    }

    /// Lines of the lattice across x (0) or y (1) [m].
    pub fn lines(&self, axis: usize) -> &[f64] {
        &self.lines[axis]
    }

    /// Height over a point [m].
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let n = self.lines[0].len();
        let (along, across) = (place(&self.lines[0], x), place(&self.lines[1], y));
        let row = |j: usize| {
            let row = &self.heights[j * n..][..n];
            mix(row[along.0], row[along.1], along.2)
        };
        match across.2 {
            0.0 => row(across.0),
            share => mix(row(across.0), row(across.1), share),
        }
    }

    /// The height, where it is the same everywhere [m].
    pub fn is_level(&self) -> Option<f64> {
        let first = self.heights[0];
        self.heights.iter().all(|z| *z == first).then_some(first)
    }

    /// Lines in x (0) or y (1) at which it may bend, strictly inside an interval [m].
    pub fn bends(&self, axis: usize, [from, to]: [f64; 2]) -> impl Iterator<Item = f64> + '_ {
        let lines = self.lines[axis].iter().copied();
        // a lattice of one line across an axis does not vary along it
        let several = self.lines[axis].len() > 1;
        lines.filter(move |x| several && from < *x && *x < to)
    }

    /// Whether heights differ along x (0) or y (1).
    pub fn varies(&self, axis: usize) -> bool {
        let n = self.lines[0].len();
        let stride = [1, n][axis];
        let last = self.lines[axis].len() - 1;
        (0..self.heights.len())
            .filter(|p| [p % n, p / n][axis] < last)
            .any(|p| self.heights[p] != self.heights[p + stride])
    }

    /// Points of a rectangle, its corners among them, between which it is bilinear.
    pub fn points(&self, rectangle: [[f64; 2]; 2]) -> Vec<[f64; 2]> {
        let [x, y] = [0, 1].map(|d: usize| self.stops(d, rectangle[d]));
        (y.iter().flat_map(|y| x.iter().map(move |x| [*x, *y]))).collect()
    }

    /// Lowest and highest height over a rectangle, which may be a line or a point [m].
    pub fn range(&self, rectangle: [[f64; 2]; 2]) -> [f64; 2] {
        let heights = self.points(rectangle).into_iter().map(|p| self.at(p));
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| {
            [low.min(z), high.max(z)]
        })
    }

    /// Mean height over a rectangle, which may be a line or a point [m].
    pub fn mean(&self, rectangle: [[f64; 2]; 2]) -> f64 {
        let weighted = |d: usize| -> Vec<(f64, f64)> {
            let stops = self.stops(d, rectangle[d]);
            let length = rectangle[d][1] - rectangle[d][0];
            if length == 0.0 {
                return vec![(stops[0], 1.0)];
            }
            let reach = |i: usize| stops[(i + 1).min(stops.len() - 1)] - stops[i.saturating_sub(1)];
            let weights = (0..stops.len()).map(|i| 0.5 * reach(i) / length);
            stops.iter().copied().zip(weights).collect()
        };
        let [x, y] = [weighted(0), weighted(1)];
        let row = |y: f64| -> f64 { x.iter().map(|(x, w)| w * self.at([*x, y])).sum() };
        y.iter().map(|(y, w)| w * row(*y)).sum()
    }

    /// Ends of an interval and the lines within it.
    fn stops(&self, axis: usize, [from, to]: [f64; 2]) -> Vec<f64> {
        let mut stops = vec![from];
        stops.extend(self.bends(axis, [from, to]));
        stops.push(to);
        stops.dedup();
        stops
    }
}

/// Indices of the lines around a value, and its share of the way from the first to the second, 0 where they are one.
fn place(lines: &[f64], value: f64) -> (usize, usize, f64) {
    let last = lines.len() - 1;
    let above = lines.partition_point(|line| *line <= value);
    match above {
        0 => (0, 0, 0.0),
        above if above > last => (last, last, 0.0),
        above => {
            let (a, b) = (lines[above - 1], lines[above]);
            (above - 1, above, (value - a) / (b - a))
        }
    }
}

/// Between two values: the first at 0 and the second at 1, to the last bit.
fn mix(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saddle() -> Relief {
        Relief::new(
            [vec![0.0, 2.0, 3.0], vec![-1.0, 1.0]],
            vec![0.0, 2.0, 5.0, 4.0, 0.0, 1.0],
        )
    }

    #[test]
    fn heights_are_bilinear_within_and_constant_beyond() {
        let s = saddle();
        for (point, z) in [
            ([0.0, -1.0], 0.0),
            ([1.0, -1.0], 1.0),
            ([1.0, 0.0], 1.5),
            ([2.5, 1.0], 0.5),
            ([-7.0, 9.0], 4.0),
            ([8.0, -1.5], 5.0),
        ] {
            assert!((s.at(point) - z).abs() < 1e-15, "{point:?}");
        }
        assert_eq!((s.varies(0), s.varies(1)), (true, true));
        let slope = Relief::new([vec![0.0, 1.0], vec![0.0]], vec![1.0, 2.0]);
        assert_eq!((slope.varies(0), slope.varies(1)), (true, false));
        assert_eq!(Relief::level(3.0).is_level(), Some(3.0));
        assert_eq!(slope.is_level(), None);
    }

    #[test]
    fn means_and_ranges_are_those_of_a_fine_sum() {
        let s = saddle();
        let rectangle = [[-1.0, 2.75], [-0.5, 2.0]];
        let n = 800;
        let at = |i: usize, d: usize| {
            let [from, to]: [f64; 2] = rectangle[d];
            from + (to - from) * (i as f64 + 0.5) / n as f64
        };
        let (mut sum, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
        for j in 0..n {
            for i in 0..n {
                let z = s.at([at(i, 0), at(j, 1)]);
                sum += z;
                low = z.min(low);
                high = z.max(high);
            }
        }
        assert!((s.mean(rectangle) - sum / (n * n) as f64).abs() < 1e-5);
        let range = s.range(rectangle);
        assert!((range[0] - low).abs() < 0.02 && (range[1] - high).abs() < 0.02);
        assert!((s.mean([[2.0, 2.0], [-1.0, 1.0]]) - 1.0).abs() < 1e-15);
    }
}
