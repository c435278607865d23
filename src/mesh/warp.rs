//! Maps that move the nodes of a box grid before its fractures are split.

use super::MeshError;
use super::shear::{Leaning, lean};
use fracas_operators::random::{signed, splitmix64};

/// What a map may need to know of the grid.
#[derive(Clone, Debug)]
pub struct WarpContext<'a> {
    /// Grid lines per axis [m].
    pub lines: &'a [Vec<f64>; 3],
    /// Components per node that must not move if sides are to stay flat: the normals of the sides that it lies on.
    pub on_side: &'a [[bool; 3]],
    /// The same for the fracture planes that it lies on.
    pub on_fracture: &'a [[bool; 3]],
}

impl WarpContext<'_> {
    /// Grid indices (i, j, k) of a node.
    pub fn index(&self, node: usize) -> [usize; 3] {
        let [nx, ny] = [self.lines[0].len(), self.lines[1].len()];
        [node % nx, node / nx % ny, node / (nx * ny)]
    }
}

/// A map x ↦ x′ of node positions.
pub trait Warp: std::fmt::Debug + Send + Sync {
    /// What to change if an element comes out inverted.
    fn advice(&self) -> &'static str;
    /// Moves the nodes.
    ///
    /// # Errors
    /// [`MeshError::BadWarp`] for parameters that make no sense.
    fn apply(&self, nodes: &mut [[f64; 3]], context: &WarpContext) -> Result<(), MeshError>;
}

/// Random or smooth perturbation: x_d ← x_d + amplitude · h_d · r_d, h_d the smaller adjacent cell, r_d ∈ [−1, 1].
///
/// Sides stay flat; the numbers depend on the seed and the node alone, never on order or threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distort {
    /// Fraction of the cell size, 0 ≤ amplitude < 0.5.
    pub amplitude: f64,
    /// Seed of the pattern.
    pub seed: u64,
    /// A sum of three waves across the box instead of independent numbers.
    pub smooth: bool,
    /// Nodes on fractures stay in their planes.
    pub planar: bool,
}

/// Uniform in [−1, 1).
fn noise(seed: u64, a: u64, b: u64) -> f64 {
    signed(splitmix64(splitmix64(seed) ^ a) ^ b)
}

impl Distort {
    /// r_d of a node at relative position `s` ∈ [0, 1]³.
    fn pattern(&self, node: usize, d: usize, s: [f64; 3]) -> f64 {
        if !self.smooth {
            return noise(self.seed, node as u64, d as u64);
        }
        let wave = |m: u64| {
            let phase = |e: u64| std::f64::consts::PI * noise(self.seed, 16 * m + e, d as u64);
            let turns = std::f64::consts::TAU * (m + 1) as f64;
            (0..3).fold(1.0, |p, e| p * (turns * s[e] + phase(e as u64)).sin())
        };
        (wave(0) + wave(1) + wave(2)) / 3.0
    }
}

impl Warp for Distort {
    fn advice(&self) -> &'static str {
        "lower the amplitude of `distort`"
    }

    fn apply(&self, nodes: &mut [[f64; 3]], context: &WarpContext) -> Result<(), MeshError> {
        if !(0.0..0.5).contains(&self.amplitude) {
            return Err(MeshError::BadWarp {
                map: "distort",
                parameter: "amplitude",
                value: self.amplitude,
                requirement: "at least 0 and less than 0.5 (of a cell)",
            });
        }
        for (a, x) in nodes.iter_mut().enumerate() {
            let index = context.index(a);
            let s = [0, 1, 2].map(|d: usize| {
                let lines = &context.lines[d];
                (lines[index[d]] - lines[0]) / (lines[lines.len() - 1] - lines[0])
            });
            for d in 0..3 {
                let held = context.on_side[a][d] || (self.planar && context.on_fracture[a][d]);
                if held {
                    continue;
                }
                let (lines, i) = (&context.lines[d], index[d]);
                let size = (lines[i] - lines[i - 1]).min(lines[i + 1] - lines[i]);
                x[d] += self.amplitude * size * self.pattern(a, d, s);
            }
        }
        Ok(())
    }
}

/// Shear that tilts the planes x_plane = const: x_plane ← x_plane + w (x_along − pivot_along) tan(tilt).
///
/// w = 1 everywhere, or, fading, w falls linearly from 1 on the plane through `pivot` to 0 on both sides of the box:
/// then the sides stay, and every plane still becomes a plane. A plane x = const of dip δ has tilt 90° − δ along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incline {
    /// Normal of the planes (0–2).
    pub plane: usize,
    /// Axis along which they climb (0–2), different from `plane`.
    pub along: usize,
    /// Angle between a plane before and after [rad], between −90° and 90°.
    pub tilt: f64,
    /// A point that stays, on the plane that gets the full tilt [m].
    pub pivot: [f64; 3],
    /// Fade to nothing at the sides.
    pub fade: bool,
}

impl Warp for Incline {
    fn advice(&self) -> &'static str {
        "lower the angle of `incline`, widen the box, or let it not fade"
    }

    fn apply(&self, nodes: &mut [[f64; 3]], context: &WarpContext) -> Result<(), MeshError> {
        let bad = |parameter, value, requirement| MeshError::BadWarp {
            map: "incline",
            parameter,
            value,
            requirement,
        };
        // 1e-9 rad: tan beyond it is a plane at infinity
        if self.tilt.is_nan() || self.tilt.abs() >= std::f64::consts::FRAC_PI_2 - 1e-9 {
            return Err(bad(
                "angle",
                self.tilt.to_degrees(),
                "strictly between -90 and 90 deg of tilt",
            ));
        }
        if self.plane == self.along {
            return Err(bad(
                "along",
                self.along as f64,
                "another axis than the planes' normal",
            ));
        }
        let lines = &context.lines[self.plane];
        let (from, to, at) = (lines[0], lines[lines.len() - 1], self.pivot[self.plane]);
        if self.fade && !(at > from && at < to) {
            return Err(bad("pivot", at, "inside the box if the map fades"));
        }
        let ends = match self.fade {
            false => [f64::NEG_INFINITY, f64::INFINITY],
            true => [from, to],
        };
        let plane = Leaning {
            at,
            level: self.pivot[self.along],
            slope: self.tilt.tan(),
            reach: [f64::NEG_INFINITY, f64::INFINITY],
        };
        lean(nodes, [self.plane, self.along], ends, &[plane]);
        Ok(())
    }
}

/// Rigid rotation about an axis through `center`, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotate {
    /// Axis (0–2).
    pub axis: usize,
    /// Angle [rad].
    pub angle: f64,
    /// A point on the axis [m].
    pub center: [f64; 3],
}

impl Warp for Rotate {
    fn advice(&self) -> &'static str {
        "a rotation inverts nothing; look at the maps before it"
    }

    fn apply(&self, nodes: &mut [[f64; 3]], _: &WarpContext) -> Result<(), MeshError> {
        let (sin, cos) = self.angle.sin_cos();
        let (p, q) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        for x in nodes {
            let (u, v) = (x[p] - self.center[p], x[q] - self.center[q]);
            x[p] = self.center[p] + cos * u - sin * v;
            x[q] = self.center[q] + sin * u + cos * v;
        }
        Ok(())
    }
}
