//! Curves of what a run has written, a row per step: energies, volumes of fluid, wells.

use super::{series, time_axis, unit};
use fracas_figures::{Axis, Figure, Series};
use std::path::Path;

/// A table of numbers with their times.
pub(super) struct Rows {
    heading: Vec<String>,
    rows: Vec<Vec<f64>>,
    /// Place of the column of times.
    time: usize,
}

impl Rows {
    /// Of a file; none where there is none, or one of another form.
    pub(super) fn read(file: &Path) -> Option<Self> {
        Self::parse(&std::fs::read_to_string(file).ok()?)
    }

    fn parse(csv: &str) -> Option<Self> {
        let mut lines = csv.lines();
        let heading: Vec<String> = lines.next()?.split(',').map(str::to_owned).collect();
        let rows = lines
            .map(|line| line.split(',').map(|x| x.parse().ok()).collect())
            .collect::<Option<Vec<Vec<f64>>>>()?;
        let time = heading.iter().position(|h| h == "time_s")?;
        Some(Self {
            heading,
            rows,
            time,
        })
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.heading.iter().position(|h| h == name)
    }

    /// The axis of times, and how many seconds its unit has.
    fn times(&self) -> (Axis, f64) {
        time_axis(self.rows.iter().map(|row| row[self.time]))
    }

    /// The sum of these columns over all steps up to each.
    fn summed(&self, names: &[&str], length: f64, name: &str) -> Series {
        let columns: Vec<usize> = names.iter().filter_map(|n| self.column(n)).collect();
        let points = self.rows.iter().scan(0.0, |sum, row| {
            *sum += columns.iter().map(|k| row[*k]).sum::<f64>();
            Some([row[self.time] / length, *sum])
        });
        series(name, points.collect())
    }

    /// A column over time, times `factor`.
    fn own(&self, column: usize, (length, factor): (f64, f64), name: &str) -> Series {
        let point = |row: &Vec<f64>| [row[self.time] / length, factor * row[column]];
        series(name, self.rows.iter().map(point).collect())
    }

    /// Columns whose names end so, and what stands before that.
    fn ending(&self, with: &str) -> Vec<(usize, &str)> {
        let columns = self.heading.iter().enumerate();
        let stem = |(k, name): (usize, &'_ String)| {
            Some((k, name.len() - with.len())).filter(|_| name.ends_with(with))
        };
        let found: Vec<(usize, usize)> = columns.filter_map(stem).collect();
        found
            .into_iter()
            .map(|(k, to)| (k, &self.heading[k][..to]))
            .collect()
    }
}

/// What loads have done, and where it went, of `energy.csv`; none where it has no energies.
pub(super) fn energy(rows: &Rows) -> Option<Figure> {
    rows.column("external_work_J")?;
    let (times, length) = rows.times();
    let creeps = rows.column("creep_dissipation_J").is_some();
    let caption = match creeps {
        true => {
            "Energy since the beginning: work of the loads and of fluid pressures, what is stored in the rock, what friction and creep dissipate."
        }
        false => {
            "Energy since the beginning: work of the loads and of fluid pressures, what is stored in the rock, what friction dissipates."
        }
    };
    let summed = |names: &[&str], name: &str| rows.summed(names, length, name);
    let figure = Figure::new("energy", "", caption, times, Axis::linear("energy [J]"))
        .with(summed(&["external_work_J", "pressure_work_J"], "work"))
        .with(summed(&["elastic_change_J"], "stored"))
        .with(summed(&["dissipation_J"], "dissipated by friction"));
    Some(match creeps {
        true => figure.with(summed(&["creep_dissipation_J"], "dissipated by creep")),
        false => figure,
    })
}

/// Where the fluid went, of `flow.csv`; none where it has no volumes.
pub(super) fn volumes(rows: &Rows) -> Option<Figure> {
    rows.column("injected_m3")?;
    let (times, length) = rows.times();
    let caption = "Fluid since the beginning: what sources and wells inject, what the opening of fractures takes up, what compression and storage do, what leaves.";
    let parts = [
        ("injected_m3", "injected"),
        ("stored_opening_m3", "stored in opening"),
        ("stored_compression_m3", "stored by compression"),
        ("out_m3", "out"),
    ];
    let mut curves = parts.map(|(column, name)| rows.summed(&[column], length, name));
    let points = curves.iter().flat_map(|curve| &curve.points);
    let largest = points.fold(0.0f64, |m, [_, v]| m.max(v.abs()));
    let (unit, factor) = unit::Kind::Volume.unit(largest);
    for curve in &mut curves {
        curve.points.iter_mut().for_each(|[_, v]| *v *= factor);
        // the equilibrium at time 0 has no row
        curve.points.insert(0, [0.0; 2]);
    }
    let axis = Axis::linear(&format!("volume [{unit}]"));
    let figure = Figure::new("volumes", "", caption, times, axis);
    Some(curves.into_iter().fold(figure, Figure::with))
}

/// Rates and pressures of wells, of `flow.csv`; none where it has no well.
pub(super) fn wells(rows: &Rows) -> Vec<Figure> {
    let figure = |name: &str, ending: &str, caption: &str, axis: &str, kind: unit::Kind| {
        let wells = rows.ending(ending);
        if wells.is_empty() {
            return None;
        }
        let (times, length) = rows.times();
        let values = |k: &(usize, &str)| {
            rows.rows
                .iter()
                .map(|row| row[k.0].abs())
                .fold(0.0, f64::max)
        };
        let largest = wells.iter().map(values).fold(0.0, f64::max);
        let (unit, factor) = kind.unit(largest);
        let axis = Axis::linear(&format!("{axis} [{unit}]"));
        let mut figure = Figure::new(name, "", caption, times, axis);
        for (column, well) in wells {
            figure = figure.with(rows.own(column, (length, factor), well));
        }
        Some(figure)
    };
    let rates = figure(
        "well_rates",
        "_rate_m3_s",
        "Rate of every well over the step, into the rock above 0.",
        "rate",
        unit::Kind::Rate,
    );
    let pressures = figure(
        "well_pressures",
        "_pressure_Pa",
        "Pressure of every well at the end of a step.",
        "pressure",
        unit::Kind::Stress,
    );
    rates.into_iter().chain(pressures).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn energies_and_volumes_are_summed_over_the_steps() {
        let csv =
            "step,time_s,external_work_J,elastic_change_J,dissipation_J\n0,0,3,2,1\n1,0.5,1,-1,2\n";
        let ends = |figure: Figure| -> Vec<[f64; 2]> {
            figure
                .series
                .iter()
                .filter_map(|s| s.points.last().copied())
                .collect()
        };
        let rows = Rows::parse(csv).unwrap();
        assert_eq!(
            ends(energy(&rows).unwrap()),
            [[0.5, 4.0], [0.5, 1.0], [0.5, 3.0]]
        );
        assert!(volumes(&rows).is_none() && wells(&rows).is_empty());
        assert!(Rows::parse("step\n1\n").is_none());
        assert!(Rows::parse("time_s,dissipation_J\n0,x\n").is_none());
        let csv = "step,time_s,injected_m3,stored_opening_m3,stored_compression_m3,out_m3,balance_error_m3,A_rate_m3_s,A_pressure_Pa\n1,1,2,1,0,1,0,2,3e6\n2,2,1,-1,0,2,0,1,2e6\n";
        let rows = Rows::parse(csv).unwrap();
        assert!(energy(&rows).is_none());
        assert_eq!(
            ends(volumes(&rows).unwrap()),
            [[2.0, 3.0], [2.0, 0.0], [2.0, 0.0], [2.0, 3.0]]
        );
        let wells: Vec<_> = wells(&rows).into_iter().map(ends).collect();
        assert_eq!(wells, [[[2.0, 1.0]], [[2.0, 2.0]]]);
    }
}
