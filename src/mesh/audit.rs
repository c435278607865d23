//! What came out: counts, bodies, quality, rank.

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::EDGES;
use super::error::point;
use super::face_geometry::{dot, minus};
use super::jacobian::corners;
use super::kernel::CouplingKernel;
use super::{
    BodyPart, FractureMesh, HexMesh, Hold, bodies, coupling_kernel, kernel_report, min_jacobian,
};

/// Counts of one fracture.
#[derive(Clone, Debug, PartialEq)]
pub struct FractureCounts {
    /// Its name.
    pub name: String,
    /// Faces.
    pub faces: usize,
    /// Area [m²].
    pub area: f64,
    /// Nodes that stay single: its tips.
    pub tip_nodes: usize,
    /// Edges that it shares with other fractures.
    pub junction_edges: usize,
}

/// Everything worth knowing before a solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Audit {
    /// Elements.
    pub elements: usize,
    /// Nodes after splitting.
    pub nodes: usize,
    /// Copies that splitting made.
    pub copies: usize,
    /// Free displacements: n_u.
    pub n_u: usize,
    /// Tractions: n_t.
    pub n_t: usize,
    /// Counts per fracture.
    pub fractures: Vec<FractureCounts>,
    /// Connected bodies.
    pub bodies: Vec<BodyPart>,
    /// Smallest det J over corners and Gauss points [m³].
    pub min_jacobian: f64,
    /// Largest ratio of the longest to the shortest edge of an element.
    pub aspect_ratio: f64,
    /// Tractions without effect.
    pub kernel: CouplingKernel,
    /// Memory of the assembled system without factors: 81 entries per row of A and 8 columns of B per traction, 12 bytes
    /// each.
    pub memory_bytes: u64,
}

/// Audits a mesh; `prescribed[3·node + component]` marks the displacements that are given.
///
/// # Cost
/// O(elements), plus dense ranks for small fractures.
pub fn audit(mesh: &HexMesh, fractures: &FractureMesh, prescribed: &[bool]) -> Audit {
    let n_u = prescribed.iter().filter(|p| !**p).count();
    let n_t = 3 * fractures.faces.len();
    let mut quality = (f64::INFINITY, 1.0f64);
    for e in 0..mesh.elements.len() {
        let x = corners(mesh, e);
        quality.0 = quality.0.min(min_jacobian(&x));
        quality.1 = quality.1.max(aspect(&x));
    }
    Audit {
        elements: mesh.elements.len(),
        nodes: mesh.nodes.len(),
        copies: mesh
            .origin
            .iter()
            .enumerate()
            .filter(|(a, o)| *a as u32 != **o)
            .count(),
        n_u,
        n_t,
        fractures: fracture_counts(mesh, fractures),
        bodies: bodies(mesh, fractures, prescribed),
        min_jacobian: quality.0,
        aspect_ratio: quality.1,
        kernel: coupling_kernel(mesh, fractures, prescribed),
        memory_bytes: 12 * (81 * n_u as u64 + 24 * n_t as u64),
    }
}

/// Longest over shortest of the twelve edges.
fn aspect(x: &[[f64; 3]; 8]) -> f64 {
    let (mut short, mut long) = (f64::INFINITY, 0.0f64);
    for [a, b] in EDGES {
        let edge = minus(x[a], x[b]);
        let length = dot(edge, edge).sqrt();
        short = short.min(length);
        long = long.max(length);
    }
    long / short
}

fn fracture_counts(mesh: &HexMesh, fractures: &FractureMesh) -> Vec<FractureCounts> {
    let mut tips: Vec<HashSet<u32>> = vec![HashSet::new(); fractures.names.len()];
    let mut users: HashMap<[u32; 2], Vec<u16>> = HashMap::new();
    let mut counts: Vec<FractureCounts> = fractures
        .names
        .iter()
        .map(|name| FractureCounts {
            name: name.clone(),
            faces: 0,
            area: 0.0,
            tip_nodes: 0,
            junction_edges: 0,
        })
        .collect();
    for face in &fractures.faces {
        let f = usize::from(face.fracture);
        counts[f].faces += 1;
        counts[f].area += face.area;
        for a in 0..4 {
            let (m, p) = (face.minus.nodes[a], face.plus.nodes[a]);
            if m == p {
                tips[f].insert(m);
            }
            let ends = [a, (a + 1) % 4].map(|a| mesh.origin[face.minus.nodes[a] as usize]);
            let key = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            users.entry(key).or_default().push(face.fracture);
        }
    }
    for list in users.values_mut() {
        list.sort_unstable();
        list.dedup();
        if list.len() > 1 {
            for f in list {
                counts[usize::from(*f)].junction_edges += 1;
            }
        }
    }
    for (count, tips) in counts.iter_mut().zip(tips) {
        count.tip_nodes = tips.len();
    }
    counts
}

impl Audit {
    /// Whether A is regular: every body is held by its own boundary.
    pub fn a_is_regular(&self) -> bool {
        self.bodies.iter().all(|b| b.hold == Hold::Boundary)
    }

    /// Rigid motions that A leaves free, summed over bodies: dim ker A.
    pub fn kernel_of_a(&self) -> usize {
        self.bodies.iter().map(|b| 6 - b.boundary_rank).sum()
    }
}

/// Findings printed of each sort before "… and n more".
const SHOWN: usize = 5;

impl fmt::Display for Audit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "mesh        {} elements, {} nodes ({} copies on fractures)",
            self.elements, self.nodes, self.copies
        )?;
        writeln!(
            f,
            "unknowns    n_u = {}, n_t = {} ({:.1} % of n_u), about {:.1} MB assembled",
            self.n_u,
            self.n_t,
            100.0 * self.n_t as f64 / self.n_u.max(1) as f64,
            self.memory_bytes as f64 * 1e-6
        )?;
        writeln!(
            f,
            "quality     min det J = {:.3e} m^3, largest edge ratio {:.1}",
            self.min_jacobian, self.aspect_ratio
        )?;
        for c in self.fractures.iter().take(SHOWN) {
            writeln!(
                f,
                "fracture    \"{}\": {} faces, {:.6} m^2, {} tip nodes, {} junction edges",
                c.name, c.faces, c.area, c.tip_nodes, c.junction_edges
            )?;
        }
        more(f, "fractures", self.fractures.len())?;
        for (i, b) in self.bodies.iter().enumerate().take(SHOWN) {
            let hold = match b.hold {
                Hold::Boundary => "held by its boundary".to_string(),
                Hold::Fractures => format!(
                    "held only by fractures (its boundary stops {} of 6 rigid motions): A is singular",
                    b.boundary_rank
                ),
                Hold::Nothing { free: 1 } => "not held: 1 rigid motion is free".to_owned(),
                Hold::Nothing { free } => format!("not held: {free} rigid motions are free"),
            };
            writeln!(
                f,
                "body {i:<6} {} elements around {}: {hold}",
                b.elements,
                point(&b.center)
            )?;
        }
        more(f, "bodies", self.bodies.len())?;
        let names: Vec<&str> = self.fractures.iter().map(|c| c.name.as_str()).collect();
        kernel_report::write(f, &self.kernel, &names, SHOWN)
    }
}

/// The line that stands for what is not shown.
fn more(f: &mut fmt::Formatter<'_>, what: &str, count: usize) -> fmt::Result {
    match count > SHOWN {
        true => writeln!(f, "            … and {} more {what}", count - SHOWN),
        false => Ok(()),
    }
}
