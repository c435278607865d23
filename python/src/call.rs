//! What functions of Python's raise while a call of Python's is at work: it belongs to that call and to no other, whatever parts they share.

use pyo3::prelude::*;
use std::cell::RefCell;
use std::sync::{Arc, Mutex, PoisonError};

/// The first exception of a call.
type Raised = Arc<Mutex<Option<PyErr>>>;

thread_local! {
    /// Of the call that this thread works for.
    static RAISED: RefCell<Option<Raised>> = const { RefCell::new(None) };
}

thread_local! {
    /// Solvers and runs at work for which this thread works, by their addresses: the outer ones first.
    static OWNERS: RefCell<Vec<usize>> = const { RefCell::new(Vec::new()) };
}

/// Solvers and runs for which this thread works, for a thread that goes on for it.
pub(crate) fn owners() -> Vec<usize> {
    OWNERS.with_borrow(Clone::clone)
}

/// This thread works for these from here on.
pub(crate) fn works_for(owners: Vec<usize>) {
    OWNERS.set(owners);
}

/// Works for a solver or a run beside those of before.
pub(crate) fn owned<T>(owner: usize, work: impl FnOnce() -> T) -> T {
    OWNERS.with_borrow_mut(|owners| owners.push(owner));
    let result = work();
    OWNERS.with_borrow_mut(|owners| owners.pop());
    result
}

/// True where this thread works for it, at whatever depth: what asks is its own observer or part, or what they have called.
pub(crate) fn is_within(owner: usize) -> bool {
    OWNERS.with_borrow(|owners| owners.contains(&owner))
}

/// Puts back the call that a nested one came out of.
struct Within(Option<Raised>);

impl Drop for Within {
    fn drop(&mut self) {
        RAISED.set(self.0.take());
    }
}

/// Works for a call on this thread; what functions of Python's raise comes beside the result.
pub(crate) fn heard<T>(work: impl FnOnce() -> T) -> (T, Option<PyErr>) {
    let raised = Raised::default();
    let before = Within(RAISED.replace(Some(raised.clone())));
    let result = work();
    drop(before);
    let error = raised.lock().unwrap_or_else(PoisonError::into_inner).take();
    (result, error)
}

/// The same, and what they raise takes the place of the result.
pub(crate) fn raising<T>(work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    let (result, error) = heard(work);
    error.map_or(result, Err)
}

/// True where a function has raised: nothing of the call is asked of Python any more.
pub(crate) fn has_raised() -> bool {
    of_call(|raised| raised.is_some()).unwrap_or(false)
}

/// Keeps what a function raised, if it is the first; without a call on this thread, of rows of studies, it comes back.
pub(crate) fn keep(error: PyErr) -> Option<PyErr> {
    let mut error = Some(error);
    of_call(|raised| {
        if raised.is_none() {
            *raised = error.take();
        }
        error = None;
    });
    error
}

fn of_call<T>(look: impl FnOnce(&mut Option<PyErr>) -> T) -> Option<T> {
    let call = RAISED.with_borrow(Clone::clone)?;
    let mut raised = call.lock().unwrap_or_else(PoisonError::into_inner);
    Some(look(&mut raised))
}
