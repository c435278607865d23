//! The whole spectrum when S_u is inverted exactly and B2 = B1ᵀ: an n_t × n_t problem, symmetric where A is SPSD.

use super::form::Form;
use crate::SetupError;
use crate::eigen::dense;
use crate::saddle::{AugmentationMatrix, SaddleBlocks, schur};
use faer::{Mat, c64};
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

/// `M⁻¹𝒜` with exact S_u, in the eigenbasis of GᵀG.
///
/// With K₀ = I, `P = [I 0; −Gᵀ I]` turns T into `P⁻¹TP = [I, G(I−Ĥ); 0, Ĥ + GᵀG(I−Ĥ)]`: the eigenvalue 1 at least n_u
/// times, and those of `I − W(I−Ĥ)`, `W = I − GᵀG`, which are those of `Y = I − J|W|^{1/2}(I−Ĥ)|W|^{1/2}`, J = sign W.
/// `EᵀAE = I − GGᵀ`, so W is SPSD and Y symmetric exactly when A is SPSD; A may be singular. For an indefinite A, Y is
/// unsymmetric and its eigenvalues may be complex.
pub(super) struct Coupling {
    /// Singular values of G squared, ascending: eigenvalues of GᵀG.
    pub(super) sigma_squared: Vec<f64>,
    /// Eigenvectors of GᵀG; absent when H = 0 (nothing else needs them).
    pub(super) basis: Mat<f64>,
    /// VᵀĤV, absent when H = 0.
    h_hat: Option<Mat<f64>>,
    n_u: usize,
    /// A is SPSD: what is negative in W is rounding.
    semi_definite: bool,
}

impl Coupling {
    /// From a dense Cholesky factorization of S_u: small singular values of G keep their digits.
    pub(super) fn dense(
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
        semi_definite: bool,
    ) -> Result<Self, SetupError> {
        let root = c.inverse_root()?;
        let s_u = schur::primal_schur(&blocks.a, &blocks.b1, c)?;
        let l = dense::cholesky(dense::to_dense(&s_u)).map_err(|row| {
            SetupError::NotPositiveDefinite {
                block: "S_u",
                row: row + 1,
                advice: "a block of rock is held neither by boundary conditions nor by a fracture"
                    .to_owned(),
            }
        })?;
        let mut g = dense::to_dense(&(&blocks.b1 * &root));
        dense::solve_lower(l.as_ref(), &mut g);
        let gram = dense::multiply(g.transpose(), g.as_ref());
        let mut singular: Vec<f64> = dense::singular_values(g.as_ref())?
            .iter()
            .map(|s| s * s)
            .collect();
        singular.resize(blocks.n_t(), 0.0);
        singular.reverse();
        Self::new(gram, Some(singular), blocks, &root, semi_definite)
    }

    /// From solves with sparse factors: `GᵀG = Fᵀ Bᵀ S_u⁻¹ B F`, any n_u.
    pub(super) fn sparse(
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
        semi_definite: bool,
        inverse: &dyn Preconditioner<f64>,
    ) -> Result<Self, SetupError> {
        let root = c.inverse_root()?;
        let scaled = (&blocks.b1 * &root).to_csc();
        let n_t = blocks.n_t();
        let columns: Vec<Vec<f64>> = (0..n_t)
            .into_par_iter()
            .map_init(
                || {
                    (
                        vec![0.0; blocks.n_u()],
                        vec![0.0; blocks.n_u()],
                        vec![0.0; inverse.work_len()],
                    )
                },
                |(b, x, work), j| {
                    b.fill(0.0);
                    scaled
                        .outer_view(j)
                        .iter()
                        .for_each(|column| column.iter().for_each(|(i, v)| b[i] = *v));
                    inverse.solve(b, x, work);
                    scaled
                        .outer_iterator()
                        .map(|column| column.iter().map(|(i, v)| v * x[i]).sum())
                        .collect()
                },
            )
            .collect();
        let gram = Mat::from_fn(n_t, n_t, |i, j| columns[j][i]);
        Self::new(gram, None, blocks, &root, semi_definite)
    }

    fn new(
        mut gram: Mat<f64>,
        singular: Option<Vec<f64>>,
        blocks: &SaddleBlocks,
        root: &SparseMatrix<f64>,
        semi_definite: bool,
    ) -> Result<Self, SetupError> {
        dense::symmetrize(&mut gram);
        let (values, basis) = dense::symmetric_eigen(gram.as_ref())?;
        let sigma_squared = singular.unwrap_or_else(|| values.iter().map(|v| v.max(0.0)).collect());
        let h_hat = blocks.h.as_ref().map(|h| {
            let image = dense::sparse_multiply(root, basis.as_ref());
            let mut h_hat = dense::multiply(
                image.transpose(),
                dense::sparse_multiply(h, image.as_ref()).as_ref(),
            );
            dense::symmetrize(&mut h_hat);
            h_hat
        });
        Ok(Self {
            sigma_squared,
            basis,
            h_hat,
            n_u: blocks.n_u(),
            semi_definite,
        })
    }

    /// The n_t eigenvalues besides 1.
    pub(super) fn eigenvalues(&self) -> Result<Vec<c64>, SetupError> {
        match self.y() {
            // H = 0: Y = I − W = GᵀG
            None => Ok(real(self.sigma_squared.clone())),
            Some(y) if self.semi_definite => Ok(real(dense::symmetric_eigenvalues(y.as_ref())?)),
            Some(y) => dense::general_eigenvalues(y.as_ref()),
        }
    }

    /// Eigenvalues with eigenvectors t' of `I − W(I−Ĥ)` in the original scaled traction basis, one a column.
    pub(super) fn eigenvectors(&self) -> Result<(Vec<c64>, Mat<c64>), SetupError> {
        let complex =
            |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| c64::new(m[(i, j)], 0.0));
        let Some(y) = self.y() else {
            return Ok((real(self.sigma_squared.clone()), complex(&self.basis)));
        };
        let (values, vectors) = if self.semi_definite {
            let (values, vectors) = dense::symmetric_eigen(y.as_ref())?;
            (real(values), complex(&vectors))
        } else {
            dense::general_eigen(y.as_ref())?
        };
        // t' = V |W|^{1/2} y
        let part = |f: fn(&c64) -> f64| {
            let scaled = Mat::from_fn(vectors.nrows(), vectors.ncols(), |i, j| {
                self.root_w(i) * f(&vectors[(i, j)])
            });
            dense::multiply(self.basis.as_ref(), scaled.as_ref())
        };
        let (re, im) = (part(|v| v.re), part(|v| v.im));
        let whole = Mat::from_fn(re.nrows(), re.ncols(), |i, j| {
            c64::new(re[(i, j)], im[(i, j)])
        });
        Ok((values, whole))
    }

    fn w(&self, i: usize) -> f64 {
        let w = 1.0 - self.sigma_squared[i];
        if self.semi_definite { w.max(0.0) } else { w }
    }

    fn root_w(&self, i: usize) -> f64 {
        self.w(i).abs().sqrt()
    }

    /// Y in the eigenbasis of GᵀG; `None` for H = 0.
    fn y(&self) -> Option<Mat<f64>> {
        self.h_hat.as_ref().map(|h_hat| {
            Mat::from_fn(h_hat.nrows(), h_hat.nrows(), |i, j| {
                let diagonal = if i == j { self.sigma_squared[i] } else { 0.0 };
                let left = self.root_w(i).copysign(self.w(i));
                diagonal + left * h_hat[(i, j)] * self.root_w(j)
            })
        })
    }

    /// T in the range of G: Σ = I, `G = diag(σ) Vᵀ`; what lies beside it counts as ones.
    pub(super) fn form(&self, p: &dyn Fn(f64) -> f64) -> Result<Form, SetupError> {
        let n_t = self.sigma_squared.len();
        let rows = n_t.min(self.n_u);
        // of n_t > n_u squares the smallest are those of no displacement
        let g = Mat::from_fn(rows, n_t, |i, j| match i + n_t - rows == j {
            true => self.sigma_squared[j].max(0.0).sqrt(),
            false => 0.0,
        });
        Form::new(None, &g, self.h_hat.as_ref(), p, self.n_u - rows)
    }
}

/// Real numbers as complex ones.
fn real(values: Vec<f64>) -> Vec<c64> {
    values.into_iter().map(|v| c64::new(v, 0.0)).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::direct::DirectChoice;
    use crate::saddle::AugmentationChoice;
    use crate::saddle::samples::{random, sparse};

    #[test]
    fn with_c_equal_to_h_all_eigenvalues_are_one_and_general_c_gives_the_pencil() {
        let mut blocks = random(20, 6, 0.0, 3);
        let diagonal = |i: usize| 0.3 + 0.1 * i as f64;
        blocks.h = Some(sparse(6, 6, |i, j| if i == j { diagonal(i) } else { 0.0 }));
        let c = AugmentationMatrix::from_diagonal((0..6).map(diagonal).collect()).unwrap();
        let coupling = Coupling::dense(&blocks, &c, true).unwrap();
        assert!(
            coupling
                .eigenvalues()
                .unwrap()
                .iter()
                .all(|v| (v - 1.0).norm() < 1e-12)
        );

        // eig(S+H, S+C) by Cholesky of S+C, S = BᵀA⁻¹B.
        let direct = DirectChoice::Faer.solver().unwrap();
        let c = AugmentationChoice::Local
            .compute(&blocks, direct.as_ref())
            .unwrap()
            .matrix;
        let s = AugmentationChoice::Exact
            .compute(&blocks, direct.as_ref())
            .unwrap()
            .matrix
            .to_dense();
        let l = dense::cholesky(&s + c.to_dense()).unwrap();
        let mut k = &s + dense::to_dense(blocks.h.as_ref().unwrap());
        dense::solve_lower(l.as_ref(), &mut k);
        let mut k = k.transpose().to_owned();
        dense::solve_lower(l.as_ref(), &mut k);
        dense::symmetrize(&mut k);
        let pencil = dense::symmetric_eigenvalues(k.as_ref()).unwrap();
        let inverse = schur::exact_inverse(&blocks, &c, direct.as_ref()).unwrap();
        for coupling in [
            Coupling::dense(&blocks, &c, true).unwrap(),
            Coupling::sparse(&blocks, &c, true, inverse.as_ref()).unwrap(),
        ] {
            for (a, b) in coupling.eigenvalues().unwrap().iter().zip(&pencil) {
                assert!((a - b).norm() < 1e-11);
            }
        }
    }

    #[test]
    fn two_springs_of_either_sign_have_the_eigenvalue_of_the_formula() {
        // A = diag(2, −½), B = (1 1)ᵀ, C = 1: S_u = [3 1; 1 ½], GᵀG = 3, λ = 1 − (1 − H)(1 − 3) = 3 − 2H
        for (h, expected) in [(Some(5.0), -7.0), (None, 3.0), (Some(1.0), 1.0)] {
            let blocks = SaddleBlocks {
                a: sparse(2, 2, |i, j| if i == j { [2.0, -0.5][i] } else { 0.0 }),
                b1: sparse(2, 1, |_, _| 1.0),
                h: h.map(|h| sparse(1, 1, |_, _| h)),
                ..random(2, 1, 0.0, 1)
            };
            let c = AugmentationMatrix::from_diagonal(vec![1.0]).unwrap();
            let coupling = Coupling::dense(&blocks, &c, false).unwrap();
            let found = coupling.eigenvalues().unwrap();
            assert!((found[0] - expected).norm() < 1e-14, "{h:?}: {found:?}");
        }
    }
}
