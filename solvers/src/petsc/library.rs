//! PETSc behind a lock: it serves one thread at a time, and begins when it is first asked for.
#![allow(unsafe_code, reason = "calls a C library")]

use crate::SetupError;
use fracas_petsc_sys as sys;
use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::NonNull;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes of an error's sentence.
pub(super) const TEXT: usize = 1024;

/// Whether MPI and PETSc have begun, and the right to call them.
static LIBRARY: Mutex<Option<Result<(), String>>> = Mutex::new(None);

/// The right to call PETSc.
pub(super) struct Turn {
    _library: MutexGuard<'static, Option<Result<(), String>>>,
}

impl Turn {
    /// Waits, and begins where nobody has.
    pub(super) fn take(method: &'static str) -> Result<Self, SetupError> {
        Self::begun(method, false)
    }

    /// The same; where nobody has begun, ranks begin together.
    pub(super) fn begun(method: &'static str, together: bool) -> Result<Self, SetupError> {
        let mut library = LIBRARY.lock().unwrap_or_else(PoisonError::into_inner);
        let begun = library.get_or_insert_with(|| {
            let mut text = [0; TEXT];
            // Safety: the lock is held and the text has its length.
            let code = unsafe {
                sys::fracas_petsc_start(c_int::from(together), text.as_mut_ptr(), TEXT as c_int)
            };
            (code == 0).then_some(()).ok_or_else(|| sentence(&text))
        });
        match begun {
            Ok(()) => Ok(Self { _library: library }),
            Err(said) => Err(SetupError::NotApplicable {
                method,
                reason: format!("PETSc does not start: {said}"),
            }),
        }
    }
}

pub(super) fn sentence(text: &[c_char; TEXT]) -> String {
    // Safety: what C wrote ends with a zero, and what it did not write is zero.
    let text = unsafe { CStr::from_ptr(text.as_ptr()) };
    text.to_string_lossy().trim().to_owned()
}

/// Why PETSc made no handle.
pub(crate) enum Refusal {
    /// Nothing read this option, or it would replace the method.
    Option(String),
    /// MUMPS's INFOG(1), and both as text.
    Mumps(i32, String),
    /// No memory.
    Memory,
    /// PETSc's sentence.
    Said(String),
    /// It has not begun.
    NotBegun(SetupError),
}

impl Refusal {
    /// Of a code that is not 0, with its text.
    fn of(code: c_int, said: String) -> Self {
        match code {
            sys::REFUSED_OPTION => Self::Option(said),
            sys::ERR_MEM => Self::Memory,
            code if code <= sys::MUMPS_CODES => Self::Mumps(code + 1000, said),
            _ => Self::Said(said),
        }
    }
}

/// Compressed rows as PETSc takes them.
pub(crate) struct Rows<'a> {
    /// Rows of a node.
    pub(crate) block: usize,
    /// One more entry than there are rows; the last one is the number of entries.
    pub(crate) offsets: &'a [i32],
    /// Below the number of rows.
    pub(crate) columns: &'a [i32],
    /// As many.
    pub(crate) values: &'a [f64],
    /// As many as rows, or none.
    pub(crate) positions: &'a [f64],
}

/// A matrix of PETSc with its preconditioner.
#[derive(Debug)]
pub(crate) struct Handle {
    raw: NonNull<sys::Petsc>,
    n: usize,
}

// Safety: every call is made under the lock, and an object belongs to no thread.
unsafe impl Send for Handle {}
// Safety: as above.
unsafe impl Sync for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        if let Ok(_turn) = Turn::take("PETSc") {
            // Safety: the pointer came from the library and is released once, under the lock.
            unsafe { sys::fracas_petsc_free(self.raw.as_ptr()) }
        }
    }
}

impl Handle {
    /// A preconditioner of one of the kinds of [`sys`].
    pub(crate) fn new(
        kind: c_int,
        method: &'static str,
        rows: &Rows<'_>,
        options: &str,
    ) -> Result<Self, Refusal> {
        let n = rows.offsets.len() - 1;
        let entries = rows.offsets[n] as usize;
        let in_range = |j: &i32| (0..n as i64).contains(&i64::from(*j));
        assert!(
            rows.offsets.is_sorted()
                && rows.offsets[0] == 0
                && (rows.columns.len(), rows.values.len()) == (entries, entries)
                && rows.columns.iter().all(in_range)
                && n.is_multiple_of(rows.block)
                && [0, n].contains(&rows.positions.len()),
            "compressed rows"
        );
        let options = CString::new(options).map_err(|e| Refusal::Option(e.to_string()))?;
        let _turn = Turn::take(method).map_err(Refusal::NotBegun)?;
        let (mut raw, mut text) = (std::ptr::null_mut(), [0; TEXT]);
        let positions = match rows.positions {
            [] => std::ptr::null(),
            some => some.as_ptr(),
        };
        // Safety: the arrays are those of n compressed rows, as just checked, the text ends with a zero, and the lock is held.
        let code = unsafe {
            sys::fracas_petsc_new(
                kind,
                n as c_int,
                rows.block as c_int,
                rows.offsets.as_ptr(),
                rows.columns.as_ptr(),
                rows.values.as_ptr(),
                positions,
                options.as_ptr(),
                &mut raw,
                text.as_mut_ptr(),
                TEXT as c_int,
            )
        };
        match NonNull::new(raw).filter(|_| code == 0) {
            Some(raw) => Ok(Self { raw, n }),
            None => Err(Refusal::of(code, sentence(&text))),
        }
    }

    /// The rows of this rank of a matrix over all ranks, each of which calls this with its own; columns count through the rows of all
    /// ranks. [`set_up`](Self::set_up) comes next, when these arrays may be gone.
    pub(crate) fn of_ranks(rows: &Rows<'_>) -> Result<Self, Refusal> {
        let n = rows.offsets.len() - 1;
        let entries = rows.offsets[n] as usize;
        assert!(
            rows.offsets.is_sorted()
                && rows.offsets[0] == 0
                && (rows.columns.len(), rows.values.len()) == (entries, entries)
                && (rows.block, n % 3) == (3, 0)
                && [0, n].contains(&rows.positions.len()),
            "compressed rows of nodes"
        );
        let _turn = Turn::take("PETSc").map_err(Refusal::NotBegun)?;
        let (mut raw, mut text) = (std::ptr::null_mut(), [0; TEXT]);
        let positions = match rows.positions {
            [] => std::ptr::null(),
            some => some.as_ptr(),
        };
        // Safety: the arrays are those of n compressed rows, as just checked, PETSc checks columns against its rows, and the lock is held.
        let code = unsafe {
            sys::fracas_ranks_matrix(
                n as c_int,
                rows.offsets.as_ptr(),
                rows.columns.as_ptr(),
                rows.values.as_ptr(),
                positions,
                &mut raw,
                text.as_mut_ptr(),
                TEXT as c_int,
            )
        };
        match NonNull::new(raw).filter(|_| code == 0) {
            Some(raw) => Ok(Self { raw, n }),
            None => Err(Refusal::of(code, sentence(&text))),
        }
    }

    /// The preconditioner of a matrix of ranks, by all of them together.
    pub(crate) fn set_up(&self, kind: c_int, options: &str) -> Result<(), Refusal> {
        let options = CString::new(options).map_err(|e| Refusal::Option(e.to_string()))?;
        let _turn = Turn::take("PETSc").map_err(Refusal::NotBegun)?;
        let mut text = [0; TEXT];
        // Safety: the pointer came from the library, the text ends with a zero, and the lock is held.
        let code = unsafe {
            sys::fracas_ranks_set_up(
                self.raw.as_ptr(),
                kind,
                options.as_ptr(),
                text.as_mut_ptr(),
                TEXT as c_int,
            )
        };
        match code {
            0 => Ok(()),
            code => Err(Refusal::of(code, sentence(&text))),
        }
    }

    /// Rows.
    pub(crate) fn size(&self) -> usize {
        self.n
    }

    /// `z ← M⁻¹ r` or `M⁻ᵀ r`; where PETSc fails z is NaN, which ends an iteration with a sentence.
    pub(crate) fn apply(&self, transposed: bool, r: &[f64], z: &mut [f64]) {
        assert_eq!((r.len(), z.len()), (self.n, self.n), "length of vectors");
        let code = Turn::take("PETSc").map(|_turn| {
            let text = std::ptr::null_mut();
            // Safety: both arrays have n entries and the lock is held.
            unsafe {
                sys::fracas_petsc_apply(
                    self.raw.as_ptr(),
                    c_int::from(transposed),
                    r.as_ptr(),
                    z.as_mut_ptr(),
                    text,
                    0,
                )
            }
        });
        if code != Ok(0) {
            z.fill(f64::NAN);
        }
    }

    /// Flops that PETSc counts in one application; 0 for what others do.
    pub(crate) fn flops(&self) -> u64 {
        let (mut r, mut z) = (vec![0.0; self.n], vec![0.0; self.n]);
        let mut flops = 0.0;
        let code = Turn::take("PETSc").map(|_turn| {
            // Safety: both arrays have n entries and the lock is held.
            unsafe {
                sys::fracas_petsc_count(
                    self.raw.as_ptr(),
                    r.as_mut_ptr(),
                    z.as_mut_ptr(),
                    &mut flops,
                )
            }
        });
        if code == Ok(0) { flops as u64 } else { 0 }
    }

    /// An entry of MUMPS's INFOG, counted from 1; 0 where this is no MUMPS.
    pub(crate) fn infog(&self, index: c_int) -> f64 {
        let mut value = 0.0;
        let code = Turn::take("PETSc").map(|_turn| {
            // Safety: a plain output, under the lock.
            unsafe { sys::fracas_petsc_mumps(self.raw.as_ptr(), index, &mut value) }
        });
        if code == Ok(0) { value } else { 0.0 }
    }
}
