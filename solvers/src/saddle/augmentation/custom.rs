//! A C that is neither diagonal, nor one block per face, nor dense.

use super::matrix::{ZERO_PIVOT, not_positive_definite};
use super::{AugmentationMatrix, Block};
use crate::SetupError;
use crate::direct::{DirectChoice, Factorization, Kind};
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{LinearOperator, Preconditioner, Properties, Shape};
use std::borrow::Cow;
use std::fmt::Debug;
use std::sync::Arc;

/// A symmetric positive definite C: it multiplies, solves and tells its entries.
pub trait CustomAugmentation: LinearOperator<f64> + Preconditioner<f64> + Debug {
    /// All entries of C.
    fn entries(&self) -> SparseMatrix<f64>;

    /// F with `C⁻¹ = F Fᵀ`, where F has about as few entries as C: S_u is then assembled of it. `None` leaves S_u to a
    /// factorization of `[A B; Bᵀ −C]`, or to a dense C⁻¹.
    fn inverse_root(&self) -> Option<SparseMatrix<f64>>;
}

/// `factor · C`.
#[derive(Clone, Debug)]
pub struct Custom {
    pub(super) c: Arc<dyn CustomAugmentation>,
    pub(super) factor: f64,
}

impl Custom {
    /// All entries.
    pub(super) fn entries(&self) -> SparseMatrix<f64> {
        self.c.entries().map(|v| v * self.factor)
    }

    /// F with `C⁻¹ = F Fᵀ`.
    pub(super) fn inverse_root(&self) -> Option<SparseMatrix<f64>> {
        let root = self.c.inverse_root()?;
        Some(root.map(|v| v / self.factor.sqrt()))
    }

    pub(super) fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.c.solve(r, z, work);
        z.iter_mut().for_each(|z| *z /= self.factor);
    }
}

impl AugmentationMatrix {
    /// Any C.
    ///
    /// # Cost
    /// Two products with C and one solve.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] where sizes, entries, products and solves are not those of one symmetric C,
    /// [`SetupError::NotPositiveDefinite`] with the row.
    pub fn custom(c: Arc<dyn CustomAugmentation>) -> Result<Self, SetupError> {
        check(&*c)?;
        Ok(Self::Custom(Custom { c, factor: 1.0 }))
    }

    /// What multigrid of a run is built of: C, but of a C that couples faces its blocks, as C⁻¹ and with it S_u has an entry for every
    /// two rows beside a fracture. Small systems take all of C: of the blocks AMG takes up to a quarter more iterations (`cycle`,
    /// `floating`: 16 and 18, of the blocks 20 and 22). A dense C serves theory and stays.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] with the row.
    pub fn by_faces(&self) -> Result<Cow<'_, Self>, SetupError> {
        if !matches!(self, Self::Custom(_)) || self.is_sparse() {
            return Ok(Cow::Borrowed(self));
        }
        let blocks = self.of_faces().into_iter().map(|[c, _]| c);
        Self::from_face_blocks(blocks.collect()).map(Cow::Owned)
    }

    /// A sparse symmetric C that couples faces: a tridiagonal one along a fracture, say.
    ///
    /// # Cost
    /// A sparse factorization of C.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] with the row.
    pub fn from_sparse(c: SparseMatrix<f64>) -> Result<Self, SetupError> {
        Self::custom(Arc::new(Sparse::new(c)?))
    }
}

/// A C given by its entries.
#[derive(Debug)]
struct Sparse {
    c: Csr<f64>,
    factors: Factors,
}

/// Factors of C.
struct Factors(Box<dyn Factorization>);

impl Debug for Factors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LLᵀ, {} entries", self.0.factor_entries())
    }
}

impl Sparse {
    fn new(c: SparseMatrix<f64>) -> Result<Self, SetupError> {
        check_entries(&c)?;
        let symbolic = DirectChoice::Faer.solver()?.analyze(&c, Kind::Spd)?;
        let factors = symbolic.factor(&c).map_err(|error| error.in_block("C"))?;
        Ok(Self {
            c: Csr::new(c),
            factors: Factors(factors),
        })
    }
}

impl LinearOperator<f64> for Sparse {
    fn shape(&self) -> Shape {
        self.c.shape()
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        self.c.apply_add(alpha, x, y, work);
    }

    fn work_len(&self) -> usize {
        self.c.work_len()
    }

    fn flops(&self) -> u64 {
        LinearOperator::flops(&self.c)
    }
}

impl Preconditioner<f64> for Sparse {
    fn size(&self) -> usize {
        self.c.shape().rows
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.factors.0.solve(r, z, work);
    }

    fn work_len(&self) -> usize {
        self.factors.0.work_len()
    }

    fn flops(&self) -> u64 {
        self.factors.0.flops()
    }

    fn properties(&self) -> Properties {
        self.factors.0.properties()
    }
}

impl CustomAugmentation for Sparse {
    fn entries(&self) -> SparseMatrix<f64> {
        self.c.matrix().clone()
    }

    fn inverse_root(&self) -> Option<SparseMatrix<f64>> {
        None
    }
}

/// Refuses entries that are not those of a symmetric C with a positive diagonal.
fn check_entries(c: &SparseMatrix<f64>) -> Result<(), SetupError> {
    assert_eq!(c.rows(), c.cols(), "rows and columns of C");
    for i in 0..c.rows() {
        let c_ii = c.get(i, i).copied().unwrap_or(0.0);
        if !(c_ii > 0.0 && c_ii.is_finite()) {
            return Err(not_positive_definite(i));
        }
    }
    match unsymmetric_row(c) {
        None => Ok(()),
        Some(row) => Err(no_c(format!(
            "row {} of C is not its column: C has to be symmetric",
            row + 1
        ))),
    }
}

/// Refuses a C that is not what its entries are, or whose C⁻¹ has no digits: of C⁻¹(C 1) the row that is farthest from 1.
fn check(c: &dyn CustomAugmentation) -> Result<(), SetupError> {
    let entries = c.entries();
    let n = entries.rows();
    let (shape, size) = (c.shape(), Preconditioner::size(c));
    if entries.cols() != n || shape != Shape::square(n) || size != n {
        return Err(no_c(format!(
            "its entries are {n}×{}, its products {shape} and its solves of {size} rows",
            entries.cols()
        )));
    }
    check_entries(&entries)?;
    let ones = vec![1.0; n];
    let (mut r, mut z) = (vec![0.0; n], vec![0.0; n]);
    let len = LinearOperator::work_len(c).max(Preconditioner::work_len(c));
    let mut work = vec![0.0; len];
    c.apply(&ones, &mut r, &mut work);
    for (i, row) in entries.outer_iterator().enumerate() {
        let (sum, size) = row
            .data()
            .iter()
            .fold((0.0, 0.0), |(sum, size), v| (sum + v, size + v.abs()));
        if r[i].is_nan() || (r[i] - sum).abs() > ZERO_PIVOT.sqrt() * size {
            return Err(no_c(format!(
                "row {} of its products is not that of its entries",
                i + 1
            )));
        }
    }
    c.solve(&r, &mut z, &mut work);
    let far = |z: &f64| z.is_nan() || (z - 1.0).abs() > ZERO_PIVOT.sqrt();
    match z.iter().position(far) {
        Some(row) => Err(not_positive_definite(row)),
        None => Ok(()),
    }
}

fn no_c(reason: String) -> SetupError {
    SetupError::NotApplicable {
        method: "C",
        reason,
    }
}

/// The first row whose entries are not those of its column, up to rounding.
fn unsymmetric_row(c: &SparseMatrix<f64>) -> Option<usize> {
    let diagonal = |i: usize| c.get(i, i).copied().unwrap_or(0.0);
    let mut entries = c.iter();
    let found = entries.find(|(value, (i, j))| {
        let (i, j) = (*i as usize, *j as usize);
        let other = c.get(j, i).copied().unwrap_or(0.0);
        (*value - other).abs() > ZERO_PIVOT * (diagonal(i) * diagonal(j)).sqrt()
    });
    found.map(|(_, (i, _))| i as usize)
}

/// The 3×3 blocks of faces of a sparse C.
pub(super) fn face_blocks(c: &SparseMatrix<f64>) -> Vec<Block> {
    let mut blocks = vec![[[0.0; 3]; 3]; c.rows() / 3];
    for (value, (i, j)) in c {
        let (i, j) = (i as usize, j as usize);
        if i / 3 == j / 3 {
            blocks[i / 3][i % 3][j % 3] += value;
        }
    }
    blocks
}
