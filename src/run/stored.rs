//! Fields of a step as its files have them.

use super::RunError;
use super::collection::Collection;
use super::error::At;
use crate::io::read_field;
use std::path::Path;

/// What the files of a step show.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Stored {
    /// Number of the step.
    pub step: usize,
    /// Its time [s].
    pub time: f64,
    /// Three per node [m].
    pub displacement: Vec<f64>,
    /// Six per element, xx, yy, zz, xy, yz, xz [Pa].
    pub stress: Vec<f64>,
    /// n, t1, t2 per face [Pa].
    pub traction: Vec<f64>,
    /// ‖γ‖ per face [m].
    pub slip: Vec<f64>,
    /// Opening per face [m].
    pub aperture: Vec<f64>,
    /// Shear over its limit per face.
    pub criticality: Vec<f64>,
    /// Pressure of the fluid per face [Pa].
    pub pressure: Vec<f64>,
    /// Codes of [`ContactState`](crate::contact::ContactState) per face.
    pub states: Vec<f64>,
}

impl Stored {
    /// Reads the fields of a step.
    pub(super) fn read(collection: &Collection, step: usize, time: f64) -> Result<Self, RunError> {
        let [domain, fracture] = collection.files(step);
        let field = |path: &Path, name: &str| {
            let read = read_field(path, name).at("cannot read", path)?;
            let missing = || {
                let what = format!("no field {name}: the file is not of this version");
                std::io::Error::new(std::io::ErrorKind::InvalidData, what)
            };
            read.ok_or_else(missing).at("cannot read", path)
        };
        Ok(Self {
            step,
            time,
            displacement: field(&domain, "displacement")?,
            stress: field(&domain, "stress")?,
            traction: field(&fracture, "traction")?,
            slip: field(&fracture, "slip")?,
            aperture: field(&fracture, "aperture")?,
            criticality: field(&fracture, "criticality")?,
            pressure: field(&fracture, "pressure")?,
            states: field(&fracture, "fractureState")?,
        })
    }
}
