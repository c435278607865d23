//! What a row can measure, by name.

use super::solving::Measured;
use fracas_solvers::spectrum::SpectrumReport;
use serde::{Deserialize, Serialize};

macro_rules! measures {
    ($($variant:ident $name:literal $label:literal;)*) => {
        /// A measure; the name is that in study files and in `rows.csv`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[allow(missing_docs, reason = "the label says it")]
        pub enum Name {
            $(#[serde(rename = $name)] $variant,)*
        }

        impl Name {
            /// All of them: those of a solve first, then those of a spectrum.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// As it is written.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }

            /// For axes of figures, with its unit.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$variant => $label),* }
            }
        }
    };
}

measures! {
    N "n" "unknowns n";
    DisplacementUnknowns "n_u" "displacement unknowns n_u";
    TractionUnknowns "n_t" "traction unknowns n_t";
    Iterations "n_it" "iterations n_it";
    Application "c_app" "cost of M⁻¹ over that of 𝒜, c_app";
    Cost "C_s" "cost C_s [products with 𝒜]";
    SetUp "setup_s" "set-up [s]";
    Solve "solve_s" "iteration [s]";
    Memory "memory" "peak memory [MiB]";
    ErrorU "error_u" "error of u, relative";
    ErrorT "error_t" "error of t, relative";
    Levels "levels" "levels of multigrid";
    ConditionA "cond_A" "κ(A)";
    ConditionSu "cond_S_u" "κ(S_u)";
    RealMin "real_min" "smallest real eigenvalue";
    RealMax "real_max" "largest real eigenvalue";
    ReMin "re_min" "smallest Re λ";
    ReMax "re_max" "largest Re λ";
    ImMax "im_max" "largest |Im λ|";
    Contained "contained" "inside the proved regions";
}

impl Name {
    /// True for what takes eigenvalues.
    pub fn is_spectral(self) -> bool {
        self >= Self::ConditionA
    }

    /// True for what the clock or the system tells, and no second run repeats.
    pub fn is_measured(self) -> bool {
        matches!(self, Self::SetUp | Self::Solve | Self::Memory)
    }

    /// The value of a row as a field of `rows.csv`; empty where there is none.
    pub(super) fn field(self, measured: &Measured) -> String {
        if self == Self::Contained {
            let contained = measured.spectrum.as_ref().and_then(|s| s.contained);
            return contained.map_or(String::new(), |inside| {
                if inside { "yes" } else { "no" }.into()
            });
        }
        let value = match &measured.spectrum {
            Some(report) if self.is_spectral() => self.of_spectrum(report),
            _ => self.of_solve(measured),
        };
        let value = value.filter(|v| v.is_finite());
        value.map_or(String::new(), number)
    }

    fn of_spectrum(self, report: &SpectrumReport) -> Option<f64> {
        match self {
            Self::ConditionA => report.cond_A,
            Self::ConditionSu => report.cond_S_u,
            Self::RealMin => report.real_min,
            Self::RealMax => report.real_max,
            Self::ReMin => report.re_min,
            Self::ReMax => report.re_max,
            Self::ImMax => report.im_max,
            _ => None,
        }
    }

    fn of_solve(self, measured: &Measured) -> Option<f64> {
        let solved = measured.solved.as_ref()?;
        let count = |n: usize| Some(n as f64);
        let [error_u, error_t] = match measured.errors {
            Some(errors) => errors.map(Some),
            None => [solved.error_u, solved.error_t],
        };
        match self {
            Self::N => count(solved.n_u + solved.n_t + solved.n_p),
            Self::DisplacementUnknowns => count(solved.n_u),
            Self::TractionUnknowns => count(solved.n_t),
            Self::Iterations => solved
                .has_converged()
                .then_some(solved.iterations)
                .and_then(count),
            Self::Application => Some(solved.c_app),
            Self::Cost => solved.c_s,
            Self::SetUp => Some(solved.setup_s),
            Self::Solve => Some(solved.solve_s),
            Self::Memory => solved
                .peak_memory_bytes
                .map(|bytes| bytes as f64 / f64::from(1 << 20)),
            Self::ErrorU => error_u,
            Self::ErrorT => error_t,
            Self::Levels => solved.amg.as_ref().and_then(|amg| count(amg.levels.len())),
            _ => None,
        }
    }
}

/// The shortest digits that read back as the same number.
pub(super) fn number(value: f64) -> String {
    match value.fract() == 0.0 && value.abs() < 1e15 {
        true => format!("{value}"),
        false => format!("{value:?}"),
    }
}
