//! Claims of a study, held against its rows.

use super::findings::{Fields, Findings, PUBLISHED};
use crate::report::{Basis, Check};
use fracas_figures::format_real;
use serde::{Deserialize, Serialize};
use toml::Table;

/// `[[check]]`: a claim, the numbers that it is about, and their bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckSection {
    /// In words; `{axis}` is filled in.
    pub claim: String,
    /// A measure, an axis, or a formula of them; `eigenvalues` with `minus` is how far apart two spectra lie.
    pub of: String,
    /// Rows that it is about.
    #[serde(default, rename = "where", skip_serializing_if = "Table::is_empty")]
    pub of_rows: Table,
    /// Which number of these rows; each has its own claim by default.
    #[serde(default)]
    pub take: Take,
    /// Divided by the number of other rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<Other>,
    /// Less the number of other rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minus: Option<Other>,
    /// Axes whose values pair rows with others before one is taken.
    #[serde(
        default,
        deserialize_with = "super::figure_section::one_or_many",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub pair: Vec<String>,
    /// An axis: the claim is made for each of its values.
    #[serde(default, rename = "for", skip_serializing_if = "Option::is_none")]
    pub each: Option<String>,
    /// At least, a number or a formula of the row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<Bound>,
    /// At most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<Bound>,
    /// This, …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub equals: Option<Bound>,
    /// … up to this relative difference.
    #[serde(default)]
    pub within: f64,
    /// This word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub is: Option<String>,
    /// Levels at which it is not made.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_at: Vec<String>,
    /// Where the bound is from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// A theorem or a solution in closed form gives the bound.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub closed_form: bool,
}

/// Rows to compare with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Other {
    /// As that of the check by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// Which rows.
    #[serde(default, rename = "where", skip_serializing_if = "Table::is_empty")]
    pub of_rows: Table,
    /// Which number of them.
    #[serde(default)]
    pub take: Take,
}

/// A number, or a formula of the row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Bound {
    /// A number.
    Number(f64),
    /// A formula.
    Formula(String),
}

/// One number of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Take {
    /// None: each is judged by itself.
    #[default]
    Each,
    /// The first row.
    First,
    /// The last row.
    Last,
    /// The largest.
    Max,
    /// The smallest.
    Min,
    /// Their sum.
    Sum,
    /// The largest rise from a row to the next one.
    Rise,
    /// How many different values there are.
    Distinct,
}

/// A number with the row that it is of.
type Of<'a> = (&'a Fields, f64);

impl CheckSection {
    /// Names and formulas that it mentions.
    pub(super) fn mentions(&self) -> Vec<&str> {
        let others = [&self.over, &self.minus].into_iter().flatten();
        let bounds = [&self.min, &self.max, &self.equals].into_iter().flatten();
        let formulas = bounds.filter_map(|bound| match bound {
            Bound::Formula(text) => Some(text.as_str()),
            Bound::Number(_) => None,
        });
        (others.filter_map(|other| other.of.as_deref()))
            .chain(formulas)
            .chain((self.of != EIGENVALUES).then_some(self.of.as_str()))
            .collect()
    }

    /// What is missing or too much, in a few words.
    pub(super) fn objection(&self) -> Option<&'static str> {
        let bounds = [&self.min, &self.max, &self.equals].into_iter().flatten();
        match bounds.count() + usize::from(self.is.is_some()) {
            1 => {}
            _ => return Some("it needs one of min, max, equals, is"),
        }
        if self.over.is_some() && self.minus.is_some() {
            return Some("it has `over` and `minus`");
        }
        let alone = self.over.is_none() && self.minus.is_none();
        (!self.pair.is_empty() && alone).then_some("`pair` needs `over` or `minus`")
    }

    /// Holds the claim against rows.
    pub(super) fn checks(&self, findings: &Findings) -> Vec<Check> {
        let basis = self.basis(findings);
        let checks = self.judged_rows(findings).into_iter();
        checks.map(|check| check.by(basis.clone())).collect()
    }

    /// Printed where a bound names what is published, of a theory where the file says so, and a threshold otherwise.
    fn basis(&self, findings: &Findings) -> Basis {
        let mut bounds = [&self.min, &self.max, &self.equals].into_iter().flatten();
        let is_printed =
            |bound: &Bound| matches!(bound, Bound::Formula(text) if text.contains(PUBLISHED));
        match (bounds.any(is_printed), self.closed_form) {
            (true, _) => Basis::Published(findings.sources()),
            (false, true) => Basis::ClosedForm,
            (false, false) => Basis::Own,
        }
    }

    fn judged_rows(&self, findings: &Findings) -> Vec<Check> {
        let rows = findings.chosen(&self.of_rows);
        let Some(axis) = &self.each else {
            return self.of_rows(&rows, findings, None);
        };
        let values = findings.values(&rows, axis);
        let of_value = |value: &str| {
            let own: Vec<&Fields> = (rows.iter().copied())
                .filter(|row| findings.field(row, axis) == value)
                .collect();
            self.of_rows(&own, findings, Some((axis, value)))
        };
        values.into_iter().flat_map(of_value).collect()
    }

    fn of_rows(
        &self,
        rows: &[&Fields],
        findings: &Findings,
        only: Option<(&String, &str)>,
    ) -> Vec<Check> {
        if rows.is_empty() {
            return vec![Check::holds(&self.claim, "rows", "none", false)];
        }
        if let Some(word) = &self.is {
            let check = |row: &&Fields| {
                let found = findings.field(row, &self.of);
                let claim = findings.filled(&self.claim, row);
                Check::holds(claim, word.as_str(), found, found == word)
            };
            return rows.iter().map(check).collect();
        }
        let other = self.over.as_ref().or(self.minus.as_ref()).map(|other| {
            let mut rows = findings.chosen(&other.of_rows);
            rows.retain(|row| only.is_none_or(|(axis, value)| findings.field(row, axis) == value));
            (other, rows)
        });
        let numbers = |of: &str, rows: &[&'_ Fields]| -> Vec<f64> {
            rows.iter()
                .map(|row| findings.value(row, of, true))
                .collect()
        };
        let combined = |ours: f64, theirs: f64| match self.over {
            Some(_) => ours / theirs,
            None => ours - theirs,
        };
        let mut of: Vec<Of<'_>> = rows.iter().copied().zip(numbers(&self.of, rows)).collect();
        if let (Some((other, theirs)), false) = (&other, self.pair.is_empty()) {
            let name = other.of.as_ref().unwrap_or(&self.of);
            for (row, number) in &mut of {
                let is_partner = |other: &&&Fields| {
                    let mut axes = self.pair.iter();
                    axes.all(|axis| findings.field(other, axis) == findings.field(row, axis))
                };
                let partner = theirs.iter().find(is_partner);
                *number = partner.map_or(f64::NAN, |partner| match self.of == EIGENVALUES {
                    true => apart(findings, row, partner),
                    false => combined(*number, findings.value(partner, name, true)),
                });
            }
        }
        let mut taken = match self.take {
            Take::Distinct => vec![(rows[0], findings.values(rows, &self.of).len() as f64)],
            take => take.of(&of),
        };
        if let (Some((other, theirs)), true) = (&other, self.pair.is_empty()) {
            let name = other.of.as_ref().unwrap_or(&self.of);
            let theirs: Vec<Of<'_>> = (theirs.iter().copied())
                .zip(numbers(name, theirs))
                .collect();
            let single = match other.take.of(&theirs).as_slice() {
                [(_, one)] => *one,
                // several or none: the check says which one
                _ => f64::NAN,
            };
            taken
                .iter_mut()
                .for_each(|(_, n)| *n = combined(*n, single));
        }
        let check = |(row, number): &Of<'_>| self.judged(row, *number, findings);
        taken.iter().map(check).collect()
    }

    fn judged(&self, row: &Fields, ours: f64, findings: &Findings) -> Check {
        let mut claim = findings.filled(&self.claim, row);
        if !self.source.is_empty() {
            claim = format!("{claim} ({})", self.source);
        }
        let value = |bound: &Bound| match bound {
            Bound::Number(value) => *value,
            Bound::Formula(text) => findings.value(row, text, false),
        };
        match (&self.min, &self.max, &self.equals) {
            (Some(low), ..) => Check::at_least(claim, value(low), ours),
            (_, Some(high), _) => Check::at_most(claim, value(high), ours),
            (.., Some(expected)) if self.within > 0.0 => {
                Check::close(claim, value(expected), ours, self.within)
            }
            (.., expected) => {
                let expected = expected.as_ref().map_or(f64::NAN, value);
                let words = [expected, ours].map(format_real);
                let [theirs, own] = words;
                Check::holds(claim, theirs, own, expected == ours)
            }
        }
    }
}

/// The word for all eigenvalues of a row.
const EIGENVALUES: &str = "eigenvalues";

/// Largest distance between the spectra of two rows.
fn apart(findings: &Findings, a: &Fields, b: &Fields) -> f64 {
    let spectrum = |row: &Fields| findings.kept(row).and_then(|kept| kept.spectrum.as_ref());
    match (spectrum(a), spectrum(b)) {
        (Some(a), Some(b)) => a.distance(b),
        _ => f64::NAN,
    }
}

impl Take {
    /// One number of several, or all of them.
    fn of<'a>(self, numbers: &[Of<'a>]) -> Vec<Of<'a>> {
        let best = |better: fn(f64, f64) -> bool| {
            numbers.iter().copied().reduce(|a, b| {
                // what is missing is never passed over
                match b.1.is_nan() || (!a.1.is_nan() && better(b.1, a.1)) {
                    true => b,
                    false => a,
                }
            })
        };
        let one = match self {
            Self::Each | Self::Distinct => return numbers.to_vec(),
            Self::First => numbers.first().copied(),
            Self::Last => numbers.last().copied(),
            Self::Max => best(|a, b| a > b),
            Self::Min => best(|a, b| a < b),
            Self::Sum => {
                let sum = numbers.iter().map(|(_, n)| n).sum();
                numbers.first().map(|(row, _)| (*row, sum))
            }
            Self::Rise => {
                let rise = |(a, b): (&Of<'a>, &Of<'a>)| match a.1 == b.1 {
                    true => (b.0, 0.0),
                    false => (b.0, b.1 - a.1),
                };
                let rises: Vec<Of<'a>> = numbers.iter().zip(&numbers[1..]).map(rise).collect();
                return Self::Max.of(&rises);
            }
        };
        one.into_iter().collect()
    }
}
