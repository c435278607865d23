//! Rows as fields under headings: looked up, chosen, computed with.

use super::formula;
use super::labels::{label, told_apart};
use super::measure::{Group, Name};
use super::outcome::{GOOD, NOT_TRIED};
use super::product::Wanted;
use fracas::units::Quantity;
use fracas_figures::Spectrum;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Names of values that others have published.
pub(super) const PUBLISHED: &str = "published.";

/// `[[published]]`: what others have published of some rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// Of which rows.
    #[serde(rename = "where")]
    pub rows: Table,
    /// Where from.
    pub source: String,
    /// By measure; `"X"` for a method that failed.
    #[serde(flatten)]
    pub values: BTreeMap<String, Value>,
}

/// What figures and checks need of a row beside its fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Kept {
    #[serde(default)]
    pub(super) residuals: Vec<f64>,
    #[serde(default)]
    pub(super) spectrum: Option<Spectrum>,
}

/// A row, field by field.
pub(super) type Fields = Vec<String>;

/// Every row, in the order of the product.
#[derive(Default)]
pub(super) struct Findings {
    pub(super) header: Vec<String>,
    pub(super) rows: Vec<Fields>,
    /// By number of the row.
    pub(super) kept: BTreeMap<usize, Kept>,
    published: Vec<(Wanted, BTreeMap<String, String>)>,
    sources: std::collections::BTreeSet<String>,
    /// Of paths whose last part is not theirs alone.
    labels: BTreeMap<String, String>,
}

/// A number, or the value in SI of one with a unit.
pub(super) fn number(text: &str) -> Option<f64> {
    let plain = text.parse().ok();
    plain.or_else(|| Some(text.parse::<Quantity>().ok()?.si()))
}

impl Findings {
    pub(super) fn new(header: Vec<String>, published: &[Published]) -> Self {
        let text = |(key, value): (&String, &Value)| (key.clone(), super::product::text(value));
        let sources = published.iter().map(|p| p.source.clone()).collect();
        let published = published.iter().map(|p| {
            let values = p.values.iter().map(text).collect();
            (Wanted::new(&p.rows), values)
        });
        Self {
            header,
            published: published.collect(),
            sources,
            ..Self::default()
        }
    }

    /// The same with rows, and what is kept of them.
    pub(super) fn with_rows(self, rows: Vec<Fields>, kept: BTreeMap<usize, Kept>) -> Self {
        let labels = told_apart(rows.iter().flatten().map(String::as_str));
        Self {
            rows,
            kept,
            labels,
            ..self
        }
    }

    /// A field as it is shown.
    pub(super) fn label(&self, field: &str) -> String {
        self.labels.get(field).cloned().unwrap_or(label(field))
    }

    /// Where what is published is from.
    pub(super) fn sources(&self) -> String {
        let sources: Vec<&str> = self.sources.iter().map(String::as_str).collect();
        sources.join("; ")
    }

    /// What is kept of a row.
    pub(super) fn kept(&self, row: &[String]) -> Option<&Kept> {
        self.kept.get(&self.field(row, "row").parse().ok()?)
    }

    /// The field of a row under a heading, or what is published of it; empty where there is none.
    pub(super) fn field<'a>(&'a self, row: &'a [String], name: &str) -> &'a str {
        if let Some(measure) = name.strip_prefix(PUBLISHED) {
            let is_meant = |wanted: &Wanted| wanted.is_met(|n| self.field(row, n).to_owned());
            let mut found = self.published.iter().filter(|(wanted, _)| is_meant(wanted));
            let value = found.find_map(|(_, values)| values.get(measure));
            return value.map_or("", String::as_str);
        }
        let column = self.header.iter().position(|heading| heading == name);
        column.map_or("", |column| &row[column])
    }

    /// The same as a number: yes is 1, no is 0, of a quantity its value in SI.
    pub(super) fn number(&self, row: &[String], name: &str) -> Option<f64> {
        match self.field(row, name) {
            "yes" => Some(1.0),
            "no" => Some(0.0),
            text => number(text).filter(|value| value.is_finite()),
        }
    }

    /// Value of a formula; not a number where a part of it is missing. With `failed`, n_it and C_s of a row that failed are infinite.
    pub(super) fn value(&self, row: &[String], of: &str, failed: bool) -> f64 {
        let mut number = |name: &str| {
            let infinite = failed && Name::find(name).is_some_and(|n| n.group() == Group::Count);
            let otherwise = if infinite { f64::INFINITY } else { f64::NAN };
            self.number(row, name).unwrap_or(otherwise)
        };
        formula::value(of, &mut number).unwrap_or(f64::NAN)
    }

    /// True where a row has what it was to bring.
    pub(super) fn is_good(&self, row: &[String]) -> bool {
        GOOD.contains(&self.field(row, "outcome"))
    }

    /// True where a row failed; one that nobody tried did not.
    pub(super) fn has_failed(&self, row: &[String]) -> bool {
        !self.is_good(row) && self.field(row, "outcome") != NOT_TRIED
    }

    /// Rows that have all of these values.
    pub(super) fn chosen(&self, of: &Table) -> Vec<&Fields> {
        let wanted = Wanted::new(of);
        let is_meant = |row: &&Fields| wanted.is_met(|name| label(self.field(row, name)));
        let is_named = |row: &&Fields| wanted.is_met(|name| self.field(row, name).to_owned());
        let rows = self.rows.iter();
        rows.filter(|row| is_meant(row) || is_named(row)).collect()
    }

    /// A sentence with the fields of a row in the place of `{name}`.
    pub(super) fn filled(&self, text: &str, row: &[String]) -> String {
        let mut filled = text.to_owned();
        for name in &self.header {
            let place = format!("{{{name}}}");
            if filled.contains(&place) {
                filled = filled.replace(&place, &self.label(self.field(row, name)));
            }
        }
        filled
    }

    /// Values of a column in the order in which rows have them first.
    pub(super) fn values<'a>(&'a self, rows: &[&'a Fields], name: &str) -> Vec<&'a str> {
        let mut values = Vec::new();
        for row in rows {
            let value = self.field(row, name);
            if !values.contains(&value) {
                values.push(value);
            }
        }
        values
    }
}
