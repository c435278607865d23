//! Eigenvalues of M⁻¹𝒜, as JSON.

use crate::error::{Kind, Raise, raise};
use crate::settings::Settings;
use crate::watch::Watch;
use crate::work::apart;
use fracas::solve::{Loaded, Problem, inf_sup, spectrum as analyse, spectrum_method};
use fracas_solvers::Observer;
use fracas_solvers::spectrum::SpectrumRequest;
use pyo3::prelude::*;
use std::sync::atomic::AtomicBool;

/// Where the matrices come from.
pub(crate) enum From {
    /// They are there.
    Loaded(Box<Loaded>),
    /// The problem is assembled.
    Problem,
}

/// As `fracas spectrum --json`, without what that says of the file.
pub(crate) fn spectrum(
    py: Python<'_>,
    settings: &Settings,
    problem: &Problem,
    from: From,
    dense_limit: Option<usize>,
    observer: Option<Py<PyAny>>,
) -> PyResult<String> {
    let how = &settings.solve;
    let method = spectrum_method(problem, &how.method, how.inner, "spectrum")
        .map_err(|error| raise(Kind::Input, error.to_string()))?;
    let default = SpectrumRequest::default();
    let request = SpectrumRequest {
        dense_limit: dense_limit.unwrap_or(default.dense_limit),
        ..default
    };
    let stop = AtomicBool::new(false);
    let work = |observer: &mut dyn Observer| -> PyResult<String> {
        let loaded = match from {
            From::Loaded(loaded) => *loaded,
            From::Problem => problem.load(observer).raised()?,
        };
        let report = analyse(problem, &loaded, &method, &request, observer).raised()?;
        let inf_sup = inf_sup(problem, &loaded).raised()?;
        let json = serde_json::to_value(&report).and_then(|mut json| {
            if let serde_json::Value::Object(keys) = &mut json {
                keys.insert("inf_sup".into(), serde_json::to_value(inf_sup)?);
            }
            serde_json::to_string(&json)
        });
        json.map_err(|error| raise(Kind::Plain, error.to_string()))
    };
    apart(py, &stop, || {
        let mut watch = Watch::new(&stop, observer);
        let report = work(&mut watch);
        watch.end(report)
    })
}
