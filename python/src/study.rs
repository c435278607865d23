//! Studies: a row per solve, each on the disk before the next begins.

use crate::error::{Kind, of_any};
use crate::work::apart;
use fracas_experiments::report::Formats;
use fracas_experiments::study::{Engine, Study, Taken, gallery};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Solves what is left of a study in `out`: `(rows done, rows, checks hold)`. `text` is TOML, or the name of a study of the gallery;
/// `tell(done, total, name, outcome)` hears of every row.
#[pyfunction]
#[pyo3(signature = (text, name, folder, out, jobs, level=None, tell=None))]
pub(crate) fn study(
    py: Python<'_>,
    text: Option<String>,
    name: &str,
    folder: PathBuf,
    out: PathBuf,
    jobs: usize,
    level: Option<&str>,
    tell: Option<Py<PyAny>>,
) -> PyResult<(usize, usize, bool)> {
    let study = match (text, gallery::named(name)) {
        (Some(text), _) => Study::from_toml(&text, name, &folder, level),
        (None, Some(study)) => study.read(level),
        (None, None) => Study::load(Path::new(name), level),
    };
    let study = study.map_err(|error| of_any(Kind::Study, &error))?;
    let stop = AtomicBool::new(false);
    apart(py, &stop, || {
        let engine = Engine {
            study: &study,
            out: &out,
            jobs,
            formats: Formats::default(),
        };
        let mut raised = None;
        let ended = engine.run(&stop, |row: &Taken| {
            let Some(tell) = tell.as_ref().filter(|_| raised.is_none()) else {
                return;
            };
            let told = Python::attach(|py| {
                tell.call1(py, (row.done, row.total, &row.name, &row.outcome))
                    .map(drop)
            });
            if let Err(error) = told {
                stop.store(true, Ordering::Relaxed);
                raised = Some(error);
            }
        });
        if let Some(error) = raised {
            return Err(error);
        }
        let ended = ended.map_err(|error| of_any(Kind::Study, &error))?;
        Ok((ended.done, ended.total, ended.failed.is_empty()))
    })
}
