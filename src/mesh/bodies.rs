//! Connected bodies after splitting, and what holds them.

use super::face_geometry::minus;
use super::jacobian::{center, corners, volume};
use super::loose::{Block, Cluster, add_product};
use super::rank::gram_rank;
use super::{FractureMesh, HexMesh};

/// What keeps a body from moving rigidly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// Its own prescribed displacements.
    Boundary,
    /// Closed fractures to bodies that are held: K is regular, but A alone is singular.
    Fractures,
    /// Nothing: with every fracture closed, it and the bodies joined to it still have `free` rigid motions.
    Nothing {
        /// Their number.
        free: usize,
    },
}

/// A connected component of elements after splitting.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPart {
    /// Elements in it.
    pub elements: usize,
    /// Its lowest element.
    pub first_element: u32,
    /// Nodes in it.
    pub nodes: usize,
    /// Volume [m³].
    pub volume: f64,
    /// Centre of volume [m].
    pub center: [f64; 3],
    /// Rigid motions (of 6) that its prescribed displacements stop.
    pub boundary_rank: usize,
    /// Axes along which no displacement of it is prescribed.
    pub free_axes: [bool; 3],
    /// What holds it.
    pub hold: Hold,
}

/// Pivots below this share of the largest one count as zero: (1e-5)², so a body held over a hundred-thousandth of its
/// size counts as held.
const RANK_TOLERANCE: f64 = 1e-10;

/// Rigid motions of a body.
pub(super) const MODES: usize = 6;

/// Rigid motions of a body: the displacement of a point is Σ_m c_m φ_m, three translations and three rotations about
/// the centre, divided by the size so that all are of order one.
#[derive(Clone, Copy)]
struct Modes {
    center: [f64; 3],
    size: f64,
}

impl Modes {
    /// Values of the six motions at `x` in component `d`.
    fn row(&self, x: [f64; 3], d: usize) -> [f64; MODES] {
        let r = minus(x, self.center).map(|v| v / self.size);
        let mut row = [0.0; MODES];
        row[d] = 1.0;
        // e_m × r
        let (p, q) = ((d + 1) % 3, (d + 2) % 3);
        row[3 + p] = r[q];
        row[3 + q] = -r[p];
        row
    }
}

/// Components of elements that share nodes: a body number per element, numbered by lowest element.
pub(super) fn body_of_elements(mesh: &HexMesh) -> (Vec<u32>, usize) {
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut parent: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    for element in &mesh.elements {
        let a = root(&mut parent, element[0]);
        for node in &element[1..] {
            let b = root(&mut parent, *node);
            parent[b as usize] = a;
        }
    }
    let mut number = vec![u32::MAX; mesh.nodes.len()];
    let mut count = 0;
    let body = mesh
        .elements
        .iter()
        .map(|element| {
            let r = root(&mut parent, element[0]) as usize;
            if number[r] == u32::MAX {
                number[r] = count;
                count += 1;
            }
            number[r]
        })
        .collect();
    (body, count as usize)
}

/// Bodies in order of their lowest element; `prescribed[3·node + component]` marks the displacements that are given.
///
/// A body is held by its boundary if its prescribed displacements stop all six rigid motions, and by fractures if the
/// area-weighted jumps over closed fractures (what Bᵀ sees) do so together with those of the bodies it touches.
pub fn bodies(mesh: &HexMesh, fractures: &FractureMesh, prescribed: &[bool]) -> Vec<BodyPart> {
    assert_eq!(
        prescribed.len(),
        3 * mesh.nodes.len(),
        "bodies: one mark per displacement"
    );
    let (body_of, count) = body_of_elements(mesh);
    let mut parts: Vec<BodyPart> = Vec::with_capacity(count);
    for (e, b) in body_of.iter().enumerate() {
        if parts.len() == *b as usize {
            parts.push(BodyPart {
                elements: 0,
                first_element: e as u32,
                nodes: 0,
                volume: 0.0,
                center: [0.0; 3],
                boundary_rank: 0,
                free_axes: [true; 3],
                hold: Hold::Nothing { free: 6 },
            });
        }
        let x = corners(mesh, e);
        let (v, c, part) = (volume(&x), center(&x), &mut parts[*b as usize]);
        part.elements += 1;
        part.volume += v;
        for d in 0..3 {
            part.center[d] += v * c[d];
        }
    }
    for part in &mut parts {
        part.center = part.center.map(|m| m / part.volume);
    }
    let modes: Vec<Modes> = parts
        .iter()
        .map(|p| Modes {
            center: p.center,
            size: p.volume.cbrt(),
        })
        .collect();

    let mut grams = vec![[0.0; 36]; count];
    let mut seen = vec![false; mesh.nodes.len()];
    for (e, element) in mesh.elements.iter().enumerate() {
        let b = body_of[e] as usize;
        for node in element.map(|n| n as usize) {
            if std::mem::replace(&mut seen[node], true) {
                continue;
            }
            parts[b].nodes += 1;
            for d in (0..3).filter(|d| prescribed[3 * node + d]) {
                parts[b].free_axes[d] = false;
                let row = modes[b].row(mesh.nodes[node], d);
                add_product(&mut grams[b], 1.0, &row, &row);
            }
        }
    }
    for (part, gram) in parts.iter_mut().zip(&grams) {
        part.boundary_rank = gram_rank(&mut gram.clone(), 6, RANK_TOLERANCE);
        if part.boundary_rank == 6 {
            part.hold = Hold::Boundary;
        }
    }

    let joints: Vec<Joint> = fractures
        .faces
        .iter()
        .map(|f| Joint {
            bodies: [
                body_of[f.minus.element as usize],
                body_of[f.plus.element as usize],
            ],
            at: f.center,
        })
        .filter(|j| j.bodies[0] != j.bodies[1])
        .collect();
    hold_by_fractures(&mut parts, &mut grams, &modes, &joints);
    parts
}

/// A fracture face between two bodies: stops their relative motion at its centre in the mean.
struct Joint {
    bodies: [u32; 2],
    at: [f64; 3],
}

/// First absorbs bodies one by one into what is held; then looks at clusters that only hold each other up.
fn hold_by_fractures(
    parts: &mut [BodyPart],
    grams: &mut [Block],
    modes: &[Modes],
    joints: &[Joint],
) {
    let mut at_body: Vec<Vec<u32>> = vec![Vec::new(); parts.len()];
    for (j, joint) in joints.iter().enumerate() {
        for b in joint.bodies {
            at_body[b as usize].push(j as u32);
        }
    }
    let other = |joint: &Joint, b: usize| match joint.bodies[0] as usize == b {
        true => joint.bodies[1] as usize,
        false => joint.bodies[0] as usize,
    };
    let loose = |part: &BodyPart| matches!(part.hold, Hold::Nothing { .. });

    let mut queue: Vec<usize> = (0..parts.len()).filter(|b| !loose(&parts[*b])).collect();
    while let Some(b) = queue.pop() {
        let mut touched: Vec<usize> = Vec::new();
        for joint in at_body[b].iter().map(|j| &joints[*j as usize]) {
            let c = other(joint, b);
            if loose(&parts[c]) {
                for d in 0..3 {
                    let row = modes[c].row(joint.at, d);
                    add_product(&mut grams[c], 1.0, &row, &row);
                }
                touched.push(c);
            }
        }
        touched.sort_unstable();
        touched.dedup();
        for c in touched {
            if gram_rank(&mut grams[c].clone(), 6, RANK_TOLERANCE) == 6 {
                parts[c].hold = Hold::Fractures;
                queue.push(c);
            }
        }
    }

    // clusters of bodies that are still loose, joined by fractures
    let mut local = vec![usize::MAX; parts.len()];
    for start in 0..parts.len() {
        if !loose(&parts[start]) || local[start] != usize::MAX {
            continue;
        }
        let mut cluster = vec![start];
        local[start] = 0;
        let mut next = 0;
        while next < cluster.len() {
            let b = cluster[next];
            next += 1;
            for joint in at_body[b].iter().map(|j| &joints[*j as usize]) {
                let c = other(joint, b);
                if loose(&parts[c]) && local[c] == usize::MAX {
                    local[c] = cluster.len();
                    cluster.push(c);
                }
            }
        }
        let mut gram = Cluster::new(cluster.iter().map(|b| grams[*b]).collect());
        for (l, b) in cluster.iter().enumerate() {
            // each joint once, from its − side; joints to held bodies are in `grams` already
            for joint in at_body[*b].iter().map(|j| &joints[*j as usize]) {
                let c = other(joint, *b);
                if joint.bodies[0] as usize != *b || !loose(&parts[c]) {
                    continue;
                }
                for d in 0..3 {
                    let (v, w) = (modes[*b].row(joint.at, d), modes[c].row(joint.at, d));
                    gram.join([l, local[c]], &v, &w);
                }
            }
        }
        let free = gram.free_motions(RANK_TOLERANCE);
        for b in cluster {
            parts[b].hold = match free {
                0 => Hold::Fractures,
                _ => Hold::Nothing { free },
            };
        }
    }
}
