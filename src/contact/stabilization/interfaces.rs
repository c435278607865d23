//! What the stabilization does where a fracture leaves one rock for another.

use crate::elasticity::Elastic;
use crate::mesh::{FractureEdge, FractureMesh, HexMesh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the jump stabilization H does at an edge whose faces lie in different materials, on one side of the fracture or on both. Written as
/// `"apart"` or `"joined"`. Materials that deform alike, as those that differ in name or density alone, are one ([`Rocks`]).
///
/// Stiffness, pore pressure and thermal strain of a material jump there, and the traction of the solution does, too: H takes that for a
/// checkerboard and lets a jump of displacement through that no finer mesh makes smaller relative to a cell. Left apart, the faces of a
/// material are a patch of their own. A patch at least two faces wide has nodes between its faces, which hold what is constant on it: the
/// inf-sup constant does not fall (macroelements). Where a patch is one face wide across the edge, the edge is kept.
///
/// # Source
/// R. Stenberg, Math. Comp. 42 (1984) 9–23, for macroelements; what is left out is a choice of this project.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interfaces {
    /// Faces in different materials are no neighbours, where both patches are two faces wide.
    #[default]
    Apart,
    /// They are, as published.
    Joined,
}

/// What H knows of the materials of a body; `mesh.regions` indexes both lists.
#[derive(Clone, Copy, Debug)]
pub struct Rocks<'a> {
    /// Elastic constants.
    pub elastic: &'a [Elastic],
    /// The first material that behaves as this one does: tractions go from one to the other without a jump.
    pub first_alike: &'a [usize],
}

impl Rocks<'_> {
    /// Of every material the first one that `alike` holds equal to it.
    pub fn first_alike(n: usize, alike: impl Fn(usize, usize) -> bool) -> Vec<usize> {
        let first = |i| (0..i).find(|j| alike(*j, i)).unwrap_or(i);
        (0..n).map(first).collect()
    }
}

/// No neighbour across this side of a face.
const NONE: u32 = u32::MAX;

impl Interfaces {
    /// Per edge, in the order of `edges`, whether H acts on it.
    pub(super) fn acts(
        self,
        mesh: &HexMesh,
        fractures: &FractureMesh,
        rocks: Rocks<'_>,
        edges: &[(&FractureEdge, &[u32])],
    ) -> Vec<bool> {
        let sides = |f: u32| {
            let face = &fractures.faces[f as usize];
            let region = |e: u32| usize::from(mesh.regions[e as usize]);
            [face.minus, face.plus].map(|side| rocks.first_alike[region(side.element)])
        };
        let differs = |edge: &FractureEdge| sides(edge.faces[0]) != sides(edge.faces[1]);
        if self == Self::Joined || !edges.iter().any(|(edge, _)| differs(edge)) {
            return vec![true; edges.len()];
        }
        // neighbours in the same materials across the four sides of a face
        let mut alike = vec![[NONE; 4]; fractures.faces.len()];
        for (edge, _) in edges.iter().filter(|(edge, _)| !differs(edge)) {
            let [k, l] = edge.faces;
            alike[k as usize][side(edge.nodes_k)] = l;
            alike[l as usize][side(edge.nodes_l)] = k;
        }
        let is_wide = |f: u32, nodes: [u8; 2]| alike[f as usize][(side(nodes) + 2) % 4] != NONE;
        let acts = |(edge, _): &(&FractureEdge, &[u32])| {
            let [k, l] = edge.faces;
            !(differs(edge) && is_wide(k, edge.nodes_k) && is_wide(l, edge.nodes_l))
        };
        edges.iter().map(acts).collect()
    }
}

/// The side of a face between two of its corners.
fn side([a, b]: [u8; 2]) -> usize {
    usize::from(if (a + 1) % 4 == b { a } else { b })
}
