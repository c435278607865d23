//! Which rigid motions a set of points stops.

use super::bodies::MODES;
use super::face_geometry::minus;
use super::loose::{add_product, cholesky};

/// Pivots below this share of the largest one count as zero: (1e-5)² of motions about the middle of the points that stop them, as
/// large as their levers are there.
pub(super) const RANK_TOLERANCE: f64 = 1e-10;

/// Share of the coordinates below which a lever is their rounding. Unit: 1.
const LEVER: f64 = 1e-11;

/// Coordinates of rigid motions: the displacement of a point is Σ_m c_m φ_m, three translations and three rotations about a centre, each
/// over a lever, so that all are of order one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    center: [f64; 3],
    /// Of the rotations about x, y, z [m].
    lever: [f64; 3],
}

/// A displacement in component `d` at `x` that is stopped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stop {
    pub(super) x: [f64; 3],
    pub(super) d: usize,
}

/// What a set of points stops: rows on the motions in its own frame, of its own size.
///
/// A slender body turns by its ends moving a million times more than its sides. What holds its end face stops that as well as what
/// holds a cube; only in a frame of the whole body it looks like nothing.
#[derive(Clone, Debug)]
pub(super) struct Stopped {
    frame: Frame,
    rows: Vec<[f64; MODES]>,
}

impl Frame {
    /// Of a body between these corners.
    pub(super) fn of_box(low: [f64; 3], high: [f64; 3]) -> Self {
        let half = [0, 1, 2].map(|d: usize| 0.5 * (high[d] - low[d]));
        Self {
            center: [0, 1, 2].map(|d: usize| 0.5 * (high[d] + low[d])),
            lever: [0, 1, 2].map(|m: usize| half[(m + 1) % 3].max(half[(m + 2) % 3])),
        }
    }

    /// Values of the six motions at a stop.
    fn row(&self, Stop { x, d }: Stop) -> [f64; MODES] {
        let r = minus(x, self.center);
        let mut row = [0.0; MODES];
        row[d] = 1.0;
        // e_m × r
        let (p, q) = ((d + 1) % 3, (d + 2) % 3);
        row[3 + p] = r[q] / self.lever[p];
        row[3 + q] = -r[p] / self.lever[q];
        row
    }

    /// A row on the motions of another frame on those of this one, R from here to there:
    /// `a·(c + ω × R) + Σ_m ρ_m l_m ω_m = a·c + Σ_m ((R × a)_m + ρ_m l_m) ω_m`.
    fn moved(&self, row: &[f64; MODES], from: &Self) -> [f64; MODES] {
        let r = minus(from.center, self.center);
        let mut moved = *row;
        for m in 0..3 {
            let (p, q) = ((m + 1) % 3, (m + 2) % 3);
            let turned = r[p] * row[q] - r[q] * row[p];
            moved[3 + m] = (turned + row[3 + m] * from.lever[m]) / self.lever[m];
        }
        moved
    }
}

impl Stopped {
    /// By these points.
    pub(super) fn by(stops: impl Iterator<Item = Stop> + Clone) -> Self {
        let number = stops.clone().count().max(1) as f64;
        let mut center = [0.0; 3];
        for Stop { x, .. } in stops.clone() {
            (0..3).for_each(|k| center[k] += x[k] / number);
        }
        let mut frame = Frame {
            center,
            lever: [1.0; 3],
        };
        // root mean squares of what the rotations move there
        let (mut squares, mut size) = ([0.0; 3], f64::MIN_POSITIVE);
        for stop in stops.clone() {
            let row = frame.row(stop);
            (0..3).for_each(|m| squares[m] += row[3 + m] * row[3 + m] / number);
            size = stop.x.iter().fold(size, |s: f64, x| s.max(x.abs()));
        }
        frame.lever = squares.map(|square: f64| match square.sqrt() {
            lever if lever > LEVER * size => lever,
            _ => size,
        });
        let mut gram = [0.0; MODES * MODES];
        for stop in stops {
            let row = frame.row(stop);
            add_product(&mut gram, 1.0, &row, &row);
        }
        let largest = (gram.iter().step_by(MODES + 1)).fold(0.0f64, |m, v| m.max(*v));
        // translations first: rows of rotations are without any, and seen from afar they stay rotations
        let (factor, pivots) = cholesky(&gram, 3, RANK_TOLERANCE * largest);
        let rows = factor.chunks_exact(MODES).take(pivots.len());
        Self {
            frame,
            rows: rows.map(|row| std::array::from_fn(|m| row[m])).collect(),
        }
    }

    /// Rigid motions (of 6) that are stopped.
    pub(super) fn rank(&self) -> usize {
        self.rows.len()
    }

    /// Rows of length one on the motions of a body in its frame.
    pub(super) fn rows_in(&self, frame: &Frame) -> impl Iterator<Item = [f64; MODES]> {
        self.rows_between([frame; 2]).map(|[row, _]| row)
    }

    /// Rows `w·c_b − v·c_a` on the motions of two bodies in their frames, the longer of v and w of length one.
    pub(super) fn rows_between(
        &self,
        frames: [&Frame; 2],
    ) -> impl Iterator<Item = [[f64; MODES]; 2]> {
        self.rows.iter().map(move |row| {
            let rows = frames.map(|frame| frame.moved(row, &self.frame));
            let length = |row: &[f64; MODES]| row.iter().map(|v| v * v).sum::<f64>().sqrt();
            let longest = length(&rows[0]).max(length(&rows[1]));
            rows.map(|row| row.map(|v| v / longest))
        })
    }
}
