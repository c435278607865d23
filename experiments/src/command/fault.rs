//! `fracas fault`: slip of a displaced fault without a mesh.

use super::{Status, output};
use crate::fault::{FaultFile, MOST_ELEMENTS, curve, findings, sample};
use crate::report::{Formats, Sheet};
use anyhow::Context;
use clap::Args;
use fracas::analytic::RESOLVED;
use fracas_solvers::words::by_number;
use std::io::Write;
use std::path::PathBuf;

/// Semi-analytic slip of a displaced fault, without a mesh.
#[derive(Args, Debug)]
pub(super) struct Fault {
    /// Fault file (TOML).
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Folder of the page, its figures and tables; without it only lines are printed.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Fault {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let file = FaultFile::load(&self.file)?;
        let curve = curve(&file).with_context(|| self.file.display().to_string())?;
        if let Some(folder) = &self.out {
            output::folder(folder)?;
        }
        let sampled = (file.sampling.as_ref())
            .map(|sampling| sample(&file, sampling))
            .transpose()?;
        let mega = |pascals: f64| format!("{:.4} MPa", pascals / 1e6);
        let mut rows = vec![("fault", file.title.clone())];
        let first = curve.points.iter().find(|p| p.length > 0.0);
        rows.push((
            "slips",
            match (first, &curve.runaway) {
                (Some(p), _) => format!(
                    "at a change of {} for the first time in these steps",
                    mega(p.change)
                ),
                // the first slip is that which runs away
                (None, Some(at)) => format!("not before a change of {}", mega(at.change)),
                (None, None) => "nowhere".into(),
            },
        ));
        rows.push((
            "runs away",
            match curve.runaway {
                Some(at) => format!(
                    "at a change of {}, between heights of {:.1} m and {:.1} m",
                    mega(at.change),
                    at.heights[0],
                    at.heights[1]
                ),
                None => "nowhere".into(),
            },
        ));
        if curve.nucleation.is_finite() {
            rows.push((
                "nucleation",
                format!(
                    "half-length {:.2} m where the fault is pressed most; elements are {:.2} m long",
                    curve.nucleation, curve.fault.h
                ),
            ));
        }
        if curve.fault.h > RESOLVED * curve.nucleation {
            let wanted =
                curve.fault.along.len() as f64 * curve.fault.h / (RESOLVED * curve.nucleation);
            let advice = match wanted.ceil() <= MOST_ELEMENTS as f64 {
                true => format!("take fault.elements = {}", wanted.ceil()),
                false => format!(
                    "{:.0} would, and fault.elements goes up to {MOST_ELEMENTS}: look at a shorter part of the fault",
                    wanted.ceil()
                ),
            };
            rows.push((
                "note",
                format!(
                    "elements of {:.2} m do not resolve that length, so that where slip runs away depends on them: {advice}",
                    curve.fault.h
                ),
            ));
        }
        if let Some(last) = curve.points.last() {
            rows.push((
                "in the end",
                format!(
                    "change {}: {:.1} m slide by up to {:.3} mm, ∫|δ| = {:.4e} m^2, moment {:.4e} N per metre of strike",
                    mega(last.change),
                    last.length,
                    1e3 * last.slip,
                    last.integral,
                    last.moment
                ),
            ));
            if last.open > 0 {
                rows.push((
                    "note",
                    format!(
                        "{} {} in tension: what would open carries its cohesion here",
                        last.open,
                        by_number(last.open, "element is", "elements are")
                    ),
                ));
            }
        }
        if let Some(sampled) = &sampled {
            rows.push((
                "samples",
                match sampled.samples.len() {
                    0 => "none is left of those that were drawn".into(),
                    left => format!(
                        "{left}: slip runs away in {:.1} %",
                        100.0 * sampled.share_before(f64::INFINITY)
                    ),
                },
            ));
            rows.extend(sampled.left_out().into_iter().map(|why| ("note", why)));
        }
        output::pairs(out, &rows)?;
        if let Some(folder) = &self.out {
            let findings = findings(&file, &curve, sampled.as_ref())?;
            let sheet = Sheet {
                title: &file.title,
                lead: "Slip of a straight fault in a homogeneous full space, plane strain; stress of the depleting blocks in closed form.",
                findings: &findings,
            };
            sheet.write(folder, Formats::default())?;
            writeln!(out, "{}", folder.join("report.html").display())?;
        }
        Ok(Status::Done)
    }
}
