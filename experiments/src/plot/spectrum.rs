//! Eigenvalues: in the complex plane over the regions that theorems predict, and as rows on a logarithmic axis.

use super::figure::{Figure, Mark, Series};
use super::{Axis, Scale};

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
    /// On a logarithmic axis eigenvalues ≤ 0 cannot be shown; the row says how many.
    pub fn rows(
        id: &str,
        title: &str,
        caption: &str,
        x: Axis,
        rows: &[(String, Vec<f64>)],
    ) -> Self {
        let hidden = |values: &[f64]| values.iter().filter(|v| x.linearize(**v).is_none()).count();
        // The first row is on top: categories count upwards.
        let names = rows
            .iter()
            .rev()
            .map(|(name, values)| match hidden(values) {
                0 => name.clone(),
                n => format!("{name} ({n} ≤ 0)"),
            });
        let y = Axis {
            scale: Scale::Categories(names.collect()),
            ..Axis::linear("")
        };
        let series = rows.iter().enumerate().map(|(k, (_, values))| {
            let height = (rows.len() - 1 - k) as f64;
            let points = values
                .iter()
                .filter(|v| x.linearize(**v).is_some())
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
