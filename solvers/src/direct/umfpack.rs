//! UMFPACK: multifrontal LU.
#![allow(unsafe_code, reason = "calls a C library")]

use super::equilibration::Equilibrated;
use super::graph::symmetry;
use super::nested_dissection::nested_dissection;
use super::pattern::{BLOCK, Pattern};
use super::refinement::Refined;
use super::{DirectSolver, Factorization, Faer, Kind, Symbolic};
use crate::SetupError;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use fracas_suitesparse_sys as sys;
use std::ffi::{c_int, c_void};
use std::sync::Arc;

// UMFPACK reads our offsets and indices as int64_t.
const _: () = assert!(size_of::<usize>() == size_of::<i64>());

/// Symmetry of the pattern from which pivots are sought on the diagonal first, in the order of A + Aᵀ. Unit: 1;
/// UMFPACK's own choice. On saddle points it needs a third of the time and of the entries of column ordering.
const SYMMETRIC: f64 = 0.3;

/// UMFPACK's multifrontal LU with nested dissection, on the equilibrated matrix and with one step of refinement.
///
/// # Source
/// T. A. Davis, ACM Trans. Math. Softw. 30 (2004) 196–199.
#[derive(Clone, Copy, Debug, Default)]
pub struct Umfpack;

impl DirectSolver for Umfpack {
    fn name(&self) -> &'static str {
        "umfpack"
    }

    fn analyze(&self, a: &SparseMatrix<f64>, kind: Kind) -> Result<Box<dyn Symbolic>, SetupError> {
        let pattern = Pattern::of(&a.to_csc())?;
        if pattern.size() == 0 {
            // UMFPACK refuses n = 0
            return Faer.analyze(a, kind);
        }
        let order = nested_dissection(a)?;
        let mut symbolic = UmfpackSymbolic {
            pattern: Arc::new(pattern),
            handle: std::ptr::null_mut(),
        };
        let pattern = &symbolic.pattern;
        // Safety: the arrays are those of a square compressed matrix and of a permutation of its size.
        let status = unsafe {
            sys::fracas_umfpack_analyze(
                c_int::from(symmetry(a) >= SYMMETRIC),
                pattern.size() as i64,
                pattern.offsets.as_ptr().cast(),
                pattern.indices.as_ptr().cast(),
                order.as_ptr().cast(),
                &mut symbolic.handle,
            )
        };
        checked(status, symbolic.pattern.size(), None)?;
        Ok(Box::new(symbolic))
    }
}

/// UMFPACK's status as a typed error, and the bytes that it asked for.
fn checked(status: c_int, n: usize, bytes: Option<usize>) -> Result<(), SetupError> {
    match status {
        0 => Ok(()),
        sys::UMFPACK_SINGULAR => Err(SetupError::Singular {
            block: BLOCK,
            row: None,
            advice:
                "a pivot is exactly zero; look for unconstrained bodies or dependent constraints"
                    .to_owned(),
        }),
        sys::UMFPACK_OUT_OF_MEMORY => Err(SetupError::OutOfMemory {
            method: "UMFPACK",
            n,
            bytes,
            advice: "use an iterative method, or a coarser mesh".to_owned(),
        }),
        other => Err(SetupError::NotApplicable {
            method: "UMFPACK",
            reason: format!("it stopped with status {other}"),
        }),
    }
}

/// An analysed pattern, by columns.
#[derive(Debug)]
struct UmfpackSymbolic {
    pattern: Arc<Pattern>,
    handle: *mut c_void,
}

// Safety: the object belongs to no thread, and factorizations only read it.
unsafe impl Send for UmfpackSymbolic {}
// Safety: as above.
unsafe impl Sync for UmfpackSymbolic {}

impl Drop for UmfpackSymbolic {
    fn drop(&mut self) {
        // Safety: the pointer came from the library, or is null, and is released once.
        unsafe { sys::fracas_umfpack_free_symbolic(&mut self.handle) }
    }
}

impl Symbolic for UmfpackSymbolic {
    fn factor(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Factorization>, SetupError> {
        let by_columns = a.to_csc();
        self.pattern.values(&by_columns, "UMFPACK")?;
        let factors = Equilibrated::factor(by_columns, |scaled| {
            let mut factors = UmfpackFactors {
                pattern: Arc::clone(&self.pattern),
                values: scaled.data().to_vec(),
                handle: std::ptr::null_mut(),
                entries: 0,
            };
            let mut entries = 0;
            // Safety: the symbolic factorization is that of this pattern.
            let status = unsafe {
                sys::fracas_umfpack_factorize(
                    self.pattern.offsets.as_ptr().cast(),
                    self.pattern.indices.as_ptr().cast(),
                    factors.values.as_ptr(),
                    self.handle,
                    &mut factors.handle,
                    &mut entries,
                )
            };
            let asked = size_of::<f64>() * entries as usize;
            checked(status, self.pattern.size(), Some(asked))?;
            factors.entries = entries as usize;
            Ok(factors)
        })?;
        Ok(Box::new(Refined::new(a, factors)))
    }
}

/// `P A Q = L U`.
#[derive(Debug)]
struct UmfpackFactors {
    pattern: Arc<Pattern>,
    values: Vec<f64>,
    handle: *mut c_void,
    entries: usize,
}

// Safety: the object belongs to no thread, and solves only read it.
unsafe impl Send for UmfpackFactors {}
// Safety: as above.
unsafe impl Sync for UmfpackFactors {}

impl Drop for UmfpackFactors {
    fn drop(&mut self) {
        // Safety: the pointer came from the library, or is null, and is released once.
        unsafe { sys::fracas_umfpack_free_numeric(&mut self.handle) }
    }
}

impl UmfpackFactors {
    /// `z ← A⁻¹ r` or `A⁻ᵀ r`.
    fn solve_system(&self, transposed: bool, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let n = self.pattern.size();
        assert!(r.len() == n && z.len() == n && work.len() >= 2 * n);
        let (integers, work) = work.split_at_mut(n);
        // Safety: lengths are checked above; the integer work array is f64 memory of the same size and alignment, and
        // every bit pattern left in it is a valid f64.
        let status = unsafe {
            sys::fracas_umfpack_solve(
                c_int::from(transposed),
                self.pattern.offsets.as_ptr().cast(),
                self.pattern.indices.as_ptr().cast(),
                self.values.as_ptr(),
                z.as_mut_ptr(),
                r.as_ptr(),
                self.handle,
                integers.as_mut_ptr().cast(),
                work.as_mut_ptr(),
            )
        };
        assert_eq!(status, 0, "UMFPACK refused a factorization that it made");
    }
}

impl Preconditioner<f64> for UmfpackFactors {
    fn size(&self) -> usize {
        self.pattern.size()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.solve_system(false, r, z, work);
    }

    fn work_len(&self) -> usize {
        2 * self.size()
    }

    fn flops(&self) -> u64 {
        2 * self.entries as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

impl Factorization for UmfpackFactors {
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.solve_system(true, r, z, work);
    }

    fn factor_entries(&self) -> usize {
        self.entries
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        let (mut mantissa, mut exponent) = (0.0f64, 0.0);
        // Safety: plain outputs; the factorization is numeric.
        let status =
            unsafe { sys::fracas_umfpack_determinant(&mut mantissa, &mut exponent, self.handle) };
        (status == 0).then(|| mantissa.abs().log2() + exponent * std::f64::consts::LOG2_10)
    }
}
