//! What a system folder says about itself.

use super::FolderError;
use serde::{Deserialize, Serialize};

/// `manifest.json`; keys of other codes are kept in [`other`](Self::other).
///
/// Of these [`read_folder`](super::read_folder) holds against the files, where they are there: the sizes; `stabilization` (the
/// factor of H, or true or false: whether there is an H, as matrices do not tell which factor it has); `blocks` (names such as
/// `["A", "B1", "H"]`, in both directions); `right_hand_sides` (names such as `["rhs_u"]`, that none is lost); `norms` (Frobenius norms
/// by name, such as `{"A": 3.1e10}`: most files of another scene, step or iteration have another); `states`. Neither list is empty beside files that
/// belong into it. `scene` and `units` (text), `step` and `newton` (numbers from 0) are what the writer says: matrices do not tell.
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

impl Manifest {
    /// The key of [`lists`](Self::lists).
    pub(super) const BLOCKS: &'static str = "blocks";

    /// The key of a list of right-hand sides, names such as `rhs_u`.
    pub(super) const SIDES: &'static str = "right_hand_sides";

    /// The key of [`is_stabilized`](Self::is_stabilized).
    pub(super) const STABILIZATION: &'static str = "stabilization";

    /// The key of [`norms`](Self::norms).
    pub(super) const NORMS: &'static str = "norms";

    /// The Frobenius norms that it says of blocks and right-hand sides, by name; none where it says none.
    ///
    /// # Errors
    /// [`FolderError::NormValue`] in a folder of ours for what is no norm.
    pub(super) fn norms(&self) -> Result<Vec<(String, f64)>, FolderError> {
        let norms = match self.other.get(Self::NORMS) {
            Some(serde_json::Value::Object(norms)) => norms.iter(),
            Some(says) if self.is_ours() => {
                return Err(FolderError::NormValue {
                    key: Self::NORMS.into(),
                    says: says.to_string(),
                });
            }
            // elsewhere the word may mean something else
            _ => return Ok(Vec::new()),
        };
        let mut all = Vec::new();
        for (name, says) in norms {
            match says.as_f64().filter(|norm| *norm >= 0.0) {
                Some(norm) => all.push((name.clone(), norm)),
                None if self.is_ours() => {
                    return Err(FolderError::NormValue {
                        key: format!("{}.{name}", Self::NORMS),
                        says: says.to_string(),
                    });
                }
                None => {}
            }
        }
        Ok(all)
    }

    /// True where it says that there is a jump stabilization, false where it says that there is none, `None` where it says neither in a folder
    /// of another code.
    ///
    /// # Errors
    /// [`FolderError::Stabilization`] for a negative number, and in a folder of ours for what is neither.
    pub(super) fn is_stabilized(&self) -> Result<Option<bool>, FolderError> {
        let Some(said) = self.other.get(Self::STABILIZATION) else {
            return Ok(None);
        };
        match (said.as_bool(), said.as_f64()) {
            (Some(says), _) => Ok(Some(says)),
            (_, Some(factor)) if factor >= 0.0 => Ok(Some(factor > 0.0)),
            (None, None) if !self.is_ours() => Ok(None),
            _ => Err(FolderError::Stabilization {
                says: self.said(Self::STABILIZATION),
            }),
        }
    }

    /// A key with its value, as they stand there.
    pub(super) fn said(&self, key: &str) -> String {
        let value = self.other.get(key).unwrap_or(&serde_json::Value::Null);
        format!("{key} = {value}")
    }

    /// Whether a block is listed; `None` without a list of names.
    pub(super) fn lists(&self, block: &str) -> Option<bool> {
        Some(self.names(Self::BLOCKS)?.contains(&block))
    }

    /// Whether the list of blocks leaves one out; a list without A has names of its own, and says nothing.
    pub(super) fn leaves_out(&self, block: &str) -> bool {
        self.lists("A") == Some(true) && self.lists(block) == Some(false)
    }

    /// The names listed under a key, where it has a list of names.
    pub(super) fn names(&self, key: &str) -> Option<Vec<&str>> {
        let listed = self.other.get(key)?.as_array()?;
        listed.iter().map(|name| name.as_str()).collect()
    }

    /// True where fracas wrote the folder: three tractions per face.
    pub fn is_ours(&self) -> bool {
        let version = self.version.as_deref();
        version.is_some_and(|version| version.starts_with("fracas"))
    }
}
