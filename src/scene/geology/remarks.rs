//! What tops that are not level have become on the grid.

use super::columns::Columns;
use crate::scene::geometry::axis;
use crate::scene::located::{Located, at};
use crate::scene::sections::SceneSections;
use std::fmt;

/// Something that a reader of a [geology] with tops that are not level should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Remark {
    /// Where a top lies.
    Lies {
        /// Which one.
        top: String,
        /// Level of the grid that follows it [m].
        level: f64,
        /// Lowest and highest point before faults offset it [m].
        heights: [f64; 2],
    },
    /// A top that bends between lines of the grid.
    Off {
        /// Which one.
        top: String,
        /// How far it lies from the surface through its points [m].
        by: f64,
    },
    /// A layer that ends.
    Thin {
        /// Its material.
        layer: String,
        /// The least height that the grid leaves it [m].
        least: f64,
        /// Share of the area of the box in which other rock fills its cells. Unit: 1.
        share: f64,
        /// Change of its volume, over this. Unit: 1.
        volume: f64,
    },
    /// An end of a fault that lies on a top.
    Follows {
        /// Which end.
        what: String,
        /// Which top.
        top: String,
        /// Lowest and highest point of the top along it [m].
        heights: [f64; 2],
        /// As written [m].
        written: f64,
    },
}

impl Remark {
    /// True where the grid differs from what is written.
    pub fn is_warning(&self) -> bool {
        !matches!(self, Self::Lies { .. })
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lies {
                top,
                level,
                heights: [low, high],
            } => write!(
                f,
                "{top} goes from {low} m to {high} m, on the grid level z = {level} m"
            ),
            Self::Off { top, by } => write!(
                f,
                "{top} is followed at the lines of the grid, and is up to about {by:.3} m off between them"
            ),
            Self::Thin {
                layer,
                least,
                share,
                volume,
            } => write!(
                f,
                "layer \"{layer}\" ends: the grid leaves it {least:.3} m at least, and where it is thinner than half of that, in {:.2} % of the area, its cells have the material beside it; its volume changes by {:.3} %",
                100.0 * share,
                100.0 * volume
            ),
            Self::Follows {
                what,
                top,
                heights: [low, high],
                written,
            } => write!(
                f,
                "{what} lies on {top}, from {low:.3} m to {high:.3} m, and not at {written} m"
            ),
        }
    }
}

/// Where tops lie.
pub(super) fn heights(columns: &Columns) -> impl Iterator<Item = Remark> {
    let layers = columns.layers;
    let tilted = (0..layers.names.len()).filter(|k| layers.tops[*k].is_level().is_none());
    tilted.map(|k| Remark::Lies {
        top: layers.name(k),
        level: layers.levels[k],
        heights: layers.tops[k].range(columns.ends),
    })
}

/// How far tops are from the surfaces of the grid between its lines.
pub(super) fn off(sections: &SceneSections, columns: &Columns) -> Result<Vec<Remark>, Located> {
    let mesh = &sections.mesh;
    let mut lines: [Vec<f64>; 2] = Default::default();
    for (d, (section, name)) in [(&mesh.x, "x"), (&mesh.y, "y")].into_iter().enumerate() {
        let own = axis(section, name)?.lines(d);
        lines[d] = own.map_err(|e| at(&["mesh", name], e))?;
    }
    let mut remarks = Vec::new();
    let leans = columns.leaning.iter().any(|leaning| !leaning.is_empty());
    for k in 0..columns.layers.names.len() {
        let top = &columns.layers.tops[k];
        let meets = |d: usize| top.bends(d, columns.ends[d]).all(|x| lines[d].contains(&x));
        if top.is_level().is_some() || (!leans && meets(0) && meets(1)) {
            continue;
        }
        let mut by = 0.0f64;
        for block in 0..columns.blocks.count() {
            by = by.max(columns.off(block, k, &lines)?);
        }
        if by > columns.layers.rounding() {
            let top = columns.layers.name(k);
            remarks.push(Remark::Off { top, by });
        }
    }
    Ok(remarks)
}
