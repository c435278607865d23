//! Shear between planes that lean each by its own angle.

use super::{MeshError, Warp, WarpContext};

/// A plane x_plane = at that leans: x_plane = at + (x_along − level) slope, upright beyond `reach`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaning {
    /// Where it is before [m].
    pub at: f64,
    /// x_along at which it stays there [m].
    pub level: f64,
    /// Tangent of the angle between the plane before and after. Unit: 1.
    pub slope: f64,
    /// Interval of x_along in which it leans [m].
    pub reach: [f64; 2],
}

impl Leaning {
    /// How far it has moved where x_along is z [m].
    pub fn shift(&self, z: f64) -> f64 {
        (z.clamp(self.reach[0], self.reach[1]) - self.level) * self.slope
    }

    /// Where it is where x_along is z [m].
    pub fn position(&self, z: f64) -> f64 {
        self.at + self.shift(z)
    }
}

/// Shear that is linear between planes: each gets its own angle, and the sides of the box stay,
/// ```text
/// x_plane ← x_plane + Σ_i w_i(x_plane) (x_along − level_i) slope_i        w_i: 1 on plane i, 0 on its neighbours, linear between
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Shear {
    /// Normal of the planes (0–2).
    pub plane: usize,
    /// Axis along which they climb (0–2), different from `plane`.
    pub along: usize,
    /// The planes, in order of their positions, which differ.
    pub leaning: Vec<Leaning>,
}

impl Warp for Shear {
    fn advice(&self) -> &'static str {
        "lower the dips, widen the box, or move the planes apart"
    }

    fn apply(&self, nodes: &mut [[f64; 3]], context: &WarpContext) -> Result<(), MeshError> {
        let bad = |parameter, value, requirement| MeshError::BadWarp {
            map: "shear",
            parameter,
            value,
            requirement,
        };
        if self.plane == self.along {
            let requirement = "another axis than the planes' normal";
            return Err(bad("along", self.along as f64, requirement));
        }
        let lines = &context.lines[self.plane];
        let (from, to) = (lines[0], lines[lines.len() - 1]);
        let mut before = from;
        for plane in &self.leaning {
            // from the first side of the box on; NaN is refused, too
            if !(plane.at > before && plane.at < to) {
                return Err(bad("at", plane.at, "inside the box, beyond the one before"));
            }
            // beyond 1e9 a plane is one at infinity
            if plane.slope.is_nan() || plane.slope.abs() > 1e9 {
                return Err(bad("dip", plane.slope, "more than 0 and less than 180 deg"));
            }
            if plane.reach[0].is_nan() || plane.reach[0] > plane.reach[1] {
                return Err(bad("z", plane.reach[0], "an interval, its lower end first"));
            }
            before = plane.at;
        }
        lean(nodes, [self.plane, self.along], [from, to], &self.leaning);
        Ok(())
    }
}

/// Moves nodes with planes; what lies at the `ends` stays, and where these are infinite everything goes along with the nearest plane.
pub(crate) fn lean(
    nodes: &mut [[f64; 3]],
    [plane, along]: [usize; 2],
    ends: [f64; 2],
    leaning: &[Leaning],
) {
    for x in nodes {
        let (s, z) = (x[plane], x[along]);
        for (i, p) in leaning.iter().enumerate() {
            let before = i.checked_sub(1).map_or(ends[0], |j| leaning[j].at);
            let after = leaning.get(i + 1).map_or(ends[1], |q| q.at);
            let weight = match (s < p.at, before.is_finite(), after.is_finite()) {
                (true, true, _) => ((s - before) / (p.at - before)).max(0.0),
                (false, _, true) => ((after - s) / (after - p.at)).max(0.0),
                _ => 1.0,
            };
            x[plane] += weight * p.shift(z);
        }
    }
}
