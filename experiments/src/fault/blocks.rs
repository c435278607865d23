//! Blocks of a fault file as polygons that make sense.

use anyhow::ensure;
use fracas::analytic::{meeting_edges, shared_area, signed_area};
use fracas::units::{Length, Measure};
use serde::{Deserialize, Serialize};

/// `[[block]]`
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BlockSection {
    corners: Vec<[Measure<Length>; 2]>,
}

/// Blocks, counter-clockwise, none over another [m].
///
/// # Errors
/// A block that is no polygon, or two that overlap.
pub(super) fn polygons(blocks: &[BlockSection]) -> anyhow::Result<Vec<Vec<[f64; 2]>>> {
    let all = (blocks.iter().enumerate())
        .map(corners)
        .collect::<anyhow::Result<Vec<_>>>()?;
    apart(&all)?;
    Ok(all)
}

/// A polygon, turned counter-clockwise.
fn corners((k, block): (usize, &BlockSection)) -> anyhow::Result<Vec<[f64; 2]>> {
    let mut points: Vec<[f64; 2]> = (block.corners.iter())
        .map(|c| [c[0].si(), c[1].si()])
        .collect();
    let n = points.len();
    let number = k + 1;
    ensure!(
        n > 2,
        "block {number}: a block is a polygon of three or more corners [x, z], and it has {n}"
    );
    if let Some(edges) = meeting_edges(&points) {
        let [first, second] =
            edges.map(|i| format!("from corner {} to {}", i + 1, (i + 1) % n + 1));
        anyhow::bail!(
            "block {number}: its edges {first} and {second} meet; list its corners in turn, each once"
        );
    }
    if signed_area(&points) < 0.0 {
        points.reverse();
    }
    Ok(points)
}

/// Share of the smaller block within which what two share is rounding of their corners. Unit: 1.
const TOUCHING: f64 = 1e-6;

/// No two blocks overlap: pressure would change twice there.
fn apart(blocks: &[Vec<[f64; 2]>]) -> anyhow::Result<()> {
    for (k, a) in blocks.iter().enumerate() {
        for (l, b) in blocks.iter().enumerate().skip(k + 1) {
            let shared = shared_area(a, b);
            ensure!(
                shared <= TOUCHING * signed_area(a).min(signed_area(b)),
                "blocks {} and {} overlap by {shared:.4e} m^2, where the pressure would change twice; let them touch at most",
                k + 1,
                l + 1
            );
        }
    }
    Ok(())
}
