//! How far a measure swings as one setting at a time is changed.

use super::curves::axis_label;
use super::figure_section::FigureSection;
use super::findings::{Fields, Findings};
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::words::by_number;

/// Between a setting and its value in the name of a variant: `Biot = 0.6`.
pub(super) const SETS: &str = " = ";

/// Where the line of a value of 0 ends on a logarithmic axis, over the least value that is shown.
const BEYOND: f64 = 0.5;

/// Rows that change the same setting, in the order of the study: what they give.
struct Setting<'a> {
    name: &'a str,
    values: Vec<(&'a str, f64)>,
}

impl Setting<'_> {
    /// Least and largest value, that of the base among them.
    fn ends(&self, base: f64) -> [f64; 2] {
        let values = self.values.iter().map(|(_, value)| *value);
        values.fold([base; 2], |[low, high], v| [low.min(v), high.max(v)])
    }
}

/// A line per setting, the one that swings most on top, with a mark per row and a vertical line at the row that changes nothing: the one whose
/// name has no `=`. `None` without such a row, or where none has a value.
pub(super) fn tornado(
    id: &str,
    section: &FigureSection,
    rows: &[&Fields],
    findings: &Findings,
) -> Option<Figure> {
    let axis = section.y.first()?;
    let (mut settings, mut base, mut missing) = (Vec::<Setting<'_>>::new(), None, 0);
    for row in rows {
        let value = findings.value(row, &section.x, false);
        if !findings.is_good(row) || !value.is_finite() {
            missing += 1;
            continue;
        }
        match findings.field(row, axis).split_once(SETS) {
            None => base = base.or(Some(value)),
            Some((name, of)) => match settings.iter_mut().find(|s| s.name == name) {
                Some(setting) => setting.values.push((of, value)),
                None => settings.push(Setting {
                    name,
                    values: vec![(of, value)],
                }),
            },
        }
    }
    let base = base?;
    // what a logarithm cannot show lies beyond the end of the axis, and its line goes there
    let all = settings.iter().flat_map(|s| &s.values).map(|(_, v)| *v);
    let positive = all.clone().chain([base]).filter(|v| *v > 0.0);
    let floor = match section.log_x {
        true => BEYOND * positive.fold(f64::INFINITY, f64::min),
        false => f64::NEG_INFINITY,
    };
    let beyond = all.filter(|v| *v < floor).count();
    let swing = |setting: &Setting<'_>| {
        let [low, high] = setting.ends(base);
        if section.log_x {
            (high / low.max(f64::MIN_POSITIVE)).ln()
        } else {
            high - low
        }
    };
    // names go upwards
    settings.sort_by(|a, b| swing(a).total_cmp(&swing(b)));
    let words = settings.iter().map(|setting| {
        let values: Vec<&str> = setting.values.iter().map(|(of, _)| *of).collect();
        format!("{}: {}", setting.name, values.join(", "))
    });
    let names = Axis::categories("", words.collect());
    let label = section.x_label.clone();
    let label = label.unwrap_or_else(|| axis_label(&section.x));
    let along = match section.log_x {
        true => Axis::log(&label),
        false => Axis::linear(&label),
    };
    let mut caption = findings.filled(&section.caption, rows.first()?);
    if missing > 0 {
        caption += &format!(
            " {missing} of {} rows {} no value; the table says why.",
            rows.len(),
            by_number(missing, "has", "have")
        );
    }
    if beyond > 0 {
        let are = by_number(beyond, "value is", "values are");
        caption += &format!(" {beyond} {are} 0, left of the axis.");
    }
    let mut figure = Figure::new(id, "", caption.trim(), along, names);
    let (mut first, mut between, mut last) = (Vec::new(), Vec::new(), Vec::new());
    for (k, setting) in settings.iter().enumerate() {
        let place = k as f64;
        let ends = setting.ends(base).map(|value| [value.max(floor), place]);
        figure = figure.with(Series::new("", Mark::Line, ends.to_vec()).tone(0));
        let end = setting.values.len() - 1;
        for (i, (_, value)) in setting.values.iter().enumerate() {
            let marks = match i {
                0 => &mut first,
                i if i == end => &mut last,
                _ => &mut between,
            };
            marks.extend((*value >= floor).then_some([*value, place]));
        }
    }
    let top = settings.len() as f64 - 0.5;
    let unchanged = vec![[base, -0.5], [base, top]];
    figure = figure.with(Series::new("nothing changed", Mark::Dashed, unchanged).tone(3));
    let marks = [
        ("first value", first),
        ("between", between),
        ("last value", last),
    ];
    for (tone, (name, points)) in marks.into_iter().enumerate() {
        if !points.is_empty() {
            figure = figure.with(Series::new(name, Mark::Points, points).tone(tone));
        }
    }
    (!settings.is_empty()).then_some(figure)
}
