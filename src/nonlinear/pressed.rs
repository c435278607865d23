//! Rows of p multiplied by S_p⁻¹: residuals of volume as the pressures that they stand for.

use super::jacobian::{ContactJacobian, Tractions};
use crate::contact::ContactState;
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{Layout, LinearOperator, Preconditioner, Properties, Shape};
use fracas_solvers::SetupError;
use fracas_solvers::saddle::{FlowBlocks, P, PressureFactors, PressureSystem, T, U};

/// Share of the diagonal of T below which the sum of a row is rounding. Unit: 1.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// S_p⁻¹ that outlives the system it was made for.
#[derive(Default)]
pub(super) struct PressureSolver {
    factors: PressureFactors,
    known: Option<Known>,
}

/// Factors of a matrix.
struct Known {
    matrix: SparseMatrix<f64>,
    inverse: Box<dyn Preconditioner<f64>>,
    /// Force of a pressure on a face, the largest.
    force: f64,
}

impl PressureSolver {
    /// Factors of S_p, those at hand where it is the same to the last bit.
    ///
    /// # Errors
    /// Of a singular S_p.
    pub(super) fn prepare(
        &mut self,
        system: &PressureSystem,
        flow: &FlowBlocks,
    ) -> Result<(), SetupError> {
        let force = flow.q1.data().iter().fold(0.0, |m: f64, q| m.max(q.abs()));
        // where no pressure moves anything, any number serves
        let force = if force > 0.0 { force } else { 1.0 };
        match &mut self.known {
            Some(known) if known.matrix == *system.matrix() => known.force = force,
            _ => {
                self.known = Some(Known {
                    inverse: self.factors.factor(system)?,
                    matrix: system.matrix().clone(),
                    force,
                });
            }
        }
        Ok(())
    }

    /// A residual with its part of p as forces of pressures; `None` where S_p is not known.
    pub(super) fn scaled(&self, layout: &Layout, residual: &[f64]) -> Option<Vec<f64>> {
        let known = self.known.as_ref()?;
        let mut scaled = residual.to_vec();
        known.scale(layout, &mut scaled);
        Some(scaled)
    }
}

impl Known {
    fn scale(&self, layout: &Layout, r: &mut [f64]) {
        let [r_p] = layout.split_mut([P], r);
        let mut work = vec![0.0; self.inverse.work_len()];
        let mut p = vec![0.0; r_p.len()];
        self.inverse.solve(r_p, &mut p, &mut work);
        (r_p.iter_mut().zip(&p)).for_each(|(r, p)| *r = self.force * p);
    }
}

/// `b S_p⁻¹ [Q2 T]`, b the largest entry of Q1: the rows of p, in which an error of a pressure counts as its force.
///
/// A residual of volumes says little: that of a conductive fracture is made of fluxes far larger than the volumes that it holds, and the
/// mean pressure, which these alone determine, would be lost among them. `S_p⁻¹` weighs each by what it does.
///
/// T acts by differences of pressures, `Σ_j T_ij (p_j − p_i)` and the sum of its row where it is more than rounding: what leaves one face
/// comes to another to the last bit.
pub(super) struct Pressed<'a> {
    known: &'a Known,
    q2: Csr<f64>,
    t: &'a SparseMatrix<f64>,
    sums: Vec<f64>,
}

impl<'a> Pressed<'a> {
    /// For these blocks; `solver` is prepared.
    pub(super) fn new(solver: &'a PressureSolver, flow: &'a FlowBlocks) -> Self {
        let Some(known) = &solver.known else {
            unreachable!("prepared before")
        };
        let sums = flow.t.outer_iterator().map(|row| {
            let (mut sum, mut size) = (0.0, 0.0);
            for value in row.data() {
                sum += value;
                size += f64::abs(*value);
            }
            if f64::abs(sum) <= ROUNDING * size {
                0.0
            } else {
                sum
            }
        });
        Self {
            known,
            q2: Csr::new(flow.q2.clone()),
            t: &flow.t,
            sums: sums.collect(),
        }
    }

    /// The rows of p of a residual.
    pub(super) fn scale(&self, layout: &Layout, r: &mut [f64]) {
        self.known.scale(layout, r);
    }

    /// `b S_p⁻¹ Q2`.
    pub(super) fn q2(&self) -> PressedVolumes<'_> {
        PressedVolumes(self)
    }

    /// `b S_p⁻¹ S_p`, inverted.
    pub(super) fn unit(&self) -> Forces {
        Forces {
            n: self.sums.len(),
            force: self.known.force,
        }
    }

    /// `y ← y + α b S_p⁻¹ w`, w in the first part of `work`.
    fn add(&self, alpha: f64, y: &mut [f64], work: &mut [f64]) {
        let (w, work) = work.split_at_mut(y.len());
        let (p, work) = work.split_at_mut(y.len());
        self.known.inverse.solve(w, p, work);
        let scale = alpha * self.known.force;
        y.iter_mut().zip(p).for_each(|(y, p)| *y += scale * *p);
    }

    fn work_len(&self) -> usize {
        2 * self.sums.len() + self.known.inverse.work_len()
    }

    fn flops(&self) -> u64 {
        self.known.inverse.flops() + 2 * self.sums.len() as u64
    }
}

/// `b S_p⁻¹ Q2`.
pub(super) struct PressedVolumes<'a>(&'a Pressed<'a>);

impl LinearOperator<f64> for PressedVolumes<'_> {
    fn shape(&self) -> Shape {
        self.0.q2.shape()
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let w = &mut work[..y.len()];
        w.fill(0.0);
        self.0.q2.apply_add(1.0, x, w, &mut []);
        self.0.add(alpha, y, work);
    }

    fn work_len(&self) -> usize {
        self.0.work_len()
    }

    fn flops(&self) -> u64 {
        self.0.q2.flops() + self.0.flops()
    }
}

/// `y = x/b`.
pub(super) struct Forces {
    n: usize,
    force: f64,
}

impl Preconditioner<f64> for Forces {
    fn size(&self) -> usize {
        self.n
    }

    fn solve(&self, x: &[f64], y: &mut [f64], _: &mut [f64]) {
        y.iter_mut().zip(x).for_each(|(y, x)| *y = x / self.force);
    }

    fn flops(&self) -> u64 {
        self.n as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

/// `[J Q1; b S_p⁻¹Q2 b S_p⁻¹T]` around the J of rock and contact, of which nothing is assembled, with what pressures do to the rows of t.
///
/// The traction of a closed face counts as that of the rock, `t̃_N = t_N − p`, which alone pushes on it and which H acts on; its law takes
/// t_N. In an open face t_N is given by its law, and p pushes:
/// ```text
/// y_u = A x_u + B t̃ − B E_o p          y_t = D (Bᵀ x_u − H (t̃ − E_o p)) − L (t̃ + E_c p)
/// ```
/// E_o and E_c place pressures in the normal rows of open and of closed faces. Where no face slips and H acts on closed faces alone the rows
/// of t have no pressures.
pub(super) struct CoupledJacobian<'a> {
    rock: &'a ContactJacobian<'a>,
    q1: &'a Csr<f64>,
    pressed: &'a Pressed<'a>,
    open: Vec<bool>,
    layout: Layout,
}

impl<'a> CoupledJacobian<'a> {
    /// In these states; `q1` is that of open faces, its other columns empty.
    pub(super) fn new(
        rock: &'a ContactJacobian<'a>,
        (q1, pressed): (&'a Csr<f64>, &'a Pressed<'a>),
        states: &[ContactState],
        layout: Layout,
    ) -> Self {
        Self {
            rock,
            q1,
            pressed,
            open: states.iter().map(|s| *s == ContactState::Open).collect(),
            layout,
        }
    }
}

/// Increments of t_N from those of t̃_N: `δt_N = δt̃_N + δp` on closed faces, tractions and pressures in one unit.
pub(super) fn of_contact(layout: &Layout, states: &[ContactState], x: &mut [f64]) {
    let [x_t, x_p] = layout.split_mut([T, P], x);
    for ((t, p), state) in x_t.chunks_exact_mut(3).zip(x_p).zip(states) {
        if *state != ContactState::Open {
            t[0] += *p;
        }
    }
}

impl LinearOperator<f64> for CoupledJacobian<'_> {
    fn shape(&self) -> Shape {
        Shape::square(self.layout.len())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let flow = self.layout.range(P).start;
        let [x_u, x_t, x_p] = self.layout.split([U, T, P], x);
        let (y_ut, y_p) = y.split_at_mut(flow);
        {
            let (acting, work) = work.split_at_mut(x_t.len());
            let (in_law, work) = work.split_at_mut(x_t.len());
            acting.copy_from_slice(x_t);
            in_law.copy_from_slice(x_t);
            for (f, (p, open)) in x_p.iter().zip(&self.open).enumerate() {
                match open {
                    true => acting[3 * f] -= p,
                    false => in_law[3 * f] += p,
                }
            }
            let t = Tractions {
                pushing: x_t,
                acting,
                in_law,
            };
            self.rock.add_parts(alpha, x_u, &t, y_ut, work);
        }
        self.q1.apply_add(alpha, x_p, &mut y_ut[..x_u.len()], work);
        // Q2 x_u + T x_p
        let w = &mut work[..x_p.len()];
        let rows = self.pressed.t.outer_iterator().zip(&self.pressed.sums);
        for (i, (w, (row, sum))) in w.iter_mut().zip(rows).enumerate() {
            let flux = |(j, t): (usize, &f64)| t * (x_p[j] - x_p[i]);
            *w = sum * x_p[i] + row.iter().map(flux).sum::<f64>();
        }
        self.pressed.q2.apply_add(1.0, x_u, w, &mut []);
        self.pressed.add(alpha, y_p, work);
    }

    fn work_len(&self) -> usize {
        let tractions = 2 * self.layout.length(T);
        (tractions + self.rock.work_len()).max(self.pressed.work_len())
    }

    fn flops(&self) -> u64 {
        let flow = self.q1.flops() + self.pressed.q2.flops() + 3 * self.pressed.t.nnz() as u64;
        self.rock.flops() + flow + self.pressed.flops() + self.open.len() as u64
    }
}
