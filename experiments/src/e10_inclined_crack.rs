//! e10: an inclined crack under compression slides as its closed form says.

use crate::crack::{Answer, Family, INCLINED, Profile, Strip};
use crate::report::{Check, Experiment, Findings, Level, Table};
use fracas::analytic::{InclinedCrack, Rock};
use fracas::contact::ContactState;
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Do traction and slip of a closed crack come out as in the literature?
#[derive(Debug)]
pub struct Inclined;

/// Share of the length that is left out at each tip.
const TIP: f64 = 0.1;

/// Half-length of the crack [m].
const HALF_LENGTH: f64 = 1.0;

/// The closed form of the scene `inclined_crack`.
pub fn exact() -> InclinedCrack {
    InclinedCrack {
        rock: Rock {
            young: 25e9,
            poisson: 0.25,
        },
        compression: 100e6,
        inclination: 20f64.to_radians(),
        friction_angle: 30f64.to_radians(),
        cohesion: 0.0,
        half_length: HALF_LENGTH,
    }
}

/// Slip and tractions along the crack of the scene `inclined_crack`.
///
/// # Errors
/// A mesh that cannot be made or a step that fails.
pub fn solve(family: Family, observer: &mut dyn Observer) -> anyhow::Result<(Answer, Profile)> {
    let body = INCLINED.body(family)?;
    let answer = Answer::of(&body, observer)?;
    let (sin, cos) = exact().inclination.sin_cos();
    let profile = Profile::new(&body, &answer, [sin, 0.0, cos], HALF_LENGTH);
    Ok((answer, profile))
}

/// ‖g_T‖ of a face [m].
pub fn slip(strip: &Strip) -> f64 {
    strip.jump[1]
}

/// t_N of a face [Pa].
pub fn normal(strip: &Strip) -> f64 {
    strip.traction[0]
}

/// Mean slip of the closed form over a face [m].
pub fn exact_slip(strip: &Strip) -> f64 {
    exact().mean_slip(strip.span[0], strip.span[1])
}

/// One mesh.
struct Row {
    s: f64,
    answer: Answer,
    profile: Profile,
    /// Slip of the middle face over that of the closed form.
    peak: f64,
    /// Largest error of t_N without the tips.
    normal: f64,
}

impl Row {
    fn new(s: f64, observer: &mut dyn Observer) -> anyhow::Result<Self> {
        let (answer, profile) = solve(Family::Graded(s), observer)?;
        let middle = profile
            .central()
            .map(|strip| slip(strip) / exact_slip(strip));
        Ok(Self {
            s,
            peak: middle.unwrap_or(f64::NAN),
            normal: profile.largest_error(TIP, normal, |_| exact().normal_traction()),
            answer,
            profile,
        })
    }

    fn cells(&self) -> [crate::report::Cell; 12] {
        let share = |v: f64| 100.0 * v;
        let p = &self.profile;
        let area = p.integral(slip) / exact().slip_area() - 1.0;
        let [active, newton, krylov] = self.answer.iterations;
        [
            self.s.into(),
            p.row().count().into(),
            self.answer.n_u.into(),
            share(self.peak - 1.0).into(),
            share(area).into(),
            share(p.relative_error(TIP, slip, exact_slip)).into(),
            share(self.normal).into(),
            self.answer.count(ContactState::Slip).into(),
            self.answer.count(ContactState::Open).into(),
            active.into(),
            newton.into(),
            krylov.into(),
        ]
    }
}

fn slip_figure(rows: &[Row]) -> Figure {
    let mm = 1e3;
    let curve = (-100..=100).map(|k| f64::from(k) / 100.0);
    let mut figure = Figure::new(
        "e10_slip",
        "",
        "Slip along the crack: a marker per face, the closed form as a line.",
        Axis::linear("position along the crack [m]"),
        Axis::linear("slip [mm]"),
    )
    .with(Series::new(
        "closed form",
        Mark::Line,
        curve.map(|x| [x, mm * exact().slip(x)]).collect(),
    ));
    for row in rows {
        let points = row.profile.row().map(|f| [f.middle(), mm * slip(f)]);
        let name = format!("{} faces", row.profile.row().count());
        figure = figure.with(Series::new(&name, Mark::Points, points.collect()));
    }
    figure
}

fn traction_figure(rows: &[Row]) -> Figure {
    let mpa = 1e-6;
    let level = |v: f64| vec![[-HALF_LENGTH, mpa * v], [HALF_LENGTH, mpa * v]];
    let mut figure = Figure::new(
        "e10_traction",
        "",
        "Normal traction and shear traction along the crack. The grid is sheared by 20°, so that nothing but the equations \
         makes t_N uniform; errors gather in the last faces before the tips.",
        Axis::linear("position along the crack [m]"),
        Axis::linear("traction [MPa]"),
    )
    .with(Series::new("t_N, closed form", Mark::Line, level(exact().normal_traction())).tone(0))
    .with(Series::new("‖t_T‖, closed form", Mark::Line, level(exact().shear_limit())).tone(1));
    if let Some(row) = rows.last() {
        let points = |k: usize| {
            row.profile
                .row()
                .map(move |f| [f.middle(), mpa * f.traction[k]])
        };
        let n = row.profile.row().count();
        figure = figure
            .with(
                Series::new(
                    &format!("t_N, {n} faces"),
                    Mark::Points,
                    points(0).collect(),
                )
                .tone(0),
            )
            .with(
                Series::new(
                    &format!("‖t_T‖, {n} faces"),
                    Mark::Points,
                    points(1).collect(),
                )
                .tone(1),
            );
    }
    figure
}

impl Experiment for Inclined {
    fn id(&self) -> &'static str {
        "e10"
    }

    fn title(&self) -> &'static str {
        "Inclined crack under compression"
    }

    fn question(&self) -> &'static str {
        "Does a closed crack under inclined compression slide, and carry traction, as the closed form says?"
    }

    fn setup(&self) -> &'static str {
        "Scene inclined_crack: a crack of 2 m at 20° to 100 MPa of uniaxial compression, friction angle 30°, no cohesion, \
         E = 25 GPa, ν = 0.25, plane strain between rollers, a body of 200 m × 200 m on a grid sheared by 20°. Cells of \
         s²/2 at the tips grow by e^s per cell away from them. All three cycles: active set, Newton, Krylov. Slip is \
         compared face by face with the mean of the closed form over the face; 10 % of the length are left out at each tip."
    }

    fn expect(&self) -> &'static str {
        "t_N = −σ sin²ψ = −11.698 MPa on every face; slip (4(1−ν²)/E) σ sinψ (cosψ − sinψ tanθ) √(b² − s²), 3.808 mm in the \
         middle (Phan et al. 2003). At the finest mesh the slip in the middle and t_N away from the tips within 1 %."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        // limits on |t_N| error and on the peak
        let (steps, limit): (&[f64], f64) = match level {
            Level::Smoke => (&[0.6, 0.42, 0.3], 0.05),
            Level::Paper => (&[0.6, 0.3, 0.15, 0.105], 0.01),
        };
        let mut findings = Findings::default();
        findings.set("s", steps.to_vec()).set("tip", TIP);
        let mut rows = Vec::new();
        for (k, s) in steps.iter().enumerate() {
            let step = Step::Progress {
                stage: "meshes",
                done: k,
                total: steps.len(),
            };
            if observer.observe(&step) == ControlFlow::Break(()) {
                anyhow::bail!("stopped on request");
            }
            rows.push(Row::new(*s, observer)?);
        }
        let mut table = Table::new(
            "e10_meshes",
            "Errors against the closed form: slip of the middle face, ∫ slip, slip in L2 and the largest error of t_N \
             without the tips; states of faces and iterations of the three cycles.",
            &[
                "s",
                "faces",
                "n_u",
                "middle slip [%]",
                "∫ slip [%]",
                "slip in L2 [%]",
                "largest t_N error [%]",
                "slipping",
                "open",
                "n_it active set",
                "n_it Newton",
                "n_it Krylov",
            ],
        );
        rows.iter().for_each(|row| table.push(row.cells()));
        if let [first, .., last] = &rows[..] {
            findings.checks.push(
                Check::at_most(
                    "finest mesh: error of the slip in the middle",
                    limit,
                    (last.peak - 1.0).abs(),
                )
                .closed_form(),
            );
            findings.checks.push(
                Check::at_most(
                    "finest mesh: largest error of t_N without the tips",
                    limit,
                    last.normal,
                )
                .closed_form(),
            );
            findings.checks.push(Check::at_most(
                "error of the slip in the middle, finest over coarsest mesh",
                0.35,
                ((last.peak - 1.0) / (first.peak - 1.0)).abs(),
            ));
            findings.checks.push(Check::equal(
                "finest mesh: faces that stick",
                0,
                last.answer.count(ContactState::Stick),
            ));
        }
        findings.figures.push(slip_figure(&rows));
        findings.figures.push(traction_figure(&rows));
        findings.tables.push(table);
        Ok(findings)
    }
}
