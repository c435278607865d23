//! The contact rows of a run in their states.

use super::face_rules::FaceRule;
use super::state_c::Coupled;
use fracas_operators::small::times;
use fracas_operators::{Preconditioner, Properties};
use fracas_solvers::saddle::ContactRows;

/// The rows of faces that stick, slip or are open: C⁻¹ of the directions that a face keeps, a law for each of the others.
/// ```text
/// t_l = −Λ⁻¹ x_l        y_l = t_l − (L_ln/Λ) y_n
/// ```
pub(super) struct StateRows {
    rules: Vec<FaceRule>,
    /// C⁻¹ of the kept directions, where C couples faces.
    coupled: Option<Coupled>,
}

impl StateRows {
    pub(super) fn new(rules: Vec<FaceRule>, coupled: Option<Coupled>) -> Self {
        Self { rules, coupled }
    }

    /// Every face with its x and its y.
    fn faces<'v>(
        &'v self,
        x: &'v [f64],
        y: &'v mut [f64],
    ) -> impl Iterator<Item = (&'v FaceRule, &'v [f64; 3], &'v mut [f64; 3])> {
        let rows = x.as_chunks().0.iter().zip(y.as_chunks_mut().0);
        self.rules
            .iter()
            .zip(rows)
            .map(|(rule, (x, y))| (rule, x, y))
    }
}

impl Preconditioner<f64> for StateRows {
    fn size(&self) -> usize {
        3 * self.rules.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        if let Some(coupled) = &self.coupled {
            return coupled.solve(r, z, work);
        }
        for (rule, r, z) in self.faces(r, z) {
            *z = times(&rule.g, r);
        }
    }

    fn work_len(&self) -> usize {
        self.coupled.as_ref().map_or(0, Coupled::work_len)
    }

    fn flops(&self) -> u64 {
        let by_faces = 15 * self.rules.len() as u64;
        self.coupled.as_ref().map_or(by_faces, Coupled::flops)
    }

    fn properties(&self) -> Properties {
        (self.coupled.as_ref()).map_or(Properties::LINEAR, Coupled::properties)
    }
}

impl ContactRows for StateRows {
    fn keep(&self, x_t: &[f64], w_t: &mut [f64]) {
        for (rule, x, w) in self.faces(x_t, w_t) {
            *w = times(&rule.kept, x);
        }
    }

    fn add_laws(&self, x_t: &[f64], y_t: &mut [f64]) {
        for (rule, x, y) in self.faces(x_t, y_t) {
            let l = times(&rule.law, x);
            (0..3).for_each(|i| y[i] += l[i]);
        }
    }

    fn solve_laws(&self, x_t: &[f64], y_t: &mut [f64]) {
        for (rule, x, y) in self.faces(x_t, y_t) {
            let (l, m) = (times(&rule.law, x), times(&rule.friction, y));
            (0..3).for_each(|i| y[i] = y[i] - l[i] - m[i]);
        }
    }

    fn law_flops(&self) -> u64 {
        69 * self.rules.len() as u64
    }
}
