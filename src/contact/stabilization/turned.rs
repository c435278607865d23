//! Frames of two faces that are not in one plane, turned into one.

use crate::mesh::{FractureFace, cross, dot, unit};

/// Sine of the angle between normals below which two faces are in one plane. Unit: 1.
const LEVEL: f64 = 1e-6;

/// 1 + cosine of that angle below which no turn leads from one normal to the other. Unit: 1.
const OPPOSITE: f64 = 1e-6;

/// The frames (n, t1, t2) of two faces, each turned by the shortest way so that its normal is the one half-way between theirs: a traction
/// along the normal stays one. Frames of faces in one plane are as they were.
pub(super) fn in_one_plane(faces: [&FractureFace; 2]) -> [[[f64; 3]; 3]; 2] {
    let frames = faces.map(|face| face.frame);
    let [n, m] = frames.map(|frame| frame[0]);
    let across = cross(n, m);
    if dot(across, across).sqrt() <= LEVEL || 1.0 + dot(n, m) <= OPPOSITE {
        return frames;
    }
    let middle = unit(std::array::from_fn(|i| n[i] + m[i]));
    frames.map(|frame| frame.map(|e| turned(e, frame[0], middle)))
}

/// `e + v × e + v × (v × e)/(1 + n·m)`, `v = n × m`: e turned as n turns to m.
///
/// # Source
/// O. Rodrigues, J. Math. Pures Appl. 5 (1840) 380–440.
fn turned(e: [f64; 3], n: [f64; 3], m: [f64; 3]) -> [f64; 3] {
    let v = cross(n, m);
    let once = cross(v, e);
    let twice = cross(v, once);
    std::array::from_fn(|i| e[i] + once[i] + twice[i] / (1.0 + dot(n, m)))
}
