//! Grid lines that layers and faults ask for, and what moves because two of them are close.

use crate::scene::mesh_sections::AxisSection;

/// Share of the finest cells within which two lines become one. Half a cell would take offsets of a quarter to half a cell away, and an
/// eighth leaves cells of 1:8. Unit: 1.
const CLOSE: f64 = 0.25;

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

/// Lines of an axis.
pub(super) struct Lines<'a> {
    axis: &'static str,
    /// Distance within which two become one [m]; 0 where the axis has lines of its own.
    close: f64,
    points: Vec<f64>,
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
            moved,
        }
    }

    /// A line where it is, whatever is near.
    pub(super) fn keep(&mut self, value: f64) {
        if !self.points.contains(&value) {
            self.points.push(value);
        }
    }

    /// A line, or the one that is close.
    pub(super) fn place(&mut self, value: f64, what: impl FnOnce() -> String) -> f64 {
        let distance = |x: &f64| (x - value).abs();
        let nearest =
            (self.points.iter().copied()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        match nearest {
            Some(line) if line == value => value,
            Some(line) if distance(&line) <= self.close => {
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
            _ => {
                self.points.push(value);
                value
            }
        }
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
