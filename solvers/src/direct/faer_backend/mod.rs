//! faer: LLᵀ, LDLᵀ and LU in pure Rust, ordered by METIS.
#![allow(unsafe_code, reason = "scratch memory as faer asks for it")]

mod general;
mod single;
mod symmetric;

use super::pattern::Pattern;
use super::{DirectSolver, Factorization, Kind, Symbolic};
use crate::SetupError;
use faer::sparse::FaerError;
use fracas_operators::sparse::SparseMatrix;
use serde::{Deserialize, Serialize};
use std::mem::MaybeUninit;

/// faer's sparse factorizations with nested dissection.
///
/// LLᵀ for [`Kind::Spd`]; LDLᵀ without pivoting for [`Kind::QuasiDefinite`]; LU with partial pivoting on the
/// equilibrated matrix for [`Kind::General`], with one step of refinement. LDLᵀ has none: with `C = BᵀA⁻¹B` of
/// condition 10⁴ a step in working precision replaced errors that A and C compensate by errors that they do not, and
/// GMRES took 10 iterations instead of the 8 of exact arithmetic.
///
/// # Source
/// S. El Kazdadi, faer 0.24, <https://faer.veganb.tw>.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Faer;

impl Faer {
    /// `L Lᵀ` of a positive semidefinite matrix with a unit diagonal, without the rows that depend on rows eliminated before them
    /// (pivots of `least` or less); solves leave zeros to rounding there. The second part lists these rows, ascending.
    ///
    /// # Errors
    /// [`SetupError::OutOfMemory`], [`SetupError::NotPositiveDefinite`] for what is no number.
    pub fn independent(
        &self,
        a: &SparseMatrix<f64>,
        least: f64,
    ) -> Result<(Box<dyn Factorization>, Vec<usize>), SetupError> {
        symmetric::SymmetricSymbolic::new(a, Kind::QuasiDefinite)?.independent(a, least)
    }

    /// LU as for [`Kind::General`], also where the matrix is singular in the digits of f64: what its solves are worth is the caller's to know.
    ///
    /// # Errors
    /// [`SetupError::OutOfMemory`], [`SetupError::Singular`] for rows and columns of zeros, and where no entry is left to pivot on.
    pub fn of_any_condition(
        &self,
        a: &SparseMatrix<f64>,
    ) -> Result<Box<dyn Factorization>, SetupError> {
        general::GeneralSymbolic::new(a)?.of_any_condition(a)
    }
}

impl DirectSolver for Faer {
    fn name(&self) -> &'static str {
        "faer"
    }

    fn analyze(&self, a: &SparseMatrix<f64>, kind: Kind) -> Result<Box<dyn Symbolic>, SetupError> {
        Ok(match kind {
            Kind::Spd | Kind::QuasiDefinite => {
                Box::new(symmetric::SymmetricSymbolic::new(a, kind)?)
            }
            Kind::General => Box::new(general::GeneralSymbolic::new(a)?),
        })
    }
}

/// faer's only failures that are not numerical.
fn out_of_memory(n: usize, bytes: Option<usize>) -> SetupError {
    SetupError::OutOfMemory {
        method: "faer",
        n,
        bytes,
        advice: "use an iterative method, or a coarser mesh".to_owned(),
    }
}

/// faer's symbolic failures: memory and index range.
fn symbolic_failure(error: FaerError, n: usize) -> SetupError {
    match error {
        FaerError::OutOfMemory | FaerError::IndexOverflow => out_of_memory(n, None),
        other => SetupError::NotApplicable {
            method: "faer",
            reason: other.to_string(),
        },
    }
}

/// Entries of a work array that hold faer's scratch space at any alignment.
fn work_entries(scratch: faer::dyn_stack::StackReq) -> usize {
    scratch
        .unaligned_bytes_required()
        .div_ceil(size_of::<f64>())
}

/// A work array that is faer's scratch space for a while, and zero afterwards.
///
/// faer takes uninitialized bytes, and may leave such bytes: the entries are numbers again before safe code has them back.
struct Scratch<'a>(&'a mut [MaybeUninit<f64>]);

impl<'a> Scratch<'a> {
    fn new(work: &'a mut [f64]) -> Self {
        // SAFETY: MaybeUninit<f64> has the layout of f64; the borrow is exclusive, and drop writes every entry before it ends.
        Self(unsafe { &mut *(std::ptr::from_mut(work) as *mut [MaybeUninit<f64>]) })
    }

    fn stack(&mut self) -> &mut faer::dyn_stack::MemStack {
        faer::dyn_stack::MemStack::new_any(self.0)
    }
}

impl Drop for Scratch<'_> {
    fn drop(&mut self) {
        self.0.fill(MaybeUninit::new(0.0));
    }
}

/// The order of elimination with its inverse.
fn with_inverse(order: Vec<usize>) -> (Vec<usize>, Vec<usize>) {
    let mut position = vec![0; order.len()];
    for (k, &i) in order.iter().enumerate() {
        position[i] = k;
    }
    (order, position)
}

/// Offsets and indices as faer's symbolic view.
fn faer_pattern(pattern: &Pattern) -> faer::sparse::SymbolicSparseColMatRef<'_, usize> {
    faer::sparse::SymbolicSparseColMatRef::new_checked(
        pattern.size(),
        pattern.size(),
        &pattern.offsets,
        None,
        &pattern.indices,
    )
}
