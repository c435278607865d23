//! From sections to wells: the faces that their lines cut.

use super::flow::holds;
use super::flow_sections::WellSection;
use super::history::Histories;
use super::located::{Located, at};
use super::sections::SceneSections;
use super::{FlowProblem, Problem};
use crate::flow::{Well, WellGiven};
use crate::mesh::{BuiltMesh, FractureFace};
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

/// The faces that the line of a well cuts, one per fracture and place, each with `2π/ln(r_e/r_w)`.
fn cuts(section: &WellSection, built: &BuiltMesh) -> Result<Vec<(u32, f64)>, FlowProblem> {
    let point = |p: &[Measure<crate::units::Length>; 3]| [0, 1, 2].map(|k: usize| p[k].si());
    let (from, to) = (point(&section.from), point(&section.to));
    let radius = section.radius.as_ref().map_or(RADIUS, Measure::si);
    let along: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let minus = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| a[k] - b[k]) };
    let mut found: Vec<(u32, [f64; 3])> = Vec::new();
    let mut cuts = Vec::new();
    for (f, face) in built.fractures.faces.iter().enumerate() {
        let n = face.frame[0];
        let crossing = dot(along, n);
        if crossing == 0.0 {
            continue;
        }
        let share = dot(minus(face.center, from), n) / crossing;
        let at: [f64; 3] = std::array::from_fn(|k| from[k] + share * along[k]);
        if !(0.0..=1.0).contains(&share) || !holds(face, built, at) {
            continue;
        }
        let corners = face.minus.nodes.map(|node| built.mesh.nodes[node as usize]);
        let [a, b] = [1, 3].map(|c: usize| minus(corners[c], corners[0]));
        let size = (dot(a, a) + dot(b, b)).sqrt();
        // an edge belongs to two faces of a fracture: the first of them is cut
        let is_same = |(other, place): &(u32, [f64; 3])| {
            let d = minus(*place, at);
            let other: &FractureFace = &built.fractures.faces[*other as usize];
            other.fracture == face.fracture && dot(d, d).sqrt() < 1e-6 * size
        };
        if found.iter().any(is_same) {
            continue;
        }
        found.push((f as u32, at));
        let ratio = EQUIVALENT * size / radius;
        if ratio <= 1.0 {
            return Err(FlowProblem::WideWell {
                name: section.name.clone(),
                radius,
                most: EQUIVALENT * size,
            });
        }
        cuts.push((f as u32, TAU / ratio.ln()));
    }
    if cuts.is_empty() {
        let distance = |face: &FractureFace| {
            let to_center = minus(face.center, from);
            let share = (dot(to_center, along) / dot(along, along)).clamp(0.0, 1.0);
            let off: [f64; 3] = std::array::from_fn(|k| to_center[k] - share * along[k]);
            dot(off, off).sqrt()
        };
        let faces = built.fractures.faces.iter();
        let nearest = faces.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        return Err(FlowProblem::NothingCut {
            name: section.name.clone(),
            nearest: nearest.map_or(String::new(), |face| {
                built.fractures.names[usize::from(face.fracture)].clone()
            }),
            center: nearest.map_or([f64::NAN; 3], |face| face.center),
        });
    }
    Ok(cuts)
}
