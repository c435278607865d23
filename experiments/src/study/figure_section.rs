//! What a study file says of a figure.

use serde::{Deserialize, Serialize};

/// `[[figure]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureSection {
    /// A measure or an axis.
    pub x: String,
    /// A measure.
    pub y: String,
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
}

/// `[[figure.line]]`: a value of y that others have published or proved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceLine {
    /// The value.
    pub y: f64,
    /// In the legend.
    pub label: String,
    /// Where the value is from.
    pub source: String,
}
