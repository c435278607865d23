//! How a system is solved, as Python says it.

use crate::error::{Kind, raise};
use crate::parts::{Lent, Part};
use fracas::solve::{InnerRule, RightHandSide, Solve};
use fracas_experiments::study::Inner;
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, Measure, SaddleMethod};
use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use std::fmt::Display;
use std::str::FromStr;

/// A part by its name, by settings in JSON, or as an object of Python's.
#[derive(FromPyObject)]
pub(crate) enum Named {
    Text(String),
    Object(Py<Part>),
}

/// Everything that `solve`, `set_up` and `spectrum` are asked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Asked {
    preconditioner: Named,
    augmentation: Option<Named>,
    inner: Option<Named>,
    krylov: Option<String>,
    measure: String,
    tol: f64,
    max_iterations: usize,
    traction_unit: Option<f64>,
    rhs: Option<String>,
    explain: bool,
}

/// Settings, with the parts that Python lends to them.
pub(crate) struct Settings {
    pub(crate) solve: Solve,
    pub(crate) lent: Vec<Lent>,
}

/// A name, or JSON of settings.
fn read<T: FromStr + DeserializeOwned>(text: &str) -> PyResult<T>
where
    T::Err: Display,
{
    let refuse = |said: String| raise(Kind::Input, said);
    match text.starts_with('{') {
        true => serde_json::from_str(text).map_err(|error| refuse(format!("{error} in {text}"))),
        false => text
            .parse()
            .map_err(|error: T::Err| refuse(error.to_string())),
    }
}

impl Asked {
    /// The settings; `unit` is that of the tractions of a system whose units we know.
    pub(crate) fn settings(&self, unit: Option<f64>) -> PyResult<Settings> {
        let mut lent = Vec::new();
        // parts of one's own know a system of another code in its own units
        let objects = [
            Some(&self.preconditioner),
            self.augmentation.as_ref(),
            self.inner.as_ref(),
        ];
        let is_own = objects
            .into_iter()
            .flatten()
            .any(|part| matches!(part, Named::Object(_)));
        let unit = self.traction_unit.or(unit).or(is_own.then_some(1.0));
        let method = match &self.preconditioner {
            Named::Text(text) => read(text)?,
            Named::Object(part) => {
                let part = Lent::method(part, unit.unwrap_or(1.0))?;
                lent.push(part.0);
                part.1
            }
        };
        let augmentation = match &self.augmentation {
            None => None,
            Some(Named::Text(text)) => Some(augmentation(text)?),
            Some(Named::Object(part)) => {
                let part = Lent::augmentation(part, unit.unwrap_or(1.0))?;
                lent.push(part.0);
                Some(part.1)
            }
        };
        let (inner, rule) = match &self.inner {
            None => Inner::choose(None),
            Some(Named::Text(text)) => inner(text)?,
            Some(Named::Object(part)) => {
                let part = Lent::inner(part)?;
                lent.push(part.0);
                (Some(part.1), InnerRule::Fixed)
            }
        };
        let method: SaddleMethod = method;
        // what fits the system concerns methods with an inner solver
        let method = method
            .with_parts(augmentation, inner)
            .map_err(|error| raise(Kind::Input, error.to_string()))?;
        let solve = Solve {
            method,
            inner: rule,
            krylov: (self.krylov.as_deref())
                .map(read::<KrylovChoice>)
                .transpose()?,
            measure: measure(&self.measure)?,
            tolerance: self.tol,
            max_iterations: self.max_iterations,
            traction_unit: unit,
            rhs: self.rhs.as_deref().map(right_hand_side).transpose()?,
            explain: self.explain,
        };
        Ok(Settings { solve, lent })
    }
}

/// A choice of C by name.
pub(crate) fn augmentation(text: &str) -> PyResult<AugmentationChoice> {
    read(text)
}

fn inner(text: &str) -> PyResult<(Option<InnerChoice>, InnerRule)> {
    match text.starts_with('{') {
        true => Ok(Inner::choose(Some(Inner::Named(read(text)?)))),
        false => {
            let found = text.parse::<Inner>();
            let found = found.map_err(|error| raise(Kind::Input, error.to_string()))?;
            Ok(Inner::choose(Some(found)))
        }
    }
}

fn measure(text: &str) -> PyResult<Measure> {
    match text {
        "error" => Ok(Measure::Error),
        "residual" => Ok(Measure::Residual),
        _ => Err(raise(
            Kind::Input,
            format!("unknown measure {text:?}: expected error or residual"),
        )),
    }
}

fn right_hand_side(text: &str) -> PyResult<RightHandSide> {
    match text {
        "system" => Ok(RightHandSide::System),
        "sin" => Ok(RightHandSide::Sin),
        "ones" => Ok(RightHandSide::Ones),
        "given" => Ok(RightHandSide::Given),
        _ => Err(raise(
            Kind::Input,
            format!("unknown rhs {text:?}: expected system, sin, ones, or an array"),
        )),
    }
}
