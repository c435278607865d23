//! MUMPS of the system's PETSc, on one rank: LLᵀ, LDLᵀ with pivoting and LU.

use super::equilibration::Equilibrated;
use super::pattern::{BLOCK, Pattern};
use super::refinement::Refined;
use super::{DirectSolver, Factorization, Faer, Kind, Symbolic};
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

/// MUMPS's codes for too little memory: of the main arrays, of an allocation, of all together.
const MEMORY: [i32; 4] = [-8, -9, -13, -19];

/// Where MUMPS counts negative pivots.
const NEGATIVE_PIVOTS: i32 = 12;

/// Where MUMPS counts the entries of its factors.
pub(crate) const ENTRIES: i32 = 29;

/// MUMPS with an ordering of its own, for every [`Kind`]; one call at a time, because PETSc serves one thread.
///
/// It does not tell which pivot failed: an indefinite matrix is refused with the first row whose diagonal entry is not positive,
/// where there is one. A new matrix on the analysed pattern is analysed again.
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
        let pattern = Pattern::of(&a.to_csc())?;
        if pattern.size() == 0 {
            // PETSc factorizes no empty matrix
            return Faer.analyze(a, kind);
        }
        let offsets = pattern.offsets.iter().map(|o| index(*o, NAME));
        Ok(Box::new(MumpsSymbolic {
            offsets: offsets.collect::<Result<_, _>>()?,
            columns: pattern.indices.iter().map(|j| *j as i32).collect(),
            pattern,
            kind,
        }))
    }
}

/// A pattern by columns, in 32 bits.
#[derive(Debug)]
struct MumpsSymbolic {
    pattern: Pattern,
    offsets: Vec<i32>,
    columns: Vec<i32>,
    kind: Kind,
}

impl Symbolic for MumpsSymbolic {
    fn factor(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Factorization>, SetupError> {
        let by_columns = a.to_csc();
        self.pattern.values(&by_columns, NAME)?;
        let n = self.pattern.size();
        // a symmetric matrix is scaled alike on both sides
        let factors = Equilibrated::factor(by_columns, |scaled| {
            let kind = match self.kind {
                Kind::Spd => sys::MUMPS_SPD,
                Kind::QuasiDefinite => sys::MUMPS_SYMMETRIC,
                Kind::General => sys::MUMPS_LU,
            };
            let rows = Rows {
                block: 1,
                offsets: &self.offsets,
                columns: &self.columns,
                values: scaled.data(),
                positions: &[],
            };
            let handle = Handle::new(kind, NAME, &rows, "").map_err(|said| why(n, said))?;
            if self.kind == Kind::Spd {
                positive(&handle, Some(a))?;
            }
            Ok(MumpsFactors {
                entries: handle.infog(ENTRIES) as usize,
                handle,
                is_symmetric: self.kind != Kind::General,
            })
        })?;
        Ok(match self.kind {
            Kind::General => Box::new(Refined::new(a, factors)),
            _ => Box::new(factors),
        })
    }
}

/// The typed error of a refusal by MUMPS, of n equations.
pub(crate) fn why(n: usize, refusal: Refusal) -> SetupError {
    match refusal {
        Refusal::Mumps(SINGULAR, said) => singular(said),
        Refusal::Mumps(code, _) if MEMORY.contains(&code) => refused(NAME, n, Refusal::Memory),
        refusal => refused(NAME, n, refusal),
    }
}

/// Refuses factors with negative pivots, with a row of A to look at where there is all of A.
///
/// # Errors
/// [`SetupError::NotPositiveDefinite`] or [`SetupError::Singular`].
pub(crate) fn positive(handle: &Handle, a: Option<&SparseMatrix<f64>>) -> Result<(), SetupError> {
    match handle.infog(NEGATIVE_PIVOTS) {
        negative if negative > 0.0 => Err(indefinite(a, negative)),
        _ => Ok(()),
    }
}

fn singular(said: String) -> SetupError {
    SetupError::Singular {
        block: BLOCK,
        row: None,
        advice: format!("MUMPS says {said}: unconstrained bodies or dependent constraints"),
    }
}

fn indefinite(a: Option<&SparseMatrix<f64>>, negative: f64) -> SetupError {
    let advice = format!(
        "MUMPS counts {negative} negative pivots; check constraints and material, or factorize it as a general matrix"
    );
    let bad =
        |a: &SparseMatrix<f64>| (0..a.rows()).find(|i| a.get(*i, *i).is_none_or(|v| *v <= 0.0));
    match a.and_then(bad) {
        Some(row) => SetupError::NotPositiveDefinite {
            block: BLOCK,
            row: row + 1,
            advice,
        },
        None => SetupError::Singular {
            block: BLOCK,
            row: None,
            advice,
        },
    }
}

/// Factors that MUMPS keeps, of rows that are the columns of A.
#[derive(Debug)]
struct MumpsFactors {
    handle: Handle,
    entries: usize,
    is_symmetric: bool,
}

impl Preconditioner<f64> for MumpsFactors {
    fn size(&self) -> usize {
        self.handle.size()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], _: &mut [f64]) {
        self.handle.apply(!self.is_symmetric, r, z);
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
        self.handle.apply(false, r, z);
    }

    fn factor_entries(&self) -> usize {
        self.entries
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        None
    }
}
