//! Bodies with one crack: meshes of them, what they answer, and how far that is from a closed form.

mod family;
mod orders;
mod profile;
mod solve;

pub use family::{CrackScene, Family, INCLINED, LINE, PENNY};
pub use orders::{between, fitted};
pub use profile::{Profile, Strip};
pub use solve::Answer;
