//! Segments that share their ends, as lines.

use std::collections::HashMap;

/// Place of a point on a grid much finer than elements.
pub(super) type Key = [i64; 2];

/// Points of a plane told apart by where they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    size: f64,
}

/// Cells of that grid over the extent of what is drawn. Unit: 1.
const FINE: f64 = 1e7;

/// How far a point may lie beside the line that goes on without it, over the extent: half a point of a wide figure. Unit: 1.
const STRAIGHT: f64 = 5e-4;

impl Ends {
    /// For points within this extent [m].
    pub(super) fn new(extent: f64) -> Self {
        let size = extent / FINE;
        Self {
            size: if size > 0.0 { size } else { 1.0 },
        }
    }

    pub(super) fn key(&self, p: [f64; 2]) -> Key {
        p.map(|x| (x / self.size).round() as i64)
    }

    /// Lines through segments, without points that a straight piece does not need. A line ends where another than two segments meet.
    pub(super) fn joined(&self, segments: &[[[f64; 2]; 2]]) -> Vec<Vec<[f64; 2]>> {
        let mut at: HashMap<Key, Vec<usize>> = HashMap::new();
        for (s, ends) in segments.iter().enumerate() {
            for end in ends {
                at.entry(self.key(*end)).or_default().push(s);
            }
        }
        let mut used = vec![false; segments.len()];
        let mut lines = Vec::new();
        // from the ends of lines, then around what is closed
        let is_end = |s: &usize| segments[*s].iter().any(|p| at[&self.key(*p)].len() != 2);
        let (open, closed): (Vec<usize>, Vec<usize>) = (0..segments.len()).partition(is_end);
        for first in open.into_iter().chain(closed) {
            if std::mem::replace(&mut used[first], true) {
                continue;
            }
            let [mut a, mut b] = segments[first];
            if at[&self.key(a)].len() == 2 {
                (a, b) = (b, a);
            }
            let mut line = vec![a, b];
            loop {
                let end = self.key(b);
                let [s, t] = at[&end][..] else { break };
                let Some(next) = [s, t].into_iter().find(|s| !used[*s]) else {
                    break;
                };
                used[next] = true;
                let [p, q] = segments[next];
                b = if self.key(p) == end { q } else { p };
                line.push(b);
            }
            lines.push(self.straightened(&line));
        }
        lines
    }

    /// Leaves out what lies on a straight piece (Ramer, Douglas and Peucker).
    fn straightened(&self, line: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut keep = vec![false; line.len()];
        let last = line.len() - 1;
        (keep[0], keep[last]) = (true, true);
        let mut pieces = vec![(0, last)];
        while let Some((a, b)) = pieces.pop() {
            let far = (a + 1..b)
                .map(|k| (k, beside(line[k], line[a], line[b])))
                .max_by(|p, q| p.1.total_cmp(&q.1));
            if let Some((k, distance)) = far
                && distance > STRAIGHT * FINE * self.size
            {
                keep[k] = true;
                pieces.extend([(a, k), (k, b)]);
            }
        }
        let kept = line.iter().zip(keep).filter(|(_, keep)| *keep);
        kept.map(|(p, _)| *p).collect()
    }
}

/// Distance of a point from the segment between two others.
fn beside(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (d, e) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = d[0] * d[0] + d[1] * d[1];
    let share = match square > 0.0 {
        true => ((d[0] * e[0] + d[1] * e[1]) / square).clamp(0.0, 1.0),
        false => 0.0,
    };
    (e[0] - share * d[0]).hypot(e[1] - share * d[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_in_pieces_is_one_line_through_its_corners() {
        let around: Vec<[f64; 2]> = (0..40)
            .map(|k| {
                let s = f64::from(k % 10) / 10.0;
                [[s, 0.0], [1.0, s], [1.0 - s, 1.0], [0.0, 1.0 - s]][k as usize / 10]
            })
            .collect();
        // every third first, some backwards
        let segment = |k: usize| match k % 2 {
            0 => [around[k], around[(k + 1) % 40]],
            _ => [around[(k + 1) % 40], around[k]],
        };
        let order = (0..3).flat_map(|r| (r..40).step_by(3));
        let segments: Vec<_> = order.map(segment).collect();
        let lines = Ends::new(1.0).joined(&segments);
        assert_eq!(lines.len(), 1);
        // its corners, and where it begins and ends
        assert_eq!(lines[0].first(), lines[0].last());
        assert!(lines[0].len() <= 6, "{lines:?}");
        let is_there = |corner| lines[0].contains(corner);
        assert!(
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .iter()
                .all(is_there)
        );
    }

    #[test]
    fn lines_end_where_three_meet() {
        let middle = [0.5, 0.5];
        let arm = |end: [f64; 2]| {
            let half = [0, 1].map(|d: usize| 0.5 * (end[d] + middle[d]));
            [[middle, half], [half, end]]
        };
        let ends = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]];
        let segments: Vec<_> = ends.into_iter().flat_map(arm).collect();
        let lines = Ends::new(1.0).joined(&segments);
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.len() == 2), "{lines:?}");
    }
}
