//! Area, centre and frame of a bilinear quadrilateral.

use super::jacobian::GAUSS;

/// Reference coordinates of the four nodes.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// What a fracture face needs to know of its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceGeometry {
    /// Σ node_areas [m²].
    pub area: f64,
    /// ∫ x dS / area [m].
    pub center: [f64; 3],
    /// Rows (n, t1, t2), right-handed.
    pub frame: [[f64; 3]; 3],
    /// ∫ N_a dS, 2×2 Gauss [m²].
    pub node_areas: [f64; 4],
}

/// a × b.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// a · b.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a − b.
pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a/‖a‖.
pub(crate) fn unit(a: [f64; 3]) -> [f64; 3] {
    let norm = dot(a, a).sqrt();
    a.map(|v| v / norm)
}

/// Frame of a unit normal: t1 is horizontal, along the strike z × n; t2 = n × t1 points up the dip.
///
/// Where n is within 1e-3 rad of the vertical no strike exists, and t1 is the x axis projected onto the face.
fn frame(n: [f64; 3]) -> [[f64; 3]; 3] {
    let strike = [-n[1], n[0], 0.0]; // z × n
    let t1 = match dot(strike, strike).sqrt() > 1e-3 {
        true => unit(strike),
        false => unit([1.0 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2]]),
    };
    [n, t1, cross(n, t1)]
}

/// Calls `visit(x, N, n dS)` at the 2×2 Gauss points of a quadrilateral: place [m], shape functions, area vector with its weight [m²].
pub(crate) fn for_each_point(
    x: &[[f64; 3]; 4],
    mut visit: impl FnMut([f64; 3], [f64; 4], [f64; 3]),
) {
    for q in CORNERS {
        let (xi, eta) = (GAUSS * q[0], GAUSS * q[1]);
        let (mut d_xi, mut d_eta, mut position) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let mut shape = [0.0; 4];
        for a in 0..4 {
            let [s, t] = CORNERS[a];
            shape[a] = 0.25 * (1.0 + s * xi) * (1.0 + t * eta);
            for d in 0..3 {
                d_xi[d] += 0.25 * s * (1.0 + t * eta) * x[a][d];
                d_eta[d] += 0.25 * t * (1.0 + s * xi) * x[a][d];
                position[d] += shape[a] * x[a][d];
            }
        }
        visit(position, shape, cross(d_xi, d_eta));
    }
}

/// Geometry of the quadrilateral whose corners go counter-clockwise around its normal.
///
/// n is the direction of the area vector ∫ ∂x/∂ξ × ∂x/∂η = ½ (x₂ − x₀) × (x₃ − x₁), so it is the area-averaged normal
/// of a face that is not plane; areas are 2×2 Gauss sums of ‖∂x/∂ξ × ∂x/∂η‖.
pub fn face_geometry(x: &[[f64; 3]; 4]) -> FaceGeometry {
    let mut node_areas = [0.0; 4];
    let mut moment = [0.0; 3];
    for_each_point(x, |position, shape, normal| {
        let ds = dot(normal, normal).sqrt();
        for a in 0..4 {
            node_areas[a] += shape[a] * ds;
        }
        for d in 0..3 {
            moment[d] += position[d] * ds;
        }
    });
    let area: f64 = node_areas.iter().sum();
    FaceGeometry {
        area,
        center: moment.map(|m| m / area),
        frame: frame(unit(cross(minus(x[2], x[0]), minus(x[3], x[1])))),
        node_areas,
    }
}

/// Height of the corners of a face over its mean plane that is rounding, relative to its size and its distance from the origin. Unit: 1.
const FLAT: f64 = 1e-12;

impl FaceGeometry {
    /// True where these corners, of which it is the geometry, lie in one plane.
    pub fn is_plane(&self, corners: &[[f64; 3]; 4]) -> bool {
        let height = |x: &[f64; 3]| dot(self.frame[0], minus(*x, self.center));
        let far = corners.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let size = self.area.sqrt().max(far);
        corners.iter().all(|x| height(x).abs() <= FLAT * size)
    }

    /// `∫ N_a (n(x) − n) dS` at these corners, n(x) the normal of every point [m²]; `None` for a plane face.
    pub fn tilts(&self, corners: &[[f64; 3]; 4]) -> Option<[[f64; 3]; 4]> {
        if self.is_plane(corners) {
            return None;
        }
        let n = self.frame[0];
        let mut tilts = self.node_areas.map(|area| n.map(|n| -area * n));
        for_each_point(corners, |_, shape, normal| {
            for (tilt, shape) in tilts.iter_mut().zip(shape) {
                (0..3).for_each(|i| tilt[i] += shape * normal[i]);
            }
        });
        Some(tilts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangle_is_exact() {
        let g = face_geometry(&[
            [1.0, 0.0, 0.0],
            [1.0, 2.0, 0.0],
            [1.0, 2.0, 3.0],
            [1.0, 0.0, 3.0],
        ]);
        approx::assert_relative_eq!(g.area, 6.0, max_relative = 1e-14);
        assert!(g.node_areas.iter().all(|a| (a - 1.5).abs() < 1e-14));
        assert_eq!(g.frame, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        approx::assert_relative_eq!(g.center[2], 1.5, max_relative = 1e-14);
    }

    #[test]
    fn frames_are_right_handed_for_all_normals() {
        for i in 0..50 {
            let (a, b) = (0.7 * f64::from(i), 0.13 * f64::from(i));
            for n in [
                [a.cos() * b.sin(), a.sin() * b.sin(), b.cos()],
                [0.0, 0.0, -1.0],
            ] {
                let [n, t1, t2] = frame(unit(n));
                for (u, v, w) in [(n, t1, t2), (t1, t2, n), (t2, n, t1)] {
                    let c = cross(u, v);
                    assert!((0..3).all(|d| (c[d] - w[d]).abs() < 1e-13));
                }
            }
        }
    }
}
