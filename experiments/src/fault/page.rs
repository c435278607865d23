//! Curves, profiles and quantiles as figures and tables.

use super::curve::height;
use super::{Curve, FaultFile, Sampled};
use crate::report::{Findings, Table};
use fracas_figures::{Axis, Figure, Mark, Series};

/// Pascals in a megapascal, metres in a millimetre.
const MEGA: f64 = 1e6;
const MILLI: f64 = 1e-3;

/// Everything that a page shows.
///
/// # Errors
/// Settings that do not print as JSON.
pub fn findings(
    file: &FaultFile,
    curve: &Curve,
    sampled: Option<&Sampled>,
) -> anyhow::Result<Findings> {
    let mut findings = Findings::default();
    if let serde_json::Value::Object(settings) = serde_json::to_value(file)? {
        findings.settings = settings;
    }
    findings.figures = vec![growth(curve), slip(curve), shear(curve)];
    findings.tables.push(points(curve));
    findings.tables.push(profiles(curve));
    if let Some(sampled) = sampled {
        findings.figures.push(share(file, sampled));
        findings.tables.push(quantiles(sampled));
        findings.notes.extend(sampled.left_out());
    }
    findings.notes.push(
        "Shear traction is singular at the corners of the blocks: the first slip and the largest criticality move with the \
         logarithm of the length of the elements; lengths and sums do not."
            .into(),
    );
    Ok(findings)
}

fn growth(curve: &Curve) -> Figure {
    let of = |y: fn(&super::Point) -> f64| {
        (curve.points.iter())
            .map(|p| [p.change / MEGA, y(p)])
            .collect()
    };
    Figure::new(
        "length",
        "",
        "Length of the fault that slides, and its longest piece without a gap, over the change of pressure.",
        Axis::linear("change of pressure [MPa]"),
        Axis::linear("length [m]"),
    )
    .with(Series::new("all that slides", Mark::Line, of(|p| p.length)))
    .with(Series::new("longest piece", Mark::Dashed, of(|p| p.patch)))
}

/// A curve per state that was kept, over heights.
fn over_height(curve: &Curve, figure: Figure, value: impl Fn(usize, usize) -> f64) -> Figure {
    let states = curve.states.iter().enumerate();
    states.fold(figure, |figure, (k, (change, _))| {
        let points = (0..curve.fault.along.len())
            .map(|i| [value(k, i), height(&curve.fault, i)])
            .collect();
        let name = format!("{:.3} MPa", change / MEGA);
        figure.with(Series::new(&name, Mark::Line, points))
    })
}

fn slip(curve: &Curve) -> Figure {
    let figure = Figure::new(
        "slip",
        "",
        "Slip along the fault at some changes of pressure.",
        Axis::linear("slip [mm]"),
        Axis::linear("height [m]"),
    );
    over_height(curve, figure, |k, i| curve.states[k].1.slip[i] / MILLI)
}

fn shear(curve: &Curve) -> Figure {
    let figure = Figure::new(
        "shear",
        "",
        "Shear traction along the fault at the same changes of pressure.",
        Axis::linear("shear traction [MPa]"),
        Axis::linear("height [m]"),
    );
    over_height(curve, figure, |k, i| curve.states[k].1.shear[i] / MEGA)
}

fn points(curve: &Curve) -> Table {
    let mut table = Table::new(
        "curve",
        "A row per step of the pressure; the last row of a fault that runs away is its last stable state.",
        &[
            "pressure_change [Pa]",
            "slipping_length [m]",
            "longest_patch [m]",
            "slip_max [m]",
            "slip_integral [m^2]",
            "moment_per_strike [N]",
            "chi_max",
            "elements_in_tension",
        ],
    );
    for p in &curve.points {
        table.push([
            p.change.into(),
            p.length.into(),
            p.patch.into(),
            p.slip.into(),
            p.integral.into(),
            p.moment.into(),
            p.criticality.into(),
            p.open.into(),
        ]);
    }
    table
}

fn profiles(curve: &Curve) -> Table {
    let mut table = Table::new(
        "profiles",
        "The fault at the changes of pressure of the figures.",
        &[
            "pressure_change [Pa]",
            "height [m]",
            "slip [m]",
            "shear [Pa]",
            "effective_normal [Pa]",
            "chi",
        ],
    );
    for (change, state) in &curve.states {
        for i in 0..state.slip.len() {
            table.push([
                (*change).into(),
                height(&curve.fault, i).into(),
                state.slip[i].into(),
                state.shear[i].into(),
                state.normal[i].into(),
                state.criticality[i].into(),
            ]);
        }
    }
    table
}

/// Changes of pressure at which the share of samples is drawn.
const SHARES: usize = 60;

fn share(file: &FaultFile, sampled: &Sampled) -> Figure {
    let points = (0..=SHARES)
        .map(|k| {
            let change = file.change() * k as f64 / SHARES as f64;
            [change / MEGA, sampled.share_before(change)]
        })
        .collect();
    Figure::new(
        "runaway",
        "",
        "Share of the samples in which slip has run away, over the change of pressure.",
        Axis::linear("change of pressure [MPa]"),
        Axis::linear("share of samples"),
    )
    .with(Series::new("", Mark::Line, points))
}

fn quantiles(sampled: &Sampled) -> Table {
    let mut table = Table::new(
        "quantiles",
        "At the whole change of pressure, or where slip runs away before it.",
        &["quantile", "slipping_length [m]", "moment_per_strike [N]"],
    );
    for q in [0.05, 0.25, 0.5, 0.75, 0.95] {
        table.push([
            q.into(),
            sampled.quantile(q, |s| s.length).into(),
            sampled.quantile(q, |s| s.moment).into(),
        ]);
    }
    table
}
