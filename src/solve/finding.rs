//! What is to be said of a solve, as data.

use crate::multigrid::Lost;
use fracas_solvers::saddle::folder;
use serde::{Serialize, Serializer};
use std::fmt;

/// Something worth telling of a solve; each prints as one sentence.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Finding {
    /// A remark of the import.
    Import(folder::Finding),
    /// The scene has settings of its own, which are those of runs.
    OfRuns,
    /// Why this inner solver was chosen.
    Inner {
        /// Its name and why.
        reason: String,
    },
    /// An inner solver took the place of one that could not be set up.
    Instead {
        /// Its name.
        inner: String,
        /// Why the one before could not.
        failure: String,
    },
    /// An inner solver goes on from where another one got nowhere.
    GaveWay {
        /// Its name.
        inner: String,
        /// The one before.
        first: String,
        /// Relative residual that the one before left. Unit: 1.
        residual: f64,
        /// Iterations around the one before.
        iterations: usize,
    },
    /// An inner solver gets nowhere, and no other can be set up.
    NoOther {
        /// Why not.
        failure: String,
    },
    /// f32 and f64.
    Precision(Rounding),
    /// Memory decided on the iteration.
    Krylov {
        /// Its name and why.
        reason: String,
    },
    /// Residuals in twice the digits.
    Refined {
        /// Passes with them.
        passes: usize,
    },
    /// The last digits of the entries leave more of the answer open than the tolerance.
    LeftOpen {
        /// What is left open most, in words.
        part: &'static str,
        /// Relative change of it; infinite where the digits make the system singular. Unit: 1.
        by: f64,
    },
    /// Residuals in twice the digits could not be had.
    NotRefined {
        /// Why.
        failure: String,
    },
}

/// What f32 inside a preconditioner lost.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Rounding {
    /// Entries of A spread over its digits; f64 is taken.
    Spread {
        /// Largest over smallest diagonal entry. Unit: 1.
        spread: f64,
    },
    /// The set-up fails with f32 and not with f64.
    SetUp {
        /// How it fails.
        failure: String,
    },
    /// The hierarchy would have lost too much; it is in f64.
    Hierarchy(Lost),
    /// The iteration failed and f64 could not be set up.
    NoDouble {
        /// How the iteration failed.
        failure: String,
        /// Why there is no f64.
        reason: String,
    },
    /// The iteration failed, but M⁻¹r is that of f64.
    NotToBlame {
        /// How the iteration failed.
        failure: String,
        /// Relative difference of M⁻¹r. Unit: 1.
        difference: f64,
    },
    /// The iteration failed and went on with f64.
    WentOn {
        /// How the iteration failed.
        failure: String,
        /// Relative difference of M⁻¹r. Unit: 1.
        difference: f64,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Import(finding) => finding.fmt(f),
            Self::OfRuns => write!(
                f,
                "settings: [solver] of the scene is for `run`, and a solve of one system takes its own settings in its place"
            ),
            Self::Inner { reason } => write!(f, "inner: {reason}"),
            Self::Instead { inner, failure } => {
                write!(
                    f,
                    "inner: {inner} instead, because the set-up failed: {failure}"
                )
            }
            Self::GaveWay {
                inner,
                first,
                residual,
                iterations,
            } => write!(
                f,
                "inner: {inner} goes on from {first}, which leaves a residual of {residual:.1e} in {iterations} iterations"
            ),
            Self::NoOther { failure } => {
                write!(f, "inner: no other can be set up: {failure}")
            }
            Self::Precision(rounding) => write!(f, "precision: {rounding}"),
            Self::Krylov { reason } => write!(f, "krylov: {reason}"),
            Self::Refined { passes } => write!(
                f,
                "refinement: f64 holds no more digits of the residual; passes with residuals in twice the digits: {passes}"
            ),
            Self::LeftOpen { by, .. } if !by.is_finite() => write!(
                f,
                "digits: the system is singular in the digits of f64, and this is one of its answers"
            ),
            Self::LeftOpen { part, by } => write!(
                f,
                "digits: rounding of the entries to f64 leaves {by:.1e} of the {part} open, more than the tolerance"
            ),
            Self::NotRefined { failure } => write!(
                f,
                "refinement: f64 holds no more digits of the residual, and entries for twice the digits could not be had: {failure}"
            ),
        }
    }
}

impl fmt::Display for Rounding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spread { spread } => write!(
                f,
                "entries of A spread over {spread:.0e}, the digits of f32; the hierarchy is in f64"
            ),
            Self::SetUp { failure } => {
                write!(f, "with f32 {failure}; the hierarchy is in f64")
            }
            Self::Hierarchy(lost) => write!(f, "{lost}; the hierarchy is in f64"),
            Self::NoDouble { failure, reason } => {
                write!(f, "{failure}; f64 could not be set up: {reason}")
            }
            Self::NotToBlame {
                failure,
                difference,
            } => write!(
                f,
                "{failure}; f32 inside is not to blame, its M⁻¹r is that of f64 to {difference:.0e}"
            ),
            Self::WentOn {
                failure,
                difference,
            } => write!(
                f,
                "{failure}; M⁻¹r in f32 is off by {difference:.0e} of that in f64, so the iteration went on with f64"
            ),
        }
    }
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
