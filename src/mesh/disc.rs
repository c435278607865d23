//! A map that turns squares into circles, for fractures that are discs.

use super::{MeshError, Warp, WarpContext};

/// The square `|p| ≤ R`, `|q| ≤ R` around a point of the plane across `axis` becomes the disc of radius R; all layers
/// along `axis` move alike.
/// ```text
/// x ← x (1 − w + w m/r)      x = (p, q), m = max(|p|, |q|), r = |x|
/// w = m/R for m ≤ R,  (M − m)/(M − R) for R ≤ m ≤ M,  0 beyond
/// ```
/// The square of half-width m becomes a mean of itself and its inscribed circle, wholly the circle at m = R; M is the
/// distance of the nearest side of the box, not counting sides through the point itself, so that a quarter of a disc
/// stays between its planes of symmetry. The corners of the square become flat angles of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Axis of the disc (0–2).
    pub axis: usize,
    /// R [m].
    pub radius: f64,
    /// A point on the axis [m].
    pub center: [f64; 3],
}

impl Disc {
    /// M: distance of the nearest side across the axis that does not pass through the center [m].
    fn reach(&self, lines: &[Vec<f64>; 3]) -> Result<f64, MeshError> {
        let mut reach = f64::INFINITY;
        for d in (0..3).filter(|d| *d != self.axis) {
            let (from, to) = (lines[d][0], lines[d][lines[d].len() - 1]);
            let at = self.center[d];
            if !(from..=to).contains(&at) {
                return Err(self.bad("center", at, "inside the box or on its side"));
            }
            for distance in [at - from, to - at] {
                if distance > 0.0 {
                    reach = reach.min(distance);
                }
            }
        }
        match reach > self.radius {
            true => Ok(reach),
            false => Err(self.bad(
                "radius",
                self.radius,
                "smaller than the distance to the sides",
            )),
        }
    }

    fn bad(&self, parameter: &'static str, value: f64, requirement: &'static str) -> MeshError {
        MeshError::BadWarp {
            map: "disc",
            parameter,
            value,
            requirement,
        }
    }
}

impl Warp for Disc {
    fn advice(&self) -> &'static str {
        "lower the radius of `disc`, widen the box, or use cells of similar size in both directions"
    }

    fn apply(&self, nodes: &mut [[f64; 3]], context: &WarpContext) -> Result<(), MeshError> {
        if !(self.radius > 0.0 && self.radius.is_finite()) {
            return Err(self.bad("radius", self.radius, "positive"));
        }
        let outer = self.reach(context.lines)?;
        let (p, q) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        for x in nodes {
            let (dp, dq) = (x[p] - self.center[p], x[q] - self.center[q]);
            let m = dp.abs().max(dq.abs());
            if m == 0.0 || m >= outer {
                continue;
            }
            let weight = match m <= self.radius {
                true => m / self.radius,
                false => (outer - m) / (outer - self.radius),
            };
            let factor = 1.0 - weight + weight * m / dp.hypot(dq);
            x[p] = self.center[p] + factor * dp;
            x[q] = self.center[q] + factor * dq;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Axis, BoxGrid, BuiltMesh, PlaneFracture, SizeField, min_jacobian};

    /// A disc of radius 1 in the middle of a box, n cells per radius near the rim.
    fn whole(n: usize) -> BuiltMesh {
        let across = Axis::Sized(SizeField {
            from: -4.0,
            to: 4.0,
            zones: vec![[-1.0, 1.0]],
            size: 1.0 / n as f64,
            growth: 1.3,
            through: Vec::new(),
            largest: f64::INFINITY,
        });
        let along = Axis::uniform(-2.0, 2.0, 4);
        let mut grid = BoxGrid::new([across.clone(), across, along]);
        let mut fracture = PlaneFracture::through("penny", 2, 0.0);
        fracture.spans = [Some([-1.0, 1.0]), Some([-1.0, 1.0]), None];
        grid.fractures.push(fracture);
        grid.warps.push(Box::new(Disc {
            axis: 2,
            radius: 1.0,
            center: [0.0; 3],
        }));
        grid.build().unwrap()
    }

    fn area(built: &BuiltMesh) -> f64 {
        built.fractures.faces.iter().map(|f| f.area).sum()
    }

    #[test]
    fn volumes_stay_positive_and_fill_the_box() {
        for n in [1, 3, 8, 20] {
            let built = whole(n);
            let mesh = &built.mesh;
            let smallest = mesh
                .elements
                .iter()
                .map(|e| min_jacobian(&e.map(|a| mesh.nodes[a as usize])))
                .fold(f64::INFINITY, f64::min);
            assert!(smallest > 0.0, "{n}: {smallest:e}");
            let total: f64 = (0..mesh.elements.len()).map(|e| built.volume(e)).sum();
            approx::assert_relative_eq!(total, 8.0 * 8.0 * 4.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn the_rim_is_a_circle_and_the_area_that_of_the_disc() {
        let mut errors = Vec::new();
        for n in [4, 8, 16] {
            let built = whole(n);
            // corners of faces that only one face has
            let faces = &built.fractures.faces;
            let mut farthest: f64 = 0.0;
            for face in faces {
                for node in face.minus.nodes {
                    let [x, y, z] = built.mesh.nodes[node as usize];
                    assert_eq!(z, 0.0);
                    farthest = farthest.max(x.hypot(y));
                }
            }
            approx::assert_relative_eq!(farthest, 1.0, max_relative = 1e-14);
            let tips = built
                .mesh
                .nodes
                .iter()
                .filter(|x| x[2] == 0.0 && (x[0].hypot(x[1]) - 1.0).abs() < 1e-12)
                .count();
            let side = faces.len().isqrt();
            assert_eq!(tips, 4 * side);
            errors.push(1.0 - area(&built) / std::f64::consts::PI);
        }
        // a polygon inside the circle: second order
        assert!(errors[2] > 0.0 && errors[2] < 0.4 * errors[1] && errors[1] < 0.4 * errors[0]);
    }

    #[test]
    fn a_quarter_between_its_planes_of_symmetry_is_a_quarter_of_the_whole() {
        let across = Axis::Sized(SizeField {
            from: 0.0,
            to: 4.0,
            zones: vec![[1.0, 1.0]],
            size: 1.0 / 6.0,
            growth: 1.3,
            through: Vec::new(),
            largest: f64::INFINITY,
        });
        let mut grid = BoxGrid::new([across.clone(), across, Axis::uniform(-2.0, 2.0, 4)]);
        let mut fracture = PlaneFracture::through("penny", 2, 0.0);
        fracture.spans = [Some([0.0, 1.0]), Some([0.0, 1.0]), None];
        grid.fractures.push(fracture);
        grid.warps.push(Box::new(Disc {
            axis: 2,
            radius: 1.0,
            center: [0.0; 3],
        }));
        let built = grid.build().unwrap();
        for side in [0, 2] {
            for node in built.sides[side].iter().flat_map(|f| f.nodes) {
                assert_eq!(built.mesh.nodes[node as usize][side / 2], 0.0);
            }
        }
        for side in [1, 3] {
            for node in built.sides[side].iter().flat_map(|f| f.nodes) {
                assert_eq!(built.mesh.nodes[node as usize][side / 2], 4.0);
            }
        }
        let quarter = std::f64::consts::FRAC_PI_4;
        approx::assert_relative_eq!(area(&built), quarter, max_relative = 2e-2);
    }

    #[test]
    fn a_disc_that_does_not_fit_is_refused() {
        let refused = |radius: f64, center: [f64; 3]| {
            let mut grid = BoxGrid::uniform([0.0; 3], [4.0, 4.0, 2.0], [8, 8, 2]);
            grid.warps.push(Box::new(Disc {
                axis: 2,
                radius,
                center,
            }));
            grid.build().unwrap_err().to_string()
        };
        assert!(refused(2.0, [2.0, 2.0, 0.0]).contains("smaller than the distance"));
        assert!(refused(-1.0, [2.0, 2.0, 0.0]).contains("positive"));
        assert!(refused(1.0, [5.0, 2.0, 0.0]).contains("inside the box"));
    }
}
