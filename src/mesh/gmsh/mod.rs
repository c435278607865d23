//! Meshes from Gmsh files: hexahedra are the body, physical surfaces its fractures and sides.
//!
//! [`GmshFile`] is what the file says (formats 2.2 and 4.1, ASCII and binary), [`GmshMesh`] a body whose hexahedra meet
//! face to face, and [`GmshMesh::build`] splits it along fractures as a box grid is split.

mod body;
mod boxes;
mod conforming;
mod cursor;
mod distinct;
mod element_kind;
mod error;
mod faces;
mod file;
mod groups;
mod header;
mod orientation;
mod surface;
mod tags;
mod version2;
mod version4;

pub use body::{GmshMesh, SurfaceFracture};
pub use cursor::Spot;
pub use error::{GmshDefect, GmshError};
pub use file::GmshFile;
pub use groups::GroupName;
pub use surface::{Surface, SurfaceUse};
