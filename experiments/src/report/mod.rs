//! From an experiment to tables, figures and a page: typed tables → CSV and JSON manifest → SVG → one `report.html`.

mod check;
mod experiment;
mod folder;
mod html;
mod lecture;
mod manifest;
mod math;
mod sheet;
mod table;

#[cfg(test)]
mod tests;

pub use check::{Basis, Check};
pub use experiment::{Experiment, Findings, Level, Panels};
pub(crate) use folder::write_whole;
pub use folder::{Chapter, Formats, Outcome, run_chapter, write_report};
pub(crate) use sheet::FIGURES;
pub use sheet::Sheet;
pub use table::{Cell, Column, Table};
