//! One figure of a study: curves or bars, reference lines, labels.

use super::Name;
use super::figure_section::{FigureSection, Kind};
use super::findings::{Fields, Findings};
use super::measure::Group;
use super::product::Wanted;
use crate::plot::{Axis, Figure, Mark, Series};
use std::path::Path;

/// Place of black in the palette: reference lines are nobody's curve.
const BLACK: usize = 6;

/// Cut off of a path in legends.
const EXTENSION: &str = "toml";

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
    facet: Option<&str>,
    varying: &[String],
    (rows, findings): (&[&Fields], &Findings),
) -> Option<Figure> {
    let chosen = section.series.as_deref().unwrap_or(varying);
    let is_taken = |name: &String| *name == section.x || Some(name) == section.facet.as_ref();
    let chosen: Vec<&String> = chosen.iter().filter(|name| !is_taken(name)).collect();
    let names = categories(section, rows, findings);
    let place = |row: &[String]| match &names {
        Some(names) => {
            let own = label(findings.field(row, &section.x));
            names.iter().position(|name| *name == own).map(|k| k as f64)
        }
        None => Some(findings.value(row, &section.x, false)).filter(|x| x.is_finite()),
    };
    let series_of = |row: &[String], y: &str| {
        let mut parts: Vec<String> = chosen
            .iter()
            .map(|name| named(name, findings.field(row, name)))
            .filter(|part| !part.is_empty())
            .collect();
        if let Some(measure) = y.strip_prefix("published.") {
            parts.push("published".into());
            if parts.len() == 1 {
                parts.push(axis_label(measure));
            }
        } else if section.y.len() > 1 && !section.y.iter().any(|y| y.starts_with("published.")) {
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
        caption += &format!("{gap}{missing} of {all} rows have no point here; the table says why.");
    }
    let x = match &names {
        Some(names) => Axis::categories(&axis_label(&section.x), names.clone()),
        None => axis(&section.x, section.log_x, &points, |p| p.x),
    };
    let x = match &section.x_label {
        Some(label) => Axis {
            label: label.clone(),
            ..x
        },
        None => x,
    };
    let first_y = section.y.first().map_or("", String::as_str);
    let mut y = axis(first_y, section.log_y, &points, |p| p.y);
    let plain = section.y.iter().filter(|y| !y.starts_with("published."));
    y.label = plain.map(|y| axis_label(y)).collect::<Vec<_>>().join(", ");
    let title = facet.map(label).unwrap_or_default();
    // what the clock tells and what a sweep moves to and fro is joined in the order of the rows
    let group = Name::find(&section.x).map(Name::group);
    let is_timed = matches!(group, Some(Group::Clock | Group::Condition));
    let mut figure = Figure::new(id, &title, &caption, x, y);
    let bars = names.is_some() && section.kind == Kind::Curves;
    figure.series = curves(&points, bars, is_timed, section.kind);
    reference_lines(&mut figure, section, (rows, findings), &points, bars);
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
            .all(|field| field.is_empty() || field.parse::<f64>().is_ok())
    {
        return None;
    }
    let mut names = Vec::new();
    fields.by_ref().map(label).for_each(|name| {
        if !names.contains(&name) {
            names.push(name);
        }
    });
    Some(names)
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

fn reference_lines(
    figure: &mut Figure,
    section: &FigureSection,
    (rows, findings): (&[&Fields], &Findings),
    points: &[Point],
    bars: bool,
) {
    let ends = points.iter().map(|point| point.x);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
        (a.min(x), b.max(x))
    });
    let margin = if bars { 0.5 } else { 0.0 };
    for (k, line) in section.line.iter().enumerate() {
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
        let Some(y) = line.y.or_else(of_row).filter(|y| y.is_finite()) else {
            continue;
        };
        let name = match line.source.as_str() {
            "" => line.label.clone(),
            source => format!("{} ({source})", line.label),
        };
        let ends = vec![[low - margin, y], [high + margin, y]];
        // that of a row goes with the curve of its place
        let tone = if line.y.is_some() { BLACK } else { k };
        let series = Series::new(&name, Mark::Dashed, ends);
        figure.series.push(series.tone(tone));
    }
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

/// A value in a legend; what is no word of its own says whose value it is.
pub(super) fn named(axis: &str, field: &str) -> String {
    let of_its_own = ["refine", "rhs", "tolerance", "stabilization", "threads"];
    match field {
        "" => String::new(),
        "default" if axis == "augmentation" => "default C".into(),
        "default" => format!("default {axis}"),
        _ if axis == "augmentation" => format!("C = {field}"),
        _ if of_its_own.contains(&axis) || axis.contains('.') => {
            let short = axis.rsplit('.').next().unwrap_or(axis);
            format!("{short} = {field}")
        }
        _ => label(field),
    }
}

/// The name of a file in the place of its path, that of a scene without its size.
pub(super) fn label(field: &str) -> String {
    let field = field.strip_suffix(crate::scenes::SMALL).unwrap_or(field);
    let path = Path::new(field);
    let is_scene = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(EXTENSION));
    let name = if is_scene {
        path.file_stem()
    } else {
        path.file_name()
    };
    match (path.is_absolute(), name) {
        (true, Some(name)) => name.to_string_lossy().into_owned(),
        _ => field.to_owned(),
    }
}
