//! A body with patches of slip and opening, brought to equilibrium with them.

use fracas::contact::{ContactState, JumpStabilization};
use fracas::jacobian::{ContactPoint, ContactSystem};
use fracas::scene::Body;
use fracas_operators::LinearOperator;
use fracas_operators::vector::{axpy, norm2};
use fracas_solvers::Prepare;
use fracas_solvers::Silent;
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::saddle::{Iterated, Racp, SaddleBlocks, SaddleOperator, T, U};

/// Newton steps that a fixed state may take; each step after the first one without new slip squares the error.
const NEWTON_LIMIT: usize = 12;

/// Residual of the nonlinear equations relative to that of the sticking body: the direction of slip is known to this.
const NEWTON_TOLERANCE: f64 = 1e-5;

/// Fluid pressure on open faces over the compression that the sticking fracture carries there. Unit: 1.
const OVERPRESSURE: f64 = 1.5;

/// The patch of every fracture grows around this point of its bounding box (a hypocentre off the middle).
const HYPOCENTRE: [f64; 3] = [0.44, 0.42, 0.38];

/// Shares of the faces of every fracture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shares {
    /// Slip, around the open patch.
    pub slip: f64,
    /// Open, around the hypocentre.
    pub open: f64,
}

/// A linearized state.
pub(super) struct Linearized {
    /// Jacobian in the balanced unit of tractions; the right-hand side belongs to (u, t) itself.
    pub blocks: SaddleBlocks,
    /// Faces per state: stick, slip, open.
    pub faces: [usize; 3],
    /// Newton steps.
    pub newton: usize,
    /// Reached [`NEWTON_TOLERANCE`].
    pub converged: bool,
    /// Closed faces in tension.
    pub tension: usize,
    /// Open faces that overlap.
    pub overlap: usize,
}

/// Faces of every fracture by their distance from its hypocentre, as (rank, faces of the fracture) per face.
fn ranks(body: &Body) -> Vec<(usize, usize)> {
    let faces = &body.fractures.faces;
    let mut ranks = vec![(0, 0); faces.len()];
    for fracture in 0..body.fractures.names.len() {
        let mut own: Vec<usize> = (0..faces.len())
            .filter(|&f| usize::from(faces[f].fracture) == fracture)
            .collect();
        let center: [f64; 3] = std::array::from_fn(|d| {
            let ends = own.iter().map(|&f| faces[f].center[d]);
            let low = ends.clone().fold(f64::INFINITY, f64::min);
            let high = ends.fold(f64::NEG_INFINITY, f64::max);
            low + HYPOCENTRE[d] * (high - low)
        });
        let distance = |f: usize| -> f64 {
            (0..3)
                .map(|d| (faces[f].center[d] - center[d]).powi(2))
                .sum()
        };
        own.sort_by(|&f, &g| distance(f).total_cmp(&distance(g)).then(f.cmp(&g)));
        for (rank, &f) in own.iter().enumerate() {
            ranks[f] = (rank, own.len());
        }
    }
    ranks
}

/// State per face for given shares, slip faces in the state `slip`.
fn pattern(body: &Body, shares: Shares, slip: ContactState) -> Vec<ContactState> {
    ranks(body)
        .into_iter()
        .map(|(rank, of)| {
            let count = |share: f64| (share * of as f64).round() as usize;
            let open = count(shares.open);
            if rank < open {
                ContactState::Open
            } else if rank < open + count(shares.slip) {
                slip
            } else {
                ContactState::Stick
            }
        })
        .collect()
}

/// A body, its all-stick tractions, and the unit in which systems are solved.
pub(super) struct Laboratory<'a> {
    body: &'a Body,
    system: ContactSystem<'a>,
    unit: f64,
    stick_t: Vec<f64>,
}

impl<'a> Laboratory<'a> {
    /// Solves the body with every face in stick.
    pub(super) fn new(body: &'a Body) -> anyhow::Result<Self> {
        let stick = body.stick_system(Some(JumpStabilization::PUBLISHED));
        let system = ContactSystem::new(stick, &body.forces()?, &body.friction)?;
        let unit = system.stick().traction_unit();
        let blocks = system.stick().in_traction_unit(unit);
        let x = solve(&blocks, &blocks.rhs())?;
        let [t] = blocks.layout().split([T], &x);
        let stick_t = t.iter().map(|t| unit * t).collect();
        Ok(Self {
            body,
            system,
            unit,
            stick_t,
        })
    }

    /// Nodal forces of the fluid in open faces over the free displacements: `B1 (p, 0, 0)`, `p = 1.5 |t_N|` of stick.
    fn fluid(&self, states: &[ContactState]) -> Vec<f64> {
        let b1 = &self.system.stick().b1;
        let pressure = |k: usize| match states[k / 3] {
            ContactState::Open if k.is_multiple_of(3) => OVERPRESSURE * self.stick_t[k].abs(),
            _ => 0.0,
        };
        b1.outer_iterator()
            .map(|row| row.iter().map(|(k, b)| b * pressure(k)).sum())
            .collect()
    }

    /// Newton's method for these states from rest: new slip along the shear traction of stick, then slip.
    pub(super) fn linearize(&self, shares: Shares) -> anyhow::Result<Linearized> {
        let states = pattern(self.body, shares, ContactState::Slip);
        let new_slip = pattern(self.body, shares, ContactState::NewSlip);
        let fluid = self.fluid(&states);
        let (n_u, n_t) = (self.system.stick().n_u(), self.stick_t.len());
        let zero = vec![0.0; n_t];
        let (mut u, mut t) = (vec![0.0; n_u], self.stick_t.clone());
        let (mut steps, mut first) = (0, None);
        loop {
            let point = ContactPoint {
                u: &u,
                t: &t,
                start_jump: &zero,
                start_t: &zero,
            };
            let now = if steps == 0 { &new_slip } else { &states };
            let mut blocks = self.system.linearize(now, &point)?;
            axpy(1.0, &fluid, &mut blocks.rhs_u);
            let mut blocks = blocks.in_traction_unit(self.unit);
            let residual = norm2(&blocks.rhs());
            let first = *first.get_or_insert(residual);
            let converged = steps > 1 && residual <= NEWTON_TOLERANCE * first;
            if converged || steps == NEWTON_LIMIT {
                // 𝒜 x − r(x): the same Jacobian asked for (u, t) instead of for a correction
                let x: Vec<f64> = u
                    .iter()
                    .copied()
                    .chain(t.iter().map(|t| t / self.unit))
                    .collect();
                let operator = SaddleOperator::new(&blocks);
                let mut b = blocks.rhs();
                operator.apply_add(1.0, &x, &mut b, &mut vec![0.0; operator.work_len()]);
                drop(operator);
                blocks.rhs_t = b.split_off(n_u);
                blocks.rhs_u = b;
                let jumps = self.system.jumps(&u);
                let count_faces = |wrong: &dyn Fn(usize, ContactState) -> bool| {
                    (0..states.len()).filter(|&f| wrong(f, states[f])).count()
                };
                let count = |s: ContactState| states.iter().filter(|x| **x == s).count();
                return Ok(Linearized {
                    blocks,
                    faces: [ContactState::Stick, ContactState::Slip, ContactState::Open].map(count),
                    newton: steps,
                    converged,
                    tension: count_faces(&|f, s| s != ContactState::Open && t[3 * f] > 0.0),
                    overlap: count_faces(&|f, s| s == ContactState::Open && jumps[3 * f] < 0.0),
                });
            }
            let d = solve(&blocks, &blocks.rhs())?;
            let [d_u, d_t] = blocks.layout().split([U, T], &d);
            axpy(1.0, d_u, &mut u);
            axpy(self.unit, d_t, &mut t);
            steps += 1;
        }
    }
}

/// Solves by RACP with exact S_u to 1e-10.
fn solve(blocks: &SaddleBlocks, rhs: &[f64]) -> anyhow::Result<Vec<f64>> {
    let m = Racp::default().prepare(blocks)?;
    let operator = SaddleOperator::new(blocks);
    let system = System {
        operator: &operator,
        preconditioner: m.as_ref(),
        rhs,
    };
    let criteria = Criteria {
        relative_tolerance: 1e-10,
        max_iterations: 500,
    };
    let mut x = vec![0.0; rhs.len()];
    let krylov = KrylovChoice::default();
    Iterated::new(&system, krylov, &criteria, &mut x, &mut Silent).reached()?;
    Ok(x)
}
