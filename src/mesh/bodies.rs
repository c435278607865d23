//! Connected bodies after splitting, and what holds them.

use super::jacobian::{brick_size, center, corners, volume};
use super::loose::{Block, Cluster, add_product};
use super::rank::gram_rank;
use super::rigid::{Frame, RANK_TOLERANCE, Stop, Stopped};
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

/// Rigid motions of a body.
pub(super) const MODES: usize = 6;

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
        let v = brick_size(&x).map_or_else(|| volume(&x), |[x, y, z]| x * y * z);
        let (c, part) = (center(&x), &mut parts[*b as usize]);
        part.elements += 1;
        part.volume += v;
        for d in 0..3 {
            part.center[d] += v * c[d];
        }
    }
    for part in &mut parts {
        part.center = part.center.map(|m| m / part.volume);
    }
    let mut held: Vec<(u32, Stop)> = Vec::new();
    let mut boxes = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; count];
    let mut seen = vec![false; mesh.nodes.len()];
    for (e, element) in mesh.elements.iter().enumerate() {
        let b = body_of[e] as usize;
        for node in element.map(|n| n as usize) {
            if std::mem::replace(&mut seen[node], true) {
                continue;
            }
            let x = mesh.nodes[node];
            parts[b].nodes += 1;
            let [low, high] = &mut boxes[b];
            for d in 0..3 {
                (low[d], high[d]) = (low[d].min(x[d]), high[d].max(x[d]));
                if prescribed[3 * node + d] {
                    parts[b].free_axes[d] = false;
                    held.push((b as u32, Stop { x, d }));
                }
            }
        }
    }
    let frames: Vec<Frame> = boxes
        .iter()
        .map(|[low, high]| Frame::of_box(*low, *high))
        .collect();
    let mut grams = vec![[0.0; 36]; count];
    held.sort_by_key(|(b, _)| *b);
    for stops in held.chunk_by(|a, b| a.0 == b.0) {
        let b = stops[0].0 as usize;
        let stopped = Stopped::by(stops.iter().map(|(_, stop)| *stop));
        parts[b].boundary_rank = stopped.rank();
        for row in stopped.rows_in(&frames[b]) {
            add_product(&mut grams[b], 1.0, &row, &row);
        }
        if stopped.rank() == MODES {
            parts[b].hold = Hold::Boundary;
        }
    }
    let joints = joints(fractures, &body_of);
    hold_by_fractures(&mut parts, &mut grams, &frames, &joints);
    parts
}

/// Two bodies, and what all fracture faces between them stop of their relative motion in the mean.
struct Joint {
    bodies: [usize; 2],
    stopped: Stopped,
}

/// The joints of all pairs of bodies.
fn joints(fractures: &FractureMesh, body_of: &[u32]) -> Vec<Joint> {
    let mut faces: Vec<([u32; 2], [f64; 3])> = Vec::new();
    for face in &fractures.faces {
        let [a, b] = [&face.minus, &face.plus].map(|side| body_of[side.element as usize]);
        if a != b {
            faces.push(([a.min(b), a.max(b)], face.center));
        }
    }
    faces.sort_by_key(|(bodies, _)| *bodies);
    let joint = |faces: &[([u32; 2], [f64; 3])]| {
        let stops = faces
            .iter()
            .flat_map(|(_, x)| (0..3).map(|d| Stop { x: *x, d }));
        Joint {
            bodies: faces[0].0.map(|b| b as usize),
            stopped: Stopped::by(stops),
        }
    };
    faces.chunk_by(|a, b| a.0 == b.0).map(joint).collect()
}

/// First absorbs bodies one by one into what is held; then looks at clusters that only hold each other up.
fn hold_by_fractures(
    parts: &mut [BodyPart],
    grams: &mut [Block],
    frames: &[Frame],
    joints: &[Joint],
) {
    let mut at_body: Vec<Vec<u32>> = vec![Vec::new(); parts.len()];
    for (j, joint) in joints.iter().enumerate() {
        for b in joint.bodies {
            at_body[b].push(j as u32);
        }
    }
    let other = |joint: &Joint, b: usize| match joint.bodies[0] == b {
        true => joint.bodies[1],
        false => joint.bodies[0],
    };
    let loose = |part: &BodyPart| matches!(part.hold, Hold::Nothing { .. });

    let mut queue: Vec<usize> = (0..parts.len()).filter(|b| !loose(&parts[*b])).collect();
    while let Some(b) = queue.pop() {
        let mut touched: Vec<usize> = Vec::new();
        for joint in at_body[b].iter().map(|j| &joints[*j as usize]) {
            let c = other(joint, b);
            if loose(&parts[c]) {
                for row in joint.stopped.rows_in(&frames[c]) {
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
            // each joint once, from its first body; joints to held bodies are in `grams` already
            for joint in at_body[*b].iter().map(|j| &joints[*j as usize]) {
                let c = other(joint, *b);
                if joint.bodies[0] != *b || !loose(&parts[c]) {
                    continue;
                }
                let rows = joint.stopped.rows_between([&frames[*b], &frames[c]]);
                for [v, w] in rows {
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
