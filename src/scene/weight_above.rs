//! The weight of the rock above a point, whatever the shapes of elements.

use super::box_tree::{Bounds, BoxTree, NOWHERE, union};
use crate::mesh::{FACES, HexMesh};
use std::collections::HashMap;

/// σ_v = ∫ ρ g dz from a point up. A face with rock of weights w below and w' above it counts (w − w') times its height above the point, and sides
/// that lean count as faces do: exact for trilinear elements, layer by layer, across throws, in columns that lean.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WeightAbove {
    patches: Vec<Patch>,
    tree: BoxTree,
    /// Middle of the body in x and y, and how far a vertical line is moved towards it [m].
    middle: [f64; 2],
    nudge: [f64; 2],
}

/// A bilinear face between rock of two weights, or at the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Patch {
    /// Counter-clockwise seen from outside of an element [m].
    corners: [[f64; 3]; 4],
    /// Force per volume along z in that element, less that beyond the face [N/m³].
    weight: f64,
}

/// Share of the extent of the body by which a vertical line is moved, so that it hits no edge: far more than rounding, and far less than a point
/// inside of an element is away from its sides. Unit: 1.
const NUDGE: f64 = 1e-13;

/// Parts of that along x and y: along no edge.
const ALONG: [f64; 2] = [0.618, 0.382];

/// Node of the body before it was cut.
fn root(mesh: &HexMesh, mut node: u32) -> u32 {
    while mesh.origin[node as usize] != node {
        node = mesh.origin[node as usize];
    }
    node
}

impl WeightAbove {
    /// Of any mesh; `weights` are forces per volume along z, per region [N/m³].
    ///
    /// # Cost
    /// O(elements), and memory of the faces where weights differ.
    pub(super) fn new(mesh: &HexMesh, weights: &[f64]) -> Self {
        // faces of which one side has been met
        let mut open: HashMap<[u32; 4], Patch> = HashMap::new();
        let mut patches = Vec::new();
        for (nodes, region) in mesh.elements.iter().zip(&mesh.regions) {
            let weight = weights[usize::from(*region)];
            for face in FACES {
                let face = face.map(|a| nodes[a]);
                let mut key = face.map(|node| root(mesh, node));
                key.sort_unstable();
                match open.remove(&key) {
                    Some(patch) if patch.weight == weight => {}
                    Some(patch) => patches.push(Patch {
                        weight: patch.weight - weight,
                        ..patch
                    }),
                    None => {
                        let corners = face.map(|node| mesh.nodes[node as usize]);
                        open.insert(key, Patch { corners, weight });
                    }
                }
            }
        }
        let mut surface: Vec<([u32; 4], Patch)> = open.into_iter().collect();
        surface.sort_unstable_by_key(|(key, _)| *key);
        patches.extend(surface.into_iter().map(|(_, patch)| patch));
        // no vertical line crosses a vertical one
        patches.retain(|patch| patch.bends_or_lies());
        let centers: Vec<[f64; 3]> = patches.iter().map(Patch::center).collect();
        let tree = BoxTree::new(&centers, &|p| patches[p as usize].bounds());
        let all = tree.around(0..tree.len()).copied().unwrap_or_default();
        let [low, high] = all;
        Self {
            patches,
            tree,
            middle: [0, 1].map(|d| 0.5 * (low[d] + high[d])),
            nudge: [0, 1].map(|d| NUDGE * ALONG[d] * (high[d] - low[d])),
        }
    }

    /// σ_v at a point, negative below rock [Pa].
    pub(super) fn at(&self, [x, y, z]: [f64; 3]) -> f64 {
        let line = [(0, x), (1, y)].map(|(d, value)| {
            let inwards = if value < self.middle[d] { 1.0 } else { -1.0 };
            value + inwards * self.nudge[d]
        });
        let mut stress = 0.0;
        self.tree.on_line(line, &mut |p| {
            stress += self.patches[p as usize].part(line, z);
        });
        stress
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Area on the plane of x and y over that of a square around it, below which a face is vertical: rounding. Unit: 1.
const VERTICAL: f64 = 1e-14;

impl Patch {
    fn center(&self) -> [f64; 3] {
        // its height does not matter to vertical lines
        let mean = |d: usize| self.corners.iter().map(|c| 0.25 * c[d]).sum();
        [mean(0), mean(1), 0.0]
    }

    fn bounds(&self) -> Bounds {
        let each = self.corners.iter();
        each.fold(NOWHERE, |all, x| union(&all, &[*x, *x]))
    }

    /// `P(u, v) = a + u b + v c + u v d` in x and y.
    fn plan(&self) -> [[f64; 2]; 4] {
        let [p0, p1, p2, p3] = self.corners;
        [
            [p0[0], p0[1]],
            [p1[0] - p0[0], p1[1] - p0[1]],
            [p3[0] - p0[0], p3[1] - p0[1]],
            [0, 1].map(|k: usize| p0[k] - p1[k] + p2[k] - p3[k]),
        ]
    }

    /// False where all of it is vertical.
    fn bends_or_lies(&self) -> bool {
        let [_, b, c, d] = self.plan();
        let largest = [b, c, d]
            .iter()
            .flatten()
            .fold(0.0, |m: f64, v| m.max(v.abs()));
        let turns = [cross(b, c), cross(b, d), cross(c, d)];
        turns
            .iter()
            .any(|turn| turn.abs() > VERTICAL * largest * largest)
    }

    /// Its part of σ_v at height z on a vertical line: `± w (z_P − z)` for every point P above, + where the line leaves the element upwards.
    fn part(&self, line: [f64; 2], z: f64) -> f64 {
        let [a, b, c, d] = self.plan();
        let e = [line[0] - a[0], line[1] - a[1]];
        // e − v c and b + v d are parallel
        let (square, linear, constant) = (-cross(c, d), cross(e, d) - cross(c, b), cross(e, b));
        let discriminant = linear * linear - 4.0 * square * constant;
        if discriminant < 0.0 {
            return 0.0;
        }
        let q = -0.5 * (linear + discriminant.sqrt().copysign(linear));
        let [p0, p1, p2, p3] = self.corners.map(|corner| corner[2]);
        let of = |v: f64| {
            let along = [b[0] + v * d[0], b[1] + v * d[1]];
            let rest = [e[0] - v * c[0], e[1] - v * c[1]];
            let u = (rest[0] * along[0] + rest[1] * along[1])
                / (along[0] * along[0] + along[1] * along[1]);
            let is_inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
            let height = (1.0 - v) * ((1.0 - u) * p0 + u * p1) + v * ((1.0 - u) * p3 + u * p2);
            if !is_inside || height <= z {
                return 0.0;
            }
            let turn = cross(along, [c[0] + u * d[0], c[1] + u * d[1]]);
            turn.signum() * self.weight * (height - z)
        };
        // one of the two is at infinity where opposite sides are parallel
        of(q / square) + of(constant / q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::jacobian::CORNERS;
    use crate::mesh::{BoxGrid, BoxRegion, Distort, PlaneFracture};
    use fracas_operators::random::Random;

    /// A cube of bricks of two weights in turn, moved at random.
    fn mesh(seed: u64, amplitude: f64) -> HexMesh {
        let mut grid = BoxGrid::uniform([0.0; 3], [4.0, 3.0, 5.0], [4, 3, 5]);
        let whole = [f64::NEG_INFINITY, f64::INFINITY];
        grid.regions.push(BoxRegion {
            name: "b".into(),
            boxes: vec![
                [[1.0, 3.0], whole, [1.0, 3.0]],
                [whole, [2.0, 3.0], [4.0, 5.0]],
            ],
        });
        grid.fractures = vec![PlaneFracture::through("f", 0, 2.0)];
        grid.warps = vec![Box::new(Distort {
            amplitude,
            seed,
            smooth: false,
            planar: true,
        })];
        grid.build().unwrap().mesh
    }

    const WEIGHTS: [f64; 2] = [-2.0, -5.0];

    /// Corners of an element, and the point at local coordinates between -1 and 1.
    fn point(mesh: &HexMesh, e: usize, at: [f64; 3]) -> [f64; 3] {
        let shape = |a: usize| {
            (0..3)
                .map(|d| 0.5 * (1.0 + CORNERS[a][d] * at[d]))
                .product::<f64>()
        };
        let nodes = mesh.elements[e].map(|a| mesh.nodes[a as usize]);
        [0, 1, 2].map(|d: usize| (0..8).map(|a| shape(a) * nodes[a][d]).sum())
    }

    #[test]
    fn it_falls_by_the_weight_of_the_element_and_begins_at_the_ground() {
        let dice = &mut Random::new(3);
        for case in 0..40 {
            let mesh = mesh(case, dice.between(0.05, 0.3));
            let above = WeightAbove::new(&mesh, &WEIGHTS);
            for (e, region) in mesh.regions.iter().enumerate() {
                let local = [0, 1, 2].map(|_| dice.between(-0.8, 0.8));
                let [x, y, z] = point(&mesh, e, local);
                let dz = 0.01;
                let slope = (above.at([x, y, z + dz]) - above.at([x, y, z])) / dz;
                let weight = WEIGHTS[usize::from(*region)];
                assert!((slope + weight).abs() < 1e-9, "case {case}, {e}: {slope}");
                if e >= mesh.elements.len() - 12 {
                    let [x, y, z] = point(&mesh, e, [local[0], local[1], 1.0]);
                    let found = above.at([x, y, z - 1e-6]);
                    assert!((found - 1e-6 * weight).abs() < 1e-9, "case {case}: {found}");
                }
            }
        }
    }

    #[test]
    fn on_lines_of_a_grid_the_column_counts_once() {
        let mesh = mesh(1, 0.0);
        let above = WeightAbove::new(&mesh, &[-2.0, -2.0]);
        for x in 0..=4 {
            for y in 0..=3 {
                let found = above.at([f64::from(x), f64::from(y), 1.5]);
                assert!((found + 7.0).abs() < 1e-12, "{x} {y}: {found}");
            }
        }
    }
}
