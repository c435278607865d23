//! Equilibrium and contact rows of a body, in balanced units.

use super::creeping::Creeping;
use super::friction;
use super::jacobian::{ContactJacobian, FaceTangent};
use super::{Load, Loads, Start};
use crate::contact::{ContactState, FaceLaw, FaceMeasure, FacePoint, FaceRows, face_compliance};
use crate::elasticity::{Constraints, ElasticityError, strain_norm};
use crate::flow::{Balance, FlowPoint};
use crate::matrix_free::{Magnitude, MatrixFreeSaddle};
use crate::mesh::FractureFace;
use crate::scene::Body;
use crate::system::StickSystem;
use fracas_operators::sparse::Csr;
use fracas_operators::{AdjointOperator, LinearOperator};
use fracas_solvers::saddle::{EnergyNorms, SaddleBlocks, StrainNorm, T, U};

/// The equations at a point.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// `(f − A u − B t, −s (A_f r − H t*))`, with flow `(f − A u − B t − Q1 p, …, −s R)`: the right-hand side of a Newton step [N].
    pub residual: Vec<f64>,
    /// Mean jump (n, t1, t2) per face [m].
    pub jumps: Vec<f64>,
    /// The same less what H lets through, `g − H t*/A_f`: what the laws of the faces see [m].
    pub effective: Vec<f64>,
    /// The balance of fluid, where any flows.
    pub(super) flow: Option<FlowPoint>,
    /// ‖Q1 p‖₂, 0 where nothing flows [N].
    pub(super) pushed: f64,
    rows: Vec<FaceRows>,
    /// The same with derivatives that leave out weakening, or some of it, where there is any.
    lagged: Option<Vec<FaceRows>>,
}

impl Evaluation {
    /// Residual and tangent of every face; `lagged` leaves out the derivative of weakening.
    pub(super) fn rows(&self, lagged: bool) -> &[FaceRows] {
        match &self.lagged {
            Some(rows) if lagged => rows,
            _ => &self.rows,
        }
    }

    /// The derivatives that leave out weakening keep this share of it.
    pub(super) fn keep(&mut self, share: f64) {
        for (lagged, rows) in self.lagged.iter_mut().flatten().zip(&self.rows) {
            let pairs = (lagged.by_jump.iter_mut().flatten()).zip(rows.by_jump.iter().flatten());
            pairs.for_each(|(lagged, whole)| *lagged += share * (whole - *lagged));
        }
    }
}

/// A fractured body whose faces stick, slip or are open; A cell by cell, B face by face.
///
/// Rows of face f: `A_f r` of [`FaceLaw::projected_rows`] on the mean jump `(Bᵀu + prescribed part + gap − H t*)/A_f` with
/// `t* = (t_N − that of the initial stress and what the pressure of a fluid adds, t_T − t_T at the start)`. H is that of the states, or one that acts on more: then
/// faces slip along, and open by, what H does not let through. The assembled form is
/// [`ContactSystem`](crate::jacobian::ContactSystem), and a test holds them together.
pub struct ContactProblem<'a> {
    body: &'a Body,
    saddle: MatrixFreeSaddle<f64>,
    magnitude: Magnitude,
    loads: Loads<'a>,
    compliance: Vec<f64>,
    pub(super) weakens: bool,
    /// True for each fracture whose friction follows the path of its slip.
    pub(super) by_path: Vec<bool>,
    flow: Option<Box<Balance<'a>>>,
    /// Rock that creeps, where any does.
    pub(super) creep: Option<Box<Creeping<'a>>>,
}

impl<'a> ContactProblem<'a> {
    /// Everything that depends on neither states nor time.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn new(body: &'a Body) -> Result<Self, ElasticityError> {
        let system = Self::stick_system_of(body);
        let magnitude = system.magnitude()?;
        let saddle = MatrixFreeSaddle::in_traction_unit(&system, magnitude.unit)?;
        let loads = Loads::new(body, saddle.stiffness().full())?;
        let faces = &body.fractures.faces;
        let flow = |fluid| {
            let form = body.jump_stabilization();
            let rocks = &body.materials;
            Box::new(Balance::new(
                fluid,
                &body.mesh,
                &body.fractures,
                rocks,
                form,
            ))
        };
        Ok(Self {
            creep: Creeping::new(body)?.map(Box::new),
            flow: body.fluid.as_ref().map(flow),
            compliance: faces
                .iter()
                .map(|f| face_compliance(&body.mesh, &body.materials, f))
                .collect(),
            weakens: friction::weakens(body),
            by_path: friction::by_path(body),
            body,
            saddle,
            magnitude,
            loads,
        })
    }

    fn stick_system_of(body: &Body) -> StickSystem<'_> {
        body.stick_system(Some(body.jump_stabilization()))
    }

    /// The body.
    pub fn body(&self) -> &'a Body {
        self.body
    }

    /// The balance of fluid in the fractures, where the scene has any.
    pub fn balance(&self) -> Option<&Balance<'a>> {
        self.flow.as_deref()
    }

    /// Loads in time.
    pub fn loads(&self) -> &Loads<'a> {
        &self.loads
    }

    /// Displacements and tractions with every face in stick.
    pub fn saddle(&self) -> &MatrixFreeSaddle<f64> {
        &self.saddle
    }

    /// Norms of errors; displacements are judged against those that `held` prescribes, where any are.
    pub(super) fn norms<'s>(&'s self, held: Option<&'s Constraints>) -> EnergyNorms<'s> {
        let strain = |held: &'s Constraints| -> StrainNorm<'s> {
            Box::new(|u| strain_norm(self.saddle.stiffness().full(), &held.expand(u)))
        };
        (self.saddle).energy_norms(&self.magnitude, held.map(strain))
    }

    /// The assembled blocks with every face in stick and no load, tractions in Pa.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn stick_blocks(&self) -> Result<SaddleBlocks, ElasticityError> {
        let no_load = vec![0.0; self.body.constraints.full_len()];
        self.stick_system().assemble(&no_load)
    }

    /// The body with every face in stick; where rock creeps, with the elastic constants of the step at hand.
    pub fn stick_system(&self) -> StickSystem<'_> {
        let system = Self::stick_system_of(self.body);
        match &self.creep {
            Some(creep) => StickSystem {
                materials: &creep.materials,
                ..system
            },
            None => system,
        }
    }

    /// A again, and loads where they act through it.
    pub(super) fn make_stiffness(&mut self) -> Result<(), ElasticityError> {
        let unit = self.saddle.unit();
        self.saddle = MatrixFreeSaddle::in_traction_unit(&self.stick_system(), unit)?;
        if self.body.constraints.is_displaced() {
            self.loads.follow(self.saddle.stiffness().full())?;
        }
        Ok(())
    }

    /// Fracture faces.
    pub fn faces(&self) -> &'a [FractureFace] {
        &self.body.fractures.faces
    }

    /// ω per face [m/Pa].
    pub fn compliance(&self) -> &[f64] {
        &self.compliance
    }

    /// `s² ω A_f`: what an open face has on the diagonal of its rows.
    pub(super) fn law_entry(&self, f: usize) -> f64 {
        let s = self.saddle.unit();
        s * s * self.faces()[f].area * self.compliance[f]
    }

    /// H for these states, tractions in the balanced unit; `None` where it has no entries.
    pub fn stabilization(&self, states: &[ContactState]) -> Option<Csr<f64>> {
        let s = self.saddle.unit();
        let h = self.stick_system().stabilization_for(|f| states[f])?;
        Some(Csr::new(h.map(|v| v * (s * s))))
    }

    /// Mean jump (n, t1, t2) per face [m].
    pub fn jumps(&self, u: &[f64], load: &Load) -> Vec<f64> {
        self.jumps_from(load.jump.clone(), u)
    }

    /// Mean jump per face of displacements alone, or of a change of them [m].
    pub(super) fn jump_changes(&self, u: &[f64]) -> Vec<f64> {
        self.jumps_from(vec![0.0; 3 * self.faces().len()], u)
    }

    fn jumps_from(&self, mut jump: Vec<f64>, u: &[f64]) -> Vec<f64> {
        let b = self.saddle.coupling();
        let mut work = vec![0.0; b.work_len()];
        b.apply_adjoint_add(1.0 / self.saddle.unit(), u, &mut jump, &mut work);
        for (g, face) in jump.chunks_exact_mut(3).zip(self.faces()) {
            g.iter_mut().for_each(|g| *g /= face.area);
        }
        jump
    }

    /// `f ← f − A u` in N.
    pub(super) fn subtract_stiffness(&self, u: &[f64], f: &mut [f64]) {
        let a = self.saddle.stiffness();
        a.apply_add(-1.0, u, f, &mut vec![0.0; a.work_len()]);
    }

    /// `f ← f + α B t`, t in Pa, f in N.
    pub(super) fn add_forces(&self, alpha: f64, t: &[f64], f: &mut [f64]) {
        let b = self.saddle.coupling();
        let mut work = vec![0.0; b.work_len()];
        b.apply_add(alpha / self.saddle.unit(), t, f, &mut work);
    }

    /// The equations at (u, t) for fixed states; `h` is [`stabilization`](Self::stabilization) of these states, or of some that
    /// constrain more.
    pub fn evaluate(
        &self,
        states: &[ContactState],
        h: Option<&Csr<f64>>,
        [u, t]: [&[f64]; 2],
        start: &Start,
        load: &Load,
    ) -> Evaluation {
        self.evaluate_rows(h, [u, t], start, load, |effective| {
            let rows = self.rows(states, t, effective, start, false);
            let weakens = self.weakens && states.iter().any(|s| s.constrained() == 1);
            let lagged = weakens.then(|| self.rows(states, t, effective, start, true));
            (rows, lagged)
        })
    }

    /// The equations at (u, t); `rows` makes those of the faces, and the same without weakening, of the effective jumps.
    pub(super) fn evaluate_rows(
        &self,
        h: Option<&Csr<f64>>,
        [u, t]: [&[f64]; 2],
        start: &Start,
        load: &Load,
        rows: impl FnOnce(&[f64]) -> (Vec<FaceRows>, Option<Vec<FaceRows>>),
    ) -> Evaluation {
        let s = self.saddle.unit();
        let layout = self.saddle.layout();
        let mut residual = vec![0.0; layout.len()];
        let [r_u, r_t] = layout.split_mut([U, T], &mut residual);
        r_u.copy_from_slice(&load.force);
        // r_u = f − A u − B t
        self.subtract_stiffness(u, r_u);
        self.add_forces(-1.0, t, r_u);
        let jumps = self.jumps(u, load);
        // g − H t*/A_f
        let mut effective = jumps.clone();
        for (g, through) in effective.iter_mut().zip(self.let_through(h, t, start)) {
            *g -= through;
        }
        // r_t = −s A_f r
        let (rows, lagged) = rows(&effective);
        for (f, face) in self.faces().iter().enumerate() {
            for k in 0..3 {
                r_t[3 * f + k] = -s * face.area * rows[f].residual[k];
            }
        }
        Evaluation {
            residual,
            jumps,
            effective,
            flow: None,
            pushed: 0.0,
            rows,
            lagged,
        }
    }

    /// `H t*/A_f`: the jump (n, t1, t2) per face that H lets through [m].
    pub(super) fn let_through(&self, h: Option<&Csr<f64>>, t: &[f64], start: &Start) -> Vec<f64> {
        let mut through = vec![0.0; t.len()];
        if let Some(h) = h {
            let s = self.saddle.unit();
            let acting: Vec<f64> = t.iter().zip(&start.t).map(|(t, start)| t - start).collect();
            h.apply_add(1.0 / (s * s), &acting, &mut through, &mut []);
        }
        for (through, face) in through.chunks_exact_mut(3).zip(self.faces()) {
            through.iter_mut().for_each(|jump| *jump /= face.area);
        }
        through
    }

    /// Residual and tangent of every face.
    fn rows(
        &self,
        states: &[ContactState],
        t: &[f64],
        jumps: &[f64],
        start: &Start,
        lagged: bool,
    ) -> Vec<FaceRows> {
        let row = |(f, state): (usize, &ContactState)| {
            let (law, point) = self.face(f, t, jumps, start);
            match self.balance().is_some() {
                true => law.damped_rows(*state, &point, lagged),
                false => law.projected_rows(*state, &point, lagged),
            }
        };
        states.iter().enumerate().map(row).collect()
    }

    /// The law of a face and where it stands.
    pub(super) fn face(
        &self,
        f: usize,
        t: &[f64],
        jumps: &[f64],
        start: &Start,
    ) -> (FaceLaw, FacePoint) {
        let three = |v: &[f64]| [v[3 * f], v[3 * f + 1], v[3 * f + 2]];
        let (mut jump, from) = (three(jumps), three(&start.jump));
        (1..3).for_each(|k| jump[k] -= from[k]);
        let law = FaceLaw {
            friction: self.friction_in(f, start),
            compliance: self.compliance[f],
            tiny: 0.0,
        };
        let point = FacePoint {
            traction: three(t),
            jump,
            start: self.so_far(f, start),
        };
        (law, point)
    }

    /// The Jacobian at an evaluated point; `lagged` leaves out the derivative of weakening.
    pub fn jacobian<'s>(
        &'s self,
        states: &[ContactState],
        h: Option<&'s Csr<f64>>,
        at: &Evaluation,
        lagged: bool,
    ) -> ContactJacobian<'s> {
        let rows = at.rows(lagged);
        let s = self.saddle.unit();
        let tangent = |(face, rows): (&FractureFace, &FaceRows)| FaceTangent {
            by_jump: rows.by_jump,
            law: rows
                .by_traction
                .map(|row| row.map(|v| -s * s * face.area * v)),
        };
        let all_stick = states.iter().all(|state| *state == ContactState::Stick);
        ContactJacobian {
            a: self.saddle.stiffness(),
            b: self.saddle.coupling(),
            h,
            layout: self.saddle.layout(),
            faces: (!all_stick).then(|| self.faces().iter().zip(rows).map(tangent).collect()),
        }
    }

    /// What a face shows in its state; `jumps` are those of [`Evaluation::effective`].
    pub fn measure(
        &self,
        f: usize,
        state: ContactState,
        t: &[f64],
        jumps: &[f64],
        start: &Start,
    ) -> FaceMeasure {
        let (law, mut point) = self.face(f, t, jumps, start);
        if state == ContactState::Stick {
            // what is left of its jump is the work of H
            point.jump[1..].fill(0.0);
        }
        law.measure(&point)
    }
}
