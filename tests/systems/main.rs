//! Claims about linear systems: accuracy, spectra, units, imports, the library.
#![allow(clippy::unwrap_used)]

use fracas::mesh;

mod accuracy;
mod exact_schur;
mod far_from_normal;
mod foreign_accuracy;
mod foreign_systems;
mod giving_way;
mod held_by_b1;
mod held_by_h;
mod inf_sup;
mod large;
mod library;
mod reference;
#[path = "../../src/elasticity/sample.rs"]
mod sample;
mod settings;
mod singular;
mod stiffness_products;
mod theorems;
mod traction_unit;
