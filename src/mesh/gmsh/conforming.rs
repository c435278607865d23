//! Elements that touch without sharing a face.

use super::GmshDefect;
use super::boxes::{Boxes, around};
use super::faces::{Faces, corners};
use super::file::Cell;
use crate::mesh::face_geometry::{cross, dot, minus};
use crate::mesh::jacobian::{CORNERS, volume};
use rayon::prelude::*;

/// Reference coordinates on a face where it looks for what lies behind: 3 × 3 points, so that faces that overlap by a
/// twentieth of their width meet.
const PROBES: [f64; 3] = [-0.9, 0.0, 0.9];

/// How far behind a face it looks, as a share of its element's volume over the area of the face.
const BEHIND: f64 = 1e-3;

/// Reference coordinates inside an element are at most this.
const INSIDE: f64 = 1.0 + 1e-6;

/// x(ξ) and ∂x/∂ξ of a trilinear element.
fn map(x: &[[f64; 3]; 8], at: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let (mut position, mut columns) = ([0.0; 3], [[0.0; 3]; 3]);
    for a in 0..8 {
        let c = CORNERS[a];
        let f = [0, 1, 2].map(|d: usize| 1.0 + c[d] * at[d]);
        for d in 0..3 {
            position[d] += 0.125 * f[0] * f[1] * f[2] * x[a][d];
            columns[0][d] += 0.125 * c[0] * f[1] * f[2] * x[a][d];
            columns[1][d] += 0.125 * c[1] * f[0] * f[2] * x[a][d];
            columns[2][d] += 0.125 * c[2] * f[0] * f[1] * x[a][d];
        }
    }
    (position, columns)
}

/// A step this long leaves the element for good.
const FAR: f64 = 1e3;

/// Newton steps for ξ; quadratic once near.
const STEPS: usize = 20;

/// Whether a point lies in an element: x(ξ) = p with |ξ_d| ≤ 1.
fn holds(x: &[[f64; 3]; 8], p: [f64; 3]) -> bool {
    let mut at = [0.0f64; 3];
    for _ in 0..STEPS {
        let (position, [a, b, c]) = map(x, at);
        let r = minus(p, position);
        let det = dot(a, cross(b, c));
        // Cramer's rule
        let step = [
            dot(r, cross(b, c)) / det,
            dot(a, cross(r, c)) / det,
            dot(a, cross(b, r)) / det,
        ];
        at = [0, 1, 2].map(|d: usize| at[d] + step[d]);
        let size = step.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        if size < 1e-10 {
            return at.iter().all(|s| s.abs() <= INSIDE);
        }
        if size > FAR {
            return false;
        }
    }
    false
}

/// Point of a quadrilateral and its area vector there: ∂x/∂ξ × ∂x/∂η.
fn on_face(x: &[[f64; 3]; 4], xi: f64, eta: f64) -> ([f64; 3], [f64; 3]) {
    let shape = [
        0.25 * (1.0 - xi) * (1.0 - eta),
        0.25 * (1.0 + xi) * (1.0 - eta),
        0.25 * (1.0 + xi) * (1.0 + eta),
        0.25 * (1.0 - xi) * (1.0 + eta),
    ];
    let along = |weights: [f64; 4]| {
        [0, 1, 2].map(|d: usize| (0..4).map(|a| weights[a] * x[a][d]).sum::<f64>())
    };
    let d_xi = [eta - 1.0, 1.0 - eta, 1.0 + eta, -1.0 - eta].map(|w| 0.25 * w);
    let d_eta = [xi - 1.0, -1.0 - xi, 1.0 + xi, 1.0 - xi].map(|w| 0.25 * w);
    (along(shape), cross(along(d_xi), along(d_eta)))
}

/// No face of the surface has another hexahedron right behind it.
///
/// # Cost
/// O(n log n) for n faces of the surface.
///
/// # Errors
/// [`GmshDefect::NotConforming`] for the first such face.
pub(super) fn require_conforming(
    cells: &[Cell<8>],
    nodes: &[[f64; 3]],
    faces: &Faces,
) -> Result<(), GmshDefect> {
    let place = |n: u32| nodes[n as usize];
    let boundary = faces.boundary();
    let mut owners: Vec<u32> = boundary.iter().map(|face| face.1).collect();
    owners.dedup();
    let corners_of = |e: u32| cells[e as usize].nodes.map(place);
    let tree = Boxes::new(
        owners
            .par_iter()
            .map(|e| around(corners_of(*e).iter()))
            .collect(),
    );
    let found = boundary.par_iter().find_map_first(|face| {
        let quad = corners(cells, face).map(place);
        // 4 ‖∂x/∂ξ × ∂x/∂η‖ at the centre is the area of a parallelogram
        let (_, normal) = on_face(&quad, 0.0, 0.0);
        let area = 4.0 * dot(normal, normal).sqrt();
        let depth = BEHIND * volume(&corners_of(face.1)) / area;
        let mut probes = PROBES.iter().flat_map(|xi| PROBES.map(|eta| (*xi, eta)));
        probes.find_map(|(xi, eta)| {
            let (on, normal) = on_face(&quad, xi, eta);
            let length = dot(normal, normal).sqrt();
            let behind = [0, 1, 2].map(|d: usize| on[d] + depth * normal[d] / length);
            let is_other = |b: u32| {
                let other = owners[b as usize];
                other != face.1 && holds(&corners_of(other), behind)
            };
            let other = owners[tree.find(&behind, is_other)? as usize];
            Some(GmshDefect::NotConforming {
                element: cells[face.1 as usize].id,
                other: cells[other as usize].id,
                at: on,
            })
        })
    });
    match found {
        Some(defect) => Err(defect),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_distorted_element_are_inside_and_no_others() {
        let mut x = CORNERS.map(|c| [3.0 + 5.0 * c[0], 0.1 * c[1], 2.0 * c[2]]);
        for (a, p) in x.iter_mut().enumerate() {
            p[0] += 0.4 * (a as f64).sin();
            p[1] += 0.02 * (2.0 * a as f64).cos();
            p[2] += 0.3 * (3.0 * a as f64).sin();
        }
        for i in 0..=10 {
            for j in 0..=10 {
                for k in 0..=10 {
                    let at = [i, j, k].map(|c| 0.25 * f64::from(c) - 1.25);
                    let inside = at.iter().all(|s| s.abs() <= 1.0);
                    assert_eq!(holds(&x, map(&x, at).0), inside, "{at:?}");
                }
            }
        }
    }
}
