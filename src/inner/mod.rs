//! Which inner solver takes the place of another one that the program chose: of one that cannot be set up, and of one with which an
//! iteration gets nowhere. Single solves and runs share it.
//!
//! | file | what it decides |
//! |---|---|
//! | `order` | what comes behind an inner solver |
//! | `stagnation` | which iteration is given up before its limit |

mod order;
mod stagnation;

pub(crate) use order::{amg, geometric, others, without_stagnation};
pub(crate) use stagnation::{Hope, PLATEAU, Standstill};
