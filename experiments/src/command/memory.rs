//! Memory of this process: what it took, and whether there is enough for what it is asked.

use fracas::scene::Scene;

/// What a grid node takes [bytes].
#[derive(Clone, Copy, Debug)]
pub(super) struct PerNode {
    /// Where no map moves the nodes.
    bricks: u64,
    /// Where one does.
    mapped: u64,
    /// What to do where it does not fit.
    remedy: &'static str,
}

/// Mesh, fractures and sides, measured on 1.8 million nodes.
pub(super) const MESH: PerNode = PerNode {
    bricks: 160,
    mapped: 160,
    remedy: "use fewer cells, e.g. --set mesh.x.cells=8",
};

/// Mesh and assembled blocks, without any factorization, measured on 120 thousand nodes.
pub(super) const BLOCKS: PerNode = PerNode {
    bricks: 4200,
    mapped: 4200,
    remedy: "use fewer cells, e.g. --set mesh.x.cells=8, or solve with --inner geometric, which assembles no A",
};

/// Mesh, operator, hierarchy and the vectors of SQMR, without an assembled A.
pub(super) const MATRIX_FREE: PerNode = PerNode {
    bricks: 650,
    mapped: 1000,
    remedy: "use fewer cells, e.g. --set mesh.x.cells=8",
};

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
pub(super) fn room_for(name: &str, scene: &Scene, bytes: PerNode) -> anyhow::Result<()> {
    let mesh = &scene.sections().mesh;
    let nodes = mesh.nodes();
    let per_node = if mesh.map.is_some() {
        bytes.mapped
    } else {
        bytes.bricks
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
            remedy: bytes.remedy,
        }
        .into()),
        _ => Ok(()),
    }
}

/// Share of the free memory that vectors may take: the rest is for what the estimate does not know.
const SHARE: f64 = 0.9;

/// Vectors of `n` numbers that fit into memory now; as many as anybody wants where the system does not tell.
pub(super) fn vectors_that_fit(n: usize) -> usize {
    let bytes = 8.0 * n.max(1) as f64;
    available_bytes().map_or(usize::MAX, |free| (SHARE * free as f64 / bytes) as usize)
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
