//! Hexahedral meshes and the fractures in them.
//!
//! [`Axis`] lines make a box of bricks ([`BoxGrid`]), [`PlaneFracture`]s select faces of it, a [`Warp`] moves the
//! nodes, [`BoxGrid::build`] splits the nodes on fractures, and [`audit`] says what came out. A [`GmshMesh`]
//! does the same with hexahedra and surfaces from a file.

mod audit;
mod axis;
mod bodies;
mod box_grid;
mod disc;
mod error;
mod face_geometry;
mod fracture_edges;
mod fracture_mesh;
mod fracture_patches;
mod fronts;
mod gmsh;
mod graph;
mod hex_mesh;
mod incidence;
pub(crate) mod jacobian;
mod kernel;
mod kernel_report;
mod lift;
mod loose;
mod plane_fracture;
mod rank;
mod relief;
mod rigid;
mod shear;
mod size_field;
mod split;
mod thin;
mod warp;

pub use audit::{Audit, FractureCounts, audit};
pub use axis::{Axis, Grading};
pub use bodies::{BodyPart, Hold, bodies};
pub use box_grid::{BoxGrid, BoxRegion, BuiltMesh};
pub use disc::Disc;
pub use error::{MAX_NODES, MeshError};
pub use face_geometry::{FaceGeometry, face_geometry};
pub(crate) use face_geometry::{cross, dot, for_each_point, minus, unit};
pub use fracture_edges::fracture_edges;
pub use fracture_mesh::{Crossing, FaceSide, FractureEdge, FractureFace, FractureMesh};
pub use gmsh::{
    GmshDefect, GmshError, GmshFile, GmshMesh, GroupName, Spot, Surface, SurfaceFracture,
    SurfaceUse,
};
pub use graph::node_graph;
pub use hex_mesh::{EDGES, Grid, HexMesh};
pub(crate) use incidence::{Incidence, Places};
pub use jacobian::{brick_size, check_jacobians, min_jacobian};
pub use kernel::{CouplingKernel, KernelFinding, KernelReason, coupling_kernel};
pub use lift::Lift;
pub use plane_fracture::PlaneFracture;
pub use relief::Relief;
pub(crate) use shear::lean;
pub use shear::{Leaning, Shear};
pub use size_field::SizeField;
pub use split::{Cut, FACES, split};
pub use thin::is_thin;
pub use warp::{Distort, Incline, Rotate, Warp, WarpContext};
