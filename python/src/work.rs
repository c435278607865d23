//! Work without the interpreter's lock: on a thread of its own, while the thread that asked minds signals.

use crate::error::{Kind, raise};
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::any::Any;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often Ctrl-C is looked for.
pub(crate) const PATIENCE: Duration = Duration::from_millis(20);

/// Threads that were asked for; else all cores.
static POOL: Mutex<Option<Arc<ThreadPool>>> = Mutex::new(None);

/// Works on so many threads from here on; results do not depend on it.
#[pyfunction]
pub(crate) fn set_threads(n: usize) -> PyResult<()> {
    if !(1..=1024).contains(&n) {
        return Err(raise(Kind::Input, format!("threads = {n}: give 1 to 1024")));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build();
    let pool = pool.map_err(|error| raise(Kind::Plain, error.to_string()))?;
    *POOL.lock().unwrap_or_else(PoisonError::into_inner) = Some(pool.into());
    Ok(())
}

/// On the threads that were asked for.
pub(crate) fn in_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = POOL.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// Runs `work` on a thread of its own; a signal sets `stop`, and its exception is raised when the work has ended.
pub(crate) fn apart<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    work: impl FnOnce() -> PyResult<T> + Send,
) -> PyResult<T> {
    let (ended, signal) = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, wait) = mpsc::channel::<()>();
            let worker = scope.spawn(move || {
                let _done = done;
                in_pool(work)
            });
            let signal = mind(stop, |patience| {
                wait.recv_timeout(patience) != Err(RecvTimeoutError::Timeout)
            });
            (worker.join(), signal)
        })
    });
    if let Some(signal) = signal {
        return Err(signal);
    }
    ended.unwrap_or_else(|panic| Err(of_panic(&*panic)))
}

/// Waits until `has_ended`, asked with how long it may wait; the exception of a signal that came before.
pub(crate) fn mind(
    stop: &AtomicBool,
    mut has_ended: impl FnMut(Duration) -> bool,
) -> Option<PyErr> {
    let mut signal = None;
    while !has_ended(PATIENCE) {
        if signal.is_none()
            && let Err(error) = Python::attach(|py| py.check_signals())
        {
            stop.store(true, Ordering::Relaxed);
            signal = Some(error);
        }
    }
    signal
}

/// What a panic says; it is an error of the package and not of its input.
pub(crate) fn of_panic(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    let text = text.unwrap_or("no message");
    raise(
        Kind::Plain,
        format!("internal error, please report it: {text}"),
    )
}
