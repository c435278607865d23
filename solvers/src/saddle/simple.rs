//! SIMPLE and its full factorization.

use super::inner::Ready;
use super::method::SaddleSettings;
use super::schur::diagonal_schur_inverse;
use super::{InnerChoice, SaddleBlocks, T, U};
use crate::SetupError;
use crate::direct::DirectChoice;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{Layout, LinearOperator, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `M⁻¹ = [I −QB1; 0 I]·diag(P, −Ŝ⁻¹)·[I 0; −B2P I]`, `P ≈ A⁻¹`, `Ŝ ≈ H + B2A⁻¹B1`; Q = P, or Q = diag(A)⁻¹ in SIMPLE.
/// Exact parts with Q = P: M = 𝒜.
///
/// # Cost
/// Two solves with P (SIMPLE: one), one with Ŝ, one product with B1 and one with B2.
///
/// # Source
/// S. V. Patankar, D. B. Spalding, Int. J. Heat Mass Transfer 15 (1972) 1787–1806, for Q = diag(A)⁻¹; the full
/// factorization with this Ŝ is what PETSc calls `selfp`.
pub struct SimpleInverse<P, S> {
    b1: Csr<f64>,
    b2: Csr<f64>,
    p: P,
    s: S,
    /// diag(A)⁻¹ in place of the second P.
    inverse_diagonal: Option<Vec<f64>>,
    layout: Layout,
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> SimpleInverse<P, S> {
    /// From exact parts: B1, B2, P and Ŝ⁻¹, with Q = P.
    pub fn new(b1: SparseMatrix<f64>, b2: SparseMatrix<f64>, p: P, s: S) -> Self {
        assert_eq!(b1.rows(), p.size(), "rows of B1 and size of A");
        assert_eq!(b1.cols(), s.size(), "columns of B1 and size of S");
        assert_eq!(
            (b2.rows(), b2.cols()),
            (b1.cols(), b1.rows()),
            "B2 and B1ᵀ differ in shape"
        );
        let layout = Layout::new([(U, b1.rows()), (T, b1.cols())]);
        Self {
            b1: Csr::new(b1),
            b2: Csr::new(b2),
            p,
            s,
            inverse_diagonal: None,
            layout,
        }
    }

    /// The same with `Q = diag(q)`.
    #[must_use]
    pub fn correcting_by(mut self, q: Vec<f64>) -> Self {
        assert_eq!(q.len(), self.layout.length(U), "length of Q and n_u");
        self.inverse_diagonal = Some(q);
        self
    }
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> Preconditioner<f64> for SimpleInverse<P, S> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split([U, T], x);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        let (v_u, work) = work.split_at_mut(x_u.len());
        let (w_t, work) = work.split_at_mut(x_t.len());
        // y_u = P x_u
        self.p.solve(x_u, y_u, work);
        // w_t = B2 y_u − x_t
        w_t.iter_mut().zip(x_t).for_each(|(w, x)| *w = -x);
        self.b2.apply_add(1.0, y_u, w_t, &mut []);
        // y_t = Ŝ⁻¹ w_t
        self.s.solve(w_t, y_t, work);
        if let Some(q) = &self.inverse_diagonal {
            // y_u = y_u − diag(A)⁻¹ B1 y_t
            self.b1.apply(y_t, v_u, &mut []);
            (y_u.iter_mut().zip(&*v_u).zip(q)).for_each(|((y, v), q)| *y -= q * v);
        } else {
            // y_u = P (x_u − B1 y_t)
            v_u.copy_from_slice(x_u);
            self.b1.apply_add(-1.0, y_t, v_u, &mut []);
            self.p.solve(v_u, y_u, work);
        }
    }

    fn work_len(&self) -> usize {
        self.layout.len() + self.p.work_len().max(self.s.work_len())
    }

    fn flops(&self) -> u64 {
        let correction = match &self.inverse_diagonal {
            Some(q) => 2 * q.len() as u64,
            None => self.p.flops(),
        };
        self.p.flops() + correction + self.s.flops() + self.b1.flops() + self.b2.flops()
    }

    fn properties(&self) -> Properties {
        self.p.properties().and(self.s.properties())
    }
}

/// What corrects the displacements for the new tractions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// P again: the full block factorization.
    #[default]
    Solve,
    /// diag(A)⁻¹: SIMPLE.
    Diagonal,
}

/// Settings of SIMPLE: `Ŝ = H + B2 diag(A)⁻¹B1`, factorized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Simple {
    /// Q.
    pub correction: Correction,
    /// P.
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
}

impl SaddleSettings for Simple {
    fn name(&self) -> &'static str {
        "simple"
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        let coordinates = blocks.coordinates.as_deref();
        let p = self.inner.of_matrix(&blocks.a, coordinates)?;
        let s = diagonal_schur_inverse(blocks, DirectChoice::default())?;
        let full = |p| SimpleInverse::new(blocks.b1.clone(), blocks.b2_rows(), p, s);
        Ok(p.inside(|p| match self.correction {
            Correction::Solve => full(p),
            Correction::Diagonal => {
                let diagonal = (0..blocks.n_u()).map(|i| blocks.a.get(i, i).copied());
                // the Schur complement has checked that it is positive
                full(p).correcting_by(diagonal.map(|d| d.map_or(0.0, f64::recip)).collect())
            }
        }))
    }

    fn inner_mut(&mut self) -> Option<&mut InnerChoice> {
        Some(&mut self.inner)
    }
}
