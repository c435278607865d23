//! What a study file says of a figure.

use super::Name;
use serde::{Deserialize, Deserializer, Serialize};
use toml::Table;

/// `[[figure]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureSection {
    /// Name of its file; `{axis}` is filled in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// What is drawn.
    #[serde(default)]
    pub kind: Kind,
    /// Rows that it shows.
    #[serde(default, rename = "where", skip_serializing_if = "Table::is_empty")]
    pub of_rows: Table,
    /// A measure, an axis or a formula.
    #[serde(default)]
    pub x: String,
    /// What stands along x in place of its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x_label: Option<String>,
    /// A measure or a formula, or several.
    #[serde(default, deserialize_with = "one_or_many")]
    pub y: Vec<String>,
    /// Of a map, a measure or a formula.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub color: String,
    /// Of a map, the values at the ends of its colours; those beyond take the colour of the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colors: Option<[f64; 2]>,
    /// Of a map, an axis whose values stand side by side within each value of x, and one whose values stand so within each of y.
    #[serde(
        default,
        deserialize_with = "one_or_many",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub within: Vec<String>,
    /// Axes whose values tell curves apart; by default every axis that varies and is not x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<Vec<String>>,
    /// An axis each of whose values gets a figure of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facet: Option<String>,
    /// Logarithmic in x.
    #[serde(default)]
    pub log_x: bool,
    /// Logarithmic in y.
    #[serde(default)]
    pub log_y: bool,
    /// A sentence below the figure.
    #[serde(default)]
    pub caption: String,
    /// Reference lines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub line: Vec<ReferenceLine>,
    /// Levels at which it is not drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_at: Vec<String>,
}

/// What a figure draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// y over x, or bars where x has names.
    #[default]
    Curves,
    /// The same without lines and bars.
    Points,
    /// The eigenvalues of every row over the region that is proved.
    Spectrum,
    /// The same with the boundaries of pseudospectra and the field of values.
    Pseudospectra,
    /// GMRES in the inner product of energy under its bounds, a figure per row.
    GmresBounds,
    /// The eigenvalues of several rows over each other.
    Spectra,
    /// Real spectra, a line of marks per row, with the proved intervals.
    Strips,
    /// Relative residuals over iterations, a curve per row.
    Residuals,
    /// A measure as a colour over the values of two axes.
    Map,
    /// How far the measure x swings as one setting at a time is changed: the values of y are `setting = value`, and one that changes nothing.
    Tornado,
}

impl Kind {
    /// As it is written.
    pub(super) fn name(self) -> String {
        let text = serde_json::to_value(self).ok();
        text.and_then(|text| text.as_str().map(String::from))
            .unwrap_or_default()
    }

    /// True where it draws eigenvalues.
    pub(super) fn is_of_spectra(self) -> bool {
        matches!(
            self,
            Self::Spectrum | Self::Pseudospectra | Self::GmresBounds | Self::Spectra | Self::Strips
        )
    }

    /// True where every row has a figure of its own.
    pub(super) fn is_of_one(self) -> bool {
        matches!(
            self,
            Self::Spectrum | Self::Pseudospectra | Self::GmresBounds
        )
    }

    /// The measure without which there is nothing to draw, where it is no spectrum alone.
    pub(super) fn needs(self) -> Option<Name> {
        matches!(self, Self::Pseudospectra | Self::GmresBounds).then_some(Name::Departure)
    }

    /// True where it draws y over x.
    pub(super) fn has_axes(self) -> bool {
        !self.is_of_spectra() && self != Self::Residuals
    }
}

/// A string, or a list of them.
pub(super) fn one_or_many<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<String>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Either {
        One(String),
        Many(Vec<String>),
    }
    Ok(match Either::deserialize(deserializer)? {
        Either::One(one) => vec![one],
        Either::Many(many) => many,
    })
}

/// `[[figure.line]]`: a value of y that others have published or proved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceLine {
    /// The value; absent where a row gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// The first row with these values gives it.
    #[serde(default, rename = "where", skip_serializing_if = "Table::is_empty")]
    pub of_rows: Table,
    /// In the legend.
    pub label: String,
    /// Where the value is from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
}
