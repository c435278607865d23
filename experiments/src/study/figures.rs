//! Figures of a study, as asked for, or sensible ones.

use super::Study;
use super::curves::figure;
use super::figure_section::{FigureSection, Kind};
use super::findings::{Fields, Findings};
use super::labels::named;
use super::map::map;
use super::page::OWN_TABLES;
use super::tornado::tornado;
use fracas_figures::{Axis, Figure, Mark, Series, Spectrum};
use std::collections::BTreeSet;
use toml::Table;

/// Characters of the name of a file, at most: file systems take 255 bytes. Unit: 1.
const LONGEST: usize = 120;

/// Every figure that has something to show, and why those that were asked for and are not there have nothing.
pub(super) fn figures(study: &Study, findings: &Findings) -> (Vec<Figure>, Vec<String>) {
    let varying = varying(study, findings);
    let asked = match study.figure.is_empty() {
        true => sensible(&varying),
        false => study.figure.clone(),
    };
    let (mut figures, mut notes) = (Vec::<Figure>::new(), Vec::new());
    for section in asked.iter().filter(|f| study.is_at_level(&f.not_at)) {
        // over unknowns a curve is a method on all meshes
        let mut varying = varying.clone();
        if ["n", "n_u", "n_t"].contains(&section.x.as_str()) {
            varying.retain(|name| !is_of_size(name));
        }
        let chosen = findings.chosen(&section.of_rows);
        let (before, told) = (figures.len(), notes.len());
        let facets = facets(section, &chosen, findings);
        for (k, facet) in facets.iter().enumerate() {
            let axis = section.facet.as_deref().unwrap_or("row");
            let in_facet =
                |row: &&&Fields| facet.is_none_or(|value| findings.field(row, axis) == value);
            let rows: Vec<&Fields> = chosen.iter().filter(in_facet).copied().collect();
            let Some(first) = rows.first() else {
                continue;
            };
            let id = match (&section.id, facet) {
                (Some(id), _) if id.contains('{') => findings.filled(id, first),
                (Some(id), Some(_)) => format!("{id}_{}", k + 1),
                (Some(id), None) => id.clone(),
                (None, facet) => {
                    let y = (section.y.first()).map_or(section.kind.name(), String::clone);
                    let id = match section.x.as_str() {
                        "" => y,
                        x => format!("{y}_over_{x}"),
                    };
                    facet.map_or(id.clone(), |value| {
                        format!("{id}_{}", findings.label(value))
                    })
                }
            };
            let id = id.replace(|c: char| !c.is_ascii_alphanumeric() && c != '_', "_");
            let id: String = id.chars().take(LONGEST).collect();
            let again = |k: usize| {
                if k == 1 {
                    id.clone()
                } else {
                    format!("{id}_{k}")
                }
            };
            let is_free = |id: &String| {
                let of_table = study.table.iter().any(|table| table.id == *id);
                let taken = of_table || OWN_TABLES.contains(&id.as_str());
                !taken && figures.iter().all(|f| f.id != *id)
            };
            let id = (1..).map(again).find(is_free).unwrap_or_default();
            let title = facet.map_or(String::new(), |value| named(axis, value, findings));
            match section.kind {
                Kind::Curves | Kind::Points => {
                    let drawn = figure(&id, section, &varying, (&rows, findings));
                    figures.extend(drawn.map(|figure| Figure { title, ..figure }));
                }
                Kind::Residuals => {
                    figures.extend(residuals(&id, section, &rows, findings, &varying))
                }
                Kind::Map if is_crowded(section, &rows, findings) => {
                    notes.push(format!(
                        "Figure {id} is not drawn: several rows fall on one of its cells; choose among them by `where`, `within` or `facet`."
                    ));
                }
                Kind::Map | Kind::Tornado => {
                    let draw = match section.kind {
                        Kind::Map => map,
                        _ => tornado,
                    };
                    let drawn = draw(&id, section, &rows, findings);
                    figures.extend(drawn.map(|figure| Figure { title, ..figure }));
                }
                _ => figures.extend(eigenvalues(&id, section, &rows, findings)),
            }
        }
        if figures.len() == before && told == notes.len() && !study.figure.is_empty() {
            let name = (section.id.clone()).unwrap_or_else(|| section.kind.name());
            let why = match chosen.is_empty() {
                true => "no row has what its `where` asks for",
                false => "no row has a value for it",
            };
            notes.push(format!("Figure {name} is not drawn: {why}."));
        }
    }
    (figures, notes)
}

/// True where one cell of a map would show several rows.
fn is_crowded(section: &FigureSection, rows: &[&Fields], findings: &Findings) -> bool {
    let names = [&section.x].into_iter().chain(section.y.first());
    let names: Vec<&String> = names.chain(&section.within).collect();
    let cells: BTreeSet<Vec<&str>> = (rows.iter())
        .map(|row| names.iter().map(|name| findings.field(row, name)).collect())
        .collect();
    cells.len() < rows.len()
}

/// The figure of one or several spectra.
fn eigenvalues(
    id: &str,
    section: &FigureSection,
    rows: &[&Fields],
    findings: &Findings,
) -> Option<Figure> {
    let spectra = rows.iter().filter_map(|row| {
        let names = section.series.iter().flatten();
        let name: Vec<String> = names
            .map(|name| findings.label(findings.field(row, name)))
            .collect();
        Some((name.join(", "), findings.kept(row)?.spectrum.as_ref()?))
    });
    let spectra: Vec<(String, &Spectrum)> = spectra.collect();
    let (_, first) = spectra.first()?;
    let caption = findings.filled(&section.caption, rows.first()?);
    let mut figure = match section.kind {
        Kind::Strips => Spectrum::strips(id, "", &spectra),
        Kind::Spectra => {
            let axes = (Axis::linear("Re λ"), Axis::linear("Im λ"));
            let mut figure = Figure::new(id, "", "", axes.0, axes.1);
            for (name, spectrum) in &spectra {
                let points: Vec<_> = spectrum.points().collect();
                figure = figure.with(Series::new(&spectrum.labelled(name), Mark::Points, points));
            }
            figure
        }
        Kind::GmresBounds => first.gmres.as_ref()?.figure(id, ""),
        _ => first.figure(id),
    };
    if !caption.is_empty() {
        figure.caption = caption;
    }
    Some(figure)
}

/// Relative residuals over iterations, a curve per row.
fn residuals(
    id: &str,
    section: &FigureSection,
    rows: &[&Fields],
    findings: &Findings,
    varying: &[String],
) -> Option<Figure> {
    let caption = findings.filled(&section.caption, rows.first()?);
    let residual = Axis::log("relative residual, as the iteration tells it");
    let axes = (Axis::linear("iteration"), residual);
    let mut figure = Figure::new(id, "", &caption, axes.0, axes.1);
    let names = section.series.as_deref().unwrap_or(varying);
    let differs = |name: &&String| findings.values(rows, name).len() > 1;
    let names: Vec<&String> = names.iter().filter(differs).collect();
    for row in rows {
        let points = &findings.kept(row)?.residuals;
        let points: Vec<[f64; 2]> = points
            .iter()
            .enumerate()
            .map(|(k, r)| [k as f64, *r])
            .collect();
        let words = names
            .iter()
            .map(|name| named(name, findings.field(row, name), findings));
        let words: Vec<String> = words.filter(|word| !word.is_empty()).collect();
        if !points.is_empty() {
            figure = figure.with(Series::new(&words.join(", "), Mark::Line, points));
        }
    }
    (!figure.series.is_empty()).then_some(figure)
}

/// Values that get a figure of their own, or one figure of all rows; a spectrum has one per row.
fn facets<'a>(
    section: &FigureSection,
    rows: &[&'a Fields],
    findings: &'a Findings,
) -> Vec<Option<&'a str>> {
    let own = section.kind.is_of_one().then_some("row");
    let Some(axis) = section.facet.as_deref().or(own) else {
        return vec![None];
    };
    let values = findings.values(rows, axis).into_iter();
    values.filter(|value| !value.is_empty()).map(Some).collect()
}

/// Axes with more than one value.
fn varying(study: &Study, findings: &Findings) -> Vec<String> {
    let values = |name: &String| {
        let fields = findings.rows.iter().map(|row| findings.field(row, name));
        fields.collect::<BTreeSet<_>>().len()
    };
    let mut names = study.axis_names();
    names.retain(|name| study.varies(name) && values(name) > 1);
    names
}

/// True for axes that make meshes of a scene finer.
fn is_of_size(name: &str) -> bool {
    name == "refine" || name.starts_with("mesh.")
}

fn sensible(varying: &[String]) -> Vec<FigureSection> {
    let sizes = |name: &String| is_of_size(name);
    let has_sizes = varying.iter().any(sizes);
    let keys = varying.iter().find(|name| name.contains('.'));
    let tolerances = varying.iter().any(|name| name == "tolerance");
    let x = match (has_sizes, keys, varying.first()) {
        (true, ..) => "n",
        (_, Some(key), _) => key,
        (..) if tolerances => "tolerance",
        (_, _, Some(first)) => first,
        _ => "method",
    };
    let others = |not: &dyn Fn(&String) -> bool| {
        let names = varying.iter().filter(|name| !not(name));
        Some(names.cloned().collect::<Vec<_>>())
    };
    let of_source = |name: &&String| ["scene", "system"].contains(&name.as_str()) && *name != x;
    let facet = varying.iter().find(of_source);
    let section = |x: &str, y: &str, series, log_y| FigureSection {
        id: None,
        kind: Kind::Curves,
        color: String::new(),
        colors: None,
        within: Vec::new(),
        of_rows: Table::new(),
        not_at: Vec::new(),
        x: x.into(),
        x_label: None,
        y: vec![y.into()],
        series,
        facet: facet.cloned(),
        log_x: ["n", "tolerance", "solve_s"].contains(&x),
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
