//! Observers: Python's own, the wish to stop, residuals.

use fracas_solvers::{Observer, Step};
use pyo3::prelude::*;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// What an iteration reports.
#[pyclass(frozen, get_all, module = "fracas")]
pub(crate) struct Event {
    /// `krylov`, `newton`, `round`, `progress` or `line`.
    kind: &'static str,
    /// Iterations, Newton steps, rounds or parts so far.
    iteration: usize,
    /// Relative residual of krylov and newton.
    residual: Option<f64>,
    /// Faces that take another state.
    changed: Option<usize>,
    /// Parts in all.
    total: Option<usize>,
    /// Stage of a progress, or the line.
    text: Option<String>,
}

#[pymethods]
impl Event {
    fn __repr__(&self) -> String {
        let mut text = format!("Event({}, iteration={}", self.kind, self.iteration);
        if let Some(residual) = self.residual {
            text += &format!(", residual={residual:.3e}");
        }
        if let Some(changed) = self.changed {
            text += &format!(", changed={changed}");
        }
        if let Some(said) = &self.text {
            text += &format!(", text={said:?}");
        }
        text + ")"
    }
}

impl Event {
    fn new(kind: &'static str, iteration: usize) -> Self {
        Self {
            kind,
            iteration,
            residual: None,
            changed: None,
            total: None,
            text: None,
        }
    }

    fn of(step: &Step) -> Self {
        match *step {
            Step::Krylov {
                iteration,
                relative_residual,
            } => Self {
                residual: Some(relative_residual),
                ..Self::new("krylov", iteration)
            },
            Step::Newton {
                iteration,
                residual,
            } => Self {
                residual: Some(residual),
                ..Self::new("newton", iteration)
            },
            Step::Round { round, changed } => Self {
                changed: Some(changed),
                ..Self::new("round", round)
            },
            Step::Progress { stage, done, total } => Self {
                total: Some(total),
                text: Some(stage.into()),
                ..Self::new("progress", done)
            },
        }
    }
}

/// Stops where the caller wants to, and tells Python's observer.
pub(crate) struct Watch<'a> {
    stop: &'a AtomicBool,
    observer: Option<Py<PyAny>>,
    /// What the observer raised; the iteration then stops.
    pub(crate) raised: Option<PyErr>,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(stop: &'a AtomicBool, observer: Option<Py<PyAny>>) -> Self {
        Self {
            stop,
            observer,
            raised: None,
        }
    }

    /// From here on this observer hears; the one before is let go.
    pub(crate) fn tells(&mut self, observer: Option<Py<PyAny>>) {
        let before = std::mem::replace(&mut self.observer, observer);
        if before.is_some() {
            // its reference goes with the interpreter's lock
            Python::attach(|_| drop(before));
        }
    }

    /// False where the observer wants to stop: it returns False, or raises.
    fn tell(&mut self, event: impl FnOnce() -> Event) -> bool {
        let Some(observer) = &self.observer else {
            return true;
        };
        if self.raised.is_some() {
            return false;
        }
        let told = Python::attach(|py| {
            let answer = observer.bind(py).call1((event(),))?;
            Ok(!answer.is_exact_instance_of::<pyo3::types::PyBool>() || answer.is_truthy()?)
        });
        told.unwrap_or_else(|error| {
            self.raised = Some(error);
            false
        })
    }

    /// The result, unless the observer raised.
    pub(crate) fn end<T>(mut self, result: PyResult<T>) -> PyResult<T> {
        self.tells(None);
        self.raised.take().map_or(result, Err)
    }
}

impl Observer for Watch<'_> {
    fn observe(&mut self, step: &Step) -> ControlFlow<()> {
        if !self.tell(|| Event::of(step)) {
            // whoever else looks at it stops, too
            self.stop.store(true, Ordering::Relaxed);
        }
        if self.stop.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn say(&mut self, line: &dyn Display) {
        let goes_on = self.tell(|| Event {
            text: Some(line.to_string()),
            ..Event::new("line", 0)
        });
        if !goes_on {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}
