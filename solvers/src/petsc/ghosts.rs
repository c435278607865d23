//! Entries of a vector that live on other ranks, and what fills them.
#![allow(unsafe_code, reason = "calls a C library")]

use super::library::{TEXT, Turn, sentence};
use crate::SetupError;
use fracas_petsc_sys as sys;
use std::ffi::c_int;
use std::ptr::NonNull;

/// The way of entries from their ranks to here (PETSc's star forest).
///
/// # Cost
/// A message to every rank that has some of them, and one to every rank that wants some from here.
#[derive(Debug)]
pub(crate) struct Ghosts {
    raw: NonNull<sys::Ghosts>,
    own: usize,
    len: usize,
}

// Safety: every call is made under the lock, and an object belongs to no thread.
unsafe impl Send for Ghosts {}
// Safety: as above.
unsafe impl Sync for Ghosts {}

impl Drop for Ghosts {
    fn drop(&mut self) {
        if let Ok(_turn) = Turn::take("PETSc") {
            // Safety: the pointer came from the library and is released once, under the lock.
            unsafe { sys::fracas_ghosts_free(self.raw.as_ptr()) }
        }
    }
}

impl Ghosts {
    /// Ghosts k at places `of[k].1` among the entries of ranks `of[k].0`, for a vector with `own` entries here; every rank makes its own.
    pub(crate) fn new(own: usize, of: &[(u32, u32)]) -> Result<Self, SetupError> {
        let (owners, places): (Vec<c_int>, Vec<c_int>) =
            of.iter().map(|(r, i)| (*r as c_int, *i as c_int)).unzip();
        let _turn = Turn::take("PETSc")?;
        let (mut raw, mut text) = (std::ptr::null_mut(), [0; TEXT]);
        // Safety: both lists have an entry for every ghost, and the lock is held.
        let code = unsafe {
            sys::fracas_ghosts_new(
                own as c_int,
                of.len() as c_int,
                owners.as_ptr(),
                places.as_ptr(),
                &mut raw,
                text.as_mut_ptr(),
                TEXT as c_int,
            )
        };
        let raw = NonNull::new(raw).filter(|_| code == 0);
        let not = || SetupError::NotApplicable {
            method: "PETSc",
            reason: format!("no messages between ranks: {}", sentence(&text)),
        };
        Ok(Self {
            raw: raw.ok_or_else(not)?,
            own,
            len: of.len(),
        })
    }

    /// How many.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Fills them from the entries of every rank; where that fails they are NaN, which ends an iteration with a sentence.
    pub(crate) fn fill(&self, own: &[f64], ghosts: &mut [f64]) {
        assert_eq!((own.len(), ghosts.len()), (self.own, self.len), "entries");
        let code = Turn::take("PETSc").map(|_turn| {
            // Safety: as many entries as there were at the beginning, under the lock.
            unsafe { sys::fracas_ghosts_fill(self.raw.as_ptr(), own.as_ptr(), ghosts.as_mut_ptr()) }
        });
        if code != Ok(0) {
            ghosts.fill(f64::NAN);
        }
    }
}
