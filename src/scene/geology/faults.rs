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
    /// Depth range [m].
    pub(super) reach: [f64; 2],
    /// Levels, as written, between which it offsets tops [m].
    cut: [f64; 2],
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
        let (cut, reach) = match (&fracture.z, &fracture.cuts) {
            (Some(_), Some(_)) => {
                let what = format!("fracture \"{name}\"");
                let keys = "`z`, `cuts`";
                let found = 2;
                return Err(here("cuts", Problem::ExactlyOne { what, keys, found }));
            }
            (Some(z), None) => {
                let z = [z[0].si(), z[1].si()];
                (z, z)
            }
            (None, Some(cuts)) if cuts.is_empty() => {
                return Err(here("cuts", GeologyProblem::NoCut { name }.into()));
            }
            (None, Some(cuts)) => {
                let cut = layers.span(cuts);
                let cut = cut.map_err(|problem| here("cuts", problem.into()))?;
                (cut, cut)
            }
            (None, None) => (whole, whole),
        };
        let [from, to] = reach;
        if to <= from {
            let key = if fracture.z.is_some() { "z" } else { "cuts" };
            return Err(here(
                key,
                GeologyProblem::NoHeight { name, from, to }.into(),
            ));
        }
        let tops = &layers.levels[1..layers.levels.len() - 1];
        if throw != 0.0 && !tops.iter().any(|top| (cut[0]..=cut[1]).contains(top)) {
            let tops = tops.to_vec();
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
            let [from, to] = extents[d];
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
            cut,
            throw,
            level: fracture.level.as_ref().map(Measure::si),
            leans: dip.is_some(),
        }))
    }

    /// Level at which it lies at its position [m].
    pub(super) fn level(&self) -> f64 {
        let middle = 0.5 * (self.reach[0] + self.reach[1]);
        self.level.unwrap_or(middle)
    }

    /// True where it moves layers.
    pub(super) fn moves(&self) -> bool {
        self.throw != 0.0
    }

    /// True where it offsets a top of this level.
    pub(super) fn cuts(&self, top: f64) -> bool {
        (self.cut[0]..=self.cut[1]).contains(&top)
    }

    /// How much lower a top of this level lies at a point because of it [m].
    pub(super) fn offset(&self, top: f64, point: [f64; 2]) -> f64 {
        if !self.cuts(top) {
            return 0.0;
        }
        let passed = self.at.iter().filter(|at| point[self.axis] > **at).count();
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
                for level in layers.lying(faults, point, fault.cut) {
                    range = [range[0].min(level), range[1].max(level)];
                }
            }
        }
    }
    range
}

/// Share of the box at which a point lies beside a fault: far above rounding, far below a cell. Unit: 1.
const BESIDE: f64 = 1e-9;
