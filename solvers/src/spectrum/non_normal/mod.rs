//! How far M⁻¹𝒜 is from normal: pseudospectra, field of values, and what they say of GMRES.

mod compress;
mod ellipse;
mod inner_product;
mod pseudospectra;
mod quasi_triangle;
mod resolvent;
#[cfg(test)]
mod tests;
mod transient;

pub use inner_product::InnerProduct;
pub use pseudospectra::Pseudospectra;
pub use resolvent::Resolvent;
pub use transient::{GmresBounds, STEPS_TO};

use super::report::Eigenvalues;
use super::{FieldOfValues, field_of_values};
use crate::SetupError;
use crate::eigen::dense;
use crate::saddle::SaddleBlocks;
use faer::Mat;
use fracas_operators::laws::probe;
use fracas_operators::{Dense, LinearOperator, Preconditioner, Shape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most unknowns: the Schur form costs some 33 n³ flops and a point of the grid some 32 n², and there are thousands.
pub const LARGEST: usize = 2000;

/// What is asked for beside eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NonNormalRequest {
    /// What is a length.
    pub inner_product: InnerProduct,
    /// Abscissas of the grid; fewer than two leave out the pseudospectra that are drawn.
    pub points: usize,
}

impl Default for NonNormalRequest {
    fn default() -> Self {
        Self {
            inner_product: InnerProduct::default(),
            points: 80,
        }
    }
}

/// The departure of M⁻¹𝒜 from normality in an inner product: of `T = Lᵀ M⁻¹𝒜 L⁻ᵀ`, `G = L Lᵀ`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NonNormal {
    /// G.
    pub inner_product: &'static str,
    /// `√(‖T‖_F² − Σ|λ|²)/‖T‖_F`: 0 for a normal T (Henrici).
    pub departure: f64,
    /// W(T).
    pub field_of_values: FieldOfValues,
    /// Where they are asked for.
    pub pseudospectra: Option<Pseudospectra>,
    /// GMRES and its bounds.
    pub gmres: GmresBounds,
}

impl NonNormal {
    /// Of M⁻¹𝒜 as an operator; GMRES starts from `M⁻¹b`, or from a fixed vector where b vanishes.
    ///
    /// # Cost
    /// n products with M⁻¹𝒜, some 50 n³ flops, and 32 n² per point of the grid, a little more per point of the curves.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] above [`LARGEST`] unknowns, for an inner product that is none, and for NaN.
    pub(super) fn new(
        operator: &dyn LinearOperator<f64>,
        m: &dyn Preconditioner<f64>,
        blocks: &SaddleBlocks,
        eigenvalues: &Eigenvalues,
        request: &NonNormalRequest,
    ) -> Result<Self, SetupError> {
        let n = blocks.size();
        if n > LARGEST {
            return Err(SetupError::NotApplicable {
                method: "pseudospectra",
                reason: format!("{n} unknowns are more than {LARGEST}; take a coarser mesh"),
            });
        }
        let l = request.inner_product.factor(blocks)?;
        let product = Dense::of_operator(operator);
        let product = Mat::from_fn(n, n, |i, j| product.entry(i, j));
        let t = match &l {
            Some(l) => {
                let mut right = product.transpose().to_owned();
                dense::solve_lower(l.as_ref(), &mut right);
                dense::multiply(l.transpose(), right.transpose())
            }
            None => product,
        };
        let mut b = blocks.rhs();
        if b.iter().all(|v| *v == 0.0) {
            b = probe(n, 5);
        }
        let (mut r_0, mut work) = (vec![0.0; n], vec![0.0; m.work_len()]);
        m.solve(&b, &mut r_0, &mut work);
        if let Some(l) = &l {
            let column = Mat::from_fn(n, 1, |i, _| r_0[i]);
            let scaled = dense::multiply(l.transpose(), column.as_ref());
            r_0 = (0..n).map(|i| scaled[(i, 0)]).collect();
        }
        Self::of_matrix(&t, &r_0, eigenvalues, request)
    }

    /// The same of a dense T.
    fn of_matrix(
        t: &Mat<f64>,
        r_0: &[f64],
        eigenvalues: &Eigenvalues,
        request: &NonNormalRequest,
    ) -> Result<Self, SetupError> {
        let inner_product = request.inner_product.formula();
        let squares = t.norm_l2().powi(2);
        let small = compress::compressed(t, r_0);
        let (t, r_0) = small.as_ref().map_or((t, r_0), |(t, r_0)| (t, &r_0[..]));
        let field = field_of_values::of_matrix(t.as_ref(), inner_product)?;
        let resolvent = Resolvent::new(t)?;
        let pseudospectra = (request.points > 1)
            .then(|| Pseudospectra::new(&resolvent, eigenvalues, &field, request.points))
            .transpose()?;
        let of_values: f64 = eigenvalues.iter().map(|(re, im)| re * re + im * im).sum();
        let n = t.nrows();
        let dense = Dense::from_fn(Shape::square(n), |i, j| t[(i, j)]);
        Ok(Self {
            inner_product,
            departure: ((squares - of_values).max(0.0) / squares).sqrt(),
            gmres: GmresBounds::new(&dense, &resolvent, eigenvalues, &field, r_0)?,
            field_of_values: field,
            pseudospectra,
        })
    }
}
