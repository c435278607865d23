//! The matrix T that is similar to M⁻¹𝒜, dense.

use super::form::Form;
use crate::SetupError;
use crate::eigen::dense;
use crate::saddle::{AugmentationMatrix, InnerChoice, SaddleBlocks, schur};
use faer::Mat;
use fracas_operators::{Dense, Preconditioner};

/// `T = [K₀ + G R, G(I−Ĥ); −R, Ĥ]`, see the module [`spectrum`](super).
pub(super) struct Similarity {
    /// `S̃_u⁻¹ = E Eᵀ`.
    e: Mat<f64>,
    /// `C⁻¹ = F Fᵀ`.
    f: Mat<f64>,
    k_0: Mat<f64>,
    g: Mat<f64>,
    h_hat: Mat<f64>,
    r: Mat<f64>,
    /// S̃_u = S_u.
    is_exact: bool,
}

impl Similarity {
    /// All blocks of T.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] for S_u; [`SetupError::NotApplicable`] when S̃_u⁻¹ is not symmetric positive
    /// definite.
    ///
    /// # Cost
    /// O(n_u³) flops and six n_u × n_u matrices.
    pub(super) fn new(
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
        choice: InnerChoice,
        inner: &dyn Preconditioner<f64>,
    ) -> Result<Self, SetupError> {
        let s_u = schur::primal_schur(&blocks.a, &blocks.b1, c)?;
        let e = match choice {
            InnerChoice::Exact { .. } => exact_factor(dense::to_dense(&s_u))?,
            _ => factor_of(inner)?,
        };
        let f = c.inverse_root()?;
        let k_0 = dense::multiply(
            e.transpose(),
            dense::sparse_multiply(&s_u, e.as_ref()).as_ref(),
        );
        let f_transposed = f.transpose_view().to_csr();
        // G = Eᵀ B1 F
        let b_f = dense::to_dense(&(&blocks.b1 * &f));
        let g = dense::multiply(e.transpose(), b_f.as_ref());
        let n_t = blocks.n_t();
        let h_hat = match &blocks.h {
            Some(h) => dense::to_dense(&(&(&f_transposed * h) * &f)),
            None => Mat::zeros(n_t, n_t),
        };
        // R = Fᵀ B2 E − Ĥ Gᵀ
        let mut r = match &blocks.b2 {
            Some(b2) => dense::sparse_multiply(&(&f_transposed * b2), e.as_ref()),
            None => g.transpose().to_owned(),
        };
        r -= dense::multiply(h_hat.as_ref(), g.transpose());
        Ok(Self {
            e,
            f: dense::to_dense(&f),
            k_0,
            g,
            h_hat,
            r,
            is_exact: matches!(choice, InnerChoice::Exact { .. }),
        })
    }

    /// T.
    pub(super) fn matrix(&self) -> Mat<f64> {
        let (n_u, n_t) = (self.g.nrows(), self.g.ncols());
        let upper = &self.k_0 + dense::multiply(self.g.as_ref(), self.r.as_ref());
        let right = &self.g - dense::multiply(self.g.as_ref(), self.h_hat.as_ref());
        Mat::from_fn(n_u + n_t, n_u + n_t, |i, j| match (i < n_u, j < n_u) {
            (true, true) => upper[(i, j)],
            (true, false) => right[(i, j - n_u)],
            (false, true) => -self.r[(i - n_u, j)],
            (false, false) => self.h_hat[(i - n_u, j - n_u)],
        })
    }

    /// T by its parts where all blocks are symmetric.
    pub(super) fn form(&self, p: &dyn Fn(f64) -> f64) -> Result<Form, SetupError> {
        let sigma = (!self.is_exact).then(|| self.k_0.clone());
        Form::new(sigma, &self.g, Some(&self.h_hat), p, 0)
    }

    /// A vector of the original unknowns from one of [`Form::matrix`].
    pub(super) fn back_of(&self, form: &Form, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let v_u = Mat::from_fn(self.g.nrows(), 1, |i, _| v[i]);
        let v_t = form.tractions(v);
        let v_t = Mat::from_fn(v_t.len(), 1, |i, _| v_t[i]);
        let entries = |m: Mat<f64>| m.col(0).iter().copied().collect();
        (entries(&self.e * &v_u), entries(&self.f * &v_t))
    }

    /// `Z v = (E v_u, F Gᵀ v_u + F v_t)`: a vector of the original unknowns.
    pub(super) fn back(&self, v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let n_u = self.g.nrows();
        let v_u = Mat::from_fn(n_u, 1, |i, _| v[i]);
        let v_t = Mat::from_fn(self.g.ncols(), 1, |i, _| v[n_u + i]);
        let u = &self.e * &v_u;
        let t = &self.f * (self.g.transpose() * &v_u + v_t);
        (
            u.col(0).iter().copied().collect(),
            t.col(0).iter().copied().collect(),
        )
    }
}

/// `E = L⁻ᵀ`, `S_u = L Lᵀ`.
fn exact_factor(s_u: Mat<f64>) -> Result<Mat<f64>, SetupError> {
    let n = s_u.nrows();
    let l = dense::cholesky(s_u).map_err(|row| SetupError::NotPositiveDefinite {
        block: "S_u",
        row: row + 1,
        advice: "a block of rock is held neither by boundary conditions nor by a fracture"
            .to_owned(),
    })?;
    let mut e = Mat::identity(n, n);
    dense::solve_lower_adjoint(l.as_ref(), &mut e);
    Ok(e)
}

/// `S̃_u⁻¹ = E Eᵀ` of any linear symmetric approximation, by its columns.
fn factor_of(inner: &dyn Preconditioner<f64>) -> Result<Mat<f64>, SetupError> {
    /// Relative asymmetry that rounding explains.
    const ASYMMETRY: f64 = 1e-9;
    let not_spd = |what: &str| SetupError::NotApplicable {
        method: "the similarity transform",
        reason: format!("the approximation of S_u⁻¹ is not {what}"),
    };
    if !inner.properties().linear {
        return Err(not_spd("linear"));
    }
    let columns = Dense::of_preconditioner(inner);
    let n = inner.size();
    let mut p = Mat::from_fn(n, n, |i, j| columns.entry(i, j));
    let scale: Vec<f64> = (0..n).map(|i| p[(i, i)].abs().sqrt()).collect();
    let asymmetric = (0..n)
        .any(|j| (0..j).any(|i| (p[(i, j)] - p[(j, i)]).abs() > ASYMMETRY * scale[i] * scale[j]));
    if asymmetric {
        return Err(not_spd("symmetric"));
    }
    dense::symmetrize(&mut p);
    dense::cholesky(p).map_err(|_| not_spd("positive definite"))
}
