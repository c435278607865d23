//! Contact states: patches of slip and opening, and the body in equilibrium with them.

use fracas::contact::{ContactState, JumpStabilization};
use fracas::jacobian::{ContactPoint, ContactSystem};
use fracas::scene::Body;
use fracas_operators::LinearOperator;
use fracas_operators::vector::{axpy, norm2};
use fracas_solvers::Prepare;
use fracas_solvers::Silent;
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::saddle::{Elimination, Iterated, Racp, SaddleBlocks, SaddleOperator, T, U};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::fmt;
use std::str::FromStr;

/// Newton steps that a fixed state may take; each step after the first one without new slip squares the error.
const NEWTON_LIMIT: usize = 12;

/// Residual of the nonlinear equations relative to that of the sticking body: the direction of slip is known to this.
const NEWTON_TOLERANCE: f64 = 1e-5;

/// Fluid pressure on open faces over the compression that the sticking fracture carries there. Unit: 1.
const OVERPRESSURE: f64 = 1.5;

/// The patch of every fracture grows around this point of its bounding box (a hypocentre off the middle).
const HYPOCENTRE: [f64; 3] = [0.44, 0.42, 0.38];

/// State of the faces of every fracture: `stick`, `slip:0.25`, `open:0.1`, `slip:0.15+open:0.1`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Slip, around the open patch.
    slip: f64,
    /// Open, around the hypocentre.
    open: f64,
}

/// What is no state.
#[derive(Debug, thiserror::Error)]
#[error(
    "no contact state `{0}`; write stick, slip:SHARE, open:SHARE or slip:SHARE+open:SHARE, shares of at most 1 together"
)]
pub struct UnknownState(String);

impl FromStr for State {
    type Err = UnknownState;

    fn from_str(text: &str) -> Result<Self, UnknownState> {
        let unknown = || UnknownState(text.into());
        let mut state = Self::default();
        if text == "stick" {
            return Ok(state);
        }
        for part in text.split('+') {
            let (name, share) = part.split_once(':').ok_or_else(unknown)?;
            let share = share.parse().map_err(|_| unknown())?;
            match name {
                "slip" => state.slip = share,
                "open" => state.open = share,
                _ => return Err(unknown()),
            }
        }
        let all = 0.0..=1.0;
        let fits = [state.slip, state.open, state.slip + state.open];
        match fits.iter().all(|share| all.contains(share)) {
            true => Ok(state),
            false => Err(unknown()),
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { slip, open } = self;
        match (*slip > 0.0, *open > 0.0) {
            (false, false) => f.write_str("stick"),
            (true, false) => write!(f, "slip:{slip}"),
            (false, true) => write!(f, "open:{open}"),
            (true, true) => write!(f, "slip:{slip}+open:{open}"),
        }
    }
}

impl<'de> Deserialize<'de> for State {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(de::Error::custom)
    }
}

impl Serialize for State {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
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
fn pattern(body: &Body, shares: State, slip: ContactState) -> Vec<ContactState> {
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
    pub(super) fn new(body: &'a Body, h: Option<JumpStabilization>) -> anyhow::Result<Self> {
        let stick = body.stick_system(h);
        let system = ContactSystem::new(stick, &body.forces()?, |f| body.friction_of(f))?;
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
    pub(super) fn linearize(&self, shares: State) -> anyhow::Result<Linearized> {
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

impl Linearized {
    /// Rows with a law of their own, and whether the rest is symmetric.
    pub(super) fn own_rows(&self) -> (usize, bool) {
        match Elimination::new(&self.blocks) {
            Some(elimination) => (elimination.rows().len(), elimination.is_symmetric()),
            None => (0, self.blocks.b2.is_none()),
        }
    }

    /// Share of the faces in a state: 0 stick, 1 slip, 2 open [%].
    pub(super) fn percent(&self, state: usize) -> f64 {
        100.0 * self.faces[state] as f64 / self.faces.iter().sum::<usize>() as f64
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
