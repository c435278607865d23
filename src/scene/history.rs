//! How loads change in time.

use super::Problem;
use super::located::{Located, at};
use crate::units::{Duration, MOST, Measure};

/// Relative difference of slopes that counts as rounding. Unit: 1.
const STRAIGHT: f64 = 1e-9;

/// A factor of a load against time, linear between its points and constant outside.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// (time [s], factor), times increasing; never empty.
    points: Vec<(f64, f64)>,
    /// Between two times the factor of the earlier one holds.
    steps: bool,
}

impl History {
    /// Factor 1 always.
    pub fn constant() -> Self {
        Self {
            points: vec![(0.0, 1.0)],
            steps: false,
        }
    }

    /// Through points (time [s], factor); `None` unless there is one and times increase.
    pub fn through(points: Vec<(f64, f64)>) -> Option<Self> {
        let increasing = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let finite = points.iter().all(|(t, f)| t.is_finite() && f.is_finite());
        (!points.is_empty() && increasing && finite).then_some(Self {
            points,
            steps: false,
        })
    }

    /// The same, constant from each point to the next.
    pub fn in_steps(points: Vec<(f64, f64)>) -> Option<Self> {
        let through = Self::through(points)?;
        Some(Self {
            steps: true,
            ..through
        })
    }

    /// Times at which the factor jumps [s], increasing.
    pub fn jumps(&self) -> impl Iterator<Item = f64> + '_ {
        self.corners().filter(|_| self.steps)
    }

    /// The same with every factor less a number.
    #[must_use]
    pub fn less(mut self, by: f64) -> Self {
        self.points.iter_mut().for_each(|(_, factor)| *factor -= by);
        self
    }

    /// (time [s], change) of the slope [1/s] at points of straight lines, or of the factor itself where steps hold: what the factor is, less that
    /// at first, as a sum of ramps or of steps.
    pub(super) fn changes(&self) -> Vec<(f64, f64)> {
        let pairs = self.points.windows(2);
        if self.steps {
            return pairs
                .map(|pair| (pair[1].0, pair[1].1 - pair[0].1))
                .collect();
        }
        let mut changes = Vec::with_capacity(self.points.len());
        let mut before = 0.0;
        for pair in pairs {
            let slope = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
            changes.push((pair[0].0, slope - before));
            before = slope;
        }
        changes.extend(self.points.last().map(|(time, _)| (*time, -before)));
        changes
    }

    /// True where steps hold between points.
    pub(super) fn is_stepped(&self) -> bool {
        self.steps
    }

    /// Times at which the factor bends or jumps in slope [s], increasing.
    pub fn corners(&self) -> impl Iterator<Item = f64> + '_ {
        let slope = |k: usize| match (k.checked_sub(1).map(|k| self.points[k]), self.points.get(k))
        {
            (Some((t0, f0)), Some((t1, f1))) => (f1 - f0) / (t1 - t0),
            _ => 0.0,
        };
        let bends = move |k: &usize| {
            if self.steps {
                return *k > 0 && self.points[*k].1 != self.points[k - 1].1;
            }
            let (before, after) = (slope(*k), slope(k + 1));
            (before - after).abs() > STRAIGHT * before.abs().max(after.abs())
        };
        (0..self.points.len())
            .filter(bends)
            .map(|k| self.points[k].0)
    }

    /// The factor at a time [s].
    pub fn at(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|(t, _)| *t <= time);
        let last = self.points.len() - 1;
        match after {
            0 => self.points[0].1,
            n if n > last => self.points[last].1,
            n if self.steps => self.points[n - 1].1,
            n => {
                let ((t0, f0), (t1, f1)) = (self.points[n - 1], self.points[n]);
                f0 + (f1 - f0) * (time - t0) / (t1 - t0)
            }
        }
    }
}

/// Times at which a scene is solved: `end · n/steps` for n = 1, …, steps and the corners of its histories between them, after
/// the equilibrium at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeTable {
    /// Last time [s].
    pub end: f64,
    /// Number of steps.
    pub steps: u32,
}

/// The histories of a scene, each written one only once.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Histories(pub(super) Vec<History>);

impl Histories {
    /// The one of factor 1, number [`super::Body::ALWAYS`].
    pub(super) fn new() -> Self {
        Self(vec![History::constant()])
    }

    /// The number of a history that is written at `path`, or `default` where none is; factors are bounded as quantities are.
    pub(super) fn number(
        &mut self,
        written: Option<&Vec<(Measure<Duration>, f64)>>,
        path: &[&str],
        default: usize,
    ) -> Result<usize, Located> {
        let Some(written) = written else {
            return Ok(default);
        };
        let points: Vec<_> = written.iter().map(|(t, f)| (t.si(), *f)).collect();
        let is_large = |factor: f64| factor.is_finite() && factor.abs() > MOST;
        if let Some(k) = points.iter().position(|(_, factor)| is_large(*factor)) {
            let (place, factor) = (k.to_string(), points[k].1);
            let path = [path, &[place.as_str(), "1"]].concat();
            return Err(at(&path, Problem::LargeFactor { factor }));
        }
        let early = points.windows(2).position(|pair| pair[1].0 <= pair[0].0);
        let problem = Problem::BadHistory {
            early: early.map(|before| before + 2),
        };
        let history = History::through(points).ok_or_else(|| at(path, problem))?;
        Ok(self.number_of(history))
    }

    /// The number of a history.
    pub(super) fn number_of(&mut self, history: History) -> usize {
        if let Some(known) = self.0.iter().position(|h| *h == history) {
            return known;
        }
        self.0.push(history);
        self.0.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_points_and_constant_outside() {
        let h = History::through(vec![(1.0, 0.0), (3.0, 4.0), (5.0, -1.0)]).unwrap();
        for (t, f) in [
            (0.0, 0.0),
            (1.0, 0.0),
            (2.0, 2.0),
            (3.0, 4.0),
            (4.0, 1.5),
            (9.0, -1.0),
        ] {
            assert_eq!(h.at(t), f, "at {t}");
        }
        assert_eq!(History::constant().at(7.0), 1.0);
    }

    #[test]
    fn corners_are_where_the_slope_changes() {
        let corners = |points: &[(f64, f64)]| -> Vec<f64> {
            History::through(points.to_vec())
                .unwrap()
                .corners()
                .collect()
        };
        assert_eq!(
            corners(&[(1.0, 0.0), (3.0, 4.0), (5.0, -1.0)]),
            [1.0, 3.0, 5.0]
        );
        // 2 lies on the line from 1 to 4
        assert_eq!(corners(&[(1.0, 1.0), (2.0, 2.0), (4.0, 4.0)]), [1.0, 4.0]);
        assert_eq!(corners(&[(0.0, 2.0), (7.0, 2.0), (8.0, 0.0)]), [7.0, 8.0]);
        assert!(History::constant().corners().next().is_none());
    }

    #[test]
    fn steps_hold_the_value_before() {
        let h = History::in_steps(vec![(1.0, 0.0), (3.0, 4.0), (4.0, 4.0), (5.0, -1.0)]).unwrap();
        for (t, f) in [
            (0.0, 0.0),
            (2.9, 0.0),
            (3.0, 4.0),
            (4.5, 4.0),
            (5.0, -1.0),
            (9.0, -1.0),
        ] {
            assert_eq!(h.at(t), f, "at {t}");
        }
        assert_eq!(h.corners().collect::<Vec<_>>(), [3.0, 5.0]);
        assert_eq!(h.jumps().collect::<Vec<_>>(), [3.0, 5.0]);
        assert_eq!(History::constant().jumps().count(), 0);
        assert_eq!(h.less(1.0).at(3.5), 3.0);
    }

    #[test]
    fn times_must_increase() {
        assert_eq!(History::through(vec![]), None);
        assert_eq!(History::through(vec![(1.0, 0.0), (1.0, 2.0)]), None);
        assert_eq!(History::through(vec![(0.0, f64::NAN)]), None);
    }
}
