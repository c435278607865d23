//! What a body keeps of a pore pressure that differs from element to element.

use super::drawdown::Drawdown;
use crate::scene::Latest;
use std::fmt;
use std::sync::Arc;

/// A change of pore pressure since time 0 in each element of a material.
#[derive(Clone, Debug)]
pub struct PoreField {
    /// The material, an index of `mesh.regions`.
    pub region: usize,
    /// Biot's coefficient α [1].
    pub biot: f64,
    /// Its elements, increasing.
    pub elements: Vec<u32>,
    pub(super) change: Change,
    /// What elements take, for a person.
    pub(super) origin: String,
    /// The change at the ends of a step: loads, files and fractures beside it ask for the same ones.
    pub(super) latest: Latest,
}

/// How it changes.
#[derive(Clone, Debug)]
pub(super) enum Change {
    /// Between fields.
    Fields(Fields),
    /// By diffusion.
    Drawdown(Drawdown),
}

/// A change per element at each of some times, linear between them or that of the earlier one, constant outside.
#[derive(Clone, Debug)]
pub(super) struct Fields {
    /// Increasing [s].
    pub(super) times: Vec<f64>,
    /// Per time a change per element [Pa]; 0 at the first, which is that at time 0.
    pub(super) changes: Vec<Vec<f64>>,
    pub(super) steps: bool,
}

/// Relative difference of slopes that counts as rounding. Unit: 1.
const STRAIGHT: f64 = 1e-9;

impl Fields {
    fn at(&self, time: f64) -> Vec<f64> {
        let (times, last) = (&self.times, self.times.len() - 1);
        match times.partition_point(|t| *t <= time) {
            0 => self.changes[0].clone(),
            n if n > last => self.changes[last].clone(),
            n if self.steps => self.changes[n - 1].clone(),
            n => {
                let share = (time - times[n - 1]) / (times[n] - times[n - 1]);
                let pairs = self.changes[n - 1].iter().zip(&self.changes[n]);
                pairs.map(|(a, b)| a + (b - a) * share).collect()
            }
        }
    }

    /// True where the change of an element bends or jumps at time k.
    fn bends(&self, k: usize) -> bool {
        let slope = |e: usize, k: usize| -> f64 {
            let Some(before) = k.checked_sub(1).filter(|_| k < self.times.len()) else {
                return 0.0;
            };
            let rise = self.changes[k][e] - self.changes[before][e];
            match self.steps {
                true => rise,
                false => rise / (self.times[k] - self.times[before]),
            }
        };
        let mut elements = 0..self.changes[k].len();
        elements.any(|e| {
            let (before, after) = (slope(e, k), slope(e, k + 1));
            match self.steps {
                true => before != 0.0,
                false => (before - after).abs() > STRAIGHT * before.abs().max(after.abs()),
            }
        })
    }

    fn corners(&self) -> Vec<f64> {
        let corners = (0..self.times.len()).filter(|k| self.bends(*k));
        corners.map(|k| self.times[k]).collect()
    }
}

impl PoreField {
    /// Δp per element at a time [s], in Pa.
    ///
    /// # Cost
    /// O(elements); by diffusion, a few terms per interval of z that elements fill and time of the table. None where it is asked for the same
    /// time again.
    pub fn at(&self, time: f64) -> Arc<[f64]> {
        self.latest.at(time, || match &self.change {
            Change::Fields(fields) => fields.at(time),
            Change::Drawdown(drawdown) => drawdown.at(time),
        })
    }

    /// `α Δp` per element at a time [s], by which total stress falls [Pa].
    pub fn drained(&self, time: f64) -> Vec<f64> {
        self.at(time).iter().map(|p| p * self.biot).collect()
    }

    /// Times at which it bends [s], increasing.
    pub fn corners(&self) -> Vec<f64> {
        match &self.change {
            Change::Fields(fields) => fields.corners(),
            Change::Drawdown(drawdown) => drawdown.corners(),
        }
    }

    /// Those at which it jumps [s], increasing; what jumps at a face has not come far at that time, but it belongs to the step.
    pub fn jumps(&self) -> Vec<f64> {
        match &self.change {
            Change::Fields(fields) if fields.steps => fields.corners(),
            Change::Fields(_) => Vec::new(),
            Change::Drawdown(drawdown) => drawdown.jumps(),
        }
    }
}

impl fmt::Display for PoreField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} elements take {}", self.elements.len(), self.origin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(steps: bool) -> Fields {
        Fields {
            times: vec![1.0, 3.0, 5.0, 6.0],
            changes: vec![
                vec![0.0, 0.0],
                vec![-2.0, 4.0],
                vec![-4.0, 8.0],
                vec![-4.0, 8.0],
            ],
            steps,
        }
    }

    #[test]
    fn linear_or_in_steps_and_constant_outside() {
        let (linear, steps) = (fields(false), fields(true));
        for (t, a, b) in [
            (0.0, [0.0, 0.0], [0.0, 0.0]),
            (2.0, [-1.0, 2.0], [0.0, 0.0]),
            (3.0, [-2.0, 4.0], [-2.0, 4.0]),
            (4.0, [-3.0, 6.0], [-2.0, 4.0]),
            (9.0, [-4.0, 8.0], [-4.0, 8.0]),
        ] {
            assert_eq!([linear.at(t), steps.at(t)], [a.to_vec(), b.to_vec()], "{t}");
        }
    }

    #[test]
    fn corners_are_where_an_element_bends() {
        // 3 lies on the lines from 1 to 5
        assert_eq!(fields(false).corners(), [1.0, 5.0]);
        assert_eq!(fields(true).corners(), [3.0, 5.0]);
        let mut bent = fields(false);
        bent.changes[1][1] = 3.0;
        assert_eq!(bent.corners(), [1.0, 3.0, 5.0]);
    }
}
