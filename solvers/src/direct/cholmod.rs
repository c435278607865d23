//! CHOLMOD: supernodal LLᵀ.
#![allow(unsafe_code, reason = "calls a C library")]

use super::nested_dissection::nested_dissection;
use super::pattern::{BLOCK, Pattern};
use super::{DirectSolver, Factorization, Kind, Symbolic, for_column_blocks, pivots};
use crate::SetupError;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use fracas_suitesparse_sys as sys;
use std::ffi::c_int;
use std::ptr::NonNull;
use std::sync::Arc;

// CHOLMOD reads our offsets and indices as int64_t.
const _: () = assert!(size_of::<usize>() == size_of::<i64>());

/// CHOLMOD's supernodal LLᵀ with nested dissection, for [`Kind::Spd`].
///
/// # Source
/// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, ACM Trans. Math. Softw. 35 (2008) 22.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cholmod;

impl DirectSolver for Cholmod {
    fn name(&self) -> &'static str {
        "cholmod"
    }

    fn analyze(&self, a: &SparseMatrix<f64>, kind: Kind) -> Result<Box<dyn Symbolic>, SetupError> {
        if kind != Kind::Spd {
            return Err(SetupError::NotApplicable {
                method: "CHOLMOD",
                reason: format!(
                    "it factorizes positive definite matrices and this one is {kind:?}; choose faer or umfpack"
                ),
            });
        }
        let pattern = Pattern::of(a)?;
        let order = nested_dissection(a)?;
        let mut raw = std::ptr::null_mut();
        // Safety: the arrays are those of a square compressed matrix and of a permutation of its size.
        let status = unsafe {
            sys::fracas_cholmod_analyze(
                pattern.size() as i64,
                pattern.offsets.as_ptr().cast(),
                pattern.indices.as_ptr().cast(),
                order.as_ptr().cast(),
                &mut raw,
            )
        };
        let handle = Handle::new(raw, status, (pattern.size(), None))?;
        Ok(Box::new(CholmodSymbolic {
            order: handle.order(pattern.size()),
            handle,
            pattern: Arc::new(pattern),
        }))
    }
}

/// An object of CHOLMOD.
#[derive(Debug)]
struct Handle(NonNull<sys::Cholmod>);

// Safety: an object belongs to no thread, and the functions that take it as const do not change it.
unsafe impl Send for Handle {}
// Safety: as above.
unsafe impl Sync for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        // Safety: the pointer came from the library and is released once.
        unsafe { sys::fracas_cholmod_free(self.0.as_ptr()) }
    }
}

impl Handle {
    /// Takes over what the library returned, for n equations and so many bytes.
    fn new(
        raw: *mut sys::Cholmod,
        status: c_int,
        (n, bytes): (usize, Option<usize>),
    ) -> Result<Self, SetupError> {
        let handle = NonNull::new(raw).map(Self);
        match (status, handle) {
            (0 | sys::CHOLMOD_NOT_POSDEF, Some(handle)) => Ok(handle),
            (sys::CHOLMOD_OUT_OF_MEMORY | sys::CHOLMOD_TOO_LARGE, _) | (_, None) => {
                Err(SetupError::OutOfMemory {
                    method: "CHOLMOD",
                    n,
                    bytes,
                    advice: "use an iterative method, or a coarser mesh".to_owned(),
                })
            }
            (status, Some(_)) => Err(SetupError::NotApplicable {
                method: "CHOLMOD",
                reason: format!("it stopped with status {status}"),
            }),
        }
    }

    /// Entries of L, of a symbolic factorization, too, and of the work array for a right-hand side.
    fn sizes(&self) -> (usize, usize) {
        let (mut entries, mut work) = (0, 0);
        // Safety: plain outputs.
        unsafe { sys::fracas_cholmod_sizes(self.0.as_ptr(), &mut entries, &mut work) };
        (entries as usize, work as usize)
    }

    /// Order of elimination.
    fn order(&self, n: usize) -> Vec<usize> {
        let mut order = vec![0usize; n];
        // Safety: the array has n entries of 64 bits.
        unsafe { sys::fracas_cholmod_order(self.0.as_ptr(), order.as_mut_ptr().cast()) };
        order
    }

    /// Pivots `l_jj²` in the order of elimination.
    fn pivots(&self, n: usize) -> Vec<f64> {
        let mut diagonal = vec![0.0; n];
        // Safety: the array has n entries and the factorization is numeric.
        unsafe { sys::fracas_cholmod_diagonal(self.0.as_ptr(), diagonal.as_mut_ptr()) };
        diagonal.iter_mut().for_each(|l| *l *= *l);
        diagonal
    }
}

/// An analysed pattern.
#[derive(Debug)]
struct CholmodSymbolic {
    pattern: Arc<Pattern>,
    order: Vec<usize>,
    handle: Handle,
}

impl Symbolic for CholmodSymbolic {
    fn factor(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Factorization>, SetupError> {
        let n = self.pattern.size();
        let values = self.pattern.values(a, "CHOLMOD")?;
        let (mut raw, mut succeeded) = (std::ptr::null_mut(), n as i64);
        // Safety: the symbolic factorization is that of this pattern.
        let status = unsafe {
            sys::fracas_cholmod_factorize(
                self.handle.0.as_ptr(),
                n as i64,
                self.pattern.offsets.as_ptr().cast(),
                self.pattern.indices.as_ptr().cast(),
                values.as_ptr(),
                &mut raw,
                &mut succeeded,
            )
        };
        let handle = Handle::new(
            raw,
            status,
            (n, Some(size_of::<f64>() * self.handle.sizes().0)),
        )?;
        if status == sys::CHOLMOD_NOT_POSDEF {
            return Err(match self.order.get(succeeded as usize) {
                Some(&row) => pivots::indefinite(row, Kind::Spd),
                None => SetupError::Singular {
                    block: BLOCK,
                    row: None,
                    advice: "CHOLMOD did not tell where".to_owned(),
                },
            });
        }
        let pivots = handle.pivots(n);
        pivots::check(&pivots, |k| self.order[k], a, Kind::Spd)?;
        let (entries, work_per_column) = handle.sizes();
        Ok(Box::new(CholmodFactors {
            handle,
            order: self.order.clone(),
            entries,
            work_per_column,
            log2_determinant: pivots.iter().map(|d| d.log2()).sum(),
        }))
    }
}

/// `P A Pᵀ = L Lᵀ`.
#[derive(Debug)]
struct CholmodFactors {
    handle: Handle,
    order: Vec<usize>,
    entries: usize,
    work_per_column: usize,
    log2_determinant: f64,
}

impl CholmodFactors {
    /// Work entries for this many columns.
    fn work_for(&self, columns: usize) -> usize {
        columns * (self.order.len() + self.work_per_column)
    }

    /// Solves in place.
    fn solve_block(&self, columns: usize, b: &mut [f64], work: &mut [f64]) {
        let n = self.order.len();
        let (x, work) = work.split_at_mut(columns * n);
        for (x, b) in x.chunks_exact_mut(n.max(1)).zip(b.chunks_exact(n.max(1))) {
            x.iter_mut().zip(&self.order).for_each(|(x, i)| *x = b[*i]);
        }
        // Safety: x holds n entries a column and work what the library asked for; it changes nothing else.
        let status = unsafe {
            sys::fracas_cholmod_solve(
                self.handle.0.as_ptr(),
                columns as i64,
                x.as_mut_ptr(),
                work.as_mut_ptr(),
            )
        };
        assert_eq!(status, 0, "CHOLMOD refused a factorization that it made");
        for (x, b) in x.chunks_exact(n.max(1)).zip(b.chunks_exact_mut(n.max(1))) {
            x.iter().zip(&self.order).for_each(|(x, i)| b[*i] = *x);
        }
    }
}

impl Preconditioner<f64> for CholmodFactors {
    fn size(&self) -> usize {
        self.order.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        z.copy_from_slice(r);
        self.solve_block(1, z, work);
    }

    fn work_len(&self) -> usize {
        self.work_for(1)
    }

    fn flops(&self) -> u64 {
        4 * self.entries as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

impl Factorization for CholmodFactors {
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.solve(r, z, work);
    }

    fn solve_many(&self, columns: usize, b: &mut [f64]) {
        assert_eq!(b.len(), columns * self.size(), "{columns} right-hand sides");
        for_column_blocks(self.size(), b, |columns, part| {
            self.solve_block(columns, part, &mut vec![0.0; self.work_for(columns)]);
        });
    }

    fn factor_entries(&self) -> usize {
        self.entries
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        Some(self.log2_determinant)
    }
}
