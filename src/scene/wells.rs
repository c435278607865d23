//! From sections to wells: the faces that their lines cut.

use super::flow_sections::WellSection;
use super::history::Histories;
use super::located::{Located, at};
use super::outline::{Meeting, Outline};
use super::sections::SceneSections;
use super::{FlowProblem, Problem};
use crate::flow::{Well, WellGiven};
use crate::mesh::{BuiltMesh, FractureFace, dot, minus};
use crate::units::Measure;
use std::f64::consts::TAU;

/// Radius of a well where none is given. Unit: m.
const RADIUS: f64 = 0.1;

/// `r_e/√(a² + b²)` of a face. Unit: 1. Source: D. W. Peaceman, SPE J. 18 (1978) 183–194.
const EQUIVALENT: f64 = 0.14;

/// The wells of a scene, with their cuts.
pub(super) fn wells(
    sections: &SceneSections,
    built: &BuiltMesh,
    (histories, of_time): (&mut Histories, usize),
) -> Result<Vec<Well>, Located> {
    let mut wells: Vec<Well> = Vec::new();
    for (i, section) in sections.well.iter().enumerate() {
        let number = i.to_string();
        let place = ["well", &number];
        let path = ["well", &number, "history"];
        let history = histories.number(section.history.as_ref(), &path, of_time)?;
        let name = section.name.clone();
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(plain) || wells.iter().any(|w| w.name == name) {
            return Err(at(
                &["well", &number, "name"],
                FlowProblem::WellName { name },
            ));
        }
        let given = match (&section.rate, &section.pressure) {
            (Some(rate), None) => {
                WellGiven::Rate(rate.si(), section.limit.as_ref().map(Measure::si))
            }
            (None, Some(_)) if section.limit.is_some() => {
                return Err(at(
                    &["well", &number, "limit"],
                    FlowProblem::LimitedPressure { name },
                ));
            }
            (None, Some(pressure)) => WellGiven::Pressure(pressure.si()),
            (rate, pressure) => {
                return Err(at(
                    &place,
                    Problem::ExactlyOne {
                        what: format!("[[well]] \"{name}\""),
                        keys: "`rate`, `pressure`",
                        found: usize::from(rate.is_some()) + usize::from(pressure.is_some()),
                    },
                ));
            }
        };
        let cuts = cuts(section, built).map_err(|problem| at(&place, problem))?;
        wells.push(Well {
            name,
            cuts,
            head: [0, 1, 2].map(|k: usize| section.from[k].si()),
            given,
            history,
        });
    }
    Ok(wells)
}

/// The faces that the line of a well cuts, each with `2π/ln(r_e/r_w)`; where it cuts the border of faces of one fracture each has its
/// share of the whole circle.
fn cuts(section: &WellSection, built: &BuiltMesh) -> Result<Vec<(u32, f64)>, FlowProblem> {
    let point = |p: &[Measure<crate::units::Length>; 3]| [0, 1, 2].map(|k: usize| p[k].si());
    let (from, to) = (point(&section.from), point(&section.to));
    let name = || section.name.clone();
    let radius = section.radius.as_ref().map_or(RADIUS, Measure::si);
    if radius <= 0.0 {
        return Err(FlowProblem::NoRadius {
            name: name(),
            radius,
        });
    }
    let along = minus(to, from);
    if along == [0.0; 3] {
        return Err(FlowProblem::ShortWell { name: name() });
    }
    let faces = &built.fractures.faces;
    let fracture = |face: &FractureFace| built.fractures.names[usize::from(face.fracture)].clone();
    let mut found: Vec<(u32, [f64; 3])> = Vec::new();
    for (f, face) in faces.iter().enumerate() {
        let outline = Outline::new(face, built);
        match outline.meeting(from, along) {
            Meeting::Through(places) => {
                found.extend(places.into_iter().map(|place| (f as u32, place)));
            }
            Meeting::Along => {
                return Err(FlowProblem::WellInPlane {
                    name: name(),
                    fracture: fracture(face),
                    center: face.center,
                });
            }
        }
    }
    let mut cuts = Vec::new();
    for (f, place) in &found {
        let face = &faces[*f as usize];
        let outline = Outline::new(face, built);
        let beside = |(other, at): &&(u32, [f64; 3])| {
            faces[*other as usize].fracture == face.fracture && outline.is_same(*at, *place)
        };
        let shares = found.iter().filter(beside).count();
        let most = EQUIVALENT * outline.diagonal();
        if most <= radius {
            return Err(FlowProblem::WideWell {
                name: name(),
                radius,
                most,
            });
        }
        cuts.push((*f, TAU / (most / radius).ln() / shares as f64));
    }
    if cuts.is_empty() {
        let distance = |face: &FractureFace| {
            let to_center = minus(face.center, from);
            let share = (dot(to_center, along) / dot(along, along)).clamp(0.0, 1.0);
            let off: [f64; 3] = std::array::from_fn(|k| to_center[k] - share * along[k]);
            dot(off, off).sqrt()
        };
        let nearest = (faces.iter()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        return Err(FlowProblem::NothingCut {
            name: name(),
            nearest: nearest.map_or(String::new(), fracture),
            center: nearest.map_or([f64::NAN; 3], |face| face.center),
        });
    }
    Ok(cuts)
}
