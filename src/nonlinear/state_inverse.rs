//! RACP of a body whose faces stick, slip or are open.

use super::face_rules::{FaceRule, Matrix3};
use crate::contact::Coupling;
use fracas_operators::{AdjointOperator, Layout, LinearOperator, Preconditioner};

/// RACP around the kept directions of every face, the others solved for their own tractions:
/// ```text
/// t_l = −Λ⁻¹ x_l        y_u = S̃_u⁻¹ (x_u − B t_l + B C⁻¹ x_k)        y_k = C⁻¹ (Bᵀ y_u − x_k)        y_l = t_l − (L_ln/Λ) y_n
/// ```
/// with `S_u = A + B_k C⁻¹ B_kᵀ`. With every face in stick this is [`RacpInverse`](fracas_solvers::saddle::RacpInverse).
///
/// # Cost
/// As RACP: one solve with S̃_u, two products with B.
pub(super) struct StateInverse<'a> {
    b: &'a Coupling<f64>,
    rules: Vec<FaceRule>,
    s_u: &'a dyn Preconditioner<f64>,
    layout: Layout<2>,
}

impl<'a> StateInverse<'a> {
    pub(super) fn new(
        b: &'a Coupling<f64>,
        rules: Vec<FaceRule>,
        s_u: &'a dyn Preconditioner<f64>,
    ) -> Self {
        let shape = b.shape();
        assert_eq!(shape.rows, s_u.size(), "rows of B and size of S_u");
        assert_eq!(shape.cols, 3 * rules.len(), "columns of B and faces");
        let layout = Layout::new(["u", "t"], [shape.rows, shape.cols]);
        Self {
            b,
            rules,
            s_u,
            layout,
        }
    }
}

/// `M v` for the three components of a face.
fn times(m: &Matrix3, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn three(v: &[f64]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}

impl Preconditioner<f64> for StateInverse<'_> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split(x);
        let [y_u, y_t] = self.layout.split_mut(y);
        let (w_u, work) = work.split_at_mut(x_u.len());
        let (jump, work) = work.split_at_mut(x_t.len());
        // y_t = C⁻¹ x_k + Λ⁻¹ x_l
        for (f, rule) in self.rules.iter().enumerate() {
            let x = three(&x_t[3 * f..]);
            let (k, l) = (times(&rule.g, times(&rule.kept, x)), times(&rule.law, x));
            (0..3).for_each(|i| y_t[3 * f + i] = k[i] + l[i]);
        }
        // y_u = S̃_u⁻¹ (x_u + B y_t)
        w_u.copy_from_slice(x_u);
        self.b.apply_add(1.0, y_t, w_u, work);
        self.s_u.solve(w_u, y_u, work);
        // y_k = C⁻¹ (Bᵀ y_u − x_k),  y_l = −Λ⁻¹ x_l − (L_ln/Λ) y_n
        jump.fill(0.0);
        self.b.apply_adjoint_add(1.0, y_u, jump, work);
        for (f, rule) in self.rules.iter().enumerate() {
            let x = three(&x_t[3 * f..]);
            let (j, r) = (three(&jump[3 * f..]), times(&rule.kept, x));
            let k = times(&rule.g, [j[0] - r[0], j[1] - r[1], j[2] - r[2]]);
            let (l, m) = (times(&rule.law, x), times(&rule.friction, k));
            (0..3).for_each(|i| y_t[3 * f + i] = k[i] - l[i] - m[i]);
        }
    }

    fn work_len(&self) -> usize {
        self.layout.len() + self.s_u.work_len().max(self.b.work_len())
    }

    fn flops(&self) -> u64 {
        self.s_u.flops() + 2 * LinearOperator::flops(self.b) + 108 * self.rules.len() as u64
    }

    fn is_linear(&self) -> bool {
        self.s_u.is_linear()
    }

    fn is_single(&self) -> bool {
        self.s_u.is_single()
    }
}
