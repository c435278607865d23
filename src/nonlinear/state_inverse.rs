//! RACP of a body whose faces stick, slip or are open.

use super::face_rules::FaceRule;
use super::state_c::Coupled;
use crate::contact::Coupling;
use fracas_operators::small::times;
use fracas_operators::sparse::Csr;
use fracas_operators::{AdjointOperator, Layout, LinearOperator, Preconditioner, Properties};
use fracas_solvers::saddle::Relaxation;

/// RACP around the kept directions of every face, the others solved for their own tractions:
/// ```text
/// t_l = −Λ⁻¹ x_l        y_u = S̃_u⁻¹ (x_u − B t_l + B C⁻¹ x_k)        y_k = C⁻¹ (Bᵀ y_u − x_k)        y_l = t_l − (L_ln/Λ) y_n
/// ```
/// with `S_u = A + B_k C⁻¹ B_kᵀ`, x_k and y_k relaxed for H ([`Relaxation`]). With every face in stick this is
/// [`RacpInverse`](fracas_solvers::saddle::RacpInverse).
///
/// # Cost
/// As RACP: one solve with S̃_u, two products with B, and the relaxation of H.
pub(super) struct StateInverse<'a> {
    b: &'a Coupling<f64>,
    rules: Vec<FaceRule>,
    /// C⁻¹ of the kept directions, where C couples faces.
    coupled: Option<Coupled>,
    s_u: &'a dyn Preconditioner<f64>,
    relaxation: Option<Relaxation<&'a Csr<f64>>>,
    layout: Layout<2>,
}

impl<'a> StateInverse<'a> {
    /// `h` is that of the present states.
    pub(super) fn new(
        b: &'a Coupling<f64>,
        (h, gamma): (Option<&'a Csr<f64>>, f64),
        (rules, coupled): (Vec<FaceRule>, Option<Coupled>),
        s_u: &'a dyn Preconditioner<f64>,
    ) -> Self {
        let shape = b.shape();
        assert_eq!(shape.rows, s_u.size(), "rows of B and size of S_u");
        assert_eq!(shape.cols, 3 * rules.len(), "columns of B and faces");
        let layout = Layout::new(["u", "t"], [shape.rows, shape.cols]);
        let mut inverse = Self {
            b,
            rules,
            coupled,
            s_u,
            relaxation: None,
            layout,
        };
        let mut work = vec![0.0; inverse.coupled.as_ref().map_or(0, Coupled::work_len)];
        let c_inverse = |r: &[f64], z: &mut [f64]| inverse.kept_solve(r, z, &mut work);
        inverse.relaxation = h.and_then(|h| Relaxation::new(h, gamma, c_inverse));
        inverse
    }

    /// `z ← C⁻¹ r` in the kept directions, 0 in the others.
    fn kept_solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        if let Some(coupled) = &self.coupled {
            return coupled.solve(r, z, work);
        }
        let rows = r.chunks_exact(3).zip(z.chunks_exact_mut(3));
        for (rule, (r, z)) in self.rules.iter().zip(rows) {
            z.copy_from_slice(&times(&rule.g, &three(r)));
        }
    }
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
        let (x_k, work) = work.split_at_mut(x_t.len());
        let (y_k, work) = work.split_at_mut(x_t.len());
        // x_k = Wᵀ x_k, y_k = C⁻¹ x_k
        for (f, rule) in self.rules.iter().enumerate() {
            x_k[3 * f..][..3].copy_from_slice(&times(&rule.kept, &three(&x_t[3 * f..])));
        }
        if let Some(w) = &self.relaxation {
            w.apply_transpose(|r, z, work| self.kept_solve(r, z, work), x_k, work);
        }
        self.kept_solve(x_k, y_k, work);
        // y_t = y_k + Λ⁻¹ x_l
        for (f, rule) in self.rules.iter().enumerate() {
            let l = times(&rule.law, &three(&x_t[3 * f..]));
            (0..3).for_each(|i| y_t[3 * f + i] = y_k[3 * f + i] + l[i]);
        }
        // y_u = S̃_u⁻¹ (x_u + B y_t)
        w_u.copy_from_slice(x_u);
        self.b.apply_add(1.0, y_t, w_u, work);
        self.s_u.solve(w_u, y_u, work);
        // y_k = W C⁻¹ (Bᵀ y_u − x_k) = C⁻¹ Wᵀ (Bᵀ y_u − x_k)
        x_k.iter_mut().for_each(|x| *x = -*x);
        self.b.apply_adjoint_add(1.0, y_u, x_k, work);
        if let Some(w) = &self.relaxation {
            w.apply_transpose(|r, z, work| self.kept_solve(r, z, work), x_k, work);
        }
        self.kept_solve(x_k, y_k, work);
        // y_l = −Λ⁻¹ x_l − (L_ln/Λ) y_n
        for (f, rule) in self.rules.iter().enumerate() {
            let k = three(&y_k[3 * f..]);
            let (l, m) = (
                times(&rule.law, &three(&x_t[3 * f..])),
                times(&rule.friction, &k),
            );
            (0..3).for_each(|i| y_t[3 * f + i] = k[i] - l[i] - m[i]);
        }
    }

    fn work_len(&self) -> usize {
        let c = self.coupled.as_ref().map_or(0, Coupled::work_len);
        let inside = self.s_u.work_len().max(self.b.work_len()).max(c);
        let relaxation = (self.relaxation.as_ref()).map_or(0, |w| w.work_len(c));
        self.layout.len() + 3 * self.rules.len() + inside.max(relaxation)
    }

    fn flops(&self) -> u64 {
        let by_faces = 15 * self.rules.len() as u64;
        let c_inverse = self.coupled.as_ref().map_or(by_faces, Coupled::flops);
        let relaxation = (self.relaxation.as_ref()).map_or(0, |w| 2 * w.flops(c_inverse));
        self.s_u.flops()
            + 2 * LinearOperator::flops(self.b)
            + 108 * self.rules.len() as u64
            + relaxation
    }

    fn properties(&self) -> Properties {
        self.s_u.properties()
    }
}
