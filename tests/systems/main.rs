//! Claims about linear systems: accuracy, spectra, units, imports, the library.
#![allow(clippy::unwrap_used)]

mod accuracy;
mod exact_schur;
mod foreign_accuracy;
mod foreign_systems;
mod giving_way;
mod inf_sup;
mod library;
mod reference;
mod theorems;
mod traction_unit;
