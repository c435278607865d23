//! Components that are no unknowns, as three bits per node.

use super::coarsening::{Coarsening, for_each_fine};
use super::elements::Elements;
use super::grid::{ACROSS, Grid, STEPS};
use super::interpolation::{Owners, weights};
use crate::elasticity::Constraints;

/// The prescribed components of every node.
pub(super) fn prescribed(constraints: &Constraints) -> Vec<u8> {
    let mut bits = vec![0b111_u8; constraints.full_len() / 3];
    for dof in constraints.free() {
        bits[*dof as usize / 3] &= !(1 << (dof % 3));
    }
    bits
}

/// A coarse component is fixed where a fixed fine node lies at its place, and on the side of a coarse element in which a fine
/// one has its whole face on that side fixed:
///
/// ```text
/// x_c = 0 on fixed corners  ⇒  (P x_c)_i = 0 at every fixed fine i
/// ```
///
/// A piece of a cell reaches corners of that cell at which it has no node. Left free beside a held side, such a corner bends fixed
/// nodes, which take no part, and its function on the others is that of corners behind it: `PᵀS_u P` is singular (of the column
/// between a roller and a cut in the middle of the next coarse cell the corners (0,4), (4,0), (4,4) move two nodes). Functions that
/// vanish at all fixed nodes are independent, since an element of a piece has eight nodes and the piece eight corners.
pub(super) fn coarse(
    fine: &[u8],
    grid: &Grid<'_>,
    owners: &Owners,
    coarsening: &Coarsening,
) -> Vec<u8> {
    let Coarsening { coarse, parent, .. } = coarsening;
    let mut bits = vec![0; coarse.nodes];
    for (node, fixed) in fine.iter().enumerate().filter(|(_, fixed)| **fixed != 0) {
        let corners = &coarse.elements[owners.element[node] as usize];
        for (corner, weight) in corners.iter().zip(owners.weights(coarse, node)) {
            if weight == 1.0 {
                bits[*corner as usize] |= *fixed;
            }
        }
    }
    for axis in 0..3 {
        for (at, upper) in [(0, false), (grid.cells[axis] - 1, true)] {
            let side = ACROSS[axis].map(|[high, low]| if upper { high } else { low });
            for e in grid.layer(axis, at).flat_map(|cell| grid.elements_in(cell)) {
                let nodes = side.map(|a| fine[grid.elements[e][a] as usize]);
                let whole = nodes.iter().fold(0b111, |all, fixed| all & fixed);
                let corners = &coarse.elements[parent[e] as usize];
                for a in side.iter().filter(|_| whole != 0) {
                    bits[corners[*a] as usize] |= whole;
                }
            }
        }
    }
    bits
}

/// The fixed components in ascending order.
pub(super) fn list(bits: &[u8]) -> Vec<u32> {
    let mut list = Vec::new();
    for (node, bits) in bits.iter().enumerate() {
        list.extend(
            (0..3)
                .filter(|i| bits >> i & 1 == 1)
                .map(|i| 3 * node as u32 + i),
        );
    }
    list
}

/// Material of every coarse element that is a whole brick of one material, else [`Elements::NONE`]: its trilinear functions
/// are trilinear in every part, so its Galerkin matrix is that of a brick. Where a fixed fine component is interpolated
/// from free ones it is not.
pub(super) fn whole_bricks(
    fine: &Grid<'_>,
    elements: &Elements<'_>,
    coarsening: &Coarsening,
    owners: &Owners,
    [fixed, fixed_coarse]: [&[u8]; 2],
) -> Vec<u16> {
    let Coarsening { coarse, starts, .. } = coarsening;
    let mut kinds = vec![Elements::NONE; coarse.elements.len()];
    for cell in 0..coarse.cells.iter().product() {
        let pieces = coarse.elements_in(cell);
        if pieces.len() != 1 {
            continue;
        }
        let piece = pieces.start;
        let place = coarse.place(cell);
        let mut kind = None;
        for_each_fine(place, starts, |at| {
            let inside = fine.elements_in(fine.cell(at));
            let first = inside.start;
            let own = match elements.brick_kind(first) {
                kind if inside.len() == 1 => kind,
                _ => Elements::NONE,
            };
            let nodes = &fine.elements[first];
            let held = nodes.iter().zip(STEPS).any(|(node, up)| {
                let bits = fixed[*node as usize];
                bits != 0 && {
                    let local = [0, 1, 2].map(|d: usize| at[d] - starts[d][place[d]] + up[d]);
                    let weights = weights(owners.shares(place, local));
                    let mut corners = coarse.elements[piece].iter().zip(weights);
                    corners.any(|(c, w)| w > 0.0 && bits & !fixed_coarse[*c as usize] != 0)
                }
            });
            let own = if held { Elements::NONE } else { own };
            kind = match kind {
                None => Some(own),
                Some(kind) if kind == own => Some(own),
                _ => Some(Elements::NONE),
            };
        });
        kinds[piece] = kind.unwrap_or(Elements::NONE);
    }
    kinds
}
