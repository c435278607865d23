//! MUMPS of the system's PETSc, on one rank: LLᵀ, LDLᵀ with pivoting and LU.

use super::pattern::{BLOCK, Pattern};
use super::{DirectSolver, Factorization, Kind, Symbolic, reciprocal_condition};
use crate::SetupError;
use crate::petsc::library::{Handle, Refusal, Rows};
use crate::petsc::{index, refused};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use fracas_petsc_sys as sys;

/// As messages call it.
const NAME: &str = "MUMPS";

/// MUMPS's code for a singular matrix.
const SINGULAR: i32 = -10;

/// MUMPS's codes for too little memory: main arrays, allocation, and pivots that found no room.
const MEMORY: [i32; 4] = [-8, -9, -13, -19];

/// Below this 1/κ₁ MUMPS's factors are taken for those of a singular matrix, because it names no pivots. Unit: 1.
const SINGULAR_BELOW: f64 = f64::EPSILON;

/// MUMPS with an ordering and scaling of its own, for every [`Kind`]; PETSc serves one thread at a time.
///
/// It does not tell which pivot failed: errors name the first row whose diagonal entry is not positive, where there is one.
/// A new matrix on the analysed pattern is analysed again.
///
/// # Source
/// P. R. Amestoy, I. S. Duff, J. Koster, J.-Y. L'Excellent, SIAM J. Matrix Anal. Appl. 23 (2001) 15–41.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mumps;

impl DirectSolver for Mumps {
    fn name(&self) -> &'static str {
        "mumps"
    }

    fn analyze(&self, a: &SparseMatrix<f64>, kind: Kind) -> Result<Box<dyn Symbolic>, SetupError> {
        let pattern = Pattern::of(a)?;
        let offsets = pattern.offsets.iter().map(|o| index(*o, NAME));
        Ok(Box::new(MumpsSymbolic {
            offsets: offsets.collect::<Result<_, _>>()?,
            columns: pattern.indices.iter().map(|j| *j as i32).collect(),
            pattern,
            kind,
        }))
    }
}

/// A pattern in 32 bits.
#[derive(Debug)]
struct MumpsSymbolic {
    pattern: Pattern,
    offsets: Vec<i32>,
    columns: Vec<i32>,
    kind: Kind,
}

impl Symbolic for MumpsSymbolic {
    fn factor(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Factorization>, SetupError> {
        let values = self.pattern.values(a, NAME)?;
        let n = self.pattern.size();
        if n == 0 {
            return Ok(Box::new(MumpsFactors::empty()));
        }
        let kind = match self.kind {
            Kind::Spd => sys::MUMPS_SPD,
            Kind::QuasiDefinite => sys::MUMPS_SYMMETRIC,
            Kind::General => sys::MUMPS_LU,
        };
        let rows = Rows {
            block: 1,
            offsets: &self.offsets,
            columns: &self.columns,
            values,
            positions: &[],
        };
        let handle = Handle::new(kind, NAME, &rows, "").map_err(|refusal| match refusal {
            Refusal::Mumps(SINGULAR, said) => singular(a, &said),
            Refusal::Mumps(code, _) if MEMORY.contains(&code) => refused(NAME, n, Refusal::Memory),
            refusal => refused(NAME, n, refusal),
        })?;
        let negative = handle.infog(12);
        if self.kind == Kind::Spd && negative > 0.0 {
            return Err(indefinite(a, negative));
        }
        let factors = MumpsFactors {
            entries: handle.infog(29) as usize,
            handle: Some(handle),
            is_symmetric: self.kind != Kind::General,
            // of a matrix by columns PETSc has the transposed one
            is_transposed: self.kind == Kind::General && a.is_csc(),
        };
        let reciprocal = reciprocal_condition(a, &factors);
        if !(reciprocal >= SINGULAR_BELOW) {
            return Err(singular(a, &format!("1/condition is {reciprocal:.1e}")));
        }
        Ok(Box::new(factors))
    }
}

/// First row, from 1, whose diagonal entry is not positive.
fn first_bad_row(a: &SparseMatrix<f64>) -> Option<usize> {
    let bad = |i: &usize| a.get(*i, *i).is_none_or(|v| *v <= 0.0);
    (0..a.rows()).find(bad).map(|i| i + 1)
}

fn singular(a: &SparseMatrix<f64>, said: &str) -> SetupError {
    SetupError::Singular {
        block: BLOCK,
        row: first_bad_row(a),
        advice: format!("{said} of MUMPS: unconstrained bodies or dependent constraints"),
    }
}

fn indefinite(a: &SparseMatrix<f64>, negative: f64) -> SetupError {
    let advice = format!(
        "MUMPS counts {negative} negative pivots; check constraints and material, or factorize it as a general matrix"
    );
    match first_bad_row(a) {
        Some(row) => SetupError::NotPositiveDefinite {
            block: BLOCK,
            row,
            advice,
        },
        None => SetupError::Singular {
            block: BLOCK,
            row: None,
            advice,
        },
    }
}

/// Factors that MUMPS keeps.
#[derive(Debug)]
struct MumpsFactors {
    /// None of no equations.
    handle: Option<Handle>,
    entries: usize,
    is_symmetric: bool,
    is_transposed: bool,
}

impl MumpsFactors {
    fn empty() -> Self {
        Self {
            handle: None,
            entries: 0,
            is_symmetric: true,
            is_transposed: false,
        }
    }

    fn apply(&self, adjoint: bool, r: &[f64], z: &mut [f64]) {
        if let Some(handle) = &self.handle {
            handle.apply(!self.is_symmetric && adjoint != self.is_transposed, r, z);
        }
    }
}

impl Preconditioner<f64> for MumpsFactors {
    fn size(&self) -> usize {
        self.handle.as_ref().map_or(0, Handle::size)
    }

    fn solve(&self, r: &[f64], z: &mut [f64], _: &mut [f64]) {
        self.apply(false, r, z);
    }

    fn flops(&self) -> u64 {
        // of symmetric factors MUMPS has one half
        let times = if self.is_symmetric { 4 } else { 2 };
        times * self.entries as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

impl Factorization for MumpsFactors {
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], _: &mut [f64]) {
        self.apply(true, r, z);
    }

    fn factor_entries(&self) -> usize {
        self.entries
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        None
    }
}
