//! Hexahedral meshes and the fractures in them.

mod fracture_mesh;
mod hex_mesh;

pub use fracture_mesh::{FaceSide, FractureEdge, FractureFace, FractureMesh};
pub use hex_mesh::{CORNERS, Grid, HexMesh, jacobian_determinant};
