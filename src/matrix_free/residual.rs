//! Scales of residuals that an assembled matrix would give.

use super::MatrixFreeSaddle;
use fracas_operators::LinearOperator;
use fracas_solvers::saddle::{T, U};

impl MatrixFreeSaddle<f64> {
    /// `|B|ᵀ|u| + |b_t|` for right-hand side `b` and solution `x`.
    pub fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        let ([u], [b_t]) = (self.layout.split([U], x), self.layout.split([T], b));
        let mut scale: Vec<f64> = b_t.iter().map(|b| b.abs()).collect();
        self.coupling().add_absolute_jumps(u, &mut scale);
        scale
    }

    /// A lower bound of `‖𝒜‖_∞`: the largest row sum of |entries| over all contact rows and the row `stiffest` of A.
    ///
    /// # Cost
    /// One product and three vectors.
    pub fn norm_inf_from_below(&self, stiffest: usize) -> f64 {
        let n = self.layout.len();
        let (mut x, mut y) = (vec![0.0; n], vec![0.0; n]);
        if self.layout.length(U) > 0 {
            x[stiffest] = 1.0;
            // a column is a row: 𝒜 is symmetric
            self.apply_add(1.0, &x, &mut y, &mut vec![0.0; self.work_len()]);
        }
        let stiffest = y.iter().map(|v| v.abs()).sum();
        let ([u], [contact]) = (
            self.layout.split_mut([U], &mut x),
            self.layout.split_mut([T], &mut y),
        );
        u.fill(1.0);
        contact.fill(0.0);
        self.coupling().add_absolute_jumps(u, contact);
        for (row, sum) in self
            .stabilization()
            .iter()
            .flat_map(|h| h.matrix().outer_iterator())
            .zip(&mut *contact)
        {
            *sum += row.data().iter().map(|v| v.abs()).sum::<f64>();
        }
        contact.iter().fold(stiffest, |m: f64, sum| m.max(*sum))
    }
}
