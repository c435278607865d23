//! Eigenvalues: in the complex plane over the regions that theorems predict, and as rows on a logarithmic axis.

use super::figure::{Figure, Mark, Region, Series};
use super::non_normal::{self, Gmres, Level};
use super::{Axis, Scale};
use crate::text::format_real;
use fracas_solvers::spectrum::region::is_non_real;
use fracas_solvers::spectrum::report::Method;
use fracas_solvers::spectrum::{Part, SpectrumReport};
use serde::{Deserialize, Serialize};

/// Eigenvalues below this fraction of the largest are zero up to rounding.
const ZERO: f64 = 1e-14;

impl Figure {
    /// Eigenvalues in the complex plane, equal units on both axes; shade the predicted regions afterwards.
    pub fn complex_plane(
        id: &str,
        title: &str,
        caption: &str,
        sets: &[(&str, Vec<[f64; 2]>)],
    ) -> Self {
        let mut figure = Self::new(
            id,
            title,
            caption,
            Axis::linear("Re λ"),
            Axis::linear("Im λ"),
        );
        figure.equal_aspect = true;
        figure.series = sets
            .iter()
            .map(|(name, points)| Series::new(name, Mark::Points, points.clone()))
            .collect();
        figure
    }

    /// Real spectra side by side: one row per set, a point per eigenvalue.
    ///
    /// A logarithmic axis shows what is larger than rounding ([`ZERO`] of the largest); the row says how many are not.
    pub fn rows(
        id: &str,
        title: &str,
        caption: &str,
        x: Axis,
        rows: &[(String, Vec<f64>)],
    ) -> Self {
        let largest = rows
            .iter()
            .flat_map(|(_, values)| values)
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        let least = if x.scale == Scale::Log {
            ZERO * largest
        } else {
            f64::NEG_INFINITY
        };
        let shown = |value: &f64| *value > least;
        // The first row is on top: categories count upwards.
        let names = rows.iter().rev().map(|(name, values)| {
            match values.iter().filter(|v| !shown(v)).count() {
                0 => name.clone(),
                n => format!("{name} ({n} at 0)"),
            }
        });
        let y = Axis {
            scale: Scale::Categories(names.collect()),
            ..Axis::linear("")
        };
        let series = rows.iter().enumerate().map(|(k, (_, values))| {
            let height = (rows.len() - 1 - k) as f64;
            let points = values
                .iter()
                .filter(|v| shown(v))
                .map(|v| [*v, height])
                .collect();
            Series::new("", Mark::Points, points).tone(k)
        });
        let series = series.collect();
        Self {
            series,
            ..Self::new(id, title, caption, x.clone(), y)
        }
    }

    /// Real eigenvalues in ascending order over their place in the spectrum (0 to 1), a line per set.
    pub fn sorted(
        id: &str,
        title: &str,
        caption: &str,
        y: Axis,
        sets: &[(String, Vec<f64>)],
    ) -> Self {
        let mut figure = Self::new(id, title, caption, Axis::linear("place in the spectrum"), y);
        for (name, values) in sets {
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let last = sorted.len().saturating_sub(1).max(1) as f64;
            let points = sorted
                .iter()
                .enumerate()
                .map(|(i, v)| [i as f64 / last, *v])
                .collect();
            figure.series.push(Series::new(name, Mark::Points, points));
        }
        figure
    }
}

/// A band that starts at zero ends this far below the smallest eigenvalue on a logarithmic axis. Unit: 1.
const BELOW: f64 = 0.3;

/// The boundary of discs that share their ends' axis, from left to right above it and back below.
fn union(discs: &[(f64, f64)]) -> Vec<[f64; 2]> {
    const STEPS: usize = 400;
    let left = discs.iter().fold(f64::INFINITY, |m, d| m.min(d.0));
    let right = discs.iter().fold(f64::NEG_INFINITY, |m, d| m.max(d.1));
    let height = |x: f64| {
        let of = |d: &(f64, f64)| ((x - d.0) * (d.1 - x)).max(0.0).sqrt();
        discs.iter().map(of).fold(0.0, f64::max)
    };
    // closer points at both ends, where a circle is steep
    let place = |k: usize| {
        let angle = std::f64::consts::PI * k as f64 / STEPS as f64;
        0.5 * (left + right) - 0.5 * (right - left) * angle.cos()
    };
    let upper: Vec<[f64; 2]> = (0..=STEPS).map(|k| [place(k), height(place(k))]).collect();
    let lower = upper.iter().rev().map(|[x, y]| [*x, -y]);
    upper.iter().copied().chain(lower).collect()
}

/// What holds non-real eigenvalues; discs have their centre on the real axis, and these ends on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Circle {
    /// A disc.
    Disc(f64, f64),
    /// All that lies outside of one.
    Outside(f64, f64),
    /// All that lies right of a number.
    Right(f64),
    /// One of these.
    AnyOf(Vec<Circle>),
}

impl Circle {
    fn of(part: &Part) -> Option<Self> {
        Some(match part {
            Part::Interval { .. } | Part::Box { .. } => return None,
            Part::Disc { low, high } => Self::Disc(*low, *high),
            Part::OutsideDisc { low, high } => Self::Outside(*low, *high),
            Part::HalfPlane { low } => Self::Right(*low),
            Part::AnyOf { parts } => Self::AnyOf(parts.iter().filter_map(Self::of).collect()),
        })
    }
}

/// What a figure shows of a spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// Name of C.
    pub augmentation: String,
    /// Name of S̃_u⁻¹.
    pub inner: String,
    /// Unknowns.
    pub n_u: usize,
    /// The same of tractions.
    pub n_t: usize,
    /// Re λ.
    pub re: Vec<f64>,
    /// Im λ.
    pub im: Vec<f64>,
    /// Proved for all eigenvalues where S_u is exact, else for the real ones.
    pub real: Option<(f64, f64)>,
    /// Proved for the others: Re λ, |Im λ|.
    pub complex: Option<((f64, f64), f64)>,
    /// What else is proved of them.
    pub circles: Vec<Circle>,
    /// These are not all of them.
    #[serde(default)]
    pub is_partial: bool,
    /// Whether all that were found lie inside; nothing where nothing is proved.
    #[serde(default)]
    pub contained: Option<bool>,
    /// Corners of the field of values.
    pub field: Option<Vec<[f64; 2]>>,
    /// Boundaries of pseudospectra.
    #[serde(default)]
    pub levels: Vec<Level>,
    /// GMRES under its bounds.
    #[serde(default)]
    pub gmres: Option<Gmres>,
}

impl From<&SpectrumReport> for Spectrum {
    fn from(report: &SpectrumReport) -> Self {
        let region = &report.region;
        let corners = |field: &fracas_solvers::spectrum::FieldOfValues| {
            let points = field.re.iter().zip(&field.im);
            points.map(|(re, im)| [*re, *im]).collect()
        };
        let real = report.exact_S_u_interval.filter(|_| report.n_complex == 0);
        Self {
            augmentation: report.augmentation.clone(),
            inner: report.inner.clone(),
            n_u: report.n_u,
            n_t: report.n_t,
            re: report.eigenvalues.re.clone(),
            im: report.eigenvalues.im.clone(),
            real: real.or(region.real),
            complex: region.re.zip(region.im_max),
            circles: region.parts().iter().filter_map(Circle::of).collect(),
            is_partial: report.method == Method::Iterative,
            contained: report.contained,
            field: match &report.non_normal {
                Some(found) => Some(corners(&found.field_of_values)),
                None => report.field_of_values.as_ref().map(corners),
            },
            levels: (report
                .non_normal
                .iter()
                .flat_map(|found| &found.pseudospectra))
            .flat_map(non_normal::levels)
            .collect(),
            gmres: report.non_normal.as_ref().map(Gmres::from),
        }
    }
}

impl Spectrum {
    /// (Re λ, Im λ).
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        self.re.iter().zip(&self.im).map(|(re, im)| [*re, *im])
    }

    fn which(&self) -> String {
        match self.is_partial {
            false => "Eigenvalues of the preconditioned matrix.".to_owned(),
            true => format!(
                "The {} outer eigenvalues found of the preconditioned matrix.",
                self.re.len()
            ),
        }
    }

    /// What a figure of a part of the spectrum says beside its title; empty where all eigenvalues are there.
    pub fn note(&self) -> String {
        let n = self.re.len();
        match (self.is_partial, self.contained) {
            (false, _) => String::new(),
            (true, Some(true)) => {
                format!("A part of the spectrum: every one of the {n} found lies inside")
            }
            (true, Some(false)) => {
                format!("A part of the spectrum: not every one of the {n} found lies inside")
            }
            (true, None) => format!("A part of the spectrum: {n} eigenvalues were found"),
        }
    }

    fn is_real(&self) -> bool {
        self.points().all(|[re, im]| !is_non_real(re, im))
    }

    /// `max_i min_j |λ_i − μ_j|`, the larger of both ways.
    pub fn distance(&self, other: &Self) -> f64 {
        let one_way = |a: &Self, b: &Self| {
            let nearest = |[x, y]: [f64; 2]| {
                let distances = b.points().map(|[u, v]| (x - u).hypot(y - v));
                distances.fold(f64::INFINITY, f64::min)
            };
            a.points().map(nearest).fold(0.0, f64::max)
        };
        one_way(self, other).max(one_way(other, self))
    }

    /// A label of these eigenvalues, with their number where they are not all.
    pub fn labelled(&self, name: &str) -> String {
        match self.is_partial {
            false => name.to_owned(),
            true => format!("{name} ({} found)", self.re.len()),
        }
    }

    /// Real spectra over each other, a row each, with the proved intervals below them; the n_u ones that an exact S_u always gives are
    /// one point.
    pub fn strips(id: &str, caption: &str, sets: &[(String, &Self)]) -> Figure {
        let values = |(name, spectrum): &(String, &Self)| {
            let mut ones = spectrum.n_u;
            let mut values = spectrum.re.clone();
            values.retain(|v| {
                let drop = ones > 0 && *v == 1.0;
                ones -= usize::from(drop);
                !drop
            });
            values.push(1.0);
            (spectrum.labelled(name), values)
        };
        let rows: Vec<_> = sets.iter().map(values).collect();
        let mut figure = Figure::rows(id, "", caption, Axis::log("λ"), &rows);
        for (k, (_, spectrum)) in sets.iter().enumerate() {
            if let Some((low, high)) = spectrum.real {
                let height = (sets.len() - 1 - k) as f64 - 0.3;
                let name = if k == 0 { "proved interval" } else { "" };
                let line = vec![[low, height], [high, height]];
                figure = figure.with(Series::new(name, Mark::Line, line).tone(7));
            }
        }
        figure
    }

    /// Over what is proved about it: the complex plane, or for a real spectrum the sorted eigenvalues.
    pub fn figure(&self, id: &str) -> Figure {
        // Names of methods are words here, not symbols with an index.
        let c = self.augmentation.replace("_h", " + H").replace('_', " ");
        let title = format!(
            "C {c}, inner {}: n_u = {}, n_t = {}",
            self.inner, self.n_u, self.n_t
        );
        // Rounding around zero is not worth a power of ten.
        let round = |v: f64, scale: f64| if v.abs() < 1e-12 * scale { 0.0 } else { v };
        let name = |what: &str, (low, high): (f64, f64)| {
            let low = format_real(round(low, high));
            format!("{what} [{low}, {}]", format_real(high))
        };
        if self.is_real() && self.levels.is_empty() {
            let least = self.re.iter().copied().fold(f64::INFINITY, f64::min);
            let most = self.re.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let axis = match least > 0.0 && most > 20.0 * least {
                true => Axis::log("λ"),
                false => Axis::linear("λ"),
            };
            let caption = format!("Sorted: {}", self.which());
            let sets = [("eigenvalues".into(), self.re.clone())];
            let mut figure = Figure::sorted(id, &title, &caption, axis, &sets);
            figure.note = self.note();
            figure.x = figure.x.range(-0.02, 1.02);
            if self.is_partial {
                figure.x.label = "place among those found".into();
            }
            if let Some((low, high)) = self.real {
                // a band from zero reaches the lower end of a logarithmic axis
                let mut band = [low, high];
                if figure.y.scale == Scale::Log {
                    band[0] = low.max(BELOW * least);
                    let top = most.max(high) / BELOW.sqrt();
                    figure.y = figure.y.range(band[0].min(least), top);
                }
                let region = Region::Rectangle {
                    x: [-0.02, 1.02],
                    y: band,
                };
                figure = figure.shade(&name("proved:", (low, high)), region);
            }
            return figure;
        }
        let points = |real: bool| -> Vec<[f64; 2]> {
            let mut points: Vec<[f64; 2]> = self.points().collect();
            points.retain(|[re, im]| is_non_real(*re, *im) != real);
            points
        };
        let sets = [
            ("complex eigenvalues", points(false)),
            ("real eigenvalues", points(true)),
        ];
        let mut figure = Figure::complex_plane(id, &title, &self.which(), &sets);
        figure.note = self.note();
        self.window(&mut figure);
        let none_complex = self.is_real() && !self.levels.is_empty();
        if let Some(((low, high), im)) = self.complex.filter(|_| !none_complex) {
            let re = name("proved, complex: Re λ in", (low, high));
            let region = Region::Rectangle {
                x: [low, high],
                y: [-im, im],
            };
            figure = figure.shade(&format!("{re}, |Im λ| ≤ {}", format_real(im)), region);
        }
        for part in &self.circles {
            figure = figure.circles(part);
        }
        self.contours(&mut figure);
        if let Some(corners) = &self.field {
            figure = figure.shade("field of values", Region::Polygon(corners.clone()));
        }
        if let Some((low, high)) = self.real {
            let region = Region::RealInterval([low, high]);
            figure = figure.shade(&name("proved, real:", (low, high)), region);
        }
        figure
    }
}

impl Figure {
    /// Discs with their centre on the real axis, or all that they cover together; of what lies outside of one, the circle.
    fn circles(mut self, circle: &Circle) -> Self {
        let one = |low: f64, high: f64| Region::Disc {
            center: [0.5 * (low + high), 0.0],
            radius: 0.5 * (high - low),
        };
        let ends = |low: f64, high: f64| format!("[{}, {}]", format_real(low), format_real(high));
        match circle {
            Circle::Disc(low, high) => {
                let label = format!("disc over {}", ends(*low, *high));
                self.shade(&label, one(*low, *high))
            }
            Circle::Outside(low, high) => {
                let (center, radius) = (0.5 * (low + high), 0.5 * (high - low));
                let points = (0..=180).map(|k| {
                    let angle = f64::from(k) * std::f64::consts::TAU / 180.0;
                    [center + radius * angle.cos(), radius * angle.sin()]
                });
                let label = format!("outside of the disc over {}", ends(*low, *high));
                self.series
                    .push(Series::new(&label, Mark::Dashed, points.collect()));
                self
            }
            Circle::Right(low) => {
                let label = format!("right of {}", format_real(*low));
                let [_, right] = self.x.range.unwrap_or([*low, *low]);
                let [bottom, top] = self.y.range.unwrap_or([0.0, 0.0]);
                let region = Region::Rectangle {
                    x: [*low, right],
                    y: [bottom, top],
                };
                self.shade(&label, region)
            }
            Circle::AnyOf(parts) => {
                let discs: Vec<(f64, f64)> = (parts.iter())
                    .filter_map(|circle| match circle {
                        Circle::Disc(low, high) => Some((*low, *high)),
                        _ => None,
                    })
                    .collect();
                for hole in parts.iter().filter(|p| !matches!(p, Circle::Disc(..))) {
                    self = self.circles(hole);
                }
                match &discs[..] {
                    [] => self,
                    [(low, high)] => self.shade(
                        &format!("or disc over {}", ends(*low, *high)),
                        one(*low, *high),
                    ),
                    _ => {
                        let (label, outline) = (format!("{} discs", discs.len()), union(&discs));
                        self.shade(&label, Region::Polygon(outline))
                    }
                }
            }
        }
    }
}
