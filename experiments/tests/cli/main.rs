//! The `fracas` binary, as its users see it: status, standard output, standard error, files.

mod bad_input;
mod block;
mod breakdowns;
mod check;
mod commands;
mod digits;
mod everyday;
mod explain;
mod fault;
mod geometric;
mod gmsh;
mod instructions;
mod memory;
mod modes;
mod output;
mod pages;
mod pipe;
mod restart;
mod run;
mod scenes;
mod solve;
mod spectrum;
mod study;
mod study_values;
