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
