//! What a run is better told before it begins.

use super::loads::initial_traction;
use crate::analytic::{LinearWeakening, RESOLVED, Rock};
use crate::contact::{Friction, Weakening};
use crate::scene::{Body, Profile};

/// Something that runs, but perhaps not as meant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Remark {
    /// A dynamic angle above the static one.
    #[error(
        "fracture \"{fracture}\" strengthens with slip: its dynamic_friction_angle of {dynamic_deg:.6} deg is above its friction_angle of {static_deg:.6} deg"
    )]
    Strengthens {
        /// Its name.
        fracture: String,
        /// Friction angle [deg].
        static_deg: f64,
        /// Dynamic friction angle [deg].
        dynamic_deg: f64,
    },
    /// Levels that no face lies between.
    #[error(
        "fracture \"{fracture}\" lies from z = {:.6} m to {:.6} m, and its `profile` from {:.6} m to {:.6} m: every face has the values of the nearest level; is the sign of z the one that is meant?",
        faces[0], faces[1], levels[0], levels[1]
    )]
    Beside {
        /// Its name.
        fracture: String,
        /// z of its lowest and highest face [m].
        faces: [f64; 2],
        /// z of the lowest and the highest level [m].
        levels: [f64; 2],
    },
    /// Faces too large for the length at which weakening runs away.
    #[error(
        "fracture \"{fracture}\" weakens: slip runs away beyond a half-length of {length:.3} m under the initial stress (Uenishi and Rice 2003), which faces of {size:.3} m do not resolve; results depend on the mesh unless they are below {:.3} m",
        RESOLVED * length
    )]
    Coarse {
        /// Its name.
        fracture: String,
        /// Largest edge length √A of a face that is too large [m].
        size: f64,
        /// Nucleation half-length there [m].
        length: f64,
    },
}

/// Remarks on friction, fracture by fracture.
pub fn friction_remarks(body: &Body) -> Vec<Remark> {
    let tractions = initial_traction(body);
    let mut remarks = Vec::new();
    for (fracture, profile) in body.friction.iter().enumerate() {
        let of_pressure = body
            .pressures
            .get(fracture)
            .map(|(profile, _)| profile.range());
        let of_friction = profile.as_ref().map(Profile::range);
        let name = || (body.fractures.names.get(fracture).cloned()).unwrap_or_default();
        let ranges = [of_friction, of_pressure].into_iter().flatten();
        // faces are looked through where a profile changes alone
        let ranges: Vec<[f64; 2]> = ranges.filter(|[low, high]| low < high).collect();
        if !ranges.is_empty() {
            let own = body.fractures.faces.iter();
            let own = own.filter(|f| usize::from(f.fracture) == fracture);
            let faces = own.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], face| {
                [low.min(face.center[2]), high.max(face.center[2])]
            });
            let mut ranges = ranges.into_iter();
            if let Some(levels) = ranges.find(|[low, high]| *high < faces[0] || faces[1] < *low) {
                remarks.push(Remark::Beside {
                    fracture: name(),
                    faces,
                    levels,
                });
            }
        }
        let weakening = |f: Friction| Some((f, f.weakening?));
        let levels = profile.iter().flat_map(Profile::values);
        let levels: Vec<(Friction, Weakening)> = levels.filter_map(weakening).collect();
        let strengthens = levels.iter().find(|(f, w)| w.angle > f.angle);
        if let Some((friction, weakening)) = strengthens {
            remarks.push(Remark::Strengthens {
                fracture: name(),
                static_deg: friction.angle.to_degrees(),
                dynamic_deg: weakening.angle.to_degrees(),
            });
            continue;
        }
        // the face that is largest beside its nucleation length, softer side
        let mut worst: Option<(f64, f64)> = None;
        let faces = body.fractures.faces.iter().zip(tractions.chunks_exact(3));
        for (face, t) in faces.filter(|(f, _)| usize::from(f.fracture) == fracture) {
            let Some((friction, weakening)) = body.friction_of(face).and_then(weakening) else {
                break;
            };
            let law = LinearWeakening {
                static_friction: friction.angle.tan(),
                dynamic_friction: weakening.angle.tan(),
                critical_slip: weakening.distance,
                normal_traction: t[0].min(0.0),
            };
            let rock = |element: u32| {
                let region = usize::from(body.mesh.regions[element as usize]);
                let material = &body.materials[region];
                Rock {
                    young: material.young,
                    poisson: material.poisson,
                }
            };
            let sides = [face.minus.element, face.plus.element];
            let length = sides
                .map(|e| law.nucleation_half_length(rock(e)))
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            let size = face.area.sqrt();
            if worst.is_none_or(|(s, l)| size * l > s * length) {
                worst = Some((size, length));
            }
        }
        if let Some((size, length)) = worst.filter(|(size, length)| *size > RESOLVED * length) {
            remarks.push(Remark::Coarse {
                fracture: name(),
                size,
                length,
            });
        }
    }
    remarks
}
