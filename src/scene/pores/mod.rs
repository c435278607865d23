//! Pore pressures that differ from element to element: fields in files, and diffusion into a layer.
//!
//! | file | what it decides |
//! |---|---|
//! | `read` | from a section and its files to what every element takes |
//! | `moved` | where a file lies that the scene has left behind |
//! | `room` | what it takes of memory |
//! | `field` | what a body keeps: elements and their change at any time |
//! | `drawdown` | a layer into which the change of a neighbour diffuses |
//! | `cloud` | points and their pressures, one per place |
//! | `csv_grid`, `vtu` | files of points: CSV, unstructured grids of VTK |
//! | `places` | which points an element takes: the cell that holds it, corners of a cell of a lattice, or the nearest |
//! | `cells`, `lattice`, `nearest` | a tree of cells; whether points are a lattice; a tree of points |

mod cells;
mod cloud;
mod csv_grid;
mod drawdown;
mod field;
mod lattice;
mod moved;
mod nearest;
mod places;
mod problem;
mod read;
mod room;
mod vtu;

pub use drawdown::{DrawdownSection, FarFace, FromFace};
pub use field::PoreField;
pub use places::Interpolation;
pub use problem::PoreProblem;
pub use room::PoreRoom;

pub(super) use moved::place;
pub(super) use read::{alike, digest, fields};
