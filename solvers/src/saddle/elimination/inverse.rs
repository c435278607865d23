//! The preconditioner of the whole system from one of the system without the eliminated rows.

use super::Elimination;
use crate::saddle::{T, U};
use fracas_operators::{Layout, LinearOperator, Preconditioner, Properties};

/// `M⁻¹` of the whole system from one of the system without the rows l:
/// ```text
/// w_u = x_u + B1_l H_ll⁻¹ x_l      w_k = x_k      (y_u, y_k) = M'⁻¹ w      y_l = H_ll⁻¹ (B2_l y_u − H_lk y_k − x_l)
/// ```
/// so that row l of 𝒜 M⁻¹ is row l of the identity. With RACP as published and exact S_u, `M⁻¹𝒜` has the eigenvalue 1 for every u and every l,
/// and otherwise those of `(S' + C)⁻¹ (S_12 + H)`, `S' = B_kᵀ A'⁻¹ B_k`, `S_12 = B2_k A'⁻¹ B1'`.
pub struct EliminatedInverse<M> {
    elimination: Elimination,
    inner: M,
    layout: Layout,
}

impl<M: Preconditioner<f64>> EliminatedInverse<M> {
    /// Around an M'⁻¹ for [`Elimination::kept`].
    pub fn new(elimination: Elimination, inner: M) -> Self {
        let layout = Layout::new([(U, elimination.kept.n_u()), (T, elimination.kept.n_t())]);
        assert_eq!(inner.size(), layout.len(), "size of M' and unknowns");
        Self {
            elimination,
            inner,
            layout,
        }
    }
}

impl<M: Preconditioner<f64>> Preconditioner<f64> for EliminatedInverse<M> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let Elimination {
            local,
            diagonal,
            b1_l,
            b2_l,
            h_lk,
            ..
        } = &self.elimination;
        let (w, work) = work.split_at_mut(x.len());
        let (w_l, work) = work.split_at_mut(local.len());
        let [x_t] = self.layout.split([T], x);
        w.copy_from_slice(x);
        let [w_u, w_t] = self.layout.split_mut([U, T], w);
        // w_u = x_u + B1_l H_ll⁻¹ x_l, w_l = 0
        for ((w_l, h_ll), &l) in w_l.iter_mut().zip(diagonal).zip(local) {
            *w_l = x_t[l] / h_ll;
            w_t[l] = 0.0;
        }
        b1_l.apply_add(1.0, w_l, w_u, &mut []);
        // (y_u, y_k) = M'⁻¹ (w_u, x_k)
        self.inner.solve(w, y, work);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        // y_l = H_ll⁻¹ (B2_l y_u − H_lk y_k − x_l)
        w_l.iter_mut().zip(local).for_each(|(w, &l)| *w = -x_t[l]);
        b2_l.apply_add(1.0, y_u, w_l, &mut []);
        h_lk.apply_add(-1.0, y_t, w_l, &mut []);
        for ((w_l, h_ll), &l) in w_l.iter().zip(diagonal).zip(local) {
            y_t[l] = w_l / h_ll;
        }
    }

    fn work_len(&self) -> usize {
        self.size() + self.elimination.local.len() + self.inner.work_len()
    }

    fn flops(&self) -> u64 {
        let Elimination {
            local,
            b1_l,
            b2_l,
            h_lk,
            ..
        } = &self.elimination;
        self.inner.flops() + b1_l.flops() + b2_l.flops() + h_lk.flops() + 2 * local.len() as u64
    }

    fn properties(&self) -> Properties {
        self.inner.properties()
    }
}
