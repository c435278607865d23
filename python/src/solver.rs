//! A system and its preconditioner, ready for right-hand sides.

use crate::arrays::{given, vector};
use crate::call;
use crate::error::{Kind, Raise, raise};
use crate::parts;
use crate::settings::Settings;
use crate::watch::Watch;
use crate::work::apart;
use fracas::solve::{Problem, Solve, Solved, Solver as Ready};
use fracas_experiments::command::Residuals;
use fracas_solvers::Observer;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

/// Iteration and residual.
type History = Vec<(usize, f64)>;

/// `(JSON, x, iterations, residuals)`.
fn packed(py: Python<'_>, solved: Solved, history: History) -> PyResult<Bound<'_, PyTuple>> {
    let json = serde_json::to_string(&solved);
    let json = json.map_err(|error| raise(Kind::Plain, error.to_string()))?;
    let (iterations, residuals): (Vec<u64>, Vec<f64>) =
        history.into_iter().map(|(i, r)| (i as u64, r)).unzip();
    (
        json,
        given(py, solved.x),
        given(py, iterations),
        given(py, residuals),
    )
        .into_pyobject(py)
}

/// Runs `work` under an observer that keeps residuals.
fn watched(
    py: Python<'_>,
    observer: Option<Py<PyAny>>,
    work: impl FnOnce(&mut dyn Observer) -> PyResult<Solved> + Send,
) -> PyResult<(Solved, History)> {
    let stop = AtomicBool::new(false);
    apart(py, &stop, || {
        let mut watch = Watch::new(&stop, observer);
        let mut residuals = Residuals::around(&mut watch);
        let solved = work(&mut residuals);
        let history = residuals.kept().to_vec();
        watch.end(solved.map(|solved| (solved, history)))
    })
}

/// The right-hand side, of the length that the system has.
fn with_rhs(solver: &mut Ready, b: Vec<f64>) -> PyResult<()> {
    if b.len() != solver.unknowns() {
        return Err(raise(
            Kind::Input,
            format!(
                "rhs has {} entries, expected {}",
                b.len(),
                solver.unknowns()
            ),
        ));
    }
    solver.set_rhs(b);
    Ok(())
}

/// Sets up and solves.
pub(crate) fn solve<'py>(
    py: Python<'py>,
    settings: &Settings,
    problem: &Problem,
    b: Option<PyReadonlyArray1<'py, f64>>,
    observer: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let b = b
        .map(|b| vector("rhs", &b, b.len().unwrap_or(0)))
        .transpose()?;
    let how: &Solve = &settings.solve;
    let (solved, history) = watched(py, observer, |observer| {
        let mut solver = how.set_up(problem, observer).raised()?;
        if let Some(b) = b {
            with_rhs(&mut solver, b)?;
        }
        solver.solve(observer).raised()
    })?;
    packed(py, solved, history)
}

/// What `set_up` gives.
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct Solver {
    ready: Mutex<Ready>,
    unknowns: usize,
    setup_s: f64,
    _lent: Vec<parts::Lent>,
}

impl Solver {
    pub(crate) fn new(
        py: Python<'_>,
        settings: Settings,
        problem: &Problem,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let stop = AtomicBool::new(false);
        let how = &settings.solve;
        let ready = apart(py, &stop, || {
            let mut watch = Watch::new(&stop, observer);
            let ready = how.set_up(problem, &mut watch).raised();
            watch.end(ready)
        })?;
        Ok(Self {
            unknowns: ready.unknowns(),
            setup_s: ready.setup_s(),
            ready: Mutex::new(ready),
            _lent: settings.lent,
        })
    }
}

#[pymethods]
impl Solver {
    /// `(JSON, x, iterations, residuals)`.
    #[pyo3(signature = (b=None, observer=None))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        b: Option<PyReadonlyArray1<'py, f64>>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let b = b
            .map(|b| vector("rhs", &b, b.len().unwrap_or(0)))
            .transpose()?;
        let own = std::ptr::from_ref(self) as usize;
        if call::is_within(own) {
            return Err(raise(
                Kind::Input,
                "this solver is at work, and its own observer or preconditioner asks it for another solution: set up a second one",
            ));
        }
        let (solved, history) = watched(py, observer, |observer| {
            let mut ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(b) = b {
                with_rhs(&mut ready, b)?;
            }
            call::owned(own, || ready.solve(observer).raised())
        })?;
        packed(py, solved, history)
    }

    /// Entries of b and x.
    #[getter]
    fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Wall time of the set-up [s].
    #[getter]
    fn setup_s(&self) -> f64 {
        self.setup_s
    }
}
