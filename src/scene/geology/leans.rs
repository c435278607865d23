//! The shear that leans faults, and whether a grid can follow it.

use super::GeologyProblem;
use super::faults::Fault;
use crate::mesh::Leaning;
use crate::scene::geometry::leaning;
use crate::scene::located::{Located, at};
use crate::scene::mesh_sections::{AxisName, FractureSection, ShearSection};
use crate::units::Measure;

/// Least share of the distance of two planes, or of two levels, that shear and lift may leave: cells between them become that much
/// narrower. Unit: 1.
pub(super) const SQUEEZE: f64 = 0.1;

/// A plane, the fault that made it and the number of its section.
struct Plane<'a> {
    fault: &'a Fault,
    section: ShearSection,
    leaning: Leaning,
}

/// The planes of all faults across an axis, if one of them leans.
pub(super) fn shear(
    faults: &[Fault],
    fractures: &[FractureSection],
    axis: AxisName,
    ends: [f64; 2],
) -> Result<Vec<ShearSection>, Located> {
    let across = || faults.iter().filter(|f| f.axis == axis.index());
    if !across().any(|f| f.leans) {
        return Ok(Vec::new());
    }
    let mut planes: Vec<Plane> = Vec::new();
    for fault in across() {
        for position in &fault.at {
            let dip = fractures[fault.section].dip.clone();
            let section = ShearSection {
                plane: axis,
                at: Measure::metres(*position),
                level: Measure::metres(fault.level()),
                dip: dip.unwrap_or_else(Measure::right),
                z: fault.in_rock().map(Measure::metres),
            };
            let plane = Plane {
                fault,
                leaning: leaning(&section),
                section,
            };
            match planes.iter_mut().find(|p| p.leaning.at == *position) {
                Some(other) => other.join(plane)?,
                None => planes.push(plane),
            }
        }
    }
    planes.sort_by(|a, b| a.leaning.at.total_cmp(&b.leaning.at));
    let side = |at: f64| {
        (
            format!("the side of the box at {} = {at} m", axis.name()),
            upright(at),
        )
    };
    let named = planes
        .iter()
        .map(|p| (format!("fracture \"{}\"", p.fault.name), p.leaning));
    let all: Vec<(String, Leaning)> = std::iter::once(side(ends[0]))
        .chain(named)
        .chain([side(ends[1])])
        .collect();
    for (i, pair) in all.windows(2).enumerate() {
        let [(first, a), (second, b)] = pair else {
            continue;
        };
        let fault = planes[i.min(planes.len() - 1)].fault;
        let path = ["fracture", &fault.section.to_string(), "dip"];
        apart((first, a), (second, b)).map_err(|problem| at(&path, problem))?;
    }
    Ok(planes.into_iter().map(|p| p.section).collect())
}

impl Plane<'_> {
    /// Another fault in the same place, which has to have the same plane.
    fn join(&mut self, other: Self) -> Result<(), Located> {
        let is_upright = |p: &Plane| !p.fault.leans;
        let same =
            self.section.dip == other.section.dip && self.section.level == other.section.level;
        if !(same || (is_upright(self) && is_upright(&other))) {
            let (first, second) = (self.fault.name.clone(), other.fault.name.clone());
            let path = ["fracture", &other.fault.section.to_string()];
            return Err(at(&path, GeologyProblem::SamePlace { first, second }));
        }
        let (own, new) = (self.leaning.reach, other.leaning.reach);
        self.leaning.reach = [own[0].min(new[0]), own[1].max(new[1])];
        self.section.z = self.leaning.reach.map(Measure::metres);
        Ok(())
    }
}

/// A plane that does not lean.
fn upright(at: f64) -> Leaning {
    Leaning {
        at,
        level: 0.0,
        slope: 0.0,
        reach: [f64::NEG_INFINITY, f64::INFINITY],
    }
}

/// Two neighbours keep a share of their distance at all levels; it changes linearly between the ends of what leans.
fn apart(
    (first, a): (&String, &Leaning),
    (second, b): (&String, &Leaning),
) -> Result<(), GeologyProblem> {
    let distance = b.at - a.at;
    let levels = a.reach.into_iter().chain(b.reach).filter(|z| z.is_finite());
    let left = |z: f64| b.position(z) - a.position(z);
    let worst = levels.min_by(|x, y| left(*x).total_cmp(&left(*y)));
    match worst {
        Some(level) if left(level) < SQUEEZE * distance => Err(GeologyProblem::Cross {
            first: first.clone(),
            second: second.clone(),
            distance,
            left: left(level),
            level,
        }),
        _ => Ok(()),
    }
}
