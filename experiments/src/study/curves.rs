//! One figure of a study: curves or bars, reference lines, labels.

use super::Name;
use super::figure_section::FigureSection;
use super::outcome::CONVERGED;
use super::rows::Findings;
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

/// The figure that a section asks for, where any row has a point in it.
pub(super) fn figure(
    id: &str,
    section: &FigureSection,
    facet: Option<&str>,
    varying: &[String],
    findings: &Findings,
) -> Option<Figure> {
    let chosen = section.series.as_deref().unwrap_or(varying);
    let is_taken = |name: &String| *name == section.x || Some(name) == section.facet.as_ref();
    let chosen: Vec<&String> = chosen.iter().filter(|name| !is_taken(name)).collect();
    let in_facet = |row: &&Vec<String>| match (&section.facet, facet) {
        (Some(axis), Some(value)) => findings.field(row, axis) == value,
        _ => true,
    };
    let rows: Vec<&Vec<String>> = findings.rows.iter().filter(in_facet).collect();
    let names = categories(section, findings);
    let place = |row: &[String]| match &names {
        Some(names) => {
            let own = label(findings.field(row, &section.x));
            names.iter().position(|name| *name == own).map(|k| k as f64)
        }
        None => findings.number(row, &section.x),
    };
    let series_of = |row: &[String]| {
        let parts = chosen
            .iter()
            .map(|name| named(name, findings.field(row, name)));
        parts
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let points = rows.iter().filter_map(|row| {
        let solved = findings.field(row, "outcome") == CONVERGED;
        let y = findings.number(row, &section.y).filter(|_| solved);
        Some(Point {
            series: series_of(row),
            x: place(row)?,
            y: y.unwrap_or(f64::NAN),
        })
    });
    let points: Vec<Point> = points.collect();
    let shown = points.iter().filter(|point| point.y.is_finite()).count();
    if shown == 0 {
        return None;
    }
    let missing = rows.len() - shown;
    let mut caption = section.caption.clone();
    if missing > 0 {
        let of = rows.len();
        let gap = if caption.is_empty() { "" } else { " " };
        caption += &format!("{gap}{missing} of {of} rows have no point here; the table says why.");
    }
    let x = match &names {
        Some(names) => Axis::categories(&axis_label(&section.x), names.clone()),
        None => axis(&section.x, section.log_x, &points, |p| p.x),
    };
    let y = axis(&section.y, section.log_y, &points, |p| p.y);
    let title = facet.map(label).unwrap_or_default();
    let is_timed = Name::ALL
        .iter()
        .any(|name| name.is_measured() && name.text() == section.x);
    let mut figure = Figure::new(id, &title, &caption, x, y);
    figure.series = curves(&points, names.is_some(), is_timed);
    reference_lines(&mut figure, section, &points, names.is_some());
    Some(figure)
}

/// Names along x, where its values are no numbers.
fn categories(section: &FigureSection, findings: &Findings) -> Option<Vec<String>> {
    let mut fields = findings
        .rows
        .iter()
        .map(|row| findings.field(row, &section.x));
    if Name::ALL.iter().any(|name| name.text() == section.x)
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
fn curves(points: &[Point], bars: bool, timed: bool) -> Vec<Series> {
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
        // two values of one x make no curve
        let twice = own.windows(2).any(|pair| pair[0][0] == pair[1][0]);
        let mark = if twice {
            Mark::Points
        } else {
            Mark::LinePoints
        };
        Series::new(name, mark, own)
    };
    let has_a_value = |series: &Series| series.points.iter().any(|[_, y]| y.is_finite());
    names.iter().map(curve).filter(has_a_value).collect()
}

fn reference_lines(figure: &mut Figure, section: &FigureSection, points: &[Point], bars: bool) {
    let ends = points.iter().map(|point| point.x);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
        (a.min(x), b.max(x))
    });
    let margin = if bars { 0.5 } else { 0.0 };
    for line in &section.line {
        let name = format!("{} ({})", line.label, line.source);
        let ends = vec![[low - margin, line.y], [high + margin, line.y]];
        figure
            .series
            .push(Series::new(&name, Mark::Dashed, ends).tone(BLACK));
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

fn axis_label(name: &str) -> String {
    let measure = Name::ALL.iter().find(|measure| measure.text() == name);
    measure.map_or(name, |measure| measure.label()).to_owned()
}

/// A value in a legend; what is no word of its own says whose value it is.
fn named(axis: &str, field: &str) -> String {
    let words = ["scene", "system", "method", "inner", "krylov"];
    match field {
        "" => String::new(),
        "default" if axis == "augmentation" => "default C".into(),
        "default" => format!("default {axis}"),
        _ if words.contains(&axis) => label(field),
        _ if axis == "augmentation" => format!("C = {field}"),
        _ => {
            let short = axis.rsplit('.').next().unwrap_or(axis);
            format!("{short} = {field}")
        }
    }
}

/// The name of a file in the place of its path.
pub(super) fn label(field: &str) -> String {
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
