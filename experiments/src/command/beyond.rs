//! `--pseudospectra`, `--certify`: what `spectrum` says beyond eigenvalues.

use clap::{Args, ValueEnum};
use fracas_solvers::spectrum::{
    Enclosures, InnerProduct, NonNormal, NonNormalRequest, SpectrumReport,
};

/// What is asked for beyond eigenvalues.
#[derive(Args, Debug)]
pub(super) struct Beyond {
    /// Pseudospectra and field of values of M⁻¹𝒜 and the residuals of GMRES that they allow, up to 2,000 unknowns; `=euclidean` takes
    /// the unknowns as they are in place of the energies in which errors are judged.
    #[arg(long, value_name = "INNER_PRODUCT", num_args = 0..=1, require_equals = true, default_missing_value = "energy")]
    pseudospectra: Option<InnerProductName>,
    /// Abscissas of the grid of pseudospectra.
    #[arg(long, value_name = "N", default_value_t = NonNormalRequest::default().points, requires = "pseudospectra", value_parser = points)]
    grid: usize,
    /// Proves, rounding included, where the ends of the spectrum lie and that it lies within its bounds; needs explicit blocks of M
    /// (--inner exact, H not relaxed), up to 2,000 unknowns.
    #[arg(long)]
    pub(super) certify: bool,
}

/// `--pseudospectra`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum InnerProductName {
    Energy,
    Euclidean,
}

fn points(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n @ 2..=1000) => Ok(n),
        _ => Err("a grid has 2 to 1000 abscissas".into()),
    }
}

impl Beyond {
    pub(super) fn non_normal(&self) -> Option<NonNormalRequest> {
        self.pseudospectra.map(|name| NonNormalRequest {
            inner_product: match name {
                InnerProductName::Energy => InnerProduct::Energy,
                InnerProductName::Euclidean => InnerProduct::Euclidean,
            },
            points: self.grid,
        })
    }
}

/// A line for each answer.
pub(super) fn lines(report: &SpectrumReport) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if let Some(found) = &report.non_normal {
        lines.extend(of_non_normal(found));
    }
    if let Some(enclosures) = &report.enclosures {
        lines.push(("certified", certified(report, enclosures)));
    }
    lines
}

fn of_non_normal(found: &NonNormal) -> [(&'static str, String); 4] {
    let field = &found.field_of_values;
    let end = |values: &[f64]| values.iter().fold(f64::NEG_INFINITY, |m: f64, v| m.max(*v));
    let steps = |steps: Option<usize>| steps.map_or("–".to_owned(), |n| n.to_string());
    let [measured, resolvent, by_field] = found.gmres.steps;
    [
        ("inner product", found.inner_product.to_owned()),
        (
            "departure",
            format!("{:.3e} of ‖T‖_F from normal", found.departure),
        ),
        (
            "field of values",
            format!(
                "Re in [{:.6e}, {:.6e}], |Im| ≤ {:.6e}, zero {}",
                found.gmres.coercivity,
                field.support[0],
                end(&field.im),
                if field.excludes_zero {
                    "outside"
                } else {
                    "not proved to be outside"
                }
            ),
        ),
        (
            "GMRES to 1e-8",
            format!(
                "{} steps; at most {} by the resolvent, {} by the field of values",
                steps(measured),
                steps(resolvent),
                steps(by_field)
            ),
        ),
    ]
}

fn certified(report: &SpectrumReport, found: &Enclosures) -> String {
    let interval = |ends: Option<(f64, f64)>| {
        ends.map_or("–".to_owned(), |(a, b)| format!("[{a:.12e}, {b:.12e}]"))
    };
    let word = if report.certified { "yes" } else { "no" };
    let contained = match found.contained {
        Some(true) => "; all eigenvalues lie within the bounds, to 1e-7",
        Some(false) => "; that all lie within the bounds is not proved",
        None => "",
    };
    let im = match found.im_max {
        Some(im) if im > 0.0 => format!(", |Im λ| ≤ {im:.6e}"),
        _ => String::new(),
    };
    let why = found
        .reason
        .as_ref()
        .map_or(String::new(), |why| format!("; {why}"));
    format!(
        "{word}: smallest real in {}, largest in {}{im}{contained}{why}; {}",
        interval(found.real_min),
        interval(found.real_max),
        found.statement
    )
}
