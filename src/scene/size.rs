//! How large a scene is, before anything is meshed.

use super::geometry::{axis, expand};
use super::mesh_sections::MeshSection;
use super::sections::SceneSections;
use crate::mesh::MAX_NODES;
use std::ops::RangeInclusive;

/// What meshing a scene will make, as its grid lines and the rectangles of its fractures tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneSize {
    /// Nodes before fractures split them.
    pub nodes: u128,
    /// Copies that splitting makes: exact but for the rims of fractures inside the body.
    pub copies: u128,
    /// Fracture faces.
    pub faces: u128,
}

/// Rectangles of one section: equal but for their position.
struct Planes {
    axis: usize,
    /// Grid lines that they lie on, increasing.
    at: Vec<usize>,
    /// Grid lines per axis on which their nodes are split.
    split: [RangeInclusive<usize>; 3],
}

impl Planes {
    /// Planes on the lines of a range.
    fn within(&self, range: &RangeInclusive<usize>) -> u128 {
        let first = self.at.partition_point(|i| i < range.start());
        let last = self.at.partition_point(|i| i <= range.end());
        last.saturating_sub(first) as u128
    }
}

/// Lines of a range.
fn count(range: &RangeInclusive<usize>) -> u128 {
    (range.end() + 1).saturating_sub(*range.start()) as u128
}

/// Lines of two ranges.
fn common(a: &RangeInclusive<usize>, b: &RangeInclusive<usize>) -> RangeInclusive<usize> {
    *a.start().max(b.start())..=*a.end().min(b.end())
}

impl SceneSize {
    /// Of a grid; a fracture or an axis that cannot be made counts 0, which building explains.
    ///
    /// A node on planes across k axes has 2ᵏ copies, itself included: one per plane, pair and triple through it.
    ///
    /// # Cost
    /// O(lines + planes), and O(n²) for n sections, besides those that cross.
    pub(super) fn of_grid(sections: &SceneSections) -> Self {
        let mesh = &sections.mesh;
        let nodes = mesh.nodes();
        let mut size = Self {
            nodes,
            ..Self::default()
        };
        if sections.fracture.is_empty() {
            return size;
        }
        let Some(lines) = mesh_lines(mesh) else {
            return size;
        };
        let mut planes: [Vec<Planes>; 3] = Default::default();
        for (i, fracture) in sections.fracture.iter().enumerate() {
            let expanded = expand(fracture, i, &lines).unwrap_or_default();
            let mut ranges = expanded
                .iter()
                .filter_map(|plane| plane.select(&lines).ok());
            let Some(first) = ranges.next() else {
                continue;
            };
            let d = expanded[0].axis;
            let mut at: Vec<usize> = std::iter::once(first[d].start)
                .chain(ranges.map(|r| r[d].start))
                .collect();
            at.sort_unstable();
            let faces = (0..3).filter(|e| *e != d).map(|e| first[e].len() as u128);
            size.faces += at.len() as u128 * faces.product::<u128>();
            // half of a rim inside the body counts, so that a fracture of one face has a copy
            let split = first.map(|r| r.start + usize::from(r.start > 0)..=r.end);
            planes[d].push(Planes { axis: d, at, split });
        }
        size.copies = copies(&planes);
        size
    }
}

/// Lines of the grid along x, y, z [m]; none where it cannot be made, which [`Scene::build`](super::Scene::build) explains.
pub(super) fn mesh_lines(mesh: &MeshSection) -> Option<[Vec<f64>; 3]> {
    let nodes = mesh.nodes();
    if nodes == 0 || nodes > MAX_NODES {
        return None;
    }
    let of = |section, name, d| axis(section, name).ok()?.lines(d).ok();
    Some([
        of(&mesh.x, "x", 0)?,
        of(&mesh.y, "y", 1)?,
        of(&mesh.z, "z", 2)?,
    ])
}

/// Copies of all nodes on planes.
fn copies([x, y, z]: &[Vec<Planes>; 3]) -> u128 {
    let mut copies = 0;
    for p in x.iter().chain(y).chain(z) {
        let nodes = (0..3).filter(|e| *e != p.axis).map(|e| count(&p.split[e]));
        copies += p.at.len() as u128 * nodes.product::<u128>();
    }
    for (a, b, c) in [(x, y, z), (x, z, y), (y, z, x)] {
        for p in a {
            for q in b {
                let pairs = p.within(&q.split[p.axis]) * q.within(&p.split[q.axis]);
                if pairs == 0 {
                    continue;
                }
                let third = 3 - p.axis - q.axis;
                let line = common(&p.split[third], &q.split[third]);
                copies += pairs * count(&line);
                // every triple once
                if third != 2 {
                    continue;
                }
                for r in c {
                    let [i, j] = [(p, q), (q, p)].map(|(s, other)| {
                        s.within(&common(&r.split[s.axis], &other.split[s.axis]))
                    });
                    copies += i * j * r.within(&line);
                }
            }
        }
    }
    copies
}
