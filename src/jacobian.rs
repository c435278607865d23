//! The saddle point linearized at fixed contact states: `[A B1; B2 −H] (δu, δt) = −r`.

use crate::contact::{
    ContactState, FaceLaw, FacePoint, FaceRows, Friction, SlipSoFar, face_compliance,
};
use crate::elasticity::ElasticityError;
use crate::mesh::FractureFace;
use crate::system::StickSystem;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::saddle::SaddleBlocks;

/// Why a system has no Jacobian in the asked states.
#[derive(Debug, thiserror::Error)]
pub enum ContactError {
    /// A face slips on a fracture without friction data.
    #[error(
        "face {face} of fracture {fracture:?} is in state {state:?}, but the fracture has neither friction_angle nor cohesion"
    )]
    NoFriction {
        /// Face, counted from 0.
        face: usize,
        /// Name of its fracture.
        fracture: String,
        /// State asked for.
        state: ContactState,
    },
    /// The blocks with every face in stick cannot be assembled.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
}

/// Where a system is linearized.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint<'a> {
    /// Free displacements [m].
    pub u: &'a [f64],
    /// Tractions (t_N, t_1, t_2) per face [Pa].
    pub t: &'a [f64],
    /// Mean jump (n, t1, t2) per face at the start of the step [m]; slip is counted from there.
    pub start_jump: &'a [f64],
    /// Tractions at the start of the step [Pa]; the tangential rows of H act on the increment.
    pub start_t: &'a [f64],
}

/// A fractured body whose faces stick, slip or are open.
///
/// Rows of face f: `A_f r` of [`FaceLaw`], r taken of the mean jump `(B1ᵀu + prescribed part)/A_f`. Then
/// ```text
/// B2 = (∂r/∂g) B1ᵀ        H = H_form − A_f ∂r/∂t        rhs_u = f − A u − B1 t        rhs_t = −(A_f r − H_form t*)
/// ```
/// with t* = (t_N, t_T − t_T at the start). With every face in stick this is [`StickSystem::assemble`]; open faces have
/// an empty row in B2 and `H_ii = ω A_f`; a slip face has `H_TT = ω A_f I`, `H_TN = ω A_f tan φ m`.
#[derive(Clone, Debug)]
pub struct ContactSystem<'a> {
    system: StickSystem<'a>,
    stick: SaddleBlocks,
    friction: Vec<Option<Friction>>,
    compliance: Vec<f64>,
}

/// Slip below which its direction is noise of the solve, relative to the compliance times the shear limit. Unit: 1.
const TINY_SLIP: f64 = 1e-9;

impl<'a> ContactSystem<'a> {
    /// Assembles what does not depend on the states; `friction` says that of a face, where it has one.
    ///
    /// # Errors
    /// [`ContactError::Elasticity`] for an inverted element or a region without material.
    pub fn new(
        system: StickSystem<'a>,
        force: &[f64],
        friction: impl Fn(&FractureFace) -> Option<Friction>,
    ) -> Result<Self, ContactError> {
        let faces = &system.fractures.faces;
        Ok(Self {
            stick: system.assemble(force)?,
            friction: faces.iter().map(friction).collect(),
            compliance: faces
                .iter()
                .map(|f| face_compliance(system.mesh, system.materials, f))
                .collect(),
            system,
        })
    }

    /// The blocks with every face in stick.
    pub fn stick(&self) -> &SaddleBlocks {
        &self.stick
    }

    /// Mean jump (n, t1, t2) per face [m]: `(B1ᵀu + prescribed part) / A_f`.
    pub fn jumps(&self, u: &[f64]) -> Vec<f64> {
        let mut jump: Vec<f64> = self.stick.rhs_t.iter().map(|g| -g).collect();
        for (row, u_i) in self.stick.b1.outer_iterator().zip(u) {
            row.iter().for_each(|(j, b)| jump[j] += b * u_i);
        }
        for (g, face) in jump.chunks_exact_mut(3).zip(&self.system.fractures.faces) {
            g.iter_mut().for_each(|g| *g /= face.area);
        }
        jump
    }

    /// The blocks of the Jacobian and `−r` at a point.
    ///
    /// # Errors
    /// [`ContactError::NoFriction`] for a slipping face without friction data.
    pub fn linearize(
        &self,
        states: &[ContactState],
        point: &ContactPoint<'_>,
    ) -> Result<SaddleBlocks, ContactError> {
        let (n_u, faces) = (self.stick.n_u(), self.compliance.len());
        for (what, expected, found) in [
            ("states", faces, states.len()),
            ("u", n_u, point.u.len()),
            ("t", 3 * faces, point.t.len()),
            ("start_t", 3 * faces, point.start_t.len()),
            ("start_jump", 3 * faces, point.start_jump.len()),
        ] {
            assert_eq!(found, expected, "length of {what}");
        }
        let rows = self.face_rows(states, point)?;
        let area = |f: usize| self.system.fractures.faces[f].area;
        let form = self.system.stabilization_for(|f| states[f]);

        let mut rhs_u = self.stick.rhs_u.clone();
        add_product(&self.stick.a, -1.0, point.u, &mut rhs_u);
        add_product(&self.stick.b1, -1.0, point.t, &mut rhs_u);
        let mut rhs_t: Vec<f64> = (0..3 * faces)
            .map(|i| -area(i / 3) * rows[i / 3].residual[i % 3])
            .collect();
        if let Some(form) = &form {
            let acting: Vec<f64> = (0..3 * faces)
                .map(|i| point.t[i] - if i % 3 == 0 { 0.0 } else { point.start_t[i] })
                .collect();
            add_product(form, 1.0, &acting, &mut rhs_t);
        }
        let all_stick = states.iter().all(|s| *s == ContactState::Stick);
        Ok(SaddleBlocks {
            b2: (!all_stick).then(|| turned(&self.stick.b1, &rows)),
            h: with_laws(form, &rows, area),
            rhs_u,
            rhs_t,
            ..self.stick.clone()
        })
    }

    /// Residual and tangent of every face.
    fn face_rows(
        &self,
        states: &[ContactState],
        point: &ContactPoint<'_>,
    ) -> Result<Vec<FaceRows>, ContactError> {
        let jumps = self.jumps(point.u);
        let row = |(f, state): (usize, &ContactState)| {
            let slips = matches!(state, ContactState::Slip | ContactState::NewSlip);
            let friction = match self.friction[f] {
                None if slips => return Err(self.no_friction(f, *state)),
                friction => friction.unwrap_or(Friction::NONE),
            };
            let three = |v: &[f64]| [v[3 * f], v[3 * f + 1], v[3 * f + 2]];
            let (traction, start) = (three(point.t), three(point.start_jump));
            let mut jump = three(&jumps);
            (1..3).for_each(|k| jump[k] -= start[k]);
            let law = FaceLaw {
                friction,
                compliance: self.compliance[f],
                tiny: TINY_SLIP * self.compliance[f] * friction.limit(traction[0], 0.0).abs(),
            };
            let point = FacePoint {
                traction,
                jump,
                // it got there straight
                start: SlipSoFar::straight(
                    friction.weakening.map(|w| w.by).unwrap_or_default(),
                    [start[1], start[2]],
                ),
            };
            Ok(law.rows(*state, &point))
        };
        states.iter().enumerate().map(row).collect()
    }

    fn no_friction(&self, face: usize, state: ContactState) -> ContactError {
        let fractures = self.system.fractures;
        let index = usize::from(fractures.faces[face].fracture);
        ContactError::NoFriction {
            face,
            fracture: fractures.names.get(index).cloned().unwrap_or_default(),
            state,
        }
    }
}

/// `y ← y + α M x`.
fn add_product(m: &SparseMatrix<f64>, alpha: f64, x: &[f64], y: &mut [f64]) {
    for (row, y) in m.outer_iterator().zip(y) {
        *y += alpha * row.iter().map(|(j, v)| v * x[j]).sum::<f64>();
    }
}

/// `B2 = (∂r/∂g) B1ᵀ`, one 3×3 factor per face; rows without a jump are empty.
pub(crate) fn turned(b1: &SparseMatrix<f64>, rows: &[FaceRows]) -> SparseMatrix<f64> {
    let mut factor = Triplets::new((3 * rows.len(), 3 * rows.len()));
    for (f, face) in rows.iter().enumerate() {
        for (k, row) in face.by_jump.iter().enumerate() {
            for (l, value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                factor.add_triplet(3 * f + k, 3 * f + l, *value);
            }
        }
    }
    let factor: SparseMatrix<f64> = factor.to_csr();
    let transpose = b1.transpose_view().to_csr();
    &factor * &transpose
}

/// `H = H_form − A_f ∂r/∂t`; `None` where it has no entries.
pub(crate) fn with_laws(
    form: Option<SparseMatrix<f64>>,
    rows: &[FaceRows],
    area: impl Fn(usize) -> f64,
) -> Option<SparseMatrix<f64>> {
    let mut law = Triplets::new((3 * rows.len(), 3 * rows.len()));
    for (f, face) in rows.iter().enumerate() {
        for (k, row) in face.by_traction.iter().enumerate() {
            for (l, value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                law.add_triplet(3 * f + k, 3 * f + l, -area(f) * value);
            }
        }
    }
    let law: SparseMatrix<f64> = law.to_csr();
    match form {
        None => (law.nnz() > 0).then_some(law),
        Some(form) => Some(&form + &law),
    }
}
