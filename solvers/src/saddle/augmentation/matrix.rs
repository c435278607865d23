//! C as a matrix: products, solves, its square root and its spectrum.

use super::block::{Block, blocks_add, inverse_factor, inverse3};
use super::custom::{Custom, face_blocks};
use crate::SetupError;
use crate::eigen::dense;
use faer::Mat;
use fracas_operators::operator::assert_product;
use fracas_operators::small::{diagonal, gram};
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_operators::vector::for_row_ranges;
use fracas_operators::{LinearOperator, Shape};
use fracas_operators::{Preconditioner, Properties};

/// Relative size below which a pivot of C counts as zero. Unit: 1.
pub(super) const ZERO_PIVOT: f64 = 1e-13;

/// Rows of a dense C that one thread handles without splitting.
const DENSE_ROWS: usize = 64;

/// An SPD matrix C with `C⁻¹ = F Fᵀ`.
#[derive(Clone, Debug)]
pub enum AugmentationMatrix {
    /// `C = diag(c)`.
    Diagonal {
        /// c.
        c: Vec<f64>,
    },
    /// One 3×3 block per face.
    FaceBlocks {
        /// The blocks.
        c: Vec<Block>,
        /// Their inverses.
        inverse: Vec<Block>,
    },
    /// A full symmetric matrix, by columns.
    Dense {
        /// C.
        c: Mat<f64>,
        /// C⁻¹.
        inverse: Mat<f64>,
    },
    /// Anything else, ready to solve.
    Custom(Custom),
}

impl AugmentationMatrix {
    pub(super) fn diagonal(c: Vec<f64>) -> Self {
        Self::Diagonal { c }
    }

    pub(super) fn face_blocks(c: Vec<Block>) -> Self {
        Self::FaceBlocks {
            c,
            inverse: Vec::new(),
        }
    }

    pub(super) fn dense(c: Mat<f64>) -> Self {
        Self::Dense {
            c,
            inverse: Mat::new(),
        }
    }

    /// `C = diag(c)`, for theory and tests.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] naming the first row that is not positive.
    pub fn from_diagonal(c: Vec<f64>) -> Result<Self, SetupError> {
        let mut matrix = Self::diagonal(c);
        matrix.factor()?;
        Ok(matrix)
    }

    /// A full symmetric C, for theory and tests.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] naming the first row where a pivot vanishes.
    pub fn from_dense(c: Mat<f64>) -> Result<Self, SetupError> {
        let mut matrix = Self::dense(c);
        matrix.factor()?;
        Ok(matrix)
    }

    /// One symmetric 3×3 block per face.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] naming the first row where a pivot vanishes.
    pub fn from_face_blocks(c: Vec<[[f64; 3]; 3]>) -> Result<Self, SetupError> {
        let mut matrix = Self::face_blocks(c);
        matrix.factor()?;
        Ok(matrix)
    }

    /// Checks that C is SPD and prepares C⁻¹.
    pub(super) fn factor(&mut self) -> Result<(), SetupError> {
        match self {
            Self::Diagonal { c } => match c.iter().position(|v| !(*v > 0.0 && v.is_finite())) {
                Some(row) => Err(not_positive_definite(row)),
                None => Ok(()),
            },
            Self::FaceBlocks { c, inverse } => {
                let factors = c.iter().enumerate().map(|(face, block)| {
                    let w = inverse_factor(block);
                    w.map(gram)
                        .map_err(|row| not_positive_definite(3 * face + row))
                });
                *inverse = factors.collect::<Result<_, SetupError>>()?;
                Ok(())
            }
            Self::Dense { c, inverse } => {
                let l = dense_factor(c)?;
                let mut x = Mat::identity(c.nrows(), c.nrows());
                dense::solve_lower(l.as_ref(), &mut x);
                dense::solve_lower_adjoint(l.as_ref(), &mut x);
                dense::symmetrize(&mut x);
                *inverse = x;
                Ok(())
            }
            Self::Custom(_) => Ok(()),
        }
    }

    /// n_t.
    pub fn size(&self) -> usize {
        match self {
            Self::Diagonal { c } => c.len(),
            Self::FaceBlocks { c, .. } => 3 * c.len(),
            Self::Dense { c, .. } => c.nrows(),
            Self::Custom(c) => Preconditioner::size(&*c.c),
        }
    }

    /// True where C⁻¹ has a sparse root, so that S_u may be assembled.
    pub fn is_sparse(&self) -> bool {
        match self {
            Self::Diagonal { .. } | Self::FaceBlocks { .. } => true,
            Self::Dense { .. } => false,
            Self::Custom(c) => c.inverse_root().is_some(),
        }
    }

    /// True where C couples no more than the rows of one face.
    pub fn is_by_faces(&self) -> bool {
        matches!(self, Self::Diagonal { .. } | Self::FaceBlocks { .. })
    }

    /// All entries of C.
    pub fn entries(&self) -> SparseMatrix<f64> {
        let n = self.size();
        let mut triplets = Triplets::new((n, n));
        match self {
            Self::Custom(c) => return c.entries(),
            Self::Diagonal { c } => {
                (c.iter().enumerate()).for_each(|(i, c)| triplets.add_triplet(i, i, *c));
            }
            Self::FaceBlocks { c, .. } => {
                for (i, row) in c.iter().flatten().enumerate() {
                    let first = i - i % 3;
                    (0..3).for_each(|k| triplets.add_triplet(i, first + k, row[k]));
                }
            }
            Self::Dense { c, .. } => {
                for j in 0..n {
                    (0..n).for_each(|i| triplets.add_triplet(i, j, c[(i, j)]));
                }
            }
        }
        triplets.to_csr()
    }

    /// Diagonal entries.
    pub fn diagonal_entries(&self) -> Vec<f64> {
        match self {
            Self::Diagonal { c } => c.clone(),
            Self::FaceBlocks { c, .. } => {
                c.iter().flat_map(|b| [b[0][0], b[1][1], b[2][2]]).collect()
            }
            Self::Dense { c, .. } => (0..c.nrows()).map(|i| c[(i, i)]).collect(),
            Self::Custom(c) => {
                let entries = c.entries();
                let entry = |i| entries.get(i, i).copied().unwrap_or(0.0);
                (0..entries.rows()).map(entry).collect()
            }
        }
    }

    /// C of every face and its inverse; of a C that couples faces the diagonal blocks, of a dense one the diagonal.
    ///
    /// # Panics
    /// Where n_t is no multiple of three.
    pub fn of_faces(&self) -> Vec<[Block; 2]> {
        if let Self::FaceBlocks { c, inverse } = self {
            return c.iter().zip(inverse).map(|(c, i)| [*c, *i]).collect();
        }
        if let Self::Custom(c) = self {
            let blocks = face_blocks(&c.entries()).into_iter();
            return blocks.map(|c| [c, inverse3(&c)]).collect();
        }
        let entries = self.diagonal_entries();
        let faces = entries.as_chunks().0.iter();
        faces
            .map(|c| [diagonal(*c), diagonal(c.map(|c| 1.0 / c))])
            .collect()
    }

    /// C with all its zeros.
    pub fn to_dense(&self) -> Mat<f64> {
        match self {
            Self::Diagonal { c } => {
                Mat::from_fn(c.len(), c.len(), |i, j| if i == j { c[i] } else { 0.0 })
            }
            Self::FaceBlocks { c, .. } => {
                let entry = |i: usize, j: usize| {
                    if i / 3 == j / 3 {
                        c[i / 3][i % 3][j % 3]
                    } else {
                        0.0
                    }
                };
                Mat::from_fn(3 * c.len(), 3 * c.len(), entry)
            }
            Self::Dense { c, .. } => c.clone(),
            Self::Custom(c) => {
                let mut full = Mat::zeros(self.size(), self.size());
                for (value, (i, j)) in &c.entries() {
                    full[(i as usize, j as usize)] += *value;
                }
                full
            }
        }
    }

    /// Smallest and largest eigenvalue of C.
    pub fn extremes(&self) -> Result<(f64, f64), SetupError> {
        let values: Vec<f64> = match self {
            Self::Diagonal { c } => c.clone(),
            Self::FaceBlocks { c, .. } => {
                let blocks = c.iter().map(|b| {
                    dense::symmetric_eigenvalues(Mat::from_fn(3, 3, |i, j| b[i][j]).as_ref())
                });
                blocks.collect::<Result<Vec<_>, _>>()?.concat()
            }
            Self::Dense { .. } | Self::Custom(_) => {
                dense::symmetric_eigenvalues(self.to_dense().as_ref())?
            }
        };
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Ok((low, high))
    }

    /// A factor of the inverse, `C⁻¹ = F Fᵀ`: `C^{-1/2}` where C is diagonal, L⁻ᵀ otherwise.
    pub fn inverse_root(&self) -> Result<SparseMatrix<f64>, SetupError> {
        let n = self.size();
        let mut triplets = Triplets::new((n, n));
        match self {
            Self::Diagonal { c } => c
                .iter()
                .enumerate()
                .for_each(|(i, c)| triplets.add_triplet(i, i, 1.0 / c.sqrt())),
            Self::FaceBlocks { c, .. } => {
                for (face, block) in c.iter().enumerate() {
                    let w = inverse_factor(block)
                        .map_err(|row| not_positive_definite(3 * face + row))?;
                    for i in 0..3 {
                        (i..3).for_each(|j| {
                            triplets.add_triplet(3 * face + i, 3 * face + j, w[j][i])
                        });
                    }
                }
            }
            Self::Dense { .. } | Self::Custom(_) => {
                if let Self::Custom(c) = self
                    && let Some(root) = c.inverse_root()
                {
                    return Ok(root);
                }
                let l = dense_factor(&self.to_dense())?;
                let mut f = Mat::identity(n, n);
                dense::solve_lower_adjoint(l.as_ref(), &mut f);
                for j in 0..n {
                    (0..=j).for_each(|i| triplets.add_triplet(i, j, f[(i, j)]));
                }
            }
        }
        Ok(triplets.to_csr())
    }
}

/// Cholesky factor of a dense C with a test for vanishing pivots.
fn dense_factor(c: &Mat<f64>) -> Result<Mat<f64>, SetupError> {
    let l = dense::cholesky(c.clone()).map_err(not_positive_definite)?;
    let lost = (0..c.nrows()).find(|&i| l[(i, i)] * l[(i, i)] <= ZERO_PIVOT * c[(i, i)]);
    match lost {
        Some(row) => Err(not_positive_definite(row)),
        None => Ok(l),
    }
}

pub(super) fn not_positive_definite(row: usize) -> SetupError {
    SetupError::NotPositiveDefinite {
        block: "C",
        row: row + 1,
        advice: "columns of B depend on each other (over-constrained tractions), or H is indefinite; take local_h, or with \
                 the jump stabilization exact_h"
            .to_owned(),
    }
}

/// `y ← y + α D x` of a stored symmetric matrix, by rows (a column is a row).
fn dense_add(d: &Mat<f64>, alpha: f64, x: &[f64], y: &mut [f64]) {
    for_row_ranges(0, DENSE_ROWS, y, &|start, part| {
        for (i, y_i) in part.iter_mut().enumerate() {
            let row = d.col(start + i);
            let mut sum = 0.0;
            row.iter().zip(x).for_each(|(d, x)| sum += d * x);
            *y_i += alpha * sum;
        }
    });
}

impl LinearOperator<f64> for AugmentationMatrix {
    fn shape(&self) -> Shape {
        Shape::square(self.size())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        match self {
            Self::Diagonal { c } => {
                y.iter_mut()
                    .zip(x)
                    .zip(c)
                    .for_each(|((y, x), c)| *y += alpha * c * x);
            }
            Self::FaceBlocks { c, .. } => blocks_add(c, alpha, x, y),
            Self::Dense { c, .. } => dense_add(c, alpha, x, y),
            Self::Custom(c) => c.c.apply_add(alpha * c.factor, x, y, work),
        }
    }

    fn work_len(&self) -> usize {
        match self {
            Self::Custom(c) => LinearOperator::work_len(&*c.c),
            _ => 0,
        }
    }

    fn flops(&self) -> u64 {
        let n = self.size() as u64;
        match self {
            Self::Diagonal { .. } => 3 * n,
            Self::FaceBlocks { .. } => 7 * n,
            Self::Dense { .. } => 2 * n * n + 2 * n,
            Self::Custom(c) => LinearOperator::flops(&*c.c) + 1,
        }
    }
}

/// `z ← C⁻¹ r`.
impl Preconditioner<f64> for AugmentationMatrix {
    fn size(&self) -> usize {
        self.size()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), r, z);
        match self {
            Self::Diagonal { c } => z
                .iter_mut()
                .zip(r)
                .zip(c)
                .for_each(|((z, r), c)| *z = r / c),
            Self::FaceBlocks { inverse, .. } => {
                z.fill(0.0);
                blocks_add(inverse, 1.0, r, z);
            }
            Self::Dense { inverse, .. } => {
                z.fill(0.0);
                dense_add(inverse, 1.0, r, z);
            }
            Self::Custom(c) => c.solve(r, z, work),
        }
    }

    fn work_len(&self) -> usize {
        match self {
            Self::Custom(c) => Preconditioner::work_len(&*c.c),
            _ => 0,
        }
    }

    fn flops(&self) -> u64 {
        match self {
            Self::Diagonal { c } => c.len() as u64,
            Self::Custom(c) => Preconditioner::flops(&*c.c) + self.size() as u64,
            _ => LinearOperator::flops(self),
        }
    }

    fn properties(&self) -> Properties {
        match self {
            Self::Custom(c) => c.c.properties(),
            _ => Properties::LINEAR,
        }
    }
}
