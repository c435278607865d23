//! Eigenvalues: in the complex plane over the regions that theorems predict, and as rows on a logarithmic axis.

use super::figure::{Figure, Mark, Region, Series};
use super::{Axis, Scale};
use crate::report::format_real;
use fracas_solvers::spectrum::bounds::is_non_real;
use fracas_solvers::spectrum::{SpectrumReport, Theorem};

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

/// Bounds further than this many extents of the spectrum from it are cut at the edge of the figure.
const WINDOW: f64 = 0.6;

impl Figure {
    /// A spectrum over what is proved about it: the complex plane, or for a real spectrum the sorted eigenvalues.
    pub fn of_spectrum(id: &str, report: &SpectrumReport) -> Self {
        // Names of methods are words here, not symbols with an index.
        let c = report.augmentation.replace("_h", " + H").replace('_', " ");
        let title = format!(
            "C {c}, inner {}: n_u = {}, n_t = {}",
            report.inner, report.n_u, report.n_t
        );
        let region = report.bounds.region();
        // Rounding around zero is not worth a power of ten.
        let round = |v: f64, scale: f64| if v.abs() < 1e-12 * scale { 0.0 } else { v };
        let name = |what: &str, (low, high): (f64, f64)| {
            format!(
                "{what} [{}, {}]",
                format_real(round(low, high)),
                format_real(high)
            )
        };
        let points = |real: bool| -> Vec<[f64; 2]> {
            report
                .eigenvalues
                .iter()
                .filter(|(re, im)| is_non_real(*re, *im) != real)
                .map(|(re, im)| [re, im])
                .collect()
        };
        if report.n_complex == 0 {
            let values: Vec<f64> = report.eigenvalues.re.clone();
            let positive = values.iter().all(|v| *v > 0.0);
            let wide = report
                .re_max
                .zip(report.re_min)
                .is_some_and(|(high, low)| high > 20.0 * low);
            let axis = if positive && wide {
                Axis::log("λ")
            } else {
                Axis::linear("λ")
            };
            let mut figure = Self::sorted(
                id,
                &title,
                "Sorted eigenvalues of the preconditioned matrix.",
                axis,
                &[("eigenvalues".into(), values)],
            );
            figure.x = figure.x.range(-0.02, 1.02);
            if let Some((low, high)) = report.exact_S_u_interval.or(region.real) {
                figure = figure.shade(
                    &name("proved:", (low, high)),
                    Region::Rectangle {
                        x: [-0.02, 1.02],
                        y: [low, high],
                    },
                );
            }
            return figure;
        }
        let sets = [
            ("complex eigenvalues", points(false)),
            ("real eigenvalues", points(true)),
        ];
        let mut figure = Self::complex_plane(
            id,
            &title,
            "Eigenvalues of the preconditioned matrix.",
            &sets,
        );
        figure.window(report);
        if let (Some((low, high)), Some(im)) = (region.re, region.im_max) {
            let name = format!(
                "{}, |Im λ| ≤ {}",
                name("proved, complex: Re λ in", (low, high)),
                format_real(im)
            );
            figure = figure.shade(
                &name,
                Region::Rectangle {
                    x: [low, high],
                    y: [-im, im],
                },
            );
        }
        if report.bounds.theorem == Theorem::WithoutH {
            figure = figure.shade(
                "disc |λ − ½| ≤ ½",
                Region::Disc {
                    center: [0.5, 0.0],
                    radius: 0.5,
                },
            );
        }
        if let Some(field) = &report.field_of_values {
            let corners = field
                .re
                .iter()
                .zip(&field.im)
                .map(|(re, im)| [*re, *im])
                .collect();
            figure = figure.shade("field of values", Region::Polygon(corners));
        }
        if let Some((low, high)) = region.real {
            figure = figure.shade(
                &name("proved, real:", (low, high)),
                Region::RealInterval([low, high]),
            );
        }
        figure
    }

    /// Shows all eigenvalues, and bounds as far as they lie within a window around them.
    fn window(&mut self, report: &SpectrumReport) {
        let (Some(low), Some(high), Some(im)) = (report.re_min, report.re_max, report.im_max)
        else {
            return;
        };
        let room = WINDOW * (high - low).max(im);
        let bounds = &report.bounds;
        let least =
            |a: Option<f64>, b: Option<f64>| a.unwrap_or(low).min(b.unwrap_or(low)).max(low - room);
        let most = |a: Option<f64>, b: Option<f64>| {
            a.unwrap_or(high).max(b.unwrap_or(high)).min(high + room)
        };
        let left = low.min(least(bounds.real_low, bounds.re_low));
        let right = high.max(most(bounds.real_high, bounds.re_high));
        let top = im.max(bounds.im_max.unwrap_or(im).min(im + room));
        let margin = 0.05 * (right - left);
        self.x = self.x.clone().range(left - margin, right + margin);
        self.y = self.y.clone().range(-top - margin, top + margin);
    }
}
