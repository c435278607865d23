//! Quadrilaterals that have values of their own, and a raster in their place where they are too many.

/// Quadrilaterals, each with the number of what its value belongs to.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// Corners, in the plane [m].
    pub quads: Vec<[[f64; 2]; 4]>,
    /// Number of what the value of each belongs to.
    pub of: Vec<usize>,
    /// True where squares stand for what lies at their centres.
    pub is_raster: bool,
}

impl Patches {
    /// Convex polygons, cut into quadrilaterals from their first corner.
    pub fn add(&mut self, corners: &[[f64; 2]], of: usize) {
        let mut k = 1;
        while k + 1 < corners.len() {
            let last = (k + 2).min(corners.len() - 1);
            (self.quads).push([corners[0], corners[k], corners[k + 1], corners[last]]);
            self.of.push(of);
            k += 2;
        }
    }

    /// Left and right, low and high end.
    pub fn extent(&self) -> [[f64; 2]; 2] {
        let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for p in self.quads.iter().flatten() {
            for d in 0..2 {
                ends[d] = [ends[d][0].min(p[d]), ends[d][1].max(p[d])];
            }
        }
        ends
    }

    /// As they are, or about `most` squares where they are more: each stands for what lies at its centre.
    ///
    /// # Cost
    /// O(quadrilaterals + squares).
    pub fn thinned(self, most: usize) -> Self {
        if self.quads.len() <= most {
            return self;
        }
        let [[left, right], [low, high]] = self.extent();
        let (width, height) = (right - left, high - low);
        let counts = {
            // squares, but at least a few along the shorter side
            let across = (most as f64 * width / height).sqrt();
            let across = across.clamp(4.0, most as f64 / 4.0) as usize;
            [across, most / across]
        };
        let size = [width / counts[0] as f64, height / counts[1] as f64];
        let mut at: Vec<Option<usize>> = vec![None; counts[0] * counts[1]];
        for (quad, of) in self.quads.iter().zip(&self.of) {
            let ends = |d: usize, start: f64| {
                let along = quad.iter().map(|p| (p[d] - start) / size[d] - 0.5);
                let low = along.clone().fold(f64::INFINITY, f64::min).ceil().max(0.0);
                let high = along.fold(f64::NEG_INFINITY, f64::max).floor();
                low as usize..((high + 1.0).max(0.0) as usize).min(counts[d])
            };
            for j in ends(1, low) {
                for i in ends(0, left) {
                    let center = [
                        left + size[0] * (i as f64 + 0.5),
                        low + size[1] * (j as f64 + 0.5),
                    ];
                    if is_within(quad, center) {
                        at[i + counts[0] * j] = Some(*of);
                    }
                }
            }
        }
        let mut raster = Self {
            is_raster: true,
            ..Self::default()
        };
        for (k, of) in at.into_iter().enumerate() {
            let Some(of) = of else { continue };
            let (i, j) = ((k % counts[0]) as f64, (k / counts[0]) as f64);
            let [x, y] = [left + size[0] * i, low + size[1] * j];
            let [right, up] = [left + size[0] * (i + 1.0), low + size[1] * (j + 1.0)];
            raster
                .quads
                .push([[x, y], [right, y], [right, up], [x, up]]);
            raster.of.push(of);
        }
        raster
    }
}

/// True in a convex quadrilateral or on its edges, whichever way around its corners go.
fn is_within(quad: &[[f64; 2]; 4], p: [f64; 2]) -> bool {
    let side = |k: usize| {
        let (a, b) = (quad[k], quad[(k + 1) % 4]);
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let sides = [0, 1, 2, 3].map(side);
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_become_quadrilaterals_of_the_same_area() {
        let area = |q: &[[f64; 2]]| {
            let n = q.len();
            let term = |k: usize| {
                let (a, b) = (q[k], q[(k + 1) % n]);
                0.5 * (a[0] * b[1] - a[1] * b[0])
            };
            (0..n).map(term).sum::<f64>()
        };
        for n in 3..=6 {
            let corner = |k: usize| {
                let a = std::f64::consts::TAU * k as f64 / n as f64;
                [a.cos(), a.sin()]
            };
            let polygon: Vec<[f64; 2]> = (0..n).map(corner).collect();
            let mut patches = Patches::default();
            patches.add(&polygon, 7);
            let sum: f64 = patches.quads.iter().map(|q| area(q)).sum();
            assert!((sum - area(&polygon)).abs() < 1e-12, "{n}");
            assert!(patches.of.iter().all(|of| *of == 7));
        }
    }

    #[test]
    fn a_raster_keeps_values_where_they_are() {
        let mut patches = Patches::default();
        let count = 300;
        for k in 0..count * count {
            let [x, y] = [(k % count) as f64, (k / count) as f64];
            patches.add(&[[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]], k);
        }
        let thin = patches.thinned(5_000);
        assert!(thin.is_raster && (4_500..=5_000).contains(&thin.quads.len()));
        for (quad, of) in thin.quads.iter().zip(&thin.of) {
            let center = [0, 1].map(|d: usize| 0.25 * quad.iter().map(|p| p[d]).sum::<f64>());
            let [x, y] = [(of % count) as f64, (of / count) as f64];
            assert!((center[0] - x - 0.5).abs() <= 0.5 + 1e-9);
            assert!((center[1] - y - 0.5).abs() <= 0.5 + 1e-9);
        }
    }
}
