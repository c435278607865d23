//! What you run: studies and experiments, one file per question, the report that shows them beside the published numbers, and the
//! `fracas` command line.

pub mod allocation;
mod clock;
pub mod command;
pub mod crack;
pub mod e01_checkerboard;
pub mod e10_inclined_crack;
pub mod e11_pressurised_cracks;
pub mod e12_orders;
pub mod e13_checkerboard_traction;
pub mod e14_cycle;
pub mod e15_nonlinear;
pub mod e16_settings;
pub mod e17_four_fractures;
pub mod e19_tilted_well;
pub mod e22_gas_storage;
pub mod e23_ground_ruptures;
pub mod e27_ranks;
pub mod fault;
mod flow_runs;
pub mod list;
mod rates;
pub mod report;
pub mod scenes;
pub mod sentence;
pub mod study;
