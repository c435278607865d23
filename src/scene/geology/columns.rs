//! Where lines of the grid lie in the rock, column by column, where tops are not level.

use super::GeologyProblem;
use super::blocks::Blocks;
use super::layers::Layers;
use super::leans::SQUEEZE;
use crate::mesh::{Leaning, lean};
use crate::scene::located::{Located, at};

/// A level of the grid that lies at a height of its own over a rectangle: an end of a fault, a level fracture.
pub(super) struct Held {
    /// The level [m].
    pub(super) line: f64,
    /// Where [m].
    pub(super) rectangle: [[f64; 2]; 2],
    /// Its height [m].
    pub(super) height: f64,
    /// What it is.
    pub(super) what: String,
    /// Where it is written.
    pub(super) path: [String; 3],
}

/// What lies on a level of the grid in a column.
#[derive(Clone, Copy)]
enum Who {
    /// Level k of the layers.
    Top(usize),
    /// One of [`Columns::held`].
    Held(usize),
}

/// A level of the grid, its height [m], and what lies on it.
type Entry = (f64, f64, Who);

/// Layers, blocks and leaning faults, of which columns follow.
pub(super) struct Columns<'a> {
    pub(super) layers: &'a Layers,
    pub(super) blocks: &'a Blocks,
    /// Planes that lean across x and across y.
    pub(super) leaning: [Vec<Leaning>; 2],
    /// Ends of the box [m].
    pub(super) ends: [[f64; 2]; 2],
    /// Levels with heights of their own.
    pub(super) held: Vec<Held>,
}

/// Steps in which a height on a leaning line is found: with slopes that are not close to those of the faults the error becomes 1e-16.
const STEPS: usize = 400;

impl Columns<'_> {
    /// Where the point of a column lies whose height is z [m].
    fn place(&self, [x, y]: [f64; 2], z: f64) -> [f64; 2] {
        let mut node = [[x, y, z]];
        for (d, leaning) in self.leaning.iter().enumerate() {
            lean(&mut node, [d, 2], self.ends[d], leaning);
        }
        [node[0][0], node[0][1]]
    }

    /// Height of level k in a column, moved by `shift` [m].
    fn height(&self, k: usize, column: [f64; 2], shift: f64) -> Result<f64, Located> {
        let top = &self.layers.tops[k];
        if let Some(level) = top.is_level() {
            return Ok(level + shift);
        }
        let mut z = top.at(column) + shift;
        if self.leaning.iter().all(Vec::is_empty) {
            return Ok(z);
        }
        let close = 1e-4 * self.layers.rounding();
        for _ in 0..STEPS {
            let next = top.at(self.place(column, z)) + shift;
            if (next - z).abs() <= close {
                return Ok(next);
            }
            z = next;
        }
        let (what, number) = (self.layers.name(k), k.to_string());
        let steep = GeologyProblem::Steep { what, at: column };
        Err(at(&["geology", "layers", &number, "top"], steep))
    }

    /// Heights of all levels of a block in a column as they are written [m].
    pub(super) fn written(&self, block: usize, column: [f64; 2]) -> Result<Vec<f64>, Located> {
        let lines = self.blocks.levels(block);
        let shift = |k: usize| lines[k] - self.layers.levels[k];
        let heights: Vec<f64> = (0..lines.len())
            .map(|k| self.height(k, column, shift(k)))
            .collect::<Result<_, _>>()?;
        let rounding = self.layers.rounding();
        match heights.windows(2).position(|h| h[1] > h[0] + rounding) {
            Some(k) => {
                let eaten = GeologyProblem::Eaten {
                    name: self.layers.names[k].clone(),
                    at: column,
                    top: heights[k],
                    base: heights[k + 1],
                };
                Err(at(&["geology", "layers", &k.to_string()], eaten))
            }
            None => Ok(heights),
        }
    }

    /// The least height that the grid leaves layer k of a block [m].
    pub(super) fn least(&self, block: usize, k: usize) -> f64 {
        let lines = self.blocks.levels(block);
        SQUEEZE * (lines[k] - lines[k + 1])
    }

    /// The same heights where no layer is thinner than the grid leaves it: lower bases, and above the bottom of the box higher tops [m].
    pub(super) fn kept(
        &self,
        block: usize,
        column: [f64; 2],
        mut heights: Vec<f64>,
    ) -> Result<Vec<f64>, Located> {
        let last = heights.len() - 1;
        let (top, bottom) = (heights[0], heights[last]);
        for k in 0..last {
            heights[k + 1] = heights[k + 1].min(heights[k] - self.least(block, k));
        }
        heights[last] = bottom;
        for k in (0..last).rev() {
            heights[k] = heights[k].max(heights[k + 1] + self.least(block, k));
        }
        match heights[0] > top {
            true => {
                let (at_column, height) = (column, top - bottom);
                let no_room = GeologyProblem::NoRoom {
                    at: at_column,
                    height,
                };
                Err(at(&["geology", "bottom"], no_room))
            }
            false => Ok(heights),
        }
    }

    /// All levels that something lies on in a column and their heights, increasing.
    pub(super) fn column(&self, column: [f64; 2]) -> Result<Vec<(f64, f64)>, Located> {
        let mut entries: Vec<Entry> = Vec::new();
        for block in self.blocks.around(column) {
            let written = self.written(block, column)?;
            let heights = self.kept(block, column, written)?;
            let lines = self.blocks.levels(block).iter().zip(heights);
            entries.extend(
                lines
                    .enumerate()
                    .map(|(k, (line, z))| (*line, z, Who::Top(k))),
            );
        }
        for (i, held) in self.held.iter().enumerate() {
            if touches(&held.rectangle, &column.map(|c| [c, c])) {
                entries.push((held.line, held.height, Who::Held(i)));
            }
        }
        entries.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut kept: Vec<Entry> = Vec::with_capacity(entries.len());
        let rounding = self.layers.rounding();
        for entry in entries {
            let Some(before) = kept.last() else {
                kept.push(entry);
                continue;
            };
            let (gap, rise) = (entry.0 - before.0, entry.1 - before.1);
            match gap == 0.0 {
                true if rise.abs() <= rounding => {}
                false if rise >= SQUEEZE * gap - rounding => kept.push(entry),
                _ => return Err(self.tangled(column, *before, entry)),
            }
        }
        Ok(kept.into_iter().map(|(line, z, _)| (line, z)).collect())
    }

    fn tangled(&self, column: [f64; 2], lower: Entry, upper: Entry) -> Located {
        let name = |who: Who| match who {
            Who::Top(k) => self.layers.name(k),
            Who::Held(i) => self.held[i].what.clone(),
        };
        let held = [upper.2, lower.2].into_iter().find_map(|who| match who {
            Who::Held(i) => Some(&self.held[i].path),
            Who::Top(_) => None,
        });
        let problem = GeologyProblem::Tangled {
            first: name(lower.2),
            second: name(upper.2),
            at: column,
            heights: [lower.1, upper.1],
            lines: [lower.0, upper.0],
        };
        match (held, upper.2) {
            (Some([a, b, c]), _) => at(&[a, b, c], problem),
            (None, Who::Top(k)) => at(&["geology", "layers", &k.to_string(), "top"], problem),
            (None, Who::Held(_)) => at(&["geology", "layers"], problem),
        }
    }

    /// How far level k of a block lies from the surface through its points at lines of the grid, at 25 places of each cell [m].
    pub(super) fn off(
        &self,
        block: usize,
        k: usize,
        lines: &[Vec<f64>; 2],
    ) -> Result<f64, Located> {
        let rectangle = self.blocks.rectangle(block);
        let shift = self.blocks.levels(block)[k] - self.layers.levels[k];
        let [x, y] = [0, 1].map(|d: usize| within(&lines[d], rectangle[d]));
        let mut corners = Vec::with_capacity(x.len() * y.len());
        for point in y.iter().flat_map(|y| x.iter().map(|x| [*x, *y])) {
            let z = self.height(k, point, shift)?;
            let [x, y] = self.place(point, z);
            corners.push([x, y, z]);
        }
        let mut off = 0.0f64;
        for j in 1..y.len() {
            for i in 1..x.len() {
                let corner = |a: usize, b: usize| corners[i - 1 + a + (j - 1 + b) * x.len()];
                for (u, v) in (0..25).map(|n| (0.25 * f64::from(n % 5), 0.25 * f64::from(n / 5))) {
                    let mix = |d: usize| {
                        let row = |b: usize| corner(0, b)[d] * (1.0 - u) + corner(1, b)[d] * u;
                        row(0) * (1.0 - v) + row(1) * v
                    };
                    let [x, y, z] = [0, 1, 2].map(mix);
                    off = off.max((self.layers.tops[k].at([x, y]) + shift - z).abs());
                }
            }
        }
        Ok(off)
    }

    /// The level of the grid that lies at a height in a column [m]; the highest where the height is above it.
    pub(super) fn line(&self, column: [f64; 2], height: f64) -> Result<f64, Located> {
        let levels = self.column(column)?;
        let swapped: Vec<(f64, f64)> = levels.iter().map(|(line, z)| (*z, *line)).collect();
        Ok(between(&swapped, height))
    }
}

/// Lines inside an interval, with its ends [m].
pub(super) fn within(lines: &[f64], [from, to]: [f64; 2]) -> Vec<f64> {
    let inside = lines.iter().copied().filter(|x| from < *x && *x < to);
    [from].into_iter().chain(inside).chain([to]).collect()
}

/// Two rectangles have a point in common.
pub(super) fn touches(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> bool {
    (0..2).all(|d| a[d][0] <= b[d][1] && b[d][0] <= a[d][1])
}

/// The value at x of what is straight between points (x, value) that increase; the first or last value beyond them.
pub(super) fn between(points: &[(f64, f64)], x: f64) -> f64 {
    let above = points.partition_point(|(at, _)| *at <= x);
    match (points[..above].last(), points.get(above)) {
        (Some((a, u)), Some((b, v))) => match *a == x {
            true => *u,
            false => u + (x - a) * ((v - u) / (b - a)),
        },
        (Some((_, value)), None) | (None, Some((_, value))) => *value,
        (None, None) => x,
    }
}
