//! Claims against known answers: closed forms, tables, boundary elements.
#![allow(clippy::unwrap_used)]

mod analytic;
mod closed_flow;
mod crack_table;
mod creep;
mod creep_oracle;
mod creep_runs;
mod crossing_cracks;
mod crossing_exact;
mod depleted_fault;
mod drawdown;
mod fault_sides;
mod flow_counts;
mod flow_ends;
mod flow_errors;
mod flow_family;
mod foreign_fields;
mod fracture_flow;
mod graded;
mod inclined_fault;
mod interface_crack;
mod junction_cracks;
mod layers;
mod plane_strain;
mod pore_cells;
mod pore_fields;
mod pore_moved;
mod pore_pressure;
mod pore_refusals;
mod strip_load;
mod tips;
mod volume_control;
mod weight;
mod wells;
