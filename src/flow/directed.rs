//! Fractures that let more through in one direction than across it.

use super::vertex::flat;
use crate::mesh::{FractureFace, HexMesh};

/// A conductivity of the closed fracture that depends on the direction in its plane, e ⟂ d:
/// ```text
/// K_0 = C_f0 K̂      K̂ = √r d dᵀ + e eᵀ/√r      q = −(K_0 + max(g_N, 0)³/12)/μ ∇p
/// ```
/// so that C_f0 is the geometric mean of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directed {
    /// Its part in the plane of a face has the direction d. Unit: 1.
    pub along: [f64; 3],
    /// r, the conductivity along d over that along e. Unit: 1.
    pub ratio: f64,
}

impl Directed {
    /// Sine of the angle between the given direction and the normal of a face, 0 where the face has no direction d. Unit: 1.
    pub fn lies_in(self, face: &FractureFace) -> f64 {
        let [s, t] = self.in_plane(face);
        let length = self.along.iter().map(|a| a * a).sum::<f64>().sqrt();
        s.hypot(t) / length
    }

    fn in_plane(self, face: &FractureFace) -> [f64; 2] {
        let [_, t1, t2] = face.frame;
        [t1, t2].map(|t| (0..3).map(|i| self.along[i] * t[i]).sum())
    }

    /// Corners of a face, `K̂^{-½} x`, relative to its centre [m]: flow there is flow without a direction, and areas are the same.
    pub(super) fn evened(self, face: &FractureFace, mesh: &HexMesh) -> [[f64; 2]; 4] {
        let [s, t] = self.in_plane(face);
        let d = [s, t].map(|v| v / s.hypot(t));
        let root = self.ratio.sqrt().sqrt();
        flat(face, mesh).map(|[x, y]| [(d[0] * x + d[1] * y) / root, (d[0] * y - d[1] * x) * root])
    }
}
