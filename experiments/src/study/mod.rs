//! Studies: a product of scenes or systems, meshes, loads and methods, a row per solve, figures, tables and a page.
//!
//! | file | what it knows |
//! |---|---|
//! | `file`, `axes`, `setting`, `choice`, `figure_section` | what a study file says |
//! | `names` | what it mentions, known or not |
//! | `product` | its rows, in order |
//! | `refine`, `state` | a finer mesh of the same scene, a contact state of it |
//! | `solving`, `prepared`, `counted`, `narrow`, `stepping`, `reference`, `nested`, `outcome` | one row: matrices, solve, run, true errors, how it ended |
//! | `measure`, `measured` | what is measured, by name |
//! | `rows`, `csv`, `sources` | `rows.csv`, which survives the process, and what its scenes were |
//! | `engine` | rows one after the other, or several at once |
//! | `findings`, `formula` | rows chosen and computed with |
//! | `figures`, `curves`, `labels`, `map`, `tables`, `checks`, `page` | what is drawn, listed, judged and written at the end |
//! | `gallery` | the studies of the product, which `reproduce` runs |

mod axes;
mod checks;
mod choice;
mod counted;
mod csv;
mod curves;
mod engine;
mod figure_section;
mod figures;
mod file;
mod findings;
mod formula;
pub mod gallery;
mod labels;
mod map;
mod measure;
mod measured;
mod names;
mod nested;
mod outcome;
mod page;
mod prepared;
mod product;
mod reference;
mod refine;
mod rows;
mod run_files;
mod setting;
mod slipping;
mod solving;
mod sources;
mod state;
mod stepping;
mod tables;
mod tornado;

pub use axes::{Axes, Products, Together, Tolerance};
pub use checks::{Bound, CheckSection, Other, Take};
pub use choice::{Choice, Inner, Load};
pub use engine::{Ended, Engine, Taken};
pub use figure_section::{FigureSection, Kind, ReferenceLine};
pub use file::{Counts, Limit, Study};
pub use findings::Published;
pub use measure::Name;
pub use nested::Finest;
pub use setting::Setting;
pub use state::State;
pub use tables::{Column, LongColumn, TableSection};
