//! Boundary conditions on the sides of the body.

use super::located::{Located, at};
use super::part_of_side::part;
use super::sections::{BoundarySection, HoldSection};
use super::{Problem, Pull, SurfaceTraction};
use crate::mesh::{BuiltMesh, face_geometry};
use std::collections::HashSet;

/// A face is perpendicular to an axis if its unit normal has a component larger than 1 − this: an angle of 1e-5 rad.
const FLAT: f64 = 5e-11;

/// `3·node + component`, its displacement [m] and the number of its history.
type Prescribed = (u32, f64, usize);

/// Prescribed displacements, a later one in place of an earlier one, and loads; `history` numbers that of a boundary.
pub(super) fn hold(
    boundaries: &[BoundarySection],
    built: &BuiltMesh,
    mut history: impl FnMut(usize, &BoundarySection) -> Result<usize, Located>,
) -> Result<(Vec<Prescribed>, Vec<SurfaceTraction>), Located> {
    let mut prescribed = Vec::new();
    let mut tractions = Vec::new();
    // number of the boundary, key, and where its tractions begin
    let mut loads = Vec::new();
    for (i, boundary) in boundaries.iter().enumerate() {
        let number = i.to_string();
        let faces = part(i, boundary, built)?;
        let history = history(i, boundary)?;
        let mut prescribe = |given: [Option<f64>; 3]| {
            let mut nodes: Vec<u32> = faces.iter().flat_map(|f| f.nodes).collect();
            nodes.sort_unstable();
            nodes.dedup();
            for node in nodes {
                let values = given.iter().zip(3 * node..);
                prescribed
                    .extend(values.filter_map(|(value, dof)| Some((dof, (*value)?, history))));
            }
        };
        match (
            boundary.hold,
            &boundary.displacement,
            &boundary.traction,
            &boundary.pressure,
        ) {
            (Some(HoldSection::Fixed), None, None, None) => prescribe([Some(0.0); 3]),
            (Some(HoldSection::Roller), None, None, None) => {
                // every face along its own axis: a list may have several sides
                let mut rollers: Vec<Prescribed> = Vec::new();
                for face in &faces {
                    let normal = normal(&face.nodes, built);
                    let axis = (0..3usize).find(|d| normal[*d].abs() >= 1.0 - FLAT);
                    let Some(axis) = axis else {
                        return Err(at(
                            &["boundary", &number, "hold"],
                            Problem::TiltedRoller {
                                side: boundary.place(),
                                normal,
                            },
                        ));
                    };
                    let dofs = face.nodes.map(|node| 3 * node + axis as u32);
                    rollers.extend(dofs.map(|dof| (dof, 0.0, history)));
                }
                rollers.sort_unstable_by_key(|(dof, ..)| *dof);
                rollers.dedup();
                prescribed.append(&mut rollers);
            }
            (None, Some(displacement), None, None) => {
                let given = displacement.given();
                if given.iter().all(Option::is_none) {
                    return Err(at(
                        &["boundary", &number, "displacement"],
                        Problem::NoComponent {
                            side: boundary.place(),
                        },
                    ));
                }
                prescribe(given);
            }
            (None, None, Some(traction), None) => {
                loads.push((i, "traction", tractions.len()));
                tractions.push(SurfaceTraction {
                    faces: faces.iter().map(|f| f.nodes).collect(),
                    pull: Pull::Traction(traction.si()),
                    history,
                });
            }
            (None, None, None, Some(pressure)) => {
                loads.push((i, "pressure", tractions.len()));
                tractions.push(SurfaceTraction {
                    faces: faces.iter().map(|f| f.nodes).collect(),
                    pull: Pull::Pressure(pressure.si()),
                    history,
                });
            }
            (hold, displacement, traction, pressure) => {
                let found = [
                    hold.is_some(),
                    displacement.is_some(),
                    traction.is_some(),
                    pressure.is_some(),
                ];
                return Err(at(
                    &["boundary", &number],
                    Problem::ExactlyOne {
                        what: match boundary.side {
                            Some(side) => format!("[[boundary]] of side {}", side.name()),
                            None => format!("[[boundary]] of {}", boundary.place()),
                        },
                        keys: "`hold`, `displacement`, `traction`, `pressure`",
                        found: found.iter().filter(|f| **f).count(),
                    },
                ));
            }
        }
    }
    require_free(boundaries, built, &loads, (&tractions, &prescribed))?;
    Ok((prescribed, tractions))
}

/// Component of a traction over its largest that is none: the normal of a flat side has such ones by rounding. Unit: 1.
const NONE: f64 = 1e-9;

/// Refuses loads along displacements that are all prescribed.
fn require_free(
    boundaries: &[BoundarySection],
    built: &BuiltMesh,
    loads: &[(usize, &'static str, usize)],
    (tractions, prescribed): (&[SurfaceTraction], &[Prescribed]),
) -> Result<(), Located> {
    let held: HashSet<u32> = prescribed.iter().map(|(dof, ..)| *dof).collect();
    for (k, (i, key, from)) in loads.iter().enumerate() {
        let to = loads.get(k + 1).map_or(tractions.len(), |next| next.2);
        let mut pushes = false;
        let mut moves = |load: &SurfaceTraction| {
            (load.faces.iter()).any(|nodes| {
                let value = match load.pull {
                    Pull::Traction(t) => t,
                    Pull::Pressure(p) => normal(nodes, built).map(|n| -p * n),
                };
                let largest = value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
                let along = |d: &u32| value[*d as usize].abs() > NONE * largest;
                let along: Vec<u32> = (0..3).filter(along).collect();
                pushes |= !along.is_empty();
                let mut dofs =
                    (nodes.iter()).flat_map(|node| along.iter().map(move |d| 3 * node + d));
                dofs.any(|dof| !held.contains(&dof))
            })
        };
        if !tractions[*from..to].iter().any(&mut moves) && pushes {
            let side = boundaries[*i].place();
            let path = ["boundary", &i.to_string(), key];
            return Err(at(&path, Problem::HeldLoad { key, side }));
        }
    }
    Ok(())
}

/// Outward unit normal, averaged over the face.
fn normal(nodes: &[u32; 4], built: &BuiltMesh) -> [f64; 3] {
    face_geometry(&nodes.map(|n| built.mesh.nodes[n as usize])).frame[0]
}
