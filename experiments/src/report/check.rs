//! A claim held against a number.

use fracas_figures::format_real;
use serde::{Deserialize, Serialize};

/// Where the bound of a claim is from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Chosen here: a threshold that tells a good answer from a bad one.
    #[default]
    Own,
    /// A theorem, a conservation law or a solution in closed form.
    ClosedForm,
    /// A printed value, with its source.
    Published(String),
}

/// One line of the verdict: the claim, what is expected or published, what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The claim in words.
    pub claim: String,
    /// Expected or published value.
    pub expected: String,
    /// Value found here.
    pub ours: String,
    /// Does the claim hold?
    pub pass: bool,
    /// Where the expected value is from.
    pub basis: Basis,
}

impl Check {
    /// The same, with where its bound is from.
    #[must_use]
    pub fn by(mut self, basis: Basis) -> Self {
        self.basis = basis;
        self
    }

    /// The same, with a bound that follows from a theorem, a conservation law or a solution in closed form.
    #[must_use]
    pub fn closed_form(self) -> Self {
        self.by(Basis::ClosedForm)
    }

    /// `|ours − expected| ≤ tolerance · |expected|`.
    pub fn close(claim: impl Into<String>, expected: f64, ours: f64, tolerance: f64) -> Self {
        Self {
            claim: claim.into(),
            expected: format!(
                "{} ± {} %",
                format_real(expected),
                format_real(100.0 * tolerance)
            ),
            ours: format_real(ours),
            pass: (ours - expected).abs() <= tolerance * expected.abs(),
            basis: Basis::Own,
        }
    }

    /// `ours ≤ limit`.
    pub fn at_most(claim: impl Into<String>, limit: f64, ours: f64) -> Self {
        Self {
            claim: claim.into(),
            expected: format!("≤ {}", format_real(limit)),
            ours: format_real(ours),
            pass: ours <= limit,
            basis: Basis::Own,
        }
    }

    /// `ours ≥ limit`.
    pub fn at_least(claim: impl Into<String>, limit: f64, ours: f64) -> Self {
        Self {
            claim: claim.into(),
            expected: format!("≥ {}", format_real(limit)),
            ours: format_real(ours),
            pass: ours >= limit,
            basis: Basis::Own,
        }
    }

    /// Whole numbers that must agree.
    pub fn equal(claim: impl Into<String>, expected: usize, ours: usize) -> Self {
        Self {
            claim: claim.into(),
            expected: expected.to_string(),
            ours: ours.to_string(),
            pass: expected == ours,
            basis: Basis::Own,
        }
    }

    /// Anything else that can be true or false.
    pub fn holds(
        claim: impl Into<String>,
        expected: impl Into<String>,
        ours: impl Into<String>,
        pass: bool,
    ) -> Self {
        Self {
            claim: claim.into(),
            expected: expected.into(),
            ours: ours.into(),
            pass,
            basis: Basis::Own,
        }
    }
}
