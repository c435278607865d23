//! `fracas spectrum`: eigenvalues of M⁻¹𝒜, what is proved about them, and whether it holds.

use super::beyond::{self, Beyond};
use super::method::Method;
use super::modes::Modes;
use super::progress::Progress;
use super::source::Source;
use super::{Status, output};
use clap::Args;
use fracas::solve::{inf_sup, spectrum, spectrum_method};
use fracas_figures as plot;
use fracas_solvers::Observer;
use fracas_solvers::saddle::SaddleMethod;
use fracas_solvers::spectrum::{Certificate, Part, SpectrumReport, SpectrumRequest};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
pub(super) struct Spectrum {
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    method: Method,
    /// Largest dense eigenvalue problem; above it only outer eigenvalues are found.
    #[arg(long, value_name = "N", default_value_t = SpectrumRequest::default().dense_limit)]
    dense_limit: usize,
    #[command(flatten)]
    modes: Modes,
    #[command(flatten)]
    beyond: Beyond,
    /// Report as JSON; `-` writes it to standard output, in place of the lines.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Figure of the eigenvalues, SVG or PDF; its numbers go into a CSV file beside it, and with --pseudospectra GMRES and its bounds into NAME_gmres.svg.
    #[arg(long, value_name = "FILE.svg", value_parser = drawable)]
    plot: Option<PathBuf>,
}

fn drawable(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match ["svg", "pdf"].iter().any(|end| has_end(&path, end)) {
        true => Ok(path),
        false => Err("figures are SVG or PDF: let the name end in .svg or .pdf".into()),
    }
}

fn has_end(path: &Path, end: &str) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(end))
}

impl Spectrum {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let problem = self.source.problem()?;
        let (method, rule) = self.method.of(SaddleMethod::default())?;
        let method = spectrum_method(&problem, &method, rule, "spectrum")?;
        let of_gmres = (self.plot.as_deref())
            .filter(|_| self.beyond.non_normal().is_some())
            .map(beside);
        output::try_files(self.json.iter().chain(&self.plot).chain(&of_gmres))?;
        let mut progress = Progress::new();
        let system = self.source.load(&mut progress)?;
        let request = SpectrumRequest {
            dense_limit: self.dense_limit,
            modes: self.modes.modes.clone(),
            non_normal: self.beyond.non_normal(),
            certify: self.beyond.certify,
            ..SpectrumRequest::default()
        };
        let report = spectrum(&problem, &system, &method, &request, &mut progress)?;
        let certificate = inf_sup(&problem, &system)?;
        for note in &report.notes {
            progress.say(&format_args!("note: {note}"));
        }
        drop(progress);
        if let Some(path) = &self.plot {
            let spectrum = plot::Spectrum::from(&report);
            draw(path, &spectrum.figure("spectrum"))?;
            if let Some(gmres) = &spectrum.gmres {
                draw(
                    &beside(path),
                    &gmres.figure("gmres", &report.preconditioner),
                )?;
            }
        }
        let whole = WithCertificate {
            report: &report,
            inf_sup: certificate,
        };
        if let Some(path) = &self.json {
            output::json(path, &self.source.origin().of(&whole), out)?;
        }
        if !output::is_standard(&self.json) {
            print(&report, certificate, out)?;
        }
        self.modes.write(&system, &report)?;
        if let (Some(_), None) = (&request.non_normal, &report.non_normal) {
            let why = report.notes.last().map_or("", String::as_str);
            anyhow::bail!("{why}");
        }
        Ok(if report.contained == Some(false) {
            Status::CheckFailed
        } else {
            Status::Done
        })
    }
}

fn draw(path: &Path, figure: &plot::Figure) -> anyhow::Result<()> {
    match has_end(path, "pdf") {
        true => output::file(path, &figure.to_pdf()?)?,
        false => output::file(path, &figure.to_svg()?)?,
    }
    output::file(&path.with_extension("csv"), &figure.to_csv())
}

/// `NAME_gmres.svg` beside `NAME.svg`.
fn beside(path: &Path) -> PathBuf {
    let [name, end] = [path.file_stem(), path.extension()];
    let [name, end] = [name, end].map(|part| part.unwrap_or_default().to_string_lossy());
    path.with_file_name(format!("{name}_gmres.{end}"))
}

/// `a, b, c`, or that there is nothing.
fn list_or_none(items: &[String]) -> String {
    if items.is_empty() {
        "none".to_owned()
    } else {
        items.join(", ")
    }
}

/// δ, Δ and η.
fn quality(report: &SpectrumReport) -> String {
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.6e}"));
    format!(
        "[{}, {}], ≤ {}",
        number(report.delta),
        number(report.Delta),
        number(report.eta)
    )
}

/// The report with what is proved of the inf-sup constant.
#[derive(Serialize)]
struct WithCertificate<'a> {
    #[serde(flatten)]
    report: &'a SpectrumReport,
    inf_sup: Option<Certificate>,
}

/// A statement in words.
fn in_words(part: &Part) -> String {
    match part {
        Part::Interval { low, high } => format!("real [{low:.6e}, {high:.6e}]"),
        Part::Box { im_max: 0.0, .. } => "none complex".to_owned(),
        Part::Box {
            re_low,
            re_high,
            im_max,
        } => format!("complex [{re_low:.6e}, {re_high:.6e}] ± {im_max:.6e} i"),
        Part::Disc { low, high } => format!("in the disc over [{low:.6e}, {high:.6e}]"),
        Part::OutsideDisc { low, high } => {
            format!("outside of the disc over [{low:.6e}, {high:.6e}]")
        }
        Part::HalfPlane { low } => format!("right of {low:.6e}"),
        Part::AnyOf { parts } if parts.len() <= 2 => {
            let each: Vec<String> = parts.iter().map(in_words).collect();
            each.join(" or ")
        }
        Part::AnyOf { parts } => format!("in one of {} circles (JSON)", parts.len()),
    }
}

fn print(
    report: &SpectrumReport,
    certificate: Option<Certificate>,
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.6e}"));
    let range =
        |low: Option<f64>, high: Option<f64>| format!("[{}, {}]", number(low), number(high));
    let parts: Vec<String> = report.region.parts().iter().map(in_words).collect();
    let theorem = match parts.is_empty() {
        true => "none applies".to_owned(),
        false => parts.join(", "),
    };
    let hypotheses: Vec<String> = (report.hypotheses.iter())
        .map(|h| {
            let holds = match h.holds {
                Some(true) => "holds",
                Some(false) => "FAILS",
                None => "not checked",
            };
            format!("{} {holds}", h.statement)
        })
        .collect();
    let lines = [
        ("method", report.preconditioner.clone()),
        (
            "C",
            if report.c_min.is_nan() {
                report.augmentation.clone()
            } else {
                format!(
                    "{}, eigenvalues {}",
                    report.augmentation,
                    range(Some(report.c_min), Some(report.c_max))
                )
            },
        ),
        ("inner", report.inner.clone()),
        (
            "cond A",
            report.kernel_A.map_or_else(
                || number(report.cond_A),
                |k| format!("singular, kernel of dimension {k}"),
            ),
        ),
        ("cond S_u", number(report.cond_S_u)),
        ("real eigenvalues", range(report.real_min, report.real_max)),
        ("Re λ", range(report.re_min, report.re_max)),
        (
            "|Im λ|",
            format!("≤ {}, {} non-real", number(report.im_max), report.n_complex),
        ),
        (
            "at 1, at ½",
            format!("{}, {}", report.n_at_one, report.n_at_half),
        ),
        ("S_u~^-1 S_u, C^-1 H", quality(report)),
        (
            "inf-sup",
            certificate.map_or_else(
                || "not stated".to_owned(),
                |c| format!("β² ≥ {:.6e} (local certificate)", c.beta_squared),
            ),
        ),
        ("hypotheses", list_or_none(&hypotheses)),
        ("bounds", theorem),
        ("verdict", report.verdict.clone()),
    ];
    let lines: Vec<_> = lines.into_iter().chain(beyond::lines(report)).collect();
    output::pairs(out, &lines)?;
    for mode in &report.modes {
        let (re, im) = mode.eigenvalue;
        writeln!(
            out,
            "mode              λ = {re:.6e} {im:+.6e} i, {:.1} % of the energy in t{}, residual {:.1e}",
            100.0 * mode.traction_share,
            mode.pressure_share
                .map_or_else(String::new, |p| format!(", {:.1} % in p", 100.0 * p)),
            mode.residual
        )?;
    }
    Ok(())
}
