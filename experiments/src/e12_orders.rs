//! e12: observed orders of slip, opening, traction and energy around crack tips.

use crate::crack::{Family, Profile, Strip, between, fitted};
use crate::e10_inclined_crack as inclined;
use crate::e11_pressurised_cracks as pressurised;
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// With which order do the fields on a crack converge, and what do its tips do to it?
#[derive(Debug)]
pub struct ObservedOrders;

/// Shares of the length left out at each tip.
const SHARES: [f64; 3] = [0.0, 0.1, 0.15];

/// Row of [`Measured::errors`] without 10 % at each tip.
const TEN_PERCENT: usize = 1;

/// A field whose error is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Field {
    Slip,
    Traction,
    Opening,
}

impl Field {
    const ALL: [Self; 3] = [Self::Slip, Self::Traction, Self::Opening];

    fn name(self) -> &'static str {
        match self {
            Self::Slip => "slip",
            Self::Traction => "normal traction",
            Self::Opening => "opening",
        }
    }

    fn value(self, strip: &Strip) -> f64 {
        match self {
            Self::Slip => inclined::slip(strip),
            Self::Traction => inclined::normal(strip),
            Self::Opening => pressurised::opening(strip),
        }
    }

    fn exact(self, strip: &Strip) -> f64 {
        match self {
            Self::Slip => inclined::exact_slip(strip),
            Self::Traction => inclined::exact().normal_traction(),
            Self::Opening => pressurised::exact_opening(strip),
        }
    }

    /// Relative L2 errors for the shares of [`SHARES`].
    fn errors(self, profile: &Profile) -> [f64; 3] {
        SHARES.map(|share| profile.relative_error(share, |s| self.value(s), |s| self.exact(s)))
    }
}

/// Both cracks on one mesh.
struct Measured {
    family: Family,
    /// Longest face over the half-length.
    h: f64,
    faces: usize,
    n_u: usize,
    /// Slip, traction, opening.
    errors: [[f64; 3]; 3],
    /// `√(1 − V_h/V)` of the line crack: the error in the energy norm over the energy norm.
    energy: f64,
}

impl Measured {
    fn new(family: Family, observer: &mut dyn Observer) -> anyhow::Result<Self> {
        let (sliding, slid) = inclined::solve(family, observer)?;
        let (_, opened) = pressurised::solve_line(family, observer)?;
        let volume = opened.integral(pressurised::opening) / pressurised::exact_line().volume();
        Ok(Self {
            family,
            h: slid.largest_face(),
            faces: slid.row().count(),
            n_u: sliding.n_u,
            errors: [
                Field::Slip.errors(&slid),
                Field::Traction.errors(&slid),
                Field::Opening.errors(&opened),
            ],
            energy: (1.0 - volume).abs().sqrt(),
        })
    }
}

/// Errors of one field over the meshes of one family.
fn column(rows: &[&Measured], field: usize, share: usize) -> Vec<f64> {
    rows.iter().map(|r| r.errors[field][share]).collect()
}

fn error_table(rows: &[Measured]) -> Table {
    let mut table = Table::new(
        "e12_errors",
        "Relative errors in L2 over all faces, and without 10 % and 15 % of the length at each tip; the line crack's error in \
         the energy norm.",
        &[
            "family",
            "h/b",
            "faces",
            "n_u",
            "slip",
            "slip, 10 %",
            "slip, 15 %",
            "t_N",
            "t_N, 10 %",
            "t_N, 15 %",
            "opening",
            "opening, 10 %",
            "opening, 15 %",
            "energy norm",
        ],
    );
    for row in rows {
        let [slip, traction, opening] = row.errors;
        table.push([
            row.family.name().into(),
            row.h.into(),
            row.faces.into(),
            row.n_u.into(),
            slip[0].into(),
            slip[1].into(),
            slip[2].into(),
            traction[0].into(),
            traction[1].into(),
            traction[2].into(),
            opening[0].into(),
            opening[1].into(),
            opening[2].into(),
            row.energy.into(),
        ]);
    }
    table
}

/// Orders between the last two meshes and of the least-squares line.
fn order_cells(family: &str, field: &str, share: Cell, h: &[f64], errors: &[f64]) -> [Cell; 5] {
    let last = between(h, errors).last().copied();
    [
        family.into(),
        field.into(),
        share,
        last.into(),
        fitted(h, errors).into(),
    ]
}

fn figure(family: &str, rows: &[&Measured]) -> Figure {
    let h: Vec<f64> = rows.iter().map(|r| r.h).collect();
    let mut figure = Figure::new(
        &format!("e12_{family}"),
        "",
        &format!(
            "Relative errors on the {family} meshes without 10 % of the length at each tip, and the error in the energy norm."
        ),
        Axis::log("longest face / half-length"),
        Axis::log("relative error"),
    );
    let mut add = |name: &str, errors: &[f64]| {
        let points = h.iter().zip(errors).map(|(h, e)| [*h, *e]).collect();
        figure
            .series
            .push(Series::new(name, Mark::LinePoints, points));
    };
    for (k, field) in Field::ALL.into_iter().enumerate() {
        add(field.name(), &column(rows, k, TEN_PERCENT));
    }
    let energy: Vec<f64> = rows.iter().map(|r| r.energy).collect();
    add("energy norm", &energy);
    let opening = column(rows, 2, TEN_PERCENT);
    match (h.last(), opening.last()) {
        (Some(h), Some(e)) => {
            figure.slope(if family == "graded" { 2.0 } else { 1.0 }, [*h, 0.6 * e])
        }
        _ => figure,
    }
}

impl Experiment for ObservedOrders {
    fn id(&self) -> &'static str {
        "e12"
    }

    fn title(&self) -> &'static str {
        "Orders of convergence on cracks"
    }

    fn question(&self) -> &'static str {
        "With which order do slip, opening, traction and energy converge, with and without the tips?"
    }

    fn setup(&self) -> &'static str {
        "Scenes inclined_crack (slip, t_N) and line_crack (opening, energy) on two families of meshes: uniform, n equal faces \
         along the crack; graded, cells of s²/2 at the tips that grow by e^s per cell. h is the longest face over the \
         half-length. Orders between the two finest meshes, and of the least-squares line over all of them. \
         Energy: ‖u − u_h‖²/‖u‖² = 1 − V_h/V for the line crack, V its volume."
    }

    fn expect(&self) -> &'static str {
        "The displacement has a term √r at the tips. On uniform meshes that limits the energy norm to h^½ and, through \
         pollution, slip and opening to h away from the tips as well (derived). On graded meshes the tips cost nothing: \
         order 1 in energy, 2 in slip and opening, at least 1 in traction away from the tips. A good peer reports about 1.7 \
         for slip without 10 % tips."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let (faces, steps): (&[usize], &[f64]) = match level {
            Level::Smoke => (&[4, 6, 8, 12], &[0.84, 0.6, 0.42, 0.3]),
            Level::Paper => (&[8, 16, 32, 64], &[0.6, 0.42, 0.3, 0.21, 0.15]),
        };
        let mut findings = Findings::default();
        findings
            .set("uniform", faces.to_vec())
            .set("graded", steps.to_vec());
        let uniform = faces.iter().map(|n| Family::Uniform(*n));
        let families: Vec<Family> = uniform
            .chain(steps.iter().map(|s| Family::Graded(*s)))
            .collect();
        let mut rows = Vec::new();
        for (k, family) in families.iter().enumerate() {
            let step = Step::Progress {
                stage: "meshes",
                done: k,
                total: families.len(),
            };
            if observer.observe(&step) == ControlFlow::Break(()) {
                anyhow::bail!("stopped on request");
            }
            rows.push(Measured::new(*family, observer)?);
        }
        let mut orders = Table::new(
            "e12_orders",
            "Observed orders.",
            &[
                "family",
                "field",
                "without tips [%]",
                "finest two",
                "fitted",
            ],
        );
        for family in ["uniform", "graded"] {
            let own: Vec<&Measured> = rows.iter().filter(|r| r.family.name() == family).collect();
            let h: Vec<f64> = own.iter().map(|r| r.h).collect();
            for (k, field) in Field::ALL.into_iter().enumerate() {
                for (j, share) in SHARES.into_iter().enumerate() {
                    let errors = column(&own, k, j);
                    let without = Cell::Real(100.0 * share);
                    orders.push(order_cells(family, field.name(), without, &h, &errors));
                }
                let order = fitted(&h, &column(&own, k, TEN_PERCENT));
                let least = match (family, field) {
                    ("graded", Field::Traction) => Some(1.0),
                    ("graded", _) => Some(1.5),
                    // the errors of t_N on uniform meshes change sign on the way
                    (_, Field::Traction) => None,
                    _ => Some(0.9),
                };
                if let Some(least) = least {
                    let claim =
                        format!("{family}: order of the {} without 10 % tips", field.name());
                    findings.checks.push(Check::at_least(claim, least, order));
                }
            }
            let energy: Vec<f64> = own.iter().map(|r| r.energy).collect();
            orders.push(order_cells(
                family,
                "energy norm",
                Cell::Missing,
                &h,
                &energy,
            ));
            let least = if family == "graded" { 0.8 } else { 0.45 };
            findings.checks.push(Check::at_least(
                format!("{family}: order in the energy norm"),
                least,
                fitted(&h, &energy),
            ));
            findings.figures.push(figure(family, &own));
        }
        findings.notes.push(
            "With its tips the error of t_N falls on neither family: the last faces before a tip are wrong by as much as they \
             carry on every mesh, and open where their traction would pull."
                .into(),
        );
        findings.tables.push(error_table(&rows));
        findings.tables.push(orders);
        Ok(findings)
    }
}
