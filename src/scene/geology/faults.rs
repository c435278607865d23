//! Fractures across x or y: what they cut, by how much they offset it, and how they lean.

use super::GeologyProblem;
use super::layers::Layers;
use crate::mesh::MeshError;
use crate::scene::Problem;
use crate::scene::located::{Located, at};
use crate::scene::mesh_sections::{AxisName, FractureSection};
use crate::units::Measure;

/// Dips that the grid follows [deg].
const DIPS: std::ops::RangeInclusive<f64> = 30.0..=150.0;

/// What an angle may lose on its way from degrees to radians and back [deg].
const ROUNDING: f64 = 1e-9;

/// A fracture across x or y.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    /// Number of its section.
    pub(super) section: usize,
    pub(super) name: String,
    /// 0 or 1.
    pub(super) axis: usize,
    /// Positions [m].
    pub(super) at: Vec<f64>,
    /// Depth range in the grid, before lines move to tops that are not level [m].
    pub(super) reach: [f64; 2],
    /// Depth range in the rock, where that is another one [m].
    pub(super) rock: Option<[f64; 2]>,
    /// Its `z` as written [m].
    pub(super) written: Option<[f64; 2]>,
    /// Per position, which levels it offsets, the top and the bottom of the box included.
    cut: Vec<Vec<bool>>,
    /// How much lower layers lie beyond it [m].
    pub(super) throw: f64,
    /// Level at which it lies at its position, where it is written [m].
    level: Option<f64>,
    /// True where it has a `dip`.
    pub(super) leans: bool,
}

impl Fault {
    /// Reads a fracture; `None` where it is none across x or y with positions.
    pub(super) fn new(
        section: usize,
        fracture: &FractureSection,
        layers: &Layers,
        extents: &[[f64; 2]; 3],
    ) -> Result<Option<Self>, Located> {
        let number = section.to_string();
        let name = fracture.name.clone();
        let here = |key: &str, problem: Problem| at(&["fracture", &number, key], problem);
        let axis = fracture.plane.filter(|plane| *plane != AxisName::Z);
        let (Some(axis), Some(positions)) = (axis.map(AxisName::index), &fracture.at) else {
            let keys = [
                ("dip", fracture.dip.is_some()),
                ("level", fracture.level.is_some()),
                ("throw", fracture.throw.is_some()),
                ("cuts", fracture.cuts.is_some()),
            ];
            return match keys.into_iter().find(|(_, given)| *given) {
                Some((key, _)) => Err(here(key, GeologyProblem::NoFault { name, key }.into())),
                None => Ok(None),
            };
        };
        let throw = fracture.throw.as_ref().map_or(0.0, Measure::si);
        let whole = extents[2];
        let middle = [0, 1].map(|d: usize| 0.5 * (extents[d][0] + extents[d][1]));
        let trace = |position: f64| {
            let mut point = middle;
            point[axis] = position;
            point
        };
        let last = layers.levels.len() - 1;
        let numbers = |within: &dyn Fn(usize, [f64; 2]) -> bool| -> Vec<Vec<bool>> {
            let of = |position: &f64| (0..=last).map(|k| within(k, trace(*position))).collect();
            positions.si().iter().map(of).collect()
        };
        let (cut, reach) = match (&fracture.z, &fracture.cuts) {
            (Some(_), Some(_)) => {
                let what = format!("fracture \"{name}\"");
                let keys = "`z`, `cuts`";
                let found = 2;
                return Err(here("cuts", Problem::ExactlyOne { what, keys, found }));
            }
            (Some(z), None) => {
                let z = [z[0].si(), z[1].si()];
                let is_within = |k: usize, point| (z[0]..=z[1]).contains(&layers.tops[k].at(point));
                (numbers(&is_within), z)
            }
            (None, Some(cuts)) if cuts.is_empty() => {
                return Err(here("cuts", GeologyProblem::NoCut { name }.into()));
            }
            (None, Some(cuts)) => {
                let span = layers.span(cuts);
                let [first, end] = span.map_err(|problem| here("cuts", problem.into()))?;
                let reach = [end, first].map(|k| layers.levels[k]);
                (numbers(&|k, _| (first..=end).contains(&k)), reach)
            }
            (None, None) => (numbers(&|_, _| true), whole),
        };
        let [from, to] = reach;
        if to <= from {
            let key = if fracture.z.is_some() { "z" } else { "cuts" };
            return Err(here(
                key,
                GeologyProblem::NoHeight { name, from, to }.into(),
            ));
        }
        if throw != 0.0 && !cut.iter().any(|cut| cut[1..last].contains(&true)) {
            let place = trace(positions.si().first().copied().unwrap_or(middle[axis]));
            let tops = (1..last).map(|k| layers.tops[k].at(place)).collect();
            let idle = GeologyProblem::IdleThrow {
                name,
                throw,
                from,
                to,
                tops,
            };
            return Err(here("throw", idle.into()));
        }
        let positions = positions.si();
        let spans: [Vec<f64>; 2] =
            [&fracture.x, &fracture.y].map(|span| span.iter().flatten().map(Measure::si).collect());
        let mut ends: [Vec<f64>; 3] = [spans[0].clone(), spans[1].clone(), reach.to_vec()];
        ends[axis] = positions.clone();
        for (d, values) in ends.iter().enumerate() {
            let key = if d == axis { "at" } else { ["x", "y", "z"][d] };
            let [from, mut to] = extents[d];
            if d == 2 && fracture.z.is_some() {
                let ground = |at: &f64| layers.tops[0].range(across_box(axis, *at, extents))[1];
                to = positions
                    .iter()
                    .map(ground)
                    .fold(f64::NEG_INFINITY, f64::max);
            }
            for value in values.iter().copied() {
                let (fracture, axis_name) = (name.clone(), ['x', 'y', 'z'][d]);
                if !(from..=to).contains(&value) {
                    let outside = MeshError::OutsideBox {
                        fracture,
                        axis: axis_name,
                        value,
                        from,
                        to,
                    };
                    return Err(here(key, outside.into()));
                }
                if d == axis && (value == from || value == to) {
                    let edge = MeshError::OnBoundary {
                        fracture,
                        axis: axis_name,
                        value,
                    };
                    return Err(here(key, edge.into()));
                }
            }
        }
        let dip = fracture.dip.as_ref().map(|dip| dip.si().to_degrees());
        let within = |dip: &f64| (DIPS.start() - ROUNDING..=DIPS.end() + ROUNDING).contains(dip);
        if let Some(dip) = dip.filter(|dip| !within(dip)) {
            return Err(here("dip", GeologyProblem::Dip { name, dip }.into()));
        }
        if fracture.level.is_some() && dip.is_none() {
            let (key, what, without) = ("level", format!("fracture \"{name}\""), "dip");
            return Err(here(key, Problem::Idle { key, what, without }));
        }
        Ok(Some(Self {
            section,
            name,
            axis,
            at: positions,
            reach,
            rock: None,
            written: fracture.z.as_ref().map(|_| reach),
            cut,
            throw,
            level: fracture.level.as_ref().map(Measure::si),
            leans: dip.is_some(),
        }))
    }

    /// Level at which it lies at its position [m].
    pub(super) fn level(&self) -> f64 {
        let [from, to] = self.in_rock();
        self.level.unwrap_or(0.5 * (from + to))
    }

    /// Depth range in the rock [m].
    pub(super) fn in_rock(&self) -> [f64; 2] {
        self.rock.unwrap_or(self.reach)
    }

    /// Fixes the level at which it lies at its position, where none is written.
    pub(super) fn lies_at(&mut self, level: f64) {
        self.level.get_or_insert(level);
    }

    /// True where it moves layers.
    pub(super) fn moves(&self) -> bool {
        self.throw != 0.0
    }

    /// True where it offsets level k.
    pub(super) fn cuts(&self, k: usize) -> bool {
        self.cut.iter().any(|cut| cut[k])
    }

    /// Numbers of the highest and of the lowest level that it cuts.
    pub(super) fn levels(&self) -> Option<[usize; 2]> {
        let all = self.cut.first()?.len();
        let mut cut = (0..all).filter(|k| self.cuts(*k));
        let first = cut.next()?;
        Some([first, cut.next_back().unwrap_or(first)])
    }

    /// How much lower level k lies at a point because of it [m].
    pub(super) fn offset(&self, k: usize, point: [f64; 2]) -> f64 {
        let is_passed = |(at, cut): &(&f64, &Vec<bool>)| cut[k] && point[self.axis] > **at;
        let passed = self.at.iter().zip(&self.cut).filter(is_passed).count();
        self.throw * passed as f64
    }
}

/// Depth ranges of faults that are written by the layers that they cut: these as they lie on both sides, offset by all faults.
pub(super) fn reach_layers(
    faults: &mut [Fault],
    fractures: &[FractureSection],
    layers: &Layers,
    extents: &[[f64; 2]; 3],
) {
    let ranges: Vec<[f64; 2]> = faults
        .iter()
        .map(|fault| match fractures[fault.section].cuts {
            None => fault.reach,
            Some(_) => beside(fault, faults, layers, extents),
        })
        .collect();
    for (fault, range) in faults.iter_mut().zip(ranges) {
        fault.reach = range;
    }
}

/// Lowest and highest of the levels that a fault cuts, just before and behind it.
fn beside(fault: &Fault, faults: &[Fault], layers: &Layers, extents: &[[f64; 2]; 3]) -> [f64; 2] {
    let other = 1 - fault.axis;
    // beside each fault across the other axis, and at its lower end
    let across = faults
        .iter()
        .filter(|f| f.axis == other)
        .flat_map(|f| &f.at);
    let steps = |d: usize| BESIDE * (extents[d][1] - extents[d][0]);
    let along: Vec<f64> = (across.map(|at| at + steps(other)))
        .chain([extents[other][0] + steps(other)])
        .collect();
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for at in &fault.at {
        for own in [at - steps(fault.axis), at + steps(fault.axis)] {
            for place in &along {
                let mut point = [own, *place];
                point.swap(0, fault.axis);
                for k in (0..layers.levels.len()).filter(|k| fault.cuts(*k)) {
                    let level = layers.levels[k] - layers.offset(k, faults, point);
                    range = [range[0].min(level), range[1].max(level)];
                }
            }
        }
    }
    range
}

/// The line of a position across the box.
pub(super) fn across_box(axis: usize, at: f64, extents: &[[f64; 2]; 3]) -> [[f64; 2]; 2] {
    let mut trace = [extents[0], extents[1]];
    trace[axis] = [at; 2];
    trace
}

/// Share of the box at which a point lies beside a fault: far above rounding, far below a cell. Unit: 1.
const BESIDE: f64 = 1e-9;
