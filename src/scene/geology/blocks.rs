//! Blocks between faults that offset layers, and the boxes that materials fill in them.

use super::faults::Fault;
use super::layers::{Layers, material, unknown};
use super::lines::Lines;
use super::{CompartmentSection, GeologyProblem};
use crate::scene::Problem;
use crate::scene::located::{Located, at};
use crate::scene::sections::MaterialSection;
use crate::units::{Length, Measure};

/// A box of one material, before any map.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Number of the material.
    pub material: usize,
    /// Intervals in x, y and z [m].
    pub ends: [[f64; 2]; 3],
}

/// A column of cells in a block, and which layers are too thin in it for their cells.
pub(super) struct ThinCell {
    /// Intervals in x and y [m].
    pub(super) rectangle: [[f64; 2]; 2],
    /// Per layer.
    pub(super) layers: Vec<bool>,
}

/// A part of a layer in a rectangle.
pub(super) struct Compartment {
    material: usize,
    pub(super) layer: String,
    /// Intervals in x and y [m].
    pub(super) ends: [[f64; 2]; 2],
}

impl Compartment {
    /// Reads a section; what it does not limit reaches as far as the box.
    pub(super) fn new(
        number: usize,
        section: &CompartmentSection,
        faults: &[Fault],
        layers: &Layers,
        materials: &[MaterialSection],
        extents: &[[f64; 2]; 3],
    ) -> Result<Self, Located> {
        let here = |key: &str, problem: Problem| {
            at(
                &["geology", "compartments", &number.to_string(), key],
                problem,
            )
        };
        let own = material(&section.material, materials);
        let own = own.map_err(|problem| here("material", problem.into()))?;
        let known = layers.require(&section.layer);
        known.map_err(|problem| here("layer", problem.into()))?;
        let span =
            |span: &Option<[Measure<Length>; 2]>| span.as_ref().map(|s| [s[0].si(), s[1].si()]);
        let mut spans = [span(&section.x), span(&section.y)];
        if let Some([first, second]) = &section.between {
            let find = |name: &String| {
                let known: Vec<String> = faults.iter().map(|f| f.name.clone()).collect();
                let fault = faults.iter().find(|f| f.name == *name);
                fault.ok_or_else(|| here("between", unknown("fault", name, &known).into()))
            };
            let (a, b) = (find(first)?, find(second)?);
            let ends = match (&a.at[..], &b.at[..]) {
                ([a_at], [b_at]) if a.axis == b.axis && a_at != b_at => {
                    [a_at.min(*b_at), a_at.max(*b_at)]
                }
                _ => {
                    let (first, second) = (first.clone(), second.clone());
                    return Err(here(
                        "between",
                        GeologyProblem::Between { first, second }.into(),
                    ));
                }
            };
            if spans[a.axis].replace(ends).is_some() {
                let keys = ["`between`, `x`", "`between`, `y`"][a.axis];
                let what = format!("the compartment of \"{}\"", section.material);
                return Err(here(
                    "between",
                    Problem::ExactlyOne {
                        what,
                        keys,
                        found: 2,
                    },
                ));
            }
        }
        let mut ends = [extents[0], extents[1]];
        for (d, span) in spans.into_iter().enumerate() {
            let Some([from, to]) = span else { continue };
            ends[d] = [from.max(ends[d][0]), to.min(ends[d][1])];
            if ends[d][0] >= ends[d][1] {
                let what = format!(
                    "the compartment of \"{}\" in {}",
                    section.material,
                    ["x", "y"][d]
                );
                return Err(here(
                    ["x", "y"][d],
                    Problem::EmptyInterval { what, from, to },
                ));
            }
        }
        Ok(Self {
            material: own,
            layer: section.layer.clone(),
            ends,
        })
    }

    fn holds(&self, point: [f64; 2]) -> bool {
        (0..2).all(|d| self.ends[d][0] < point[d] && point[d] < self.ends[d][1])
    }
}

/// Where tops and compartments divide x and y, the ends of the box included, increasing.
fn breaks(axis: usize, faults: &[Fault], compartments: &[Compartment], ends: [f64; 2]) -> Vec<f64> {
    let moving = faults.iter().filter(|f| f.axis == axis && f.moves());
    let positions = moving.flat_map(|f| f.at.iter().copied());
    let sides = compartments.iter().flat_map(|c| c.ends[axis]);
    let mut all: Vec<f64> = positions.chain(sides).chain(ends).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Blocks of a geology, and where tops lie in each.
pub(super) struct Blocks {
    /// Where tops and compartments divide x and y, increasing [m].
    breaks: [Vec<f64>; 2],
    /// Levels of tops and of the base in each block, x first [m].
    levels: Vec<Vec<f64>>,
}

impl Blocks {
    /// Tops become lines of z: those that lie where they are written are there already.
    pub(super) fn new(
        layers: &Layers,
        faults: &[Fault],
        compartments: &[Compartment],
        extents: &[[f64; 2]; 3],
        z: &mut Lines,
    ) -> Result<Self, Located> {
        let breaks = [0, 1].map(|d: usize| breaks(d, faults, compartments, extents[d]));
        let written: Vec<Vec<f64>> = (middles(&breaks))
            .map(|middle| block(layers, faults, middle))
            .collect::<Result<_, _>>()?;
        z.settle(written.iter().flatten().copied());
        let levels = written.iter().map(|levels| placed(layers, levels, z));
        Ok(Self {
            levels: levels.collect::<Result<_, _>>()?,
            breaks,
        })
    }

    /// The boxes of all layers and compartments: disjoint, and the whole of the box together. Where a layer is too thin for its cells, these
    /// have the material below, or at the bottom that above.
    pub(super) fn pieces(
        &self,
        layers: &Layers,
        compartments: &[Compartment],
        thin: &[Vec<ThinCell>],
    ) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for (b, (middle, levels)) in middles(&self.breaks).zip(&self.levels).enumerate() {
            let rectangle = self.rectangle(b);
            let own: Vec<usize> = (layers.names.iter().enumerate())
                .map(|(k, name)| {
                    let inside = |c: &&Compartment| c.layer == *name && c.holds(middle);
                    let part = compartments.iter().rfind(inside);
                    part.map_or(layers.materials[k], |c| c.material)
                })
                .collect();
            let cells = thin.get(b).map_or(&[][..], |cells| cells);
            for (k, material) in own.iter().enumerate() {
                let z = [levels[k + 1], levels[k]];
                if !cells.iter().any(|cell| cell.layers[k]) {
                    let [x, y] = rectangle;
                    let (material, ends) = (*material, [x, y, z]);
                    pieces.push(Piece { material, ends });
                    continue;
                }
                pieces.extend(cells.iter().map(|cell| {
                    let [x, y] = cell.rectangle;
                    let thick = |k: &usize| !cell.layers[*k];
                    let in_place = (k..own.len()).find(thick);
                    let in_place = in_place.or((0..k).rev().find(thick)).unwrap_or(k);
                    let (material, ends) = (own[in_place], [x, y, z]);
                    Piece { material, ends }
                }));
            }
        }
        (0..2).fold(pieces, joined)
    }

    /// Where tops and compartments divide x (0) or y (1), increasing [m].
    pub(super) fn breaks(&self, axis: usize) -> &[f64] {
        &self.breaks[axis]
    }

    /// Number of blocks.
    pub(super) fn count(&self) -> usize {
        self.levels.len()
    }

    /// Levels of the grid at tops and at the base in a block, decreasing [m].
    pub(super) fn levels(&self, block: usize) -> &[f64] {
        &self.levels[block]
    }

    /// Intervals of x and y of a block [m].
    pub(super) fn rectangle(&self, block: usize) -> [[f64; 2]; 2] {
        let columns = self.breaks[0].len() - 1;
        let start = [block % columns, block / columns];
        [0, 1].map(|d: usize| [self.breaks[d][start[d]], self.breaks[d][start[d] + 1]])
    }

    /// Blocks that a point lies in, or on the border of.
    pub(super) fn around(&self, point: [f64; 2]) -> impl Iterator<Item = usize> {
        let columns = self.breaks[0].len() - 1;
        let [x, y] = [0, 1].map(|d: usize| {
            let breaks = &self.breaks[d];
            let first = breaks.partition_point(|b| *b < point[d]).max(1) - 1;
            let end = breaks.partition_point(|b| *b <= point[d]);
            first..end.min(breaks.len() - 1)
        });
        y.flat_map(move |j| x.clone().map(move |i| i + columns * j))
    }

    /// A fault with a throw on both sides of which every top that it offsets lies at one level: between the same centres of cells where the
    /// lines of z are given.
    pub(super) fn lost<'f>(
        &self,
        layers: &Layers,
        faults: &'f [Fault],
        lines: Option<&[f64]>,
    ) -> Option<&'f Fault> {
        let columns = self.breaks[0].len() - 1;
        let centres: Option<Vec<f64>> =
            lines.map(|lines| lines.windows(2).map(|l| 0.5 * (l[0] + l[1])).collect());
        let below = |level: f64| match &centres {
            None => level,
            Some(centres) => centres.partition_point(|c| *c < level) as f64,
        };
        let tops = 1..layers.levels.len() - 1;
        let is_taken = |fault: &Fault| {
            let stride = [1, columns][fault.axis];
            (0..self.levels.len()).any(|behind| {
                let along = [behind % columns, behind / columns][fault.axis];
                let is_beside = along > 0 && fault.at.contains(&self.breaks[fault.axis][along]);
                is_beside
                    && (tops.clone()).filter(|k| fault.cuts(*k)).any(|k| {
                        below(self.levels[behind - stride][k]) != below(self.levels[behind][k])
                    })
            })
        };
        faults
            .iter()
            .find(|fault| fault.moves() && !is_taken(fault))
    }
}

/// Middles of blocks, x first.
fn middles([x, y]: &[Vec<f64>; 2]) -> impl Iterator<Item = [f64; 2]> + '_ {
    let middle = |pair: &[f64]| 0.5 * (pair[0] + pair[1]);
    (y.windows(2)).flat_map(move |y| x.windows(2).map(move |x| [middle(x), middle(y)]))
}

/// Levels of tops and of the base in the block around a point, as written and offset.
fn block(layers: &Layers, faults: &[Fault], middle: [f64; 2]) -> Result<Vec<f64>, Located> {
    let last = layers.levels.len() - 1;
    let offset = |k: usize| layers.offset(k, faults, middle);
    let written: Vec<f64> = (0..=last).map(|k| layers.levels[k] - offset(k)).collect();
    match (0..last).find(|k| written[*k] <= written[k + 1]) {
        Some(k) => {
            let eaten = GeologyProblem::Eaten {
                name: layers.names[k].clone(),
                at: middle,
                top: written[k],
                base: written[k + 1],
            };
            Err(at(&["geology", "layers", &k.to_string()], eaten))
        }
        None => Ok(written),
    }
}

/// The same levels on lines of z.
fn placed(layers: &Layers, written: &[f64], z: &mut Lines) -> Result<Vec<f64>, Located> {
    let last = layers.levels.len() - 1;
    let top = |k: usize| format!("the top of \"{}\"", layers.names[k]);
    let placed: Vec<f64> = (0..=last).map(|k| z.place(written[k], || top(k))).collect();
    match (0..last).find(|k| placed[*k] <= placed[k + 1]) {
        Some(k) => {
            let thin = GeologyProblem::Thin {
                what: format!("layer \"{}\"", layers.names[k]),
                from: written[k + 1],
                to: written[k],
            };
            Err(at(&["geology", "layers", &k.to_string()], thin))
        }
        None => Ok(placed),
    }
}

/// Neighbours along an axis that differ in nothing else become one.
fn joined(pieces: Vec<Piece>, axis: usize) -> Vec<Piece> {
    let mut out: Vec<Piece> = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let continues = |p: &&mut Piece| {
            let others = (0..3).filter(|d| *d != axis);
            p.material == piece.material
                && p.ends[axis][1] == piece.ends[axis][0]
                && others.into_iter().all(|d| p.ends[d] == piece.ends[d])
        };
        match out.iter_mut().find(continues) {
            Some(before) => before.ends[axis][1] = piece.ends[axis][1],
            None => out.push(piece),
        }
    }
    out
}
