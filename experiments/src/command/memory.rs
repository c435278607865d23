//! Memory of this process: what it took, and whether there is enough for what it is asked.

use fracas::scene::{Body, Scene};
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::amg::Summary;
use fracas_solvers::krylov::{Fitted, KrylovChoice};

/// What a grid node takes [bytes].
#[derive(Clone, Copy, Debug)]
pub(crate) struct PerNode {
    /// Where no map moves the nodes.
    bricks: u64,
    /// Where one does.
    mapped: u64,
    /// What to do where it does not fit.
    remedy: &'static str,
}

/// Mesh, fractures and sides, measured on 1.8 million nodes.
pub(crate) const MESH: PerNode = PerNode {
    bricks: 160,
    mapped: 160,
    remedy: "use fewer cells, e.g. --set mesh.x.cells=8",
};

/// Mesh and assembled blocks, without any factorization, measured on 120 thousand nodes.
pub(crate) const BLOCKS: PerNode = PerNode {
    bricks: 4200,
    mapped: 4200,
    remedy: "use fewer cells, e.g. --set mesh.x.cells=8, or solve with --inner geometric, which assembles no A",
};

/// Mesh, operator, hierarchy and the vectors of SQMR, without an assembled A, measured on 0.9 million nodes with few
/// fractures.
pub(crate) const MATRIX_FREE: PerNode = PerNode {
    bricks: 400,
    mapped: 870,
    remedy: "use fewer cells, e.g. --set mesh.x.cells=8",
};

/// What reading and checking a mesh file takes per node at its peak [bytes]: 305 to 320 measured on 1.0 million nodes, in
/// text and binary.
const PER_NODE_OF_FILE: u64 = 400;

/// What a fracture face adds to [`MATRIX_FREE`] [bytes], measured on a network of 147 thousand.
const PER_FACE: u64 = 3000;

/// A scene that does not fit.
#[derive(Debug, thiserror::Error)]
#[error(
    "{scene}: {nodes} grid nodes take about {needed:.1} GB and {available:.1} GB are free; {remedy}"
)]
struct TooLarge {
    scene: String,
    nodes: u128,
    needed: f64,
    available: f64,
    remedy: &'static str,
}

/// Refuses a scene that takes more memory than the system has to give, before any of it is taken.
pub(crate) fn room_for(name: &str, scene: &Scene, bytes: PerNode) -> anyhow::Result<()> {
    let mesh = &scene.sections().mesh;
    let nodes = scene.nodes();
    let (per_node, remedy) = match (&mesh.file, &mesh.map) {
        (Some(_), _) => (bytes.mapped.max(PER_NODE_OF_FILE), "use a coarser mesh"),
        (None, Some(_)) => (bytes.mapped, bytes.remedy),
        (None, None) => (bytes.bricks, bytes.remedy),
    };
    let needed = nodes as f64 * per_node as f64;
    match available_bytes() {
        // beyond the numbering of the mesh, which has its own message
        _ if nodes > fracas::mesh::MAX_NODES => Ok(()),
        Some(available) if needed > available as f64 => Err(TooLarge {
            scene: name.to_owned(),
            nodes,
            needed: needed * 1e-9,
            available: available as f64 * 1e-9,
            remedy,
        }
        .into()),
        _ => Ok(()),
    }
}

/// Refuses a meshed scene whose operator, hierarchy and vectors do not fit beside its mesh: fractures count now, too.
pub(crate) fn room_without_a(name: &str, body: &Body) -> anyhow::Result<()> {
    let bricks = body.mesh.grid.as_ref().is_some_and(|g| g.axis_aligned);
    let per_node = if bricks {
        MATRIX_FREE.bricks
    } else {
        MATRIX_FREE.mapped
    };
    let (nodes, faces) = (body.mesh.nodes.len(), body.fractures.faces.len());
    let needed = (per_node * nodes as u64 + PER_FACE * faces as u64) as f64;
    // the mesh is there already
    let held = kibibytes("/proc/self/status", "VmRSS:").unwrap_or(0);
    match available_bytes() {
        Some(available) if needed > (available + held) as f64 => Err(TooLargeMeshed {
            scene: name.to_owned(),
            nodes,
            faces,
            needed: needed * 1e-9,
            available: (available + held) as f64 * 1e-9,
            remedy: MATRIX_FREE.remedy,
        }
        .into()),
        _ => Ok(()),
    }
}

/// A second hierarchy that does not fit.
#[derive(Debug, thiserror::Error)]
#[error("it takes about {needed:.1} GB and {available:.1} GB are free")]
struct NoRoomInDouble {
    needed: f64,
    available: f64,
}

/// Refuses the hierarchy in f64 beside the one in f32 where its numbers alone, twice as long, do not fit.
pub(crate) fn room_in_double(single: Option<&Summary>) -> anyhow::Result<()> {
    let levels = single.iter().flat_map(|summary| &summary.levels);
    let needed = 2.0 * levels.map(|level| level.bytes).sum::<usize>() as f64;
    match available_bytes() {
        Some(available) if needed > SHARE * available as f64 => Err(NoRoomInDouble {
            needed: needed * 1e-9,
            available: available as f64 * 1e-9,
        }
        .into()),
        _ => Ok(()),
    }
}

/// A meshed scene whose solver does not fit.
#[derive(Debug, thiserror::Error)]
#[error(
    "{scene}: {nodes} nodes and {faces} fracture faces take about {needed:.1} GB and {available:.1} GB are free; {remedy}"
)]
struct TooLargeMeshed {
    scene: String,
    nodes: usize,
    faces: usize,
    needed: f64,
    available: f64,
    remedy: &'static str,
}

/// Share of the free memory that vectors may take: the rest is for what the estimate does not know.
const SHARE: f64 = 0.9;

/// Vectors of `n` numbers that fit into memory now; as many as anybody wants where the system does not tell.
fn vectors_that_fit(n: usize) -> usize {
    let bytes = 8.0 * n.max(1) as f64;
    available_bytes().map_or(usize::MAX, |free| (SHARE * free as f64 / bytes) as usize)
}

/// Vectors that no iteration has room for.
#[derive(Debug, thiserror::Error)]
#[error(
    "memory holds {vectors} more vectors of {n} unknowns and the shortest iteration takes 8; use fewer cells, or free memory"
)]
struct NoRoom {
    vectors: usize,
    n: usize,
}

/// The iteration whose vectors fit, beside the scratch of the product and of the preconditioner.
pub(crate) fn krylov_that_fits(
    operator: &dyn LinearOperator<f64>,
    preconditioner: &dyn Preconditioner<f64>,
    symmetric: bool,
) -> anyhow::Result<Fitted> {
    let n = preconditioner.size();
    let scratch = operator.work_len().max(preconditioner.work_len());
    // and the solution
    let taken = 1 + scratch.div_ceil(n.max(1));
    let vectors = vectors_that_fit(n).saturating_sub(taken);
    let fitted = KrylovChoice::fitted(vectors, symmetric, preconditioner);
    Ok(fitted.ok_or(NoRoom { vectors, n })?)
}

/// Memory that can be taken without swapping [bytes], where the system tells (Linux).
fn available_bytes() -> Option<u64> {
    kibibytes("/proc/meminfo", "MemAvailable:")
}

/// High-water mark of the resident set [bytes], where the system tells (Linux).
pub(crate) fn peak_bytes() -> Option<u64> {
    kibibytes("/proc/self/status", "VmHWM:")
}

/// Lets the high-water mark start again from what is resident now, where the system allows it (Linux).
pub(crate) fn reset_peak() {
    // elsewhere the mark is that of the whole process, as before
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Value of a line `key 123 kB` [bytes].
fn kibibytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.split_ascii_whitespace().next()?.parse().ok()?;
    Some(1024 * kibibytes)
}
