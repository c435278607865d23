//! What you run: one file per figure or table, the report that shows them beside the published numbers, and the
//! `fracas` command line.

pub mod allocation;
mod clock;
pub mod command;
pub mod crack;
pub mod e01_checkerboard;
pub mod e02_spectra;
pub mod e02b_spectrum_amg;
pub mod e03_conditioning;
pub mod e04_efficiency;
pub mod e05_mesh_independence;
pub mod e06_c_laboratory;
pub mod e06b_relaxation;
pub mod e07_contact_state;
pub mod e08_size;
pub mod e09_work_precision;
pub mod e10_inclined_crack;
pub mod e11_pressurised_cracks;
pub mod e12_orders;
pub mod e13_checkerboard_traction;
pub mod e14_cycle;
pub mod e15_nonlinear;
pub mod list;
pub mod measure;
pub mod plot;
pub mod published;
pub mod report;
mod scenes;
mod sentence;
pub mod study;
pub mod trial;
