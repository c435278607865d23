//! Figures of a study, as asked for, or sensible ones.

use super::curves::{figure, label};
use super::figure_section::FigureSection;
use super::rows::Findings;
use super::{Name, Study};
use crate::plot::Figure;
use anyhow::bail;
use std::collections::BTreeSet;

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
            if let Some(facet) = &figure.facet {
                require("facet", facet, &axes)?;
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
        for facet in facets(section, findings) {
            let mut id = format!("{}_over_{}", section.y, section.x);
            if let Some(value) = facet {
                id = format!("{id}_{}", label(value));
            }
            let id = id.replace(|c: char| !c.is_ascii_alphanumeric() && c != '_', "_");
            let again = (1..).find_map(|k| {
                let id = if k == 1 {
                    id.clone()
                } else {
                    format!("{id}_{k}")
                };
                figures.iter().all(|f| f.id != id).then_some(id)
            });
            let id = again.unwrap_or(id);
            figures.extend(figure(&id, section, facet, &varying, findings));
        }
    }
    figures
}

/// Values that get a figure of their own, or one figure of all rows.
fn facets<'a>(section: &FigureSection, findings: &'a Findings) -> Vec<Option<&'a str>> {
    let Some(axis) = &section.facet else {
        return vec![None];
    };
    let mut values = Vec::new();
    for row in &findings.rows {
        let value = Some(findings.field(row, axis)).filter(|value| !value.is_empty());
        if value.is_some() && !values.contains(&value) {
            values.push(value);
        }
    }
    values
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
        x: x.into(),
        y: y.into(),
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
