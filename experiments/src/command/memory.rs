//! Memory of this process: what it took, and whether there is enough for what it is asked.

use fracas::scene::Scene;

/// Mesh, fractures and sides [bytes per grid node], measured on 1.8 million nodes.
pub(super) const MESH: u64 = 160;

/// Mesh and assembled blocks, without any factorization [bytes per grid node], measured on 120 thousand nodes.
pub(super) const BLOCKS: u64 = 4200;

/// A scene that does not fit.
#[derive(Debug, thiserror::Error)]
#[error(
    "{scene}: {nodes} grid nodes take about {needed:.1} GB and {available:.1} GB are free; use fewer cells, e.g. --set mesh.x.cells=8"
)]
struct TooLarge {
    scene: String,
    nodes: u128,
    needed: f64,
    available: f64,
}

/// Refuses a scene that takes more memory than the system has to give, before any of it is taken.
pub(super) fn room_for(name: &str, scene: &Scene, bytes_per_node: u64) -> anyhow::Result<()> {
    let nodes = scene.sections().mesh.nodes();
    let needed = nodes as f64 * bytes_per_node as f64;
    match available_bytes() {
        // beyond the numbering of the mesh, which has its own message
        _ if nodes > fracas::mesh::MAX_NODES => Ok(()),
        Some(available) if needed > available as f64 => Err(TooLarge {
            scene: name.to_owned(),
            nodes,
            needed: needed * 1e-9,
            available: available as f64 * 1e-9,
        }
        .into()),
        _ => Ok(()),
    }
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
