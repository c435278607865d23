//! The preconditioner of flow and mechanics together, around one of mechanics.

mod fixed_stress;
mod form;
mod half_order;
mod near;
mod poles;
mod pressure;
mod reuse;
mod surface;

pub use form::{Form, UnknownForm};
pub use near::NearSchur;
pub use pressure::{PressureSchur, PressureSystem, UnknownPressureSchur};
pub use reuse::PressureFactors;
pub use surface::Surface;

use super::P;
use fracas_operators::{Field, Layout, LinearOperator, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Displacements and tractions together.
const UT: Field = Field {
    letter: "ut",
    name: "displacements and tractions",
};

/// `M⁻¹` of `[A B1 Q1; B2 −H 0; Q2 0 T]` around an `M_ut⁻¹` of `[A B1; B2 −H]`, in the order t, u, p:
/// ```text
/// M⁻¹ = [I −M_ut⁻¹Q1; 0 I] · diag(M_ut⁻¹, S_p⁻¹) · [I 0; −Q2 M_ut⁻¹ I]
/// w_p = x_p − Q2 (M_ut⁻¹ x_ut)_u      y_p = S_p⁻¹ w_p      y_ut = M_ut⁻¹ (x_ut − Q1 y_p)
/// ```
/// `S_p ≈ T − Q2 S_u⁻¹ Q1`, as `S̃_u⁻¹` is the block (u, u) of RACP's `M_ut⁻¹`, relaxed or with eliminated rows or not. With
/// `Q1 = −B_n` (pressure opens) it is `T + Q2 S_u⁻¹ B_n`, and where `Q2 = B_nᵀ/Δt` the second term is the volume that an open fracture
/// takes up under pressure: symmetric positive semi-definite.
///
/// An M_ut⁻¹ and an S_p⁻¹ of any make will do; [`PressureSchur`] makes S_p.
///
/// # Spectrum
/// *Exact S_u, S_p = T − Q2 S_u⁻¹ Q1 and C = H*: M = 𝒜, every eigenvalue is 1.
///
/// *Exact S_u, any C and M of `S_p = T + M`*, for B2 = B1ᵀ and `Q2 = −Q1ᵀ/Δt`, A, C, T and T + M positive definite, H positive
/// semi-definite. With `S = −Q2 S_u⁻¹ Q1`, δ_p and Δ_p the extreme eigenvalues of (T + S, T + M), γ and Γ those of (S_t + H, S_t + C),
/// `S_t = Bᵀ(A − Q1 T⁻¹ Q2)⁻¹B` (undrained), every eigenvalue of M⁻¹𝒜 is real, n_u of them are 1, and all lie in
/// ```text
/// [min(1, δ_p) min(1, γ), max(1, Δ_p) max(1, Γ)]
/// ```
/// Proof. Count p in units that make Δt = 1 and change the sign of its rows, so that `𝒜 = [A E; Eᵀ −D]`, `E = [B Q1]`, `D = diag(H, T)`,
/// and M is the same with `D' = diag(C, T + M − S)`. `X = EᵀA⁻¹E` makes M⁻¹𝒜 similar to a block triangle of 1 (n_u times) and
/// `(X + D')⁻¹(X + D)`. Eliminating t from `X + diag(C, T)` leaves T + S, as `Q1ᵀS_u⁻¹Q1 = X_pp − X_pt (X_tt + C)⁻¹ X_tp`; from X + D'
/// the same elimination leaves T + M, so that both are congruent to diag(X_tt + C, ·) by one matrix, and quotients of their forms lie in
/// [min(1, δ_p), max(1, Δ_p)]. And `xᵀ(X + D)x = xᵀ(X + diag(C, T))x + tᵀ(H − C)t`, where the form on the right is at least
/// `tᵀ(C + S_t)t`, its minimum over p; so quotients of these lie in [min(1, γ), max(1, Γ)]. Both quotients multiply. ∎
///
/// With derivatives of the conductivity in Q2 the statement fails: eigenvalues leave the real line (`three_fields/tests.rs`).
///
/// # Cost
/// Two solves with M_ut, one with S_p, a product with Q1 and one with Q2; one solve with M_ut where Q2 = 0, and in a triangular
/// [`Form`].
///
/// # Source
/// M. Ferronato, SNA'25 lecture, slides on the three-field problem.
pub struct ThreeFieldsInverse<'a> {
    ut: Box<dyn Preconditioner<f64> + 'a>,
    q1: Box<dyn LinearOperator<f64> + 'a>,
    q2: Option<Box<dyn LinearOperator<f64> + 'a>>,
    s_p: Box<dyn Preconditioner<f64> + 'a>,
    form: Form,
    layout: Layout,
    n_u: usize,
}

impl<'a> ThreeFieldsInverse<'a> {
    /// From `M_ut⁻¹`, Q1, Q2 (`None` where it is 0; [`Form::Full`] is [`Form::Upper`] then) and `S_p⁻¹`.
    pub fn new(
        ut: impl Preconditioner<f64> + 'a,
        q1: impl LinearOperator<f64> + 'a,
        q2: Option<impl LinearOperator<f64> + 'a>,
        s_p: impl Preconditioner<f64> + 'a,
        form: Form,
    ) -> Self {
        let first = q1.shape();
        assert_eq!(first.cols, s_p.size(), "columns of Q1 and size of S_p");
        if let Some(second) = q2.as_ref().map(LinearOperator::shape) {
            assert_eq!(
                (second.rows, second.cols),
                (first.cols, first.rows),
                "rows and columns of Q2"
            );
        }
        assert!(
            first.rows <= ut.size(),
            "{} rows of Q1 and {} unknowns u, t",
            first.rows,
            ut.size()
        );
        Self {
            layout: Layout::new([(UT, ut.size()), (P, s_p.size())]),
            n_u: first.rows,
            ut: Box::new(ut),
            q1: Box::new(q1),
            form: form.for_coupling(q2.is_some()),
            q2: q2.map(|q2| Box::new(q2) as _),
            s_p: Box::new(s_p),
        }
    }
}

impl Preconditioner<f64> for ThreeFieldsInverse<'_> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_ut, x_p] = self.layout.split([UT, P], x);
        let [y_ut, y_p] = self.layout.split_mut([UT, P], y);
        let (w, work) = work.split_at_mut(x.len());
        let [w_ut, w_p] = self.layout.split_mut([UT, P], w);
        w_p.copy_from_slice(x_p);
        if self.form.begins_with_mechanics() {
            // w_p = x_p − Q2 (M_ut⁻¹ x_ut)_u
            self.ut.solve(x_ut, y_ut, work);
            if let Some(q2) = &self.q2 {
                q2.apply_add(-1.0, &y_ut[..self.n_u], w_p, work);
            }
        }
        self.s_p.solve(w_p, y_p, work);
        if self.form.ends_with_mechanics() {
            // y_ut = M_ut⁻¹ (x_ut − Q1 y_p)
            w_ut.copy_from_slice(x_ut);
            self.q1.apply_add(-1.0, y_p, &mut w_ut[..self.n_u], work);
            self.ut.solve(w_ut, y_ut, work);
        }
    }

    fn work_len(&self) -> usize {
        let second = self.q2.as_ref().map_or(0, |q2| q2.work_len());
        let products = self.q1.work_len().max(second);
        let solves = self.ut.work_len().max(self.s_p.work_len());
        self.layout.len() + products.max(solves)
    }

    fn flops(&self) -> u64 {
        let first = match self.form.begins_with_mechanics() {
            true => self.ut.flops() + self.q2.as_ref().map_or(0, |q2| q2.flops()),
            false => 0,
        };
        let last = match self.form.ends_with_mechanics() {
            true => self.ut.flops() + self.q1.flops(),
            false => 0,
        };
        first + self.s_p.flops() + last
    }

    fn properties(&self) -> Properties {
        let parts = self.ut.properties().and(self.s_p.properties());
        // a factor that is missing; Q2 = 0 is missing in 𝒜, too
        let is_blind = match self.form {
            Form::Full => false,
            Form::Upper => self.q2.is_some(),
            Form::Lower => true,
        };
        match is_blind {
            true => parts.and(Properties::BLIND),
            false => parts,
        }
    }
}

/// Settings of the third field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ThreeFields {
    /// S_p.
    pub schur: PressureSchur,
    /// Which factors.
    pub form: Form,
}

impl ThreeFields {
    /// True for what is taken where nothing is said.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
