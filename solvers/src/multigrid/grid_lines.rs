//! Which lines of a grid the next one keeps, in numbers.

use crate::steering;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which lines of a grid the next one keeps: small neighbouring cells become one, rocks that differ stay apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GridLines {
    /// Ratio of shear moduli from which an interface is kept. Unit: 1.
    pub contrast: f64,
    /// Cells up to this many times the finest are small, and small neighbours become one cell. Beyond √2 cells are nearer to cubes
    /// if only the finest axis is halved: cells of 1:2 (`layered_crossing`, 64 × 32 × 32) take 16 iterations in place of 25,
    /// ν = 0.49 there 18 of 36. Unit: 1.
    pub small: f64,
    /// The same where interfaces leave no coarser grid. Unit: 1.
    pub beside_interfaces: f64,
    /// Widest over finest cell of an axis up to which all its cells count as their mean. `inclined_crack`, `line_crack`,
    /// `penny_crack` take 34, 30, 17 iterations with 5, C_s 337, 485, 152; 38, 30, 17 with 3, 43, 31, 17 with 12, 267, 59, 39
    /// (C_s 2,730, 1,017, 291) where every axis counts as its mean. Grids that grow by 1.05 to 1.4 per cell: least C_s or 5 %
    /// above it with 5. Unit: 1.
    pub alike: f64,
    /// On graded axes what is small grows, by a tenth at a time, until an axis is halved whole or this share of the cells would be
    /// left. The three cracks take 31, 26, 17 iterations with 0.5 in 1.2 to 1.7 times the time, 114, 45, 23 with 0.3. Unit: 1.
    pub left: f64,
    /// Share left from which on no other axis is halved whole, whose cells are wide beside those that have become one, at least 1 − 1/w where
    /// they are w times as wide as the finest: plates of 1:50 between cuts took 230 iterations, and take 17. Unit: 1.
    pub enough: f64,
    /// Width over thickness up to which cells beside a plate between cuts, or a stiff sheet, one cell thick between interfaces, become one. Wider ones leave
    /// functions along the sheet to no level: its nodes are stiff across. A sheet of 1:10 over rock 1,000 times softer took 200
    /// iterations, and takes 50, as many as with S_u factorized. Unit: 1.
    pub flat: f64,
    /// In rock of several kinds, share of the neighbours across an axis that fractures cut on one side of a line alone from which on it is kept,
    /// lest blocks become one on coarse cells. Columns of one cell that end in soft rock, 45,596 displacements, took 195 iterations, and take 82,
    /// as many as with S_u factorized. Unit: 1.
    pub ending: f64,
    /// Unknowns up to which algebraic multigrid takes over where only interfaces are left; a larger level drops them.
    pub hybrid: usize,
}

impl Default for GridLines {
    fn default() -> Self {
        Self {
            contrast: 8.0,
            small: 1.5,
            beside_interfaces: 2.0,
            alike: 5.0,
            left: 0.45,
            enough: 0.7,
            flat: 4.0,
            ending: 0.45,
            hybrid: 150_000,
        }
    }
}

steering! {
    GridLines:
    contrast [1.0, 1e300],
    small [1.0, 1e300],
    beside_interfaces [1.0, 1e300],
    alike [1.0, 1e300],
    left [0.125, 1.0],
    enough [0.125, 1.0],
    flat [1.0, 1e300],
    ending [1e-3, 1e300],
    hybrid [0.0, 1e15],
}
