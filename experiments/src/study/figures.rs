//! Figures of a study, as asked for, or sensible ones.

use super::figure_section::FigureSection;
use super::outcome::CONVERGED;
use super::rows::Findings;
use super::{Name, Study};
use crate::plot::{Axis, Figure, Mark, Series};
use anyhow::bail;
use std::collections::BTreeSet;
use std::path::Path;

/// Cut off of a path in legends.
const EXTENSION: &str = "toml";

impl Study {
    /// Refuses a figure of what is neither measured nor varied.
    pub(super) fn check_figures(&self) -> anyhow::Result<()> {
        let measures: Vec<&str> = Name::ALL.iter().map(|name| name.text()).collect();
        let axes = self.axis_names();
        let axes: Vec<&str> = axes.iter().map(String::as_str).collect();
        let both = [measures.as_slice(), &axes].concat();
        for (k, figure) in self.figure.iter().enumerate() {
            let require = |key: &str, name: &str, known: &[&str]| match known.contains(&name) {
                true => Ok(()),
                false => bail!(
                    "[[figure]] {}: `{key}` is `{name}`; there are: {}",
                    k + 1,
                    known.join(", ")
                ),
            };
            require("x", &figure.x, &both)?;
            require("y", &figure.y, &measures)?;
            for series in figure.series.iter().flatten() {
                require("series", series, &axes)?;
            }
        }
        Ok(())
    }
}

/// Every figure that has something to show.
pub(super) fn figures(study: &Study, findings: &Findings) -> Vec<Figure> {
    let varying = varying(study, findings);
    let asked = match study.figure.is_empty() {
        true => sensible(&varying),
        false => study.figure.clone(),
    };
    let mut figures: Vec<Figure> = Vec::new();
    for section in &asked {
        let id = format!("{}_over_{}", section.y, section.x.replace('.', "_"));
        let again = figures
            .iter()
            .filter(|figure| figure.id.starts_with(&id))
            .count();
        let id = if again == 0 {
            id
        } else {
            format!("{id}_{}", again + 1)
        };
        figures.extend(figure(&id, section, &varying, findings));
    }
    figures
}

/// Axes with more than one value.
fn varying(study: &Study, findings: &Findings) -> Vec<String> {
    let values = |name: &String| {
        let fields = findings.rows.iter().map(|row| findings.field(row, name));
        fields.collect::<BTreeSet<_>>().len()
    };
    let mut names = study.axis_names();
    names.retain(|name| values(name) > 1);
    names
}

fn sensible(varying: &[String]) -> Vec<FigureSection> {
    let sizes = |name: &String| name == "refine" || name.starts_with("mesh.");
    let has_sizes = varying.iter().any(sizes);
    let keys = varying.iter().find(|name| name.contains('.'));
    let tolerances = varying.iter().any(|name| name == "tolerance");
    let x = match (has_sizes, keys, varying.first()) {
        (true, ..) => "n",
        (_, Some(key), _) => key,
        (_, _, Some(first)) => first,
        _ => "method",
    };
    let others = |not: &dyn Fn(&String) -> bool| {
        let names = varying.iter().filter(|name| *name != x && !not(name));
        Some(names.cloned().collect::<Vec<_>>())
    };
    let section = |x: &str, y: &str, series, log_y| FigureSection {
        x: x.into(),
        y: y.into(),
        series,
        log_x: x == "n" || x.ends_with("_s"),
        log_y,
        caption: String::new(),
        line: Vec::new(),
    };
    let of_size: &dyn Fn(&String) -> bool = if has_sizes { &sizes } else { &|_| false };
    let mut sections = vec![
        section(x, "n_it", others(of_size), false),
        section(x, "C_s", others(of_size), true),
    ];
    if tolerances {
        let series = others(&|name| name == "tolerance");
        sections.push(section("solve_s", "error_u", series.clone(), true));
        sections.push(section("solve_s", "error_t", series, true));
    }
    sections
}

/// A point of a curve; y is not a number where a row has none.
struct Point {
    series: String,
    x: f64,
    y: f64,
}

fn figure(
    id: &str,
    section: &FigureSection,
    varying: &[String],
    findings: &Findings,
) -> Option<Figure> {
    let chosen = section.series.as_deref().unwrap_or(varying);
    let chosen: Vec<&String> = chosen.iter().filter(|name| **name != section.x).collect();
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
    let points = findings.rows.iter().filter_map(|row| {
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
    let missing = findings.rows.len() - shown;
    let mut caption = section.caption.clone();
    if missing > 0 {
        let of = findings.rows.len();
        let gap = if caption.is_empty() { "" } else { " " };
        caption += &format!("{gap}{missing} of {of} rows have no point here; the table says why.");
    }
    let x = match &names {
        Some(names) => Axis::categories(&axis_label(&section.x), names.clone()),
        None => axis(&section.x, section.log_x, &points, |p| p.x),
    };
    let y = axis(&section.y, section.log_y, &points, |p| p.y);
    let mut figure = Figure::new(id, "", &caption, x, y);
    figure.series = curves(&points, names.is_some());
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

/// Series in the order in which rows name them first.
fn curves(points: &[Point], bars: bool) -> Vec<Series> {
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
        own.sort_by(|a, b| a[0].total_cmp(&b[0]));
        // two values of one x make no curve
        let twice = own.windows(2).any(|pair| pair[0][0] == pair[1][0]);
        let mark = if twice {
            Mark::Points
        } else {
            Mark::LinePoints
        };
        Series::new(name, mark, own)
    };
    let all = names.iter().map(curve);
    all.filter(|series| !series.points.is_empty()).collect()
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
        figure.series.push(Series::new(&name, Mark::Dashed, ends));
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
        "default" => format!("{axis} by default"),
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
