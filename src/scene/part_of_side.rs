//! The part of a side that a boundary condition holds on.

use super::located::{Located, at};
use super::sections::{BoundarySection, SideName};
use crate::mesh::{BuiltMesh, FaceSide};
use crate::units::Measure;

/// A part of a side that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PartProblem {
    /// A span that has no length.
    #[error("`{key}` goes from {from} m to {to} m; give the smaller one first")]
    Empty {
        /// x, y or z.
        key: &'static str,
        /// Its start [m].
        from: f64,
        /// Its end [m].
        to: f64,
    },
    /// An end of a span inside a face.
    #[error(
        "the end of `{key}` at {end} m lies inside a face of {side}, from {low} m to {high} m; put a line of the grid there, e.g. by `through`, or end at one"
    )]
    CutFace {
        /// x, y or z.
        key: &'static str,
        /// The side.
        side: String,
        /// The end [m].
        end: f64,
        /// Least coordinate of the face [m].
        low: f64,
        /// Its largest [m].
        high: f64,
    },
    /// A part of a side without faces.
    #[error("no face of {side} lies between {from} m and {to} m along {key}")]
    NoFace {
        /// x, y or z.
        key: &'static str,
        /// The side.
        side: String,
        /// Start of the span [m].
        from: f64,
        /// Its end [m].
        to: f64,
    },
}

/// How far a face may reach across an end of a span, over its longest extent: coordinates are rounded. Unit: 1.
const ACROSS: f64 = 1e-6;

/// The faces of a boundary condition: those of its side or surface, or those between its spans, which no face reaches across.
///
/// # Errors
/// An end of a span inside a face, a span that goes backwards, no face.
pub(super) fn part(
    number: usize,
    boundary: &BoundarySection,
    built: &BuiltMesh,
) -> Result<Vec<FaceSide>, Located> {
    // the sides of a mesh file are those of the sections
    let mut faces = built.sides[boundary.side.map_or(number, SideName::index)].clone();
    let number = number.to_string();
    let spans = [&boundary.x, &boundary.y, &boundary.z];
    for (axis, span) in spans.into_iter().enumerate() {
        let Some(span) = span else { continue };
        let key = ["x", "y", "z"][axis];
        let refuse = |problem: PartProblem| at(&["boundary", &number, key], problem);
        let [from, to] = span.each_ref().map(Measure::si);
        if from >= to {
            return Err(refuse(PartProblem::Empty { key, from, to }));
        }
        let mut within = Vec::with_capacity(faces.len());
        for face in faces {
            let x = face.nodes.map(|node| built.mesh.nodes[node as usize][axis]);
            let low = x.into_iter().fold(f64::INFINITY, f64::min);
            let high = x.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let slack = ACROSS * extent(&face, built);
            let cuts = |end: &f64| low + slack < *end && *end < high - slack;
            if let Some(end) = [from, to].iter().copied().find(cuts) {
                let side = boundary.place();
                let [low, high] = [low, high].map(|x| (1e6 * x).round() / 1e6);
                return Err(refuse(PartProblem::CutFace {
                    key,
                    side,
                    end,
                    low,
                    high,
                }));
            }
            let middle = 0.5 * (low + high);
            if from - slack <= middle && middle <= to + slack {
                within.push(face);
            }
        }
        if within.is_empty() {
            let side = boundary.place();
            return Err(refuse(PartProblem::NoFace {
                key,
                side,
                from,
                to,
            }));
        }
        faces = within;
    }
    Ok(faces)
}

/// Longest side of the box around a face [m].
fn extent(face: &FaceSide, built: &BuiltMesh) -> f64 {
    let along = |axis: usize| {
        let x = face.nodes.map(|node| built.mesh.nodes[node as usize][axis]);
        let low = x.into_iter().fold(f64::INFINITY, f64::min);
        x.into_iter().fold(f64::NEG_INFINITY, f64::max) - low
    };
    (0..3).map(along).fold(0.0, f64::max)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::scene::Scene;

    fn scene(boundary: &str) -> Scene {
        let text = format!(
            "title = 'part'\n[mesh]\nx = {{ from = '0 m', to = '6 m', cells = 6 }}\ny = {{ from = '0 m', to = '4 m', cells = 4 }}\nz = {{ from = '0 m', to = '2 m', cells = 2 }}\n\
             [[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n\
             [[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'z+'\n{boundary}"
        );
        Scene::from_toml(&text, "part.toml").unwrap()
    }

    fn said(boundary: &str) -> String {
        scene(boundary).build().unwrap_err().to_string()
    }

    #[test]
    fn a_load_on_a_part_has_its_area_and_a_hold_its_nodes() {
        let body = scene("pressure = '2 MPa'\nx = ['1 m', '3 m']\ny = ['1 m', '4 m']\n");
        let push = &body.build().unwrap().inventory().pushes[0];
        assert_eq!(push.faces, 6);
        assert!((push.area - 6.0).abs() < 1e-12, "{push:?}");
        assert!((push.force[2] + 12e6).abs() < 1e-3, "{push:?}");
        let whole = scene("pressure = '2 MPa'\nx = ['-1 m', '7 m']\n");
        assert_eq!(whole.build().unwrap().inventory().pushes[0].faces, 24);
        let held = |keys: &str| scene(keys).build().unwrap().inventory().held[2];
        let below = held("traction = { x = '1 MPa' }\n");
        let above = held("hold = 'roller'\nx = ['2 m', '3 m']\ny = ['0 m', '1 m']\n");
        assert_eq!(above, below + 4);
    }

    #[test]
    fn a_side_at_the_end_of_a_span_belongs_to_it_as_it_is_rounded() {
        // half a turn takes y+ to y = 0, but for rounding
        let turned = "pressure = '2 MPa'\n[[boundary]]\nside = 'y+'\npressure = '1 MPa'\ny = ['0 m', '3 m']\n\
                      [mesh.map.rotate]\naxis = 'z'\nangle = '180 deg'\n";
        let found = scene(turned).build().unwrap().inventory();
        assert!(
            (found.pushes[1].area - 12.0).abs() < 1e-9,
            "{:?}",
            found.pushes
        );
    }

    #[test]
    fn an_end_inside_a_face_and_an_empty_part_are_told() {
        let found = said("pressure = '2 MPa'\nx = ['1 m', '3.5 m']\n");
        assert!(
            found.contains("3.5 m lies inside a face of z+, from 3 m to 4 m"),
            "{found}"
        );
        assert!(found.contains("part.toml:16"), "{found}");
        let found = said("hold = 'fixed'\ny = ['9 m', '12 m']\n");
        assert!(
            found.contains("no face of z+ lies between 9 m and 12 m along y"),
            "{found}"
        );
        let found = said("hold = 'fixed'\ny = ['3 m', '1 m']\n");
        assert!(found.contains("`y` goes from 3 m to 1 m"), "{found}");
    }
}
