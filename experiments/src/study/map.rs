//! A measure as a colour over the values of two axes, or of four.

use super::curves::axis_label;
use super::figure_section::FigureSection;
use super::findings::{Fields, Findings};
use fracas_figures::{Axis, Cells, Colors, Figure, Mark, Series};
use fracas_solvers::words::by_number;

/// Part of the place of a value that its cells take where others stand within it.
const FILLED: f64 = 0.94;

/// Of [`Series`]: black crosses.
const CROSSES: usize = 48;

/// Where the values of an axis lie, with those of another one side by side within each.
struct Places<'a> {
    names: [&'a str; 2],
    values: [Vec<&'a str>; 2],
    /// The same as they are shown.
    shown: [Vec<String>; 2],
}

impl<'a> Places<'a> {
    fn new(
        name: &'a str,
        within: Option<&'a String>,
        rows: &[&'a Fields],
        findings: &'a Findings,
    ) -> Self {
        let names = [name, within.map_or("", String::as_str)];
        let values = names.map(|name| findings.values(rows, name));
        let shown = |values: &Vec<&str>| values.iter().map(|v| findings.label(v)).collect();
        Self {
            names,
            shown: [shown(&values[0]), shown(&values[1])],
            values,
        }
    }

    /// Ends of the cell of a row.
    fn ends(&self, row: &Fields, findings: &Findings) -> Option<[f64; 2]> {
        let place = |k: usize| {
            let field = findings.field(row, self.names[k]);
            self.values[k].iter().position(|value| *value == field)
        };
        let (outer, inner) = (place(0)? as f64, place(1)? as f64);
        let count = self.values[1].len() as f64;
        let filled = if count > 1.0 { FILLED } else { 1.0 };
        let end = |k: f64| outer + filled * (k / count - 0.5);
        Some([end(inner), end(inner + 1.0)])
    }

    fn axis(&self) -> Axis {
        Axis::categories(&axis_label(self.names[0]), self.shown[0].clone())
    }

    /// `nu = 0.2, 0.4`, where there is something within.
    fn words(&self, how: &str) -> Option<String> {
        let values = &self.shown[1];
        (values.len() > 1).then(|| {
            let name = axis_label(self.names[1]);
            format!("{how} {name} = {}", values.join(", "))
        })
    }
}

/// A cell per row; rows without a value have a cross on white.
pub(super) fn map(
    id: &str,
    section: &FigureSection,
    rows: &[&Fields],
    findings: &Findings,
) -> Option<Figure> {
    let mut within = section.within.iter();
    let across = Places::new(&section.x, within.next(), rows, findings);
    let up = Places::new(section.y.first()?, within.next(), rows, findings);
    let (mut quads, mut values, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    for row in rows {
        let [left, right] = across.ends(row, findings)?;
        let [low, high] = up.ends(row, findings)?;
        let value = findings.value(row, &section.color, false);
        if findings.is_good(row) && value.is_finite() {
            quads.push([[left, low], [right, low], [right, high], [left, high]]);
            values.push(value);
        } else {
            missing.push([0.5 * (left + right), 0.5 * (low + high)]);
        }
    }
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values
        .iter()
        .fold(ends, |(a, b), v: &f64| (a.min(*v), b.max(*v)));
    let mut caption = findings.filled(&section.caption, rows.first()?);
    let words = [
        across.words("from left to right"),
        up.words("from below to above"),
    ];
    let words: Vec<String> = words.into_iter().flatten().collect();
    if !words.is_empty() {
        caption += &format!(" Within each: {}.", words.join("; "));
    }
    if !missing.is_empty() {
        let (lacking, all) = (missing.len(), rows.len());
        let have = by_number(lacking, "has", "have");
        caption += &format!(" {lacking} of {all} rows {have} no value: a cross.");
    }
    let along = match &section.x_label {
        Some(label) => Axis {
            label: label.clone(),
            ..across.axis()
        },
        None => across.axis(),
    };
    let mut figure = Figure::new(id, "", caption.trim(), along, up.axis());
    let own = [low, if high > low { high } else { low + 1.0 }];
    figure.cells = Some(Cells {
        colors: Colors::Diverging,
        label: axis_label(&section.color),
        quads,
        values,
        range: section.colors.unwrap_or(own),
    });
    if !missing.is_empty() {
        let mut crosses = Series::new("", Mark::Points, missing);
        crosses.tone = Some(CROSSES);
        figure = figure.with(crosses);
    }
    low.is_finite().then_some(figure)
}
