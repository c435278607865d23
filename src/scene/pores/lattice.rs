//! Points that lie where lines of a grid cross.

/// Share of the extent along an axis within which two coordinates are one. Unit: 1.
const SAME: f64 = 1e-6;

/// Full tensor lattice: a point wherever lines along x, y and z cross.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    /// Coordinates of the lines [m], increasing.
    lines: [Vec<f64>; 3],
    /// Number of the point at `i + n_x (j + n_y k)`.
    points: Vec<u32>,
}

impl Lattice {
    /// The lattice of such points, if they are one.
    pub(super) fn of(points: &[[f64; 3]]) -> Option<Self> {
        let (mut lines, mut ranks): ([Vec<f64>; 3], [Vec<u32>; 3]) = Default::default();
        for d in 0..3 {
            (lines[d], ranks[d]) = lines_along(d, points);
        }
        let [x, y, z] = [0, 1, 2].map(|d: usize| lines[d].len() as u128);
        if x * y * z != points.len() as u128 {
            return None;
        }
        let (x, y) = (x as usize, y as usize);
        let mut table = vec![u32::MAX; points.len()];
        for p in 0..points.len() {
            let [i, j, k] = [0, 1, 2].map(|d: usize| ranks[d][p] as usize);
            let place = &mut table[i + x * (j + y * k)];
            if *place != u32::MAX {
                return None;
            }
            *place = p as u32;
        }
        Some(Self {
            lines,
            points: table,
        })
    }

    /// Points along each axis.
    pub(super) fn counts(&self) -> [usize; 3] {
        [0, 1, 2].map(|d: usize| self.lines[d].len())
    }

    /// Diagonal of the median steps between lines [m].
    pub(super) fn spacing(&self) -> f64 {
        let steps = self.lines.iter().map(|lines| {
            let steps = lines.windows(2).map(|pair| pair[1] - pair[0]);
            super::places::median(steps.collect())
        });
        steps.map(|step| step * step).sum::<f64>().sqrt()
    }

    /// Points and weights of the trilinear value at x [m], or at the nearest place of the lattice where x lies outside, and how far that is [m].
    pub(super) fn weights(&self, x: [f64; 3]) -> ([(u32, f64); 8], f64) {
        let mut below = [0; 3];
        let (mut share, mut distance) = ([0.0; 3], 0.0);
        for d in 0..3 {
            let lines = &self.lines[d];
            let inside = x[d].clamp(lines[0], lines[lines.len() - 1]);
            distance += (x[d] - inside) * (x[d] - inside);
            if lines.len() > 1 {
                let above = lines.partition_point(|line| *line <= inside);
                let k = above.clamp(1, lines.len() - 1);
                below[d] = k - 1;
                share[d] = (inside - lines[k - 1]) / (lines[k] - lines[k - 1]);
            }
        }
        let [nx, ny, _] = self.counts();
        let corner = |c: usize| {
            let mut weight = 1.0;
            let at = [0, 1, 2].map(|d: usize| {
                let is_above = c >> d & 1 == 1;
                weight *= if is_above { share[d] } else { 1.0 - share[d] };
                // beyond the last line the weight is 0
                (below[d] + usize::from(is_above)).min(self.lines[d].len() - 1)
            });
            (self.points[at[0] + nx * (at[1] + ny * at[2])], weight)
        };
        (std::array::from_fn(corner), distance.sqrt())
    }
}

/// Lines along an axis, and that of each point.
fn lines_along(d: usize, points: &[[f64; 3]]) -> (Vec<f64>, Vec<u32>) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*a][d].total_cmp(&points[*b][d]));
    let at = |n: usize| points[order[n]][d];
    let slack = SAME * (at(order.len() - 1) - at(0));
    let (mut lines, mut ranks) = (Vec::new(), vec![0; points.len()]);
    for (n, p) in order.iter().enumerate() {
        if n == 0 || at(n) - at(n - 1) > slack {
            lines.push(at(n));
        }
        ranks[*p] = lines.len() as u32 - 1;
    }
    (lines, ranks)
}
