//! What a system folder says about itself.

use serde::{Deserialize, Serialize};

/// `manifest.json`; keys of other codes are kept in [`other`](Self::other).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Program and version that wrote the folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// Displacement unknowns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_u: Option<usize>,
    /// Traction unknowns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_t: Option<usize>,
    /// Pressure unknowns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_p: Option<usize>,
    /// Scene that the system comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Time step, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<usize>,
    /// Newton iteration, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub newton: Option<usize>,
    /// Contact state per fracture face: 0 stick, 1 new-slip, 2 slip, 3 open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub states: Option<Vec<u8>>,
    /// Units of all values: `SI` for metres, newtons and pascals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<String>,
    /// Everything else, untouched.
    #[serde(flatten)]
    pub other: serde_json::Map<String, serde_json::Value>,
}
