//! The list of experiments: the only place besides its own file that a new experiment touches.

use crate::report::Experiment;

/// Every experiment, in the order of the report.
pub static EXPERIMENTS: &[&dyn Experiment] = &[];

/// What `fracas reproduce` runs without arguments: about two minutes on two cores.
pub static SHORT_SELECTION: &[&str] = &[];

/// The experiment with this id.
pub fn find(id: &str) -> Option<&'static dyn Experiment> {
    EXPERIMENTS.iter().copied().find(|e| e.id() == id)
}
