//! What the stabilization does where fractures meet.

use crate::mesh::{FractureEdge, FractureMesh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the jump stabilization H does at an edge where a fracture goes through another. Written as `"joined"` or `"apart"`.
///
/// Left apart, the parts of a fracture between its junctions have tractions of their own, and on a network whose parts are one cell
/// wide nothing of the checkerboard is balanced: the inf-sup constant of N × N columns falls as 1/N. Joined, H takes the two faces
/// of a fracture at such an edge for neighbours, as everywhere else, while all faces of the others there stick: rock is then continuous
/// across them, and so is the traction. Beside a face that slips or is open tractions may jump.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Junctions {
    /// Faces of one fracture are neighbours across the others as long as these stick.
    #[default]
    Joined,
    /// They are not, as published.
    Apart,
}

impl Junctions {
    /// The edges that H acts on, each with the faces that have to stick for it.
    pub(super) fn edges(
        self,
        fractures: &FractureMesh,
    ) -> impl Iterator<Item = (&FractureEdge, &[u32])> {
        let joined = self == Self::Joined;
        let crossings = fractures.crossings.iter().filter(move |_| joined);
        let inner = fractures.edges.iter().map(|edge| (edge, &[][..]));
        inner.chain(crossings.map(|crossing| (&crossing.edge, &*crossing.others)))
    }
}
