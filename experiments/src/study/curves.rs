//! One figure of a study: curves or bars, reference lines, labels.

use super::Name;
use super::figure_section::{FigureSection, Kind, ReferenceLine};
use super::findings::{Fields, Findings, number};
use super::labels::named;
use super::measure::Group;
use super::product::Wanted;
use fracas::units::Quantity;
use fracas_figures::{Axis, Figure, Mark, Series, format_real};
use fracas_solvers::words::by_number;

/// Place of black in the palette: reference lines are nobody's curve.
const BLACK: usize = 6;

/// Largest value of a reference line over that of the data at which it is drawn. Unit: 1.
const BEYOND: f64 = 5.0;

/// Characters of a label that fit beside the axis of a figure of usual height.
const LABEL: usize = 48;

/// A point of a curve; y is not a number where a row has none.
struct Point {
    series: String,
    x: f64,
    y: f64,
}

/// The figure that a section asks for of some rows, where any of them has a point in it.
pub(super) fn figure(
    id: &str,
    section: &FigureSection,
    varying: &[String],
    (rows, findings): (&[&Fields], &Findings),
) -> Option<Figure> {
    let chosen = section.series.as_deref().unwrap_or(varying);
    let is_taken = |name: &String| *name == section.x || Some(name) == section.facet.as_ref();
    let is_published = |y: &String| y.starts_with("published.");
    let told_by_measure = section.y.len() > 1 && !section.y.iter().any(is_published);
    // curves of several measures have names already, to which what all rows share adds nothing
    let is_told = |name: &String| {
        section.series.is_some() || !told_by_measure || findings.values(rows, name).len() > 1
    };
    let chosen = chosen.iter().filter(|name| !is_taken(name));
    let chosen: Vec<&String> = chosen.filter(|name| is_told(name)).collect();
    let names = categories(section, rows, findings);
    let unit = unit(section, rows, findings);
    let scale = unit.as_ref().map_or(1.0, |(_, scale)| *scale);
    let place = |row: &[String]| match &names {
        Some(names) => {
            let own = findings.label(findings.field(row, &section.x));
            names.iter().position(|name| *name == own).map(|k| k as f64)
        }
        None => Some(findings.value(row, &section.x, false) / scale).filter(|x| x.is_finite()),
    };
    let series_of = |row: &[String], y: &str| {
        let mut parts: Vec<String> = chosen
            .iter()
            .map(|name| named(name, findings.field(row, name), findings))
            .filter(|part| !part.is_empty())
            .collect();
        if let Some(measure) = y.strip_prefix("published.") {
            parts.push("published".into());
            if parts.len() == 1 {
                parts.push(axis_label(measure));
            }
        } else if told_by_measure {
            parts.push(axis_label(y));
        }
        parts.join(", ")
    };
    let points = rows.iter().filter_map(|row| {
        let good = findings.is_good(row);
        let x = place(row)?;
        Some(section.y.iter().map(move |y| {
            let value = findings.value(row, y, false);
            let shown = good || y.starts_with("published.");
            Point {
                series: series_of(row, y),
                x,
                y: if shown { value } else { f64::NAN },
            }
        }))
    });
    let points: Vec<Point> = points.flatten().collect();
    let shown = points.iter().filter(|point| point.y.is_finite()).count();
    if shown == 0 {
        return None;
    }
    let first = rows.first().copied()?;
    let mut caption = findings.filled(&section.caption, first);
    let all = rows.len() * section.y.len();
    let missing = all - shown;
    if missing > 0 {
        let gap = if caption.is_empty() { "" } else { " " };
        let have = by_number(missing, "has", "have");
        caption +=
            &format!("{gap}{missing} of {all} rows {have} no point here; the table says why.");
    }
    let x = match &names {
        Some(names) => Axis::categories(&axis_label(&section.x), names.clone()),
        None => axis(&section.x, section.log_x, &points, |p| p.x),
    };
    let in_unit = |(unit, _): (String, f64)| format!("{} [{unit}]", axis_label(&section.x));
    let x = match section.x_label.clone().or(unit.map(in_unit)) {
        Some(label) => Axis { label, ..x },
        None => x,
    };
    let first_y = section.y.first().map_or("", String::as_str);
    let mut y = axis(first_y, section.log_y, &points, |p| p.y);
    let highest = points.iter().map(|p| p.y).filter(|y| y.is_finite());
    let highest = BEYOND * highest.fold(0.0, f64::max);
    let lines = lines(section, (rows, findings), &points, names.is_some());
    let (lines, beyond): (Vec<_>, Vec<_>) =
        lines.into_iter().partition(|line| match section.log_y {
            true => line.points[0][1] > 0.0,
            false => line.points[0][1] <= highest,
        });
    if let (Some([_, high]), false) = (y.range, section.log_y) {
        let of_lines = lines.iter().map(|line| 1.08 * line.points[0][1]);
        y = y.range(0.0, of_lines.fold(high, f64::max));
    }
    for line in &beyond {
        let at = format_real(line.points[0][1]);
        caption += &format!(" {} = {at} lies beyond the axis.", line.name);
    }
    let plain = section.y.iter().filter(|y| !y.starts_with("published."));
    y.label = plain.map(|y| axis_label(y)).collect::<Vec<_>>().join(", ");
    if told_by_measure && y.label.chars().count() > LABEL {
        // the legend has the names
        y.label = "number".to_owned();
    }
    // what the clock tells and what a sweep moves to and fro is joined in the order of the rows
    let group = Name::find(&section.x).map(Name::group);
    let is_timed = matches!(group, Some(Group::Clock | Group::Condition));
    let mut figure = Figure::new(id, "", &caption, x, y);
    let bars = names.is_some() && section.kind == Kind::Curves;
    figure.series = curves(&points, bars, is_timed, section.kind);
    figure.series.extend(lines);
    Some(figure)
}

/// Names along x, where its values are no numbers.
fn categories(
    section: &FigureSection,
    rows: &[&Fields],
    findings: &Findings,
) -> Option<Vec<String>> {
    let known = findings.header.contains(&section.x);
    let mut fields = rows.iter().map(|row| findings.field(row, &section.x));
    if !known
        || Name::find(&section.x).is_some_and(|name| name.group() != Group::Settings)
        || fields
            .clone()
            .all(|field| field.is_empty() || number(field).is_some())
    {
        return None;
    }
    let mut names = Vec::new();
    let label = |field| findings.label(field);
    fields.by_ref().map(label).for_each(|name| {
        if !names.contains(&name) {
            names.push(name);
        }
    });
    Some(names)
}

/// The unit of the first value along x, and its size in SI; none where values are plain numbers.
fn unit(section: &FigureSection, rows: &[&Fields], findings: &Findings) -> Option<(String, f64)> {
    let field = findings.field(rows.first()?, &section.x);
    let first: Quantity = field
        .parse()
        .ok()
        .filter(|_| field.parse::<f64>().is_err())?;
    let unit = first.unit().to_owned();
    let size = format!("1 {unit}").parse::<Quantity>().ok()?.si();
    Some((unit, size))
}

/// Series in the order in which rows name them first; what the clock tells is joined in the order of the rows.
fn curves(points: &[Point], bars: bool, timed: bool, kind: Kind) -> Vec<Series> {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.series.as_str()) {
            names.push(&point.series);
        }
    }
    let curve = |name: &&str| {
        let own = points.iter().filter(|point| point.series == *name);
        let mut own: Vec<[f64; 2]> = own.map(|point| [point.x, point.y]).collect();
        if bars {
            return Series::new(name, Mark::Bars, own);
        }
        own.retain(|[_, y]| y.is_finite());
        if !timed {
            own.sort_by(|a, b| a[0].total_cmp(&b[0]));
        }
        own.dedup();
        // two values of one x make no curve
        let twice = own.windows(2).any(|pair| pair[0][0] == pair[1][0]);
        let mark = if twice || kind == Kind::Points {
            Mark::Points
        } else {
            Mark::LinePoints
        };
        Series::new(name, mark, own)
    };
    let has_a_value = |series: &Series| series.points.iter().any(|[_, y]| y.is_finite());
    names.iter().map(curve).filter(has_a_value).collect()
}

/// Reference lines across a figure.
fn lines(
    section: &FigureSection,
    (rows, findings): (&[&Fields], &Findings),
    points: &[Point],
    bars: bool,
) -> Vec<Series> {
    let ends = points.iter().map(|point| point.x);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
        (a.min(x), b.max(x))
    });
    let margin = if bars { 0.5 } else { 0.0 };
    let series = |(k, line): (usize, &ReferenceLine)| {
        let wanted = Wanted::new(&line.of_rows);
        let of_row = || {
            let first = *rows.first()?;
            let facet = |row: &[String]| {
                let axis = section.facet.as_deref().unwrap_or_default();
                findings.field(row, axis).to_owned()
            };
            let is_meant = |row: &&Fields| wanted.is_met(|name| findings.field(row, name).into());
            let mut meant = findings.rows.iter().filter(is_meant);
            let row = meant.find(|row| facet(row) == facet(first))?;
            Some(findings.value(row, section.y.first()?, false))
        };
        let y = line.y.or_else(of_row).filter(|y| y.is_finite())?;
        let name = match line.source.as_str() {
            "" => line.label.clone(),
            source => format!("{} ({source})", line.label),
        };
        let ends = vec![[low - margin, y], [high + margin, y]];
        // that of a row goes with the curve of its place
        let tone = if line.y.is_some() { BLACK } else { k };
        Some(Series::new(&name, Mark::Dashed, ends).tone(tone))
    };
    section.line.iter().enumerate().filter_map(series).collect()
}

/// A linear axis of counts begins at 0, so that growth is seen for what it is.
fn axis(name: &str, log: bool, points: &[Point], of: impl Fn(&Point) -> f64) -> Axis {
    let label = axis_label(name);
    if log {
        return Axis::log(&label);
    }
    let most = points
        .iter()
        .map(of)
        .filter(|v| v.is_finite())
        .fold(0.0, f64::max);
    match ["n_it", "C_s", "n"].contains(&name) && most > 0.0 {
        true => Axis::linear(&label).range(0.0, 1.08 * most),
        false => Axis::linear(&label),
    }
}

pub(super) fn axis_label(name: &str) -> String {
    if let Some(of) = name
        .strip_prefix("log10(")
        .and_then(|of| of.strip_suffix(')'))
    {
        return format!("log₁₀ of {}", axis_label(of));
    }
    let measure = Name::ALL.iter().find(|measure| measure.text() == name);
    measure.map_or(name, |measure| measure.label()).to_owned()
}
