//! Studies: a product of scenes or systems, meshes, loads and methods, a row per solve, figures and a page.
//!
//! | file | what it knows |
//! |---|---|
//! | `file`, `axes`, `choice`, `figure_section` | what a study file says |
//! | `product` | its rows, in order |
//! | `refine` | a finer mesh of the same scene |
//! | `solving`, `reference`, `outcome` | one row: solve, true errors, how it ended |
//! | `measure` | what is measured, by name |
//! | `rows`, `csv` | `rows.csv`, which survives the process |
//! | `engine` | rows one after the other, or several at once |
//! | `figures`, `curves`, `page` | what is drawn and written at the end |

mod axes;
mod choice;
mod csv;
mod curves;
mod engine;
mod figure_section;
mod figures;
mod file;
mod measure;
mod outcome;
mod page;
mod product;
mod reference;
mod refine;
mod rows;
mod solving;

pub use axes::{Axes, Tolerance};
pub use choice::{Choice, Inner, Load};
pub use engine::{Ended, Engine, Taken};
pub use figure_section::{FigureSection, ReferenceLine};
pub use file::{Limit, Study};
pub use measure::Name;
