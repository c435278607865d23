//! Which pressures the balance of a face depends on.

use super::network::Network;
use crate::mesh::FractureEdge;
use fracas_operators::sparse::Pattern;

/// Faces that share an edge of the network or a vertex that decides on fluxes, and all faces of these
/// parts in the row of their first.
pub(super) fn pattern(
    faces: usize,
    network: &Network,
    edges: &[FractureEdge],
    parts: &mut dyn Iterator<Item = &[u32]>,
) -> Pattern {
    let mut rows: Vec<Vec<u32>> = (0..faces).map(|f| vec![f as u32]).collect();
    let mut meet = |all: &[u32]| {
        for f in all {
            rows[*f as usize].extend(all);
        }
    };
    for arms in network.meetings() {
        meet(&arms.iter().map(|arm| arm.face).collect::<Vec<_>>());
    }
    network.around().for_each(|faces| meet(&faces));
    edges.iter().for_each(|edge| meet(&edge.faces));
    for part in parts {
        rows[part[0] as usize].extend(part);
    }
    let mut pattern = Pattern {
        offsets: vec![0],
        columns: Vec::new(),
    };
    for mut row in rows {
        row.sort_unstable();
        row.dedup();
        pattern.columns.extend(row);
        pattern.offsets.push(pattern.columns.len());
    }
    pattern
}
