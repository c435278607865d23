//! e11: a line crack and a penny crack opened by pressure.

use crate::crack::{Answer, CrackScene, Family, LINE, PENNY, Profile, Strip};
use crate::report::{Check, Experiment, Findings, Level, Table};
use fracas::analytic::{LineCrack, PennyCrack, Rock};
use fracas::contact::ContactState;
use fracas::scene::Body;
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Do pressurised cracks open as Sneddon's?
#[derive(Debug)]
pub struct PressurisedCracks;

/// The rock of both scenes.
const ROCK: Rock = Rock {
    young: 25e9,
    poisson: 0.25,
};

/// Pressure of both scenes [Pa].
const PRESSURE: f64 = 2e6;

/// Share of the length that is left out at each tip.
const TIP: f64 = 0.1;

/// The closed form of the scene `line_crack`.
pub fn exact_line() -> LineCrack {
    LineCrack {
        rock: ROCK,
        half_length: 1.0,
        pressure: PRESSURE,
    }
}

/// The closed form of the scene `penny_crack`.
fn exact_penny() -> PennyCrack {
    PennyCrack {
        rock: ROCK,
        radius: 1.0,
        pressure: PRESSURE,
    }
}

/// The line crack on a mesh.
///
/// # Errors
/// A mesh that cannot be made or a step that fails.
pub fn solve_line(
    family: Family,
    observer: &mut dyn Observer,
) -> anyhow::Result<(Answer, Profile)> {
    let body = LINE.body(family)?;
    let answer = Answer::of(&body, observer)?;
    let profile = Profile::new(&body, &answer, [1.0, 0.0, 0.0], 1.0);
    Ok((answer, profile))
}

/// g_N of a face [m].
pub fn opening(strip: &Strip) -> f64 {
    strip.jump[0]
}

/// Mean opening of the closed form over a face [m].
pub fn exact_opening(strip: &Strip) -> f64 {
    exact_line().mean_opening(strip.span[0], strip.span[1])
}

/// A crack on one mesh.
struct Row {
    crack: &'static str,
    s: f64,
    faces: usize,
    answer: Answer,
    /// Opening in the middle, volume, over those of the closed form.
    peak: f64,
    volume: f64,
    /// Opening in L2 without the tips.
    l2: f64,
    /// (distance from the middle [m], opening [m]).
    points: Vec<[f64; 2]>,
}

impl Row {
    fn line(s: f64, observer: &mut dyn Observer) -> anyhow::Result<Self> {
        let (answer, profile) = solve_line(Family::Graded(s), observer)?;
        let middle = profile.central().map(|f| opening(f) / exact_opening(f));
        Ok(Self {
            crack: "line",
            s,
            faces: profile.row().count(),
            answer,
            peak: middle.unwrap_or(f64::NAN),
            volume: profile.integral(opening) / exact_line().volume(),
            l2: profile.relative_error(TIP, opening, exact_opening),
            points: profile.row().map(|f| [f.middle(), opening(f)]).collect(),
        })
    }

    fn penny(s: f64, observer: &mut dyn Observer) -> anyhow::Result<Self> {
        let scene: CrackScene = PENNY;
        let body = scene.body(Family::Graded(s))?;
        let answer = Answer::of(&body, observer)?;
        let exact = exact_penny();
        let mut faces = by_radius(&body, &answer);
        faces.sort_by(|a, b| a[0].total_cmp(&b[0]));
        // the rim takes 2 TIP of the radius on each side of the disc
        let inner = faces.iter().filter(|[r, ..]| *r <= 1.0 - 2.0 * TIP);
        let (error, norm) = inner.fold((0.0, 0.0), |(error, norm), [r, g, area]| {
            let truth = exact.opening(*r);
            (
                error + area * (g - truth).powi(2),
                norm + area * truth * truth,
            )
        });
        let quarter: f64 = faces.iter().map(|[_, g, area]| area * g).sum();
        Ok(Self {
            crack: "penny",
            s,
            faces: faces.len(),
            peak: faces
                .first()
                .map_or(f64::NAN, |[r, g, _]| g / exact.opening(*r)),
            volume: 4.0 * quarter / exact.volume(),
            l2: f64::sqrt(error / norm),
            points: faces.iter().map(|[r, g, _]| [*r, *g]).collect(),
            answer,
        })
    }

    fn cells(&self) -> [crate::report::Cell; 10] {
        let share = |v: f64| 100.0 * v;
        let [_, newton, krylov] = self.answer.iterations;
        [
            self.crack.into(),
            self.s.into(),
            self.faces.into(),
            self.answer.n_u.into(),
            share(self.peak - 1.0).into(),
            share(self.volume - 1.0).into(),
            share(self.l2).into(),
            self.answer.count(ContactState::Open).into(),
            newton.into(),
            krylov.into(),
        ]
    }
}

/// (distance of the centre from the axis [m], opening [m], area [m²]) of every face.
fn by_radius(body: &Body, answer: &Answer) -> Vec<[f64; 3]> {
    let faces = body.fractures.faces.iter().enumerate();
    faces
        .map(|(f, face)| {
            let r = face.center[0].hypot(face.center[1]);
            [r, answer.fields.jump[3 * f], face.area]
        })
        .collect()
}

fn figure(id: &str, caption: &str, position: &str, curve: Vec<[f64; 2]>, rows: &[&Row]) -> Figure {
    let mm = |p: &[f64; 2]| [p[0], 1e3 * p[1]];
    let mut figure = Figure::new(
        id,
        "",
        caption,
        Axis::linear(position),
        Axis::linear("opening [mm]"),
    )
    .with(Series::new(
        "closed form",
        Mark::Line,
        curve.iter().map(mm).collect(),
    ));
    for row in rows {
        let name = format!("{} faces", row.faces);
        figure = figure.with(Series::new(
            &name,
            Mark::Points,
            row.points.iter().map(mm).collect(),
        ));
    }
    figure
}

impl Experiment for PressurisedCracks {
    fn id(&self) -> &'static str {
        "e11"
    }

    fn title(&self) -> &'static str {
        "Pressurised line and penny cracks"
    }

    fn question(&self) -> &'static str {
        "Does a crack that a fluid holds open have the width and the volume of Sneddon's solutions?"
    }

    fn setup(&self) -> &'static str {
        "Scenes line_crack (2 m long, plane strain between rollers, in a body of 200 m × 200 m) and penny_crack (radius 1 m, a \
         quarter between planes of symmetry, body of 12 m around it, the square grid mapped to a disc), 2 MPa inside, \
         E = 25 GPa, ν = 0.25. Cells of s²/2 at the rim grow by e^s per cell away from it. L2 errors leave out 10 % of the \
         length at each tip; the penny is compared at the centres of faces, the line crack by the mean over each face."
    }

    fn expect(&self) -> &'static str {
        "w = (4(1−ν²)p/E) √(a² − s²), 0.3 mm in the middle; w = (8(1−ν²)p/(πE)) √(R² − r²), 0.191 mm in the centre (Sneddon \
         1946). Peak openings within 1 % at the finest meshes, every face open."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let (lines, pennies, limit): (&[f64], &[f64], f64) = match level {
            Level::Smoke => (&[0.6, 0.42, 0.3], &[0.6, 0.42], 0.08),
            Level::Paper => (&[0.6, 0.3, 0.15], &[0.45, 0.25, 0.13], 0.01),
        };
        let mut findings = Findings::default();
        findings
            .set("s line", lines.to_vec())
            .set("s penny", pennies.to_vec())
            .set("pressure_Pa", PRESSURE);
        let mut table = Table::new(
            "e11_openings",
            "Errors against the closed forms: opening in the middle, volume, opening in L2 without the tips.",
            &[
                "crack",
                "s",
                "faces",
                "n_u",
                "middle opening [%]",
                "volume [%]",
                "opening in L2 [%]",
                "open",
                "n_it Newton",
                "n_it Krylov",
            ],
        );
        let total = lines.len() + pennies.len();
        let mut rows = Vec::new();
        let runs = lines.iter().map(|s| (false, *s));
        for (k, (penny, s)) in runs.chain(pennies.iter().map(|s| (true, *s))).enumerate() {
            let step = Step::Progress {
                stage: "meshes",
                done: k,
                total,
            };
            if observer.observe(&step) == ControlFlow::Break(()) {
                anyhow::bail!("stopped on request");
            }
            let row = match penny {
                false => Row::line(s, observer)?,
                true => Row::penny(s, observer)?,
            };
            table.push(row.cells());
            rows.push(row);
        }
        for crack in ["line", "penny"] {
            let own: Vec<&Row> = rows.iter().filter(|r| r.crack == crack).collect();
            let (Some(first), Some(last)) = (own.first(), own.last()) else {
                continue;
            };
            findings.checks.push(
                Check::at_most(
                    format!("{crack} crack, finest mesh: error of the opening in the middle"),
                    limit,
                    (last.peak - 1.0).abs(),
                )
                .closed_form(),
            );
            findings.checks.push(Check::at_most(
                format!("{crack} crack: error of the volume, finest over coarsest mesh"),
                0.7,
                ((last.volume - 1.0) / (first.volume - 1.0)).abs(),
            ));
            let open: usize = own.iter().map(|r| r.answer.count(ContactState::Open)).sum();
            let all: usize = own
                .iter()
                .map(|r| r.answer.faces.iter().sum::<usize>())
                .sum();
            findings
                .checks
                .push(Check::equal(format!("{crack} crack: open faces"), all, open).closed_form());
            let curve = |from: f64, w: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
                let at = |k: i32| from + (1.0 - from) * f64::from(k) / 200.0;
                (0..=200).map(|k| [at(k), w(at(k))]).collect()
            };
            findings.figures.push(match crack {
                "line" => figure(
                    "e11_line",
                    "Opening of the line crack: a marker per face, Sneddon's ellipse as a line.",
                    "position along the crack [m]",
                    curve(-1.0, &|x| exact_line().opening(x)),
                    &own,
                ),
                _ => figure(
                    "e11_penny",
                    "Opening of the penny crack: a marker per face at the distance of its centre, Sneddon's ellipsoid as \
                     a line.",
                    "distance from the centre [m]",
                    curve(0.0, &|r| exact_penny().opening(r)),
                    &own,
                ),
            });
        }
        findings.tables.push(table);
        Ok(findings)
    }
}
