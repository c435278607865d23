//! A run as an iterator over steps: the work has its own thread, which waits while nobody asks for the next step.

use crate::arrays::{given, table};
use crate::call;
use crate::error::{Kind, raise};
use crate::running::{self, Line};
use crate::work::{in_own_pool, mind, no_thread, of_panic, thread};
use fracas::nonlinear::FaceFields;
use fracas::run::History;
use fracas::scene::Scene;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::JoinHandle;

/// What is asked of a run.
pub(crate) struct Asked {
    pub(crate) scene: Scene,
    pub(crate) name: String,
    pub(crate) out: Option<PathBuf>,
    pub(crate) restart: Option<PathBuf>,
    pub(crate) steps: Option<usize>,
    pub(crate) fields_every: usize,
    pub(crate) clock: bool,
    /// False leaves fields out of the steps that are handed over.
    pub(crate) fields: bool,
    pub(crate) observer: Option<Py<PyAny>>,
}

impl Asked {
    /// True where no file is written.
    pub(crate) fn in_memory(&self) -> bool {
        self.out.is_none() && self.restart.is_none()
    }
}

/// What a state shows.
pub(crate) struct Fields {
    pub(crate) displacement: Vec<f64>,
    pub(crate) faces: FaceFields,
    pub(crate) states: Vec<i8>,
}

/// A step that is done.
pub(crate) struct Step {
    /// Its line of `history.csv`.
    pub(crate) line: String,
    /// `[name, members]` each, as JSON.
    pub(crate) events: Vec<String>,
    pub(crate) fields: Option<Fields>,
}

/// How a run ended.
pub(crate) struct Ended {
    pub(crate) outcome: &'static str,
    pub(crate) reason: Option<String>,
    pub(crate) path: Option<PathBuf>,
}

/// From the thread of the run.
pub(crate) enum Message {
    Step(Box<Step>),
    Ended(Ended),
    /// With how it ended, where its end is in order.
    Failed(PyErr, Option<Ended>),
}

/// The steps of a run.
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct Steps {
    line: Mutex<Ends>,
    ended: Mutex<Option<Ended>>,
    stop: Arc<AtomicBool>,
}

/// The iterator's ends of the line.
struct Ends {
    asks: Option<Sender<Wish>>,
    tells: Receiver<Message>,
    thread: Option<JoinHandle<()>>,
    /// The process that has the thread: one that is forked has not.
    process: u32,
}

/// For the next step: who observes it, and for whom the one who asks works.
#[derive(Default)]
pub(crate) struct Wish {
    pub(crate) observer: Option<Py<PyAny>>,
    pub(crate) owners: Vec<usize>,
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Steps {
    /// Begins when the first step is asked for.
    ///
    /// # Errors
    /// No thread could be started.
    pub(crate) fn new(asked: Asked) -> PyResult<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let (ask, asks) = mpsc::channel();
        let (tell, tells) = mpsc::channel();
        let line = Line { asks, tells: tell };
        let of_thread = stop.clone();
        let failures = line.tells.clone();
        let work = move || {
            let run = move || {
                running::run(asked, &line, &of_thread);
                Ok(())
            };
            if let Err(error) = in_own_pool(run) {
                // nobody listens where the iterator is gone
                let _ = failures.send(Message::Failed(error, None));
            }
        };
        let thread = thread().spawn(work).map_err(|error| no_thread(&error))?;
        Ok(Self {
            stop,
            ended: Mutex::new(None),
            line: Mutex::new(Ends {
                asks: Some(ask),
                tells,
                thread: Some(thread),
                process: std::process::id(),
            }),
        })
    }

    fn end(&self, ended: Ended) {
        *held(&self.ended) = Some(ended);
    }

    /// The exception of a run that failed.
    fn failed(&self, error: PyErr, ended: Option<Ended>) -> PyErr {
        self.end(ended.unwrap_or_else(|| Ended {
            outcome: "failed",
            reason: Some(error.to_string()),
            path: None,
        }));
        error
    }
}

impl Ends {
    /// Asks for a step and waits for it; the exception of a signal that came before it.
    fn ask(&mut self, stop: &AtomicBool, wish: Wish) -> (Option<Message>, Option<PyErr>) {
        if let Some(asks) = &self.asks {
            // where the thread is gone, it has left a message
            let _ = asks.send(wish);
        }
        let mut message = None;
        let signal = mind(stop, |patience| match self.tells.recv_timeout(patience) {
            Ok(told) => {
                message = Some(told);
                true
            }
            Err(RecvTimeoutError::Timeout) => false,
            Err(RecvTimeoutError::Disconnected) => true,
        });
        // a step that was done all the same: the run ends with the next wish, which a stop answers
        while signal.is_some() && matches!(message, Some(Message::Step(_))) {
            let _ = self.asks.as_ref().map(|asks| asks.send(Wish::default()));
            message = self.tells.recv().ok();
        }
        (message, signal)
    }

    /// Waits for the thread, whose files are then whole.
    fn join(&mut self) -> Option<PyErr> {
        self.asks = None;
        let thread = self.thread.take()?;
        if self.process != std::process::id() {
            std::mem::forget(thread);
            return None;
        }
        let joined = thread.join();
        joined.err().map(|panic| of_panic(&*panic))
    }
}

#[pymethods]
impl Steps {
    /// First line of `history.csv`.
    #[classattr]
    const HEADING: &'static str = History::HEADING;

    /// The next step as a dictionary; None at the end. `observer` hears of it, and is let go when it is done.
    #[pyo3(signature = (observer=None))]
    fn advance<'py>(
        &self,
        py: Python<'py>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        if call::is_within(running::owner(&self.stop)) {
            return Err(raise(
                Kind::Input,
                "the next step of a run is asked for while the one before is at work, by its own observer or part",
            ));
        }
        let wish = Wish {
            observer,
            owners: call::owners(),
        };
        // nobody who has the interpreter's lock waits for this one
        let (message, signal) = py.detach(|| {
            let mut ends = held(&self.line);
            if held(&self.ended).is_some() || ends.thread.is_none() {
                return (None, None);
            }
            if ends.process != std::process::id() {
                let elsewhere = "this run goes on in the process that was forked: begin another one, or restart its folder";
                return (Some(Message::Failed(raise(Kind::Run, elsewhere), None)), None);
            }
            let (message, signal) = ends.ask(&self.stop, wish);
            if matches!(message, Some(Message::Step(_))) {
                return (message, signal);
            }
            let panic = ends.join().map(|panic| self.failed(panic, None));
            let failure = match message {
                Some(Message::Ended(ended)) => {
                    let failure = running::failure(&ended);
                    self.end(ended);
                    failure
                }
                Some(Message::Failed(error, ended)) => Some(self.failed(error, ended)),
                Some(Message::Step(_)) | None => None,
            };
            let failure = panic.or(failure).map(|error| Message::Failed(error, None));
            (failure, signal)
        });
        if let Some(signal) = signal {
            return Err(signal);
        }
        match message {
            Some(Message::Step(step)) => step.into_dict(py).map(Some),
            Some(Message::Failed(error, _)) => Err(error),
            Some(Message::Ended(_)) | None => Ok(None),
        }
    }

    /// Stops after the step at hand; what is written can be restarted. While a step is asked for, by another thread or by what the step calls,
    /// that ends the run.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.stop.store(true, Ordering::Relaxed);
        if call::is_within(running::owner(&self.stop)) {
            return Ok(());
        }
        let failed = py.detach(|| {
            let mut ends = match self.line.try_lock() {
                Ok(ends) => ends,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => return None,
            };
            let was_open = ends.thread.is_some();
            let panic = ends.join().map(|panic| self.failed(panic, None));
            let last = ends.tells.try_iter().last().filter(|_| was_open);
            match last {
                Some(Message::Failed(error, ended)) => panic.or(Some(self.failed(error, ended))),
                Some(Message::Ended(ended)) => {
                    self.end(ended);
                    panic
                }
                Some(Message::Step(_)) | None => panic,
            }
        });
        failed.map_or(Ok(()), Err)
    }

    /// `(outcome, reason, folder)`; the outcome is `running` before the end.
    #[getter]
    fn ended(&self) -> (String, Option<String>, Option<PathBuf>) {
        let ended = held(&self.ended);
        let ended = ended.as_ref();
        let told = ended.map(|e| (e.outcome.to_owned(), e.reason.clone(), e.path.clone()));
        told.unwrap_or_else(|| ("running".into(), None, None))
    }
}

impl Drop for Steps {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if call::is_within(running::owner(&self.stop)) {
            // its own thread lets it go, and ends with it
            return;
        }
        let line = self.line.get_mut().unwrap_or_else(PoisonError::into_inner);
        // the thread may wait for the interpreter's lock
        let panic = Python::attach(|py| py.detach(|| line.join()));
        if let Some(panic) = panic {
            Python::attach(|py| panic.write_unraisable(py, None));
        }
    }
}

impl Step {
    /// Numbers of the row, events, fields as arrays that take over their memory.
    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let step = PyDict::new(py);
        step.set_item("line", self.line)?;
        step.set_item("events", self.events)?;
        let Some(Fields {
            displacement,
            faces,
            states,
        }) = self.fields
        else {
            return Ok(step);
        };
        let flows = !faces.flux.is_empty();
        step.set_item("displacement", table(py, displacement, 3)?)?;
        step.set_item("traction", table(py, faces.traction, 3)?)?;
        step.set_item("jump", table(py, faces.jump, 3)?)?;
        step.set_item(
            "stabilization_jump",
            table(py, faces.stabilization_jump, 3)?,
        )?;
        step.set_item("state", given(py, states))?;
        for (name, values) in [
            ("slip", faces.slip),
            ("aperture", faces.aperture),
            ("criticality", faces.criticality),
            ("tau_limit", faces.tau_limit),
            ("pressure", faces.pressure),
        ] {
            step.set_item(name, given(py, values))?;
        }
        if !faces.path.is_empty() {
            step.set_item("cumulated_slip", given(py, faces.path))?;
        }
        if flows {
            step.set_item("conductivity", given(py, faces.conductivity))?;
            step.set_item("flux", table(py, faces.flux, 3)?)?;
        }
        Ok(step)
    }
}
