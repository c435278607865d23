//! Plane sections through a meshed body, and anything flat, as quadrilaterals to colour.
//!
//! | file | what it knows |
//! |---|---|
//! | `plane` | a plane, the two directions in it, their names |
//! | `choice` | which planes show a body and its fractures |
//! | `cut` | what a plane makes of elements, materials and fractures |
//! | `lines` | segments joined to lines |
//! | `patches` | quadrilaterals, few enough for a page |

mod choice;
mod cut;
mod lines;
mod patches;
mod plane;

pub use choice::planes;
pub use cut::Section;
pub use patches::Patches;
pub use plane::{Direction, Plane, in_plane};
