//! LU with partial pivoting, columns ordered by nested dissection or minimum degree, whichever bounds the factors lower.

use super::{Scratch, out_of_memory, symbolic_failure, work_entries};
use crate::SetupError;
use crate::direct::equilibration::Equilibrated;
use crate::direct::nested_dissection::nested_dissection;
use crate::direct::pattern::{BLOCK, Pattern};
use crate::direct::refinement::Refined;
use crate::direct::{Factorization, Symbolic, for_column_blocks};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::PermRef;
use faer::sparse::linalg::lu::{simplicial, supernodal};
use faer::sparse::linalg::{LuError, colamd, qr};
use faer::sparse::{FaerError, SparseColMatRef};
use faer::{Conj, MatMut, Par};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use std::sync::Arc;

/// Operations per entry of the factors above which dense kernels on supernodes pay. Unit: flops; faer's own choice.
const SUPERNODAL_FLOPS_PER_ENTRY: f64 = 40.0;

/// An analysed pattern, by columns.
#[derive(Clone, Debug)]
pub(super) struct GeneralSymbolic {
    pattern: Pattern,
    structure: Arc<Structure>,
}

/// Order of the columns and, where dense kernels pay, supernodes of the column elimination tree.
#[derive(Debug)]
struct Structure {
    order: Vec<usize>,
    position: Vec<usize>,
    supernodes: Option<supernodal::SymbolicSupernodalLu<usize>>,
    entries_bound: usize,
}

impl Structure {
    fn columns(&self) -> PermRef<'_, usize> {
        PermRef::new_checked(&self.order, &self.position, self.order.len())
    }
}

impl GeneralSymbolic {
    /// Order, postorder and supernodes of any square pattern.
    pub(super) fn new(a: &SparseMatrix<f64>) -> Result<Self, SetupError> {
        let (pattern, rows) = (Pattern::of(&a.to_csc())?, Pattern::of(&a.to_csr())?);
        let n = pattern.size();
        let symbolic_failure = |e| symbolic_failure(e, n);
        let dissection =
            structure(&pattern, &rows, nested_dissection(a)?).map_err(symbolic_failure)?;
        let degree = minimum_degree(&pattern)
            .and_then(|order| structure(&pattern, &rows, order))
            .map_err(symbolic_failure)?;
        let structure = if degree.entries_bound < dissection.entries_bound {
            degree
        } else {
            dissection
        };
        Ok(Self {
            pattern,
            structure: Arc::new(structure),
        })
    }
}

/// Approximate minimum degree of AᵀA, which nested dissection of A + Aᵀ does not always beat.
///
/// # Source
/// T. A. Davis, J. R. Gilbert, S. I. Larimore, E. G. Ng, ACM Trans. Math. Softw. 30 (2004) 353–376.
fn minimum_degree(columns: &Pattern) -> Result<Vec<usize>, FaerError> {
    let n = columns.size();
    let scratch = colamd::order_scratch::<usize>(n, n, columns.indices.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| FaerError::OutOfMemory)?;
    let (mut order, mut position) = (vec![0; n], vec![0; n]);
    colamd::order(
        &mut order,
        &mut position,
        super::faer_pattern(columns),
        Default::default(),
        MemStack::new(&mut memory),
    )?;
    Ok(order)
}

/// Symbolic LU for a given order: the factors of `P A` fit in the pattern of the Cholesky factor of `AᵀA`, whatever
/// the row exchanges P.
fn structure(columns: &Pattern, rows: &Pattern, order: Vec<usize>) -> Result<Structure, FaerError> {
    let n = columns.size();
    let (a, a_transposed) = (super::faer_pattern(columns), super::faer_pattern(rows));
    let scratch = StackReq::any_of(&[
        qr::col_etree_scratch::<usize>(n, n),
        qr::postorder_scratch::<usize>(n),
        qr::column_counts_aat_scratch::<usize>(n, n),
        supernodal::factorize_supernodal_symbolic_lu_scratch::<usize>(n, n),
    ]);
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| FaerError::OutOfMemory)?;
    let stack = MemStack::new(&mut memory);

    let (mut tree, mut post) = (vec![0; n], vec![0; n]);
    let (order, position) = super::with_inverse(order);
    let dissection = PermRef::new_checked(&order, &position, n);
    let parents = qr::col_etree(a, Some(dissection), &mut tree, stack);
    qr::postorder(&mut post, parents, stack);
    // supernodes are runs of columns of a postordered tree
    let (order, position) = super::with_inverse(post.iter().map(|&k| order[k]).collect());
    let postordered = PermRef::new_checked(&order, &position, n);
    let parents = qr::col_etree(a, Some(postordered), &mut tree, stack);
    qr::postorder(&mut post, parents, stack);
    let (mut counts, mut first_column) = (vec![0; n], vec![0; n]);
    qr::column_counts_ata(
        &mut counts,
        &mut first_column,
        a_transposed,
        Some(postordered),
        parents,
        &post,
        stack,
    );
    let lower = lower_counts(&first_column, parents.into_inner());
    let entries_bound = counts.iter().sum::<usize>() + lower.iter().sum::<usize>();
    let flops: f64 = (counts.iter().zip(&lower))
        .map(|(&u, &l)| l as f64 * (1.0 + u as f64))
        .sum();
    let supernodes = (flops > SUPERNODAL_FLOPS_PER_ENTRY * entries_bound as f64)
        .then(|| {
            supernodal::factorize_supernodal_symbolic_lu(
                a,
                Some(postordered),
                &first_column,
                parents,
                &counts,
                stack,
                Default::default(),
            )
        })
        .transpose()?;
    Ok(Structure {
        order,
        position,
        supernodes,
        entries_bound,
    })
}

/// Bound of the entries of each column of L: rows that begin in its subtree, less the pivots already taken there.
fn lower_counts(first_column: &[usize], parents: &[isize]) -> Vec<usize> {
    let mut counts = vec![0usize; parents.len()];
    for &first in first_column {
        if let Some(count) = counts.get_mut(first) {
            *count += 1;
        }
    }
    for j in 0..parents.len() {
        if let Ok(parent) = usize::try_from(parents[j]) {
            counts[parent] += counts[j].saturating_sub(1);
        }
    }
    counts
}

impl GeneralSymbolic {
    /// The factors, singular to rounding or not.
    pub(super) fn of_any_condition(
        &self,
        a: &SparseMatrix<f64>,
    ) -> Result<Box<dyn Factorization>, SetupError> {
        let (factors, _) = Equilibrated::of_any_condition(self.by_columns(a)?, self.factors())?;
        Ok(Box::new(Refined::new(a, factors)))
    }

    fn by_columns(&self, a: &SparseMatrix<f64>) -> Result<SparseMatrix<f64>, SetupError> {
        let by_columns = a.to_csc();
        self.pattern.values(&by_columns, "faer")?;
        Ok(by_columns)
    }

    fn factors(&self) -> impl FnOnce(&SparseMatrix<f64>) -> Result<GeneralFactors, SetupError> {
        |scaled| GeneralFactors::new(Arc::clone(&self.structure), &self.pattern, scaled)
    }
}

impl Symbolic for GeneralSymbolic {
    fn factor(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Factorization>, SetupError> {
        let factors = Equilibrated::factor(self.by_columns(a)?, self.factors())?;
        Ok(Box::new(Refined::new(a, factors)))
    }
}

/// `P A Q = L U`.
#[derive(Debug)]
struct GeneralFactors {
    structure: Arc<Structure>,
    row_order: Vec<usize>,
    row_position: Vec<usize>,
    factors: Factors,
}

/// Entry by entry, or by supernodes.
#[derive(Debug)]
enum Factors {
    Simplicial(simplicial::SimplicialLu<usize, f64>),
    Supernodal(supernodal::SupernodalLu<usize, f64>),
}

impl GeneralFactors {
    /// Factorizes a matrix stored by columns.
    fn new(
        structure: Arc<Structure>,
        pattern: &Pattern,
        a: &SparseMatrix<f64>,
    ) -> Result<Self, SetupError> {
        let n = pattern.size();
        let columns = SparseColMatRef::new(super::faer_pattern(pattern), a.data());
        let (mut row_order, mut row_position) = (vec![0; n], vec![0; n]);
        let scratch = match &structure.supernodes {
            None => simplicial::factorize_simplicial_numeric_lu_scratch::<usize, f64>(n, n),
            Some(s) => supernodal::factorize_supernodal_numeric_lu_scratch::<usize, f64>(
                s,
                Default::default(),
            ),
        };
        let mut memory = MemBuffer::try_new(scratch)
            .map_err(|_| out_of_memory(n, Some(scratch.unaligned_bytes_required())))?;
        let stack = MemStack::new(&mut memory);
        let factors = match &structure.supernodes {
            None => {
                let mut lu = simplicial::SimplicialLu::new();
                simplicial::factorize_simplicial_numeric_lu(
                    &mut row_order,
                    &mut row_position,
                    &mut lu,
                    columns,
                    structure.columns(),
                    stack,
                )
                .map(|()| Factors::Simplicial(lu))
            }
            Some(s) => {
                let transposed = a.to_csr();
                let rows = Pattern::of(&transposed)?;
                let mut lu = supernodal::SupernodalLu::new();
                supernodal::factorize_supernodal_numeric_lu(
                    &mut row_order,
                    &mut row_position,
                    &mut lu,
                    columns,
                    SparseColMatRef::new(super::faer_pattern(&rows), transposed.data()),
                    structure.columns(),
                    s,
                    Par::rayon(0),
                    stack,
                    Default::default(),
                )
                .map(|()| Factors::Supernodal(lu))
            }
        }
        .map_err(|e| match e {
            LuError::SymbolicSingular { index } => SetupError::Singular {
                block: BLOCK,
                row: None,
                advice: format!(
                    "no entry is left to pivot on in column {}",
                    structure.order[index] + 1
                ),
            },
            LuError::Generic(e) => symbolic_failure(e, n),
        })?;
        Ok(Self {
            structure,
            row_order,
            row_position,
            factors,
        })
    }

    fn rows(&self) -> PermRef<'_, usize> {
        PermRef::new_checked(&self.row_order, &self.row_position, self.row_order.len())
    }

    fn scratch(&self, columns: usize) -> StackReq {
        match &self.factors {
            Factors::Simplicial(_) => {
                simplicial::solve_in_place_scratch::<usize, f64>(self.size(), columns, Par::Seq)
            }
            Factors::Supernodal(_) => {
                supernodal::solve_in_place_scratch::<usize, f64>(self.size(), columns, Par::Seq)
            }
        }
    }

    fn solve_block(&self, columns: usize, b: &mut [f64], stack: &mut MemStack) {
        let b = MatMut::from_column_major_slice_mut(b, self.size(), columns);
        let (rows, order) = (self.rows(), self.structure.columns());
        match &self.factors {
            Factors::Simplicial(lu) => {
                lu.solve_in_place_with_conj(rows, order, Conj::No, b, Par::Seq, stack)
            }
            Factors::Supernodal(lu) => {
                lu.solve_in_place_with_conj(rows, order, Conj::No, b, Par::Seq, stack)
            }
        }
    }
}

impl Preconditioner<f64> for GeneralFactors {
    fn size(&self) -> usize {
        self.row_order.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        z.copy_from_slice(r);
        self.solve_block(1, z, Scratch::new(work).stack());
    }

    fn work_len(&self) -> usize {
        work_entries(self.scratch(1))
    }

    fn flops(&self) -> u64 {
        2 * self.factor_entries() as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

impl Factorization for GeneralFactors {
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        z.copy_from_slice(r);
        let (rows, order) = (self.rows(), self.structure.columns());
        let mut scratch = Scratch::new(work);
        let (z, stack) = (
            MatMut::from_column_major_slice_mut(z, self.size(), 1),
            scratch.stack(),
        );
        match &self.factors {
            Factors::Simplicial(lu) => {
                lu.solve_transpose_in_place_with_conj(rows, order, Conj::No, z, Par::Seq, stack)
            }
            Factors::Supernodal(lu) => {
                lu.solve_transpose_in_place_with_conj(rows, order, Conj::No, z, Par::Seq, stack)
            }
        }
    }

    fn solve_many(&self, columns: usize, b: &mut [f64]) {
        assert_eq!(b.len(), columns * self.size(), "{columns} right-hand sides");
        for_column_blocks(self.size(), b, |columns, part| {
            let mut work = vec![0.0; work_entries(self.scratch(columns))];
            self.solve_block(columns, part, Scratch::new(&mut work).stack());
        });
    }

    fn factor_entries(&self) -> usize {
        match &self.factors {
            Factors::Simplicial(lu) => {
                lu.l_factor_unsorted().compute_nnz() + lu.u_factor_unsorted().compute_nnz()
            }
            Factors::Supernodal(_) => self.structure.entries_bound,
        }
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        match &self.factors {
            // the pivot is the last entry of every column of U
            Factors::Simplicial(lu) => {
                let u = lu.u_factor_unsorted();
                let pivots = (0..u.ncols()).filter_map(|j| u.val_of_col(j).last());
                Some(pivots.map(|d: &f64| d.abs().log2()).sum())
            }
            Factors::Supernodal(_) => None,
        }
    }
}
