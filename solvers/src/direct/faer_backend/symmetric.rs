//! LLᵀ and LDLᵀ.

use super::single::SingleFactors;
use super::{Scratch, out_of_memory, symbolic_failure, work_entries};
use crate::SetupError;
use crate::direct::nested_dissection::nested_dissection;
use crate::direct::pattern::{BLOCK, Pattern};
use crate::direct::pivots;
use crate::direct::{Factorization, Kind, Symbolic, for_column_blocks};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
    supernodal::{SupernodalLdltRef, SupernodalLltRef},
};
use faer::{Conj, MatMut, Par, Side};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use std::sync::Arc;

/// Pivot that leaves a row out: its column of L and its unknown are zero to rounding. Unit: that of the matrix, whose entries are
/// of order 1.
const LEFT_OUT: f64 = 1e100;

/// An analysed symmetric pattern.
#[derive(Debug)]
pub(super) struct SymmetricSymbolic {
    pattern: Pattern,
    kind: Kind,
    structure: Arc<SymbolicCholesky<usize>>,
}

impl SymmetricSymbolic {
    /// Order and elimination tree of a symmetric matrix, both triangles stored.
    pub(super) fn new(a: &SparseMatrix<f64>, kind: Kind) -> Result<Self, SetupError> {
        let pattern = Pattern::of(a)?;
        let (order, position) = super::with_inverse(nested_dissection(a)?);
        let structure = factorize_symbolic_cholesky(
            super::faer_pattern(&pattern),
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&order, &position, pattern.size())),
            Default::default(),
        )
        .map_err(|e| symbolic_failure(e, pattern.size()))?;
        Ok(Self {
            pattern,
            kind,
            structure: Arc::new(structure),
        })
    }

    /// Row, counted from 0, of the k-th pivot.
    fn row(&self, k: usize) -> usize {
        self.structure.perm().map_or(k, |p| p.arrays().0[k])
    }

    /// Row, counted from 0, of the pivot that faer reports: it counts from 1 entry by entry, from 0 by supernodes.
    fn failed_row(&self, index: usize) -> usize {
        match self.structure.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => self.row(index - 1),
            SymbolicCholeskyRaw::Supernodal(_) => self.row(index),
        }
    }

    /// The factors, pivots unseen; `regularization` is for LDLᵀ.
    fn numeric(
        &self,
        a: &SparseMatrix<f64>,
        regularization: LdltRegularization<'_, f64>,
    ) -> Result<SymmetricFactors, SetupError> {
        let n = self.pattern.size();
        let matrix = faer::sparse::SparseColMatRef::new(
            super::faer_pattern(&self.pattern),
            self.pattern.values(a, "faer")?,
        );
        let structure = &*self.structure;
        let par = Par::rayon(0);
        let spd = self.kind == Kind::Spd;
        let scratch = if spd {
            structure.factorize_numeric_llt_scratch::<f64>(par, Default::default())
        } else {
            structure.factorize_numeric_ldlt_scratch::<f64>(par, Default::default())
        };
        let mut values = Vec::new();
        values
            .try_reserve_exact(structure.len_val())
            .map_err(|_| out_of_memory(n, Some(size_of::<f64>() * structure.len_val())))?;
        values.resize(structure.len_val(), 0.0);
        let mut memory = MemBuffer::try_new(scratch)
            .map_err(|_| out_of_memory(n, Some(scratch.unaligned_bytes_required())))?;
        let stack = MemStack::new(&mut memory);
        if spd {
            structure
                .factorize_numeric_llt(
                    &mut values,
                    matrix,
                    Side::Lower,
                    Default::default(),
                    par,
                    stack,
                    Default::default(),
                )
                .map_err(|LltError::NonPositivePivot { index }| {
                    pivots::indefinite(self.failed_row(index), self.kind)
                })?;
        } else {
            structure
                .factorize_numeric_ldlt(
                    &mut values,
                    matrix,
                    Side::Lower,
                    regularization,
                    par,
                    stack,
                    Default::default(),
                )
                .map_err(|LdltError::ZeroPivot { index }| SetupError::Singular {
                    block: BLOCK,
                    row: Some(self.failed_row(index) + 1),
                    advice: "a pivot is zero: factorize it as a general matrix".to_owned(),
                })?;
        }
        let structure = Arc::clone(&self.structure);
        Ok(SymmetricFactors::new(structure, values, self.kind))
    }

    /// `L D Lᵀ` of a positive semidefinite matrix without the rows whose pivots are `least` or less, and these, ascending.
    pub(super) fn independent(
        &self,
        a: &SparseMatrix<f64>,
        least: f64,
    ) -> Result<(Box<dyn Factorization>, Vec<usize>), SetupError> {
        // faer 0.24.4 loses a replaced pivot of LLᵀ
        assert_eq!(self.kind, Kind::QuasiDefinite, "pivots are those of LDLᵀ");
        let signs = vec![1; self.pattern.size()];
        let factors = self.numeric(
            a,
            LdltRegularization {
                dynamic_regularization_signs: Some(&signs),
                dynamic_regularization_delta: LEFT_OUT,
                dynamic_regularization_epsilon: least,
            },
        )?;
        let pivots = factors.pivots();
        let left_out = (0..pivots.len()).filter(|k| pivots[*k] > 0.5 * LEFT_OUT);
        let mut left_out: Vec<usize> = left_out.map(|k| self.row(k)).collect();
        left_out.sort_unstable();
        Ok((Box::new(factors), left_out))
    }
}

impl Symbolic for SymmetricSymbolic {
    fn factor(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Factorization>, SetupError> {
        let factors = self.numeric(a, Default::default())?;
        pivots::check(&factors.pivots(), |k| self.row(k), a, self.kind)?;
        Ok(Box::new(factors))
    }
}

/// `P A Pᵀ = L Lᵀ` or `L D Lᵀ`.
#[derive(Debug)]
struct SymmetricFactors {
    structure: Arc<SymbolicCholesky<usize>>,
    values: Vec<f64>,
    kind: Kind,
}

impl SymmetricFactors {
    fn new(structure: Arc<SymbolicCholesky<usize>>, values: Vec<f64>, kind: Kind) -> Self {
        Self {
            structure,
            values,
            kind,
        }
    }

    /// d_j of LDLᵀ, or l_jj² of LLᵀ, in the order of elimination.
    fn pivots(&self) -> Vec<f64> {
        let mut pivots = Vec::with_capacity(self.structure.nrows());
        match self.structure.raw() {
            SymbolicCholeskyRaw::Simplicial(s) => {
                let columns = &s.col_ptr()[..s.ncols()];
                pivots.extend(columns.iter().map(|&start| self.values[start]));
            }
            SymbolicCholeskyRaw::Supernodal(s) => {
                for k in 0..s.n_supernodes() {
                    let columns = s.supernode_end()[k] - s.supernode_begin()[k];
                    let block = if self.kind == Kind::Spd {
                        SupernodalLltRef::new(s, &self.values).supernode(k)
                    } else {
                        SupernodalLdltRef::new(s, &self.values).supernode(k)
                    };
                    pivots.extend((0..columns).map(|j| block.val()[(j, j)]));
                }
            }
        }
        if self.kind == Kind::Spd {
            pivots.iter_mut().for_each(|p| *p *= *p);
        }
        pivots
    }

    fn scratch(&self, columns: usize) -> StackReq {
        self.structure
            .solve_in_place_scratch::<f64>(columns, Par::Seq)
    }

    fn solve_block(&self, columns: usize, b: &mut [f64], stack: &mut MemStack) {
        let b = MatMut::from_column_major_slice_mut(b, self.size(), columns);
        if self.kind == Kind::Spd {
            LltRef::new(&self.structure, &self.values).solve_in_place_with_conj(
                Conj::No,
                b,
                Par::Seq,
                stack,
            );
        } else {
            LdltRef::new(&self.structure, &self.values).solve_in_place_with_conj(
                Conj::No,
                b,
                Par::Seq,
                stack,
            );
        }
    }
}

impl Preconditioner<f64> for SymmetricFactors {
    fn size(&self) -> usize {
        self.structure.nrows()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        z.copy_from_slice(r);
        self.solve_block(1, z, Scratch::new(work).stack());
    }

    fn work_len(&self) -> usize {
        work_entries(self.scratch(1))
    }

    fn flops(&self) -> u64 {
        4 * self.values.len() as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

impl Factorization for SymmetricFactors {
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.solve(r, z, work);
    }

    fn solve_many(&self, columns: usize, b: &mut [f64]) {
        assert_eq!(b.len(), columns * self.size(), "{columns} right-hand sides");
        for_column_blocks(self.size(), b, |columns, part| {
            let mut work = vec![0.0; work_entries(self.scratch(columns))];
            self.solve_block(columns, part, Scratch::new(&mut work).stack());
        });
    }

    fn factor_entries(&self) -> usize {
        self.values.len()
    }

    fn in_single(&self) -> Option<Box<dyn Preconditioner<f64>>> {
        if self.kind != Kind::Spd {
            return None;
        }
        let single = SingleFactors::new(&self.structure, &self.values, &self.pivots())?;
        Some(Box::new(single))
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        Some(self.pivots().iter().map(|d| d.abs().log2()).sum())
    }
}
