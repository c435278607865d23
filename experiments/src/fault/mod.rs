//! Slip of a displaced fault without a mesh: a file in, curves over the change of pressure out.

mod blocks;
mod curve;
mod file;
mod page;
mod sampling;
mod uncertain;

pub use curve::{Curve, Point, curve};
pub use file::{FaultFile, MOST_ELEMENTS};
pub use page::findings;
pub use sampling::{Sample, Sampled, sample};
