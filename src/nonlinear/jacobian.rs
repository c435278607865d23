//! The Jacobian of a contact state as an operator: nothing is assembled but H.

use crate::contact::{Coupling, FaceRows};
use crate::elasticity::Restricted;
use crate::jacobian::{turned, with_laws};
use fracas_operators::operator::assert_product;
use fracas_operators::small::{Matrix3, times};
use fracas_operators::sparse::Csr;
use fracas_operators::{AdjointOperator, Layout, LinearOperator, Shape};
use fracas_solvers::saddle::{SaddleBlocks, T, U};

/// 3×3 factors of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceTangent {
    /// D = ∂r/∂g.
    pub(super) by_jump: Matrix3<f64>,
    /// L = −s² A_f ∂r/∂t.
    pub(super) law: Matrix3<f64>,
}

impl FaceTangent {
    /// D = I, L = 0.
    pub(super) const STICK: Self = Self {
        by_jump: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        law: [[0.0; 3]; 3],
    };

    /// D = 0, no jump in any row.
    pub(super) fn is_open(&self) -> bool {
        self.by_jump == [[0.0; 3]; 3]
    }
}

/// `[A B; D Bᵀ −(D H + L)]`, D and L one 3×3 block per face, tractions in a balanced unit s; with every face in stick
/// D = I, L = 0 and neither is stored.
pub struct ContactJacobian<'a> {
    pub(super) a: &'a Restricted<Box<dyn AdjointOperator<f64>>>,
    pub(super) b: &'a Coupling<f64>,
    pub(super) h: Option<&'a Csr<f64>>,
    pub(super) faces: Option<Vec<FaceTangent>>,
    pub(super) layout: Layout,
}

/// What stands for the tractions of a product, each in its place.
pub(super) struct Tractions<'x> {
    /// What pushes on the rock: x_t of B.
    pub(super) pushing: &'x [f64],
    /// What H acts on.
    pub(super) acting: &'x [f64],
    /// What the laws of the faces take: x_t of L.
    pub(super) in_law: &'x [f64],
}

impl ContactJacobian<'_> {
    /// True where every face is in stick or open: J is symmetric on the x that meet the laws `−λ t = b_l` of open faces.
    pub fn is_symmetric(&self) -> bool {
        let faces = self.faces.iter().flatten();
        faces
            .into_iter()
            .all(|face| *face == FaceTangent::STICK || face.is_open())
    }

    /// Its blocks, made of those with every face in stick, tractions in the same unit.
    pub(super) fn blocks(&self, stick: SaddleBlocks) -> SaddleBlocks {
        let Some(faces) = &self.faces else {
            return SaddleBlocks {
                h: self.h.map(|h| h.matrix().clone()),
                ..stick
            };
        };
        let rows = faces.iter().map(|face| FaceRows {
            residual: [0.0; 3],
            by_jump: face.by_jump,
            by_traction: face.law.map(|row| row.map(|v| -v)),
        });
        let rows: Vec<FaceRows> = rows.collect();
        // D H: H is symmetric
        let form = self.h.map(|h| turned(h.matrix(), &rows));
        SaddleBlocks {
            b2: Some(turned(&stick.b1, &rows)),
            h: with_laws(form, &rows, |_| 1.0),
            ..stick
        }
    }

    /// `y_u ← y_u + α (A x_u + B t_B)`, `y_t ← y_t + α (D (Bᵀ x_u − H t_H) − L t_L)`.
    pub(super) fn add_parts(
        &self,
        alpha: f64,
        x_u: &[f64],
        t: &Tractions<'_>,
        y: &mut [f64],
        work: &mut [f64],
    ) {
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        self.a.apply_add(alpha, x_u, y_u, work);
        self.b.apply_add(alpha, t.pushing, y_u, work);
        match &self.faces {
            None => {
                self.b.apply_adjoint_add(alpha, x_u, y_t, work);
                if let Some(h) = self.h {
                    h.apply_add(-alpha, t.acting, y_t, work);
                }
            }
            Some(faces) => {
                let (jump, work) = work.split_at_mut(y_t.len());
                jump.fill(0.0);
                self.b.apply_adjoint_add(1.0, x_u, jump, work);
                if let Some(h) = self.h {
                    h.apply_add(-1.0, t.acting, jump, work);
                }
                let (jump, x_t) = (jump.as_chunks().0, t.in_law.as_chunks().0);
                let y_t = y_t.as_chunks_mut::<3>().0.iter_mut();
                for (((face, jump), x), y) in faces.iter().zip(jump).zip(x_t).zip(y_t) {
                    let (d, l) = (times(&face.by_jump, jump), times(&face.law, x));
                    (0..3).for_each(|k| y[k] += alpha * (d[k] - l[k]));
                }
            }
        }
    }
}

impl LinearOperator<f64> for ContactJacobian<'_> {
    fn shape(&self) -> Shape {
        Shape::square(self.layout.len())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let [x_u, x_t] = self.layout.split([U, T], x);
        let t = Tractions {
            pushing: x_t,
            acting: x_t,
            in_law: x_t,
        };
        self.add_parts(alpha, x_u, &t, y, work);
    }

    fn work_len(&self) -> usize {
        let jump = self.faces.as_ref().map_or(0, |faces| 3 * faces.len());
        jump + self.a.work_len()
    }

    fn flops(&self) -> u64 {
        let faces = self
            .faces
            .as_ref()
            .map_or(0, |faces| 36 * faces.len() as u64);
        let h = self.h.map_or(0, LinearOperator::flops);
        let b = 2 * LinearOperator::<f64>::flops(self.b);
        LinearOperator::<f64>::flops(self.a) + b + faces + h
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::contact::ContactState;
    use crate::nonlinear::ContactProblem;
    use crate::scene::sample::Sample;
    use fracas_operators::LinearOperator;
    use fracas_operators::random::Random;
    use fracas_operators::sparse::Csr;

    #[test]
    fn blocks_are_those_of_the_operator() {
        let random = &mut Random::new(8);
        let body = Sample::crossing([8, 4, 8], [0.0; 2], 4.0).body();
        let problem = ContactProblem::new(&body).unwrap();
        let (faces, unit) = (problem.faces().len(), problem.saddle().unit());
        let start = problem.at_rest();
        let load = problem.loads().at(0.0, 1.0);
        for case in 0..4 {
            let states: Vec<ContactState> = (0..faces)
                .map(|_| match random.whole(0, if case == 0 { 0 } else { 2 }) {
                    0 => ContactState::Stick,
                    1 => ContactState::Slip,
                    _ => ContactState::Open,
                })
                .collect();
            let mut drawn = |n: usize, size: f64| -> Vec<f64> {
                (0..n).map(|_| random.between(-size, size)).collect()
            };
            let u = drawn(body.constraints.free_len(), 1e-3);
            let t = drawn(3 * faces, 1e7);
            let h = problem.stabilization(&states);
            let at = problem.evaluate(&states, h.as_ref(), [&u, &t], &start, &load);
            let jacobian = problem.jacobian(&states, h.as_ref(), &at, false);
            let stick = problem.stick_blocks().unwrap().into_traction_unit(unit);
            let assembled = Csr::new(jacobian.blocks(stick).assembled());
            let x = drawn(problem.saddle().layout().len(), 1.0);
            let product = |operator: &dyn LinearOperator<f64>| {
                let mut y = vec![0.0; x.len()];
                operator.apply_add(1.0, &x, &mut y, &mut vec![0.0; operator.work_len()]);
                y
            };
            let (by_blocks, by_operator) = (product(&assembled), product(&jacobian));
            let size = by_operator.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            for (a, b) in by_blocks.iter().zip(&by_operator) {
                assert!((a - b).abs() <= 1e-12 * size, "case {case}: {a} {b}");
            }
        }
    }
}
