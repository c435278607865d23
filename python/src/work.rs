//! Work without the interpreter's lock: on a thread of its own, while the thread that asked minds signals.

use crate::call;
use crate::error::{Kind, raise};
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::any::Any;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// How often Ctrl-C is looked for.
pub(crate) const PATIENCE: Duration = Duration::from_millis(20);

/// Stack of threads that call Python back: twice that of Python's own main thread. Unit: B.
const STACK: usize = 16 << 20;

/// The pool of threads that were asked for, with their number and the process that they are of.
struct Pool {
    process: u32,
    threads: usize,
    pool: Arc<ThreadPool>,
}

/// Threads that were asked for; else all cores. Products share them.
static POOL: Mutex<Option<Pool>> = Mutex::new(None);

/// The process that has imported the module.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Threads, all cores for 0.
fn pool(threads: usize) -> PyResult<ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = pool.stack_size(STACK).build();
    pool.map_err(|error| raise(Kind::Plain, error.to_string()))
}

/// Remembers the process: the threads of all cores are not there in one that is forked.
pub(crate) fn begin() {
    PROCESS.get_or_init(std::process::id);
}

/// Works on so many threads from here on; results do not depend on it.
#[pyfunction]
pub(crate) fn set_threads(n: usize) -> PyResult<()> {
    if !(1..=1024).contains(&n) {
        return Err(raise(Kind::Input, format!("threads = {n}: give 1 to 1024")));
    }
    *POOL.lock().unwrap_or_else(PoisonError::into_inner) = Some(Pool {
        process: std::process::id(),
        threads: n,
        pool: pool(n)?.into(),
    });
    Ok(())
}

/// How many threads have to be started for some work: those that were asked for, or all cores in a process that was forked, whose parent has
/// the threads; `None` where those of all cores serve.
fn own_threads() -> Option<usize> {
    let asked = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let is_forked = PROCESS.get().is_some_and(|p| *p != std::process::id());
    (asked.as_ref().map(|pool| pool.threads)).or(is_forked.then_some(0))
}

/// On threads of its own, as many as were asked for: it may wait for Python as long as Python likes, and holds nobody up.
pub(crate) fn in_own_pool<T: Send>(work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    match own_threads() {
        Some(threads) => pool(threads)?.install(work),
        None => work(),
    }
}

/// On the threads that were asked for, which all products share.
pub(crate) fn in_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let shared = || -> Option<Arc<ThreadPool>> {
        let threads = own_threads()?;
        let process = std::process::id();
        let mut asked = POOL.lock().unwrap_or_else(PoisonError::into_inner);
        let here = asked.as_ref().filter(|pool| pool.process == process);
        if let Some(here) = here {
            return Some(here.pool.clone());
        }
        let pool = Arc::new(pool(threads).ok()?);
        *asked = Some(Pool {
            process,
            threads,
            pool: pool.clone(),
        });
        Some(pool)
    };
    match shared() {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// A thread that may call Python back.
pub(crate) fn thread() -> Builder {
    Builder::new().stack_size(STACK)
}

/// No thread could be started.
pub(crate) fn no_thread(error: &std::io::Error) -> PyErr {
    raise(Kind::Plain, format!("no thread to work on: {error}"))
}

/// Runs `work` on a thread of its own; a signal sets `stop`, and its exception is raised when the work has ended. What functions of
/// Python's raise takes the place of the result.
pub(crate) fn apart<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    work: impl FnOnce() -> PyResult<T> + Send,
) -> PyResult<T> {
    let owners = call::owners();
    let (ended, signal) = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, wait) = mpsc::channel::<()>();
            let worker = thread().spawn_scoped(scope, move || {
                let _done = done;
                in_own_pool(|| {
                    call::works_for(owners);
                    call::raising(work)
                })
            });
            let worker = match worker {
                Ok(worker) => worker,
                Err(error) => return (Ok(Err(no_thread(&error))), None),
            };
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
