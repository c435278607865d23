//! Grid lines that layers and faults ask for, and what moves because two of them are close.

use crate::scene::mesh_sections::AxisSection;
use std::fmt;

/// Share of the finest cells within which two lines become one. Half a cell would take offsets of a quarter to half a cell away, and an
/// eighth leaves cells of 1:8. Unit: 1.
pub(super) const CLOSE: f64 = 0.25;

/// Relative difference of distances from the middle that is rounding. Unit: 1.
const SAME: f64 = 1e-9;

/// Something that lies a little beside where it is written, on the nearest grid line.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// What.
    pub what: String,
    /// x, y or z.
    pub axis: &'static str,
    /// As written [m].
    pub from: f64,
    /// Where it lies [m].
    pub to: f64,
}

impl fmt::Display for Moved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            what,
            axis,
            from,
            to,
        } = self;
        write!(
            f,
            "{what} lies on the grid line {axis} = {to} m, and not at {from} m"
        )
    }
}

/// Which of two lines that are close stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rank {
    /// The upper one: heights.
    Upper,
    /// That nearer to the middle of the box, so that the mirror image of a scene has the mirror images of its lines: x and y. Two that are
    /// mirror images of each other become one in the middle.
    Inner,
}

/// Lines of an axis.
pub(super) struct Lines<'a> {
    axis: &'static str,
    /// Distance within which two become one [m]; 0 where the axis has lines of its own.
    close: f64,
    points: Vec<f64>,
    rank: Rank,
    moved: &'a mut Vec<Moved>,
}

impl<'a> Lines<'a> {
    /// Of an axis, with its ends.
    pub(super) fn new(
        axis: &'static str,
        section: &AxisSection,
        ends: [f64; 2],
        moved: &'a mut Vec<Moved>,
    ) -> Self {
        let size = section.size.as_ref().filter(|_| follows(section));
        Self {
            axis,
            close: CLOSE * size.map_or(0.0, |size| size.si()),
            points: ends.to_vec(),
            rank: if axis == "z" {
                Rank::Upper
            } else {
                Rank::Inner
            },
            moved,
        }
    }

    /// Lines for values of one kind, in an order that no list, axis or mirror decides; one that is close to a line that is there has none
    /// of its own. Then [`place`](Self::place) finds the line of each.
    pub(super) fn settle(&mut self, values: impl IntoIterator<Item = f64>) {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let middle = self.middle();
        let mirrored = values.clone();
        values.sort_by(|a, b| match self.rank {
            Rank::Upper => b.total_cmp(a),
            Rank::Inner => (a - middle).abs().total_cmp(&(b - middle).abs()),
        });
        for value in values {
            if self
                .nearest(value)
                .is_some_and(|line| self.is_close(line, value))
            {
                continue;
            }
            let image = 2.0 * middle - value;
            let same = |other: &f64| (other - image).abs() <= SAME * (value - middle).abs();
            let two = self.rank == Rank::Inner && mirrored.iter().any(same);
            self.points.push(match two && self.is_close(image, value) {
                true => middle,
                false => value,
            });
        }
    }

    /// Of the box.
    fn middle(&self) -> f64 {
        0.5 * (self.points[0] + self.points[1])
    }

    fn is_close(&self, line: f64, value: f64) -> bool {
        (line - value).abs() <= self.close
    }

    /// The nearest line; of two the one nearer to the middle.
    fn nearest(&self, value: f64) -> Option<f64> {
        let middle = self.middle();
        let order = |line: &f64| [(line - value).abs(), (line - middle).abs()];
        let lines = self.points.iter().copied();
        lines.min_by(|a, b| {
            let ([near_a, inner_a], [near_b, inner_b]) = (order(a), order(b));
            (near_a.total_cmp(&near_b))
                .then(inner_a.total_cmp(&inner_b))
                .then(a.total_cmp(b))
        })
    }

    /// A line where it is, whatever is near.
    pub(super) fn keep(&mut self, value: f64) {
        if !self.points.contains(&value) {
            self.points.push(value);
        }
    }

    /// The line that is close to a value, or the value.
    pub(super) fn nearest_to(&self, value: f64) -> f64 {
        let line = self.nearest(value);
        line.filter(|line| self.is_close(*line, value))
            .unwrap_or(value)
    }

    /// The line that is close to a value that [`settle`](Self::settle) has seen.
    pub(super) fn place(&mut self, value: f64, what: impl FnOnce() -> String) -> f64 {
        let line = self.nearest_to(value);
        if line == value {
            return line;
        }
        let moved = Moved {
            what: what(),
            axis: self.axis,
            from: value,
            to: line,
        };
        if !self.moved.contains(&moved) {
            self.moved.push(moved);
        }
        line
    }

    /// How many things have moved so far, on all axes.
    pub(super) fn told(&self) -> usize {
        self.moved.len()
    }

    /// How many there are, the ends included.
    pub(super) fn count(&self) -> usize {
        self.points.len()
    }

    /// All of them, the ends first.
    pub(super) fn points(self) -> Vec<f64> {
        self.points
    }
}

/// True where the lines of an axis follow from layers and faults: it says how large cells are, and not where they are fine.
pub(super) fn follows(axis: &AxisSection) -> bool {
    let AxisSection {
        from: _,
        to: _,
        cells,
        ratio,
        toward,
        size,
        growth: _,
        largest: _,
        near,
        fine,
        through,
        lines,
    } = axis;
    let others = cells.is_some() || ratio.is_some() || toward.is_some() || lines.is_some();
    let zones = near.is_some() || fine.is_some() || through.is_some();
    size.is_some() && !others && !zones
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Measure;
    use fracas_operators::random::Random;

    /// Lines of values in [-100, 100] that are close within 10, and where the values lie.
    fn settled(axis: &'static str, values: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let section = AxisSection {
            size: Some(Measure::metres(40.0)),
            ..AxisSection::default()
        };
        let mut moved = Vec::new();
        let mut lines = Lines::new(axis, &section, [-100.0, 100.0], &mut moved);
        lines.settle(values.iter().copied());
        let placed = values.iter().map(|v| lines.place(*v, String::new));
        let placed = placed.collect();
        let mut points = lines.points();
        points.sort_by(f64::total_cmp);
        (points, placed)
    }

    #[test]
    fn lines_do_not_depend_on_order_and_mirror() {
        let r = &mut Random::new(5);
        for case in 0..400 {
            let count = r.whole(1, 9);
            let mut values: Vec<f64> = (0..count)
                .map(|_| f64::from(r.whole(0, 200)) - 100.0)
                .collect();
            if case % 3 == 0 {
                // a pair around the middle
                values.extend([-4.0, 4.0]);
            }
            let (lines, placed) = settled("x", &values);
            let turned: Vec<f64> = values.iter().rev().copied().collect();
            assert_eq!(settled("x", &turned).0, lines, "{values:?}");
            let mirrored: Vec<f64> = values.iter().map(|v| -v).collect();
            let (mut image, there) = settled("x", &mirrored);
            image.iter_mut().for_each(|x| *x = -*x);
            image.reverse();
            assert!(image.iter().eq(&lines), "{values:?}: {lines:?} {image:?}");
            assert!(
                there.iter().zip(&placed).all(|(a, b)| *a == -b),
                "{values:?}"
            );
            // none is closer than a quarter of a cell, and none moves farther
            assert!(
                lines.windows(2).all(|pair| pair[1] - pair[0] > 10.0),
                "{lines:?}"
            );
            assert!(
                values
                    .iter()
                    .zip(&placed)
                    .all(|(v, line)| (v - line).abs() <= 10.0)
            );
            assert_eq!(settled("z", &turned).0, settled("z", &values).0);
        }
    }
}
