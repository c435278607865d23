//! The third field: pressures of the fluid in fractures, beside displacements and tractions.

use super::active_set::Settled;
use super::newton::{Attempt, Iterate, relative};
use super::{ContactProblem, Evaluation, Failure, Load, Simulation, SimulationError, Start, State};
use crate::contact::ContactState;
use crate::elasticity::ElasticityError;
use crate::flow::{FlowStep, Fluid};
use crate::mesh::FractureFace;
use crate::scene::Method;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::{axpy, norm2};
use fracas_operators::{Fields, Layout};
use fracas_solvers::saddle::{EnergyNorms, FlowBlocks, P, PressureSchur, SaddleBlocks};

/// How much more strictly lost volume is judged than residuals: a run adds the losses of its steps up. Unit: 1.
const STRICT: f64 = 1e3;

/// Newton steps per well that do not count as wells switch: twice from its rate over its limit to shut all at once, and then alone. Unit: 1.
const SWITCHES: usize = 8;

impl ContactProblem<'_> {
    /// Pressure per face before anything flows, of which a share is applied; empty without a fluid [Pa].
    pub(super) fn initial_pressures(&self, share: f64) -> Vec<f64> {
        let Some(balance) = self.balance() else {
            return Vec::new();
        };
        let of = |face| share * balance.fluid().initial_pressure(face);
        self.faces().iter().map(of).collect()
    }

    /// 0 for every field that is judged.
    pub(super) fn nothing(&self) -> Fields<f64> {
        let fields = self.saddle().layout().values(0.0);
        match self.balance() {
            Some(_) => fields.with(P, 0.0),
            None => fields,
        }
    }

    /// Flow goes with multipliers alone.
    pub(super) fn require_multipliers(&self) -> Result<(), SimulationError> {
        match self.balance().is_some() && self.body().solver.method != Method::Lagrange {
            true => Err(SimulationError::FlowWithSprings),
            false => Ok(()),
        }
    }

    /// S_p of runs comes from the mesh.
    pub(super) fn require_surface(&self, schur: PressureSchur) -> Result<(), SimulationError> {
        let is_here = matches!(
            schur,
            PressureSchur::HalfOrder | PressureSchur::Transmissibility
        );
        match self.balance().is_some() && !is_here {
            true => Err(SimulationError::PressureSchur { name: schur.name() }),
            false => Ok(()),
        }
    }

    /// The largest of the loads before and after and of the forces of the tractions before, and of the pressures before where something
    /// flows [N]: residuals are relative to it.
    pub(super) fn scale(&self, t: &[f64], loads: [&Load; 2], pressures: Option<&[f64]>) -> f64 {
        let unit = self.saddle().unit();
        let mut pushed = vec![0.0; self.body().constraints.free_len()];
        self.add_forces(1.0, t, &mut pushed);
        let forced = pressures.map(|p| norm2(&self.pressure_forces(p, 1.0)));
        let scale = loads
            .into_iter()
            .flat_map(|load| [norm2(&load.force), unit * norm2(&load.jump)])
            .chain(forced)
            .fold(norm2(&pushed), f64::max);
        match scale > 0.0 {
            true => scale,
            false => self.resultants(t.iter().step_by(3).copied()),
        }
    }

    /// `‖A_f t_f‖₂` of normal tractions or pressures [N]: what they weigh where faces push on nodes alone that no fracture splits.
    fn resultants(&self, normal: impl Iterator<Item = f64>) -> f64 {
        let forces = self
            .faces()
            .iter()
            .zip(normal)
            .map(|(face, t)| face.area * t);
        norm2(&forces.collect::<Vec<f64>>())
    }

    /// `−Q1 (p − p₀) = B n (p − p₀)`: the forces of what the pressures have changed; p₀ is among the loads [N].
    pub(super) fn pressure_forces(&self, p: &[f64], share: f64) -> Vec<f64> {
        let mut normal = vec![0.0; 3 * p.len()];
        let changed = p.iter().zip(self.initial_pressures(share));
        for (t, (p, p0)) in normal.chunks_exact_mut(3).zip(changed) {
            t[0] = p - p0;
        }
        let mut force = vec![0.0; self.body().constraints.free_len()];
        self.add_forces(1.0, &normal, &mut force);
        force
    }

    /// What is given of the flow between two times, from pressures and jumps at the start; `None` where nothing flows or no time
    /// passes.
    pub(super) fn flow_step(
        &self,
        times: [f64; 2],
        (p, states, jumps): (&[f64], &[ContactState], &[f64]),
    ) -> Option<FlowStep> {
        let balance = self.balance().filter(|_| times[1] > times[0])?;
        let aperture = |(f, state): (usize, &ContactState)| Fluid::aperture(*state, jumps[3 * f]);
        let apertures = states.iter().enumerate().map(aperture).collect();
        let histories = &self.body().histories;
        let factor = |history: usize, time: f64| histories[history].at(time);
        Some(balance.step(times, p.to_vec(), apertures, factor))
    }

    /// `Q1 = −B n`, `Q2 = K (B n)ᵀ`, T and −R for blocks whose tractions and pressures count in `unit`, and `K = ∂R/∂g_N A_f⁻¹`.
    fn flow_blocks(
        &self,
        (b1, unit): (&SparseMatrix<f64>, f64),
        (states, at, p): (&[ContactState], &Evaluation, &[f64]),
        step: &FlowStep,
    ) -> Option<(FlowBlocks, SparseMatrix<f64>)> {
        let tangent = self.balance()?.tangent(states, &at.jumps, p, step);
        let mut normal = Triplets::new((3 * p.len(), p.len()));
        let mut by_volume = Triplets::new((p.len(), p.len()));
        for (f, face) in self.faces().iter().enumerate() {
            normal.add_triplet(3 * f, f, 1.0);
            by_volume.add_triplet(f, f, 1.0 / face.area);
        }
        let normal: SparseMatrix<f64> = normal.to_csr();
        let by_volume: SparseMatrix<f64> = by_volume.to_csr();
        let b_n = b1 * &normal;
        // columns of closed faces are no entries
        let mut by_gap = Triplets::new((p.len(), p.len()));
        for (value, (k, m)) in &tangent.by_gap {
            if states[m as usize] == ContactState::Open {
                by_gap.add_triplet(k as usize, m as usize, *value);
            }
        }
        let by_gap: SparseMatrix<f64> = by_gap.to_csr();
        let by_gap = &by_gap * &by_volume;
        let q2 = &by_gap * &b_n.transpose_view().to_csr();
        let flow = at.flow.as_ref()?;
        let blocks = FlowBlocks {
            q1: b_n.map(|v| -v),
            q2,
            t: tangent.t.map(|v| unit * unit * v),
            rhs_p: flow.residual.iter().map(|r| -unit * r).collect(),
        };
        Some((blocks, by_gap))
    }
}

impl Attempt<'_> {
    /// Fields of its vectors: displacements, tractions and, where something flows, pressures in the same unit as these.
    pub(super) fn layout(&self) -> Layout {
        let saddle = self.problem.saddle();
        match self.flow {
            None => saddle.layout(),
            Some(step) => {
                let three = saddle.layout().with(P, step.pressure.len());
                three.counted_in(P, saddle.unit())
            }
        }
    }

    /// Norms of errors; those of pressures, where something flows, by what they move: `e_pᵀ diag(Q1ᵀ diag(A)⁻¹ Q1) e_p`, as in
    /// [`solve`](mod@crate::solve).
    pub(super) fn norms(&self) -> EnergyNorms<'_> {
        let norms = self.problem.norms(self.held.as_ref());
        match self.flow {
            None => norms,
            Some(_) => {
                let normal = norms.compliance().iter().step_by(3);
                let weights: Vec<f64> = normal.copied().collect();
                let none = SparseMatrix::zero((weights.len(), weights.len()));
                norms.and(P, weights, &none)
            }
        }
    }

    /// The equations at an iterate.
    pub(super) fn evaluate(
        &self,
        states: &[ContactState],
        h: Option<&Csr<f64>>,
        x: &Iterate,
    ) -> Evaluation {
        let problem = self.problem;
        let point = [&x.u[..], &x.t];
        let (Some(step), Some(balance)) = (self.flow, problem.balance()) else {
            return problem.evaluate(states, h, point, self.start, self.load);
        };
        let mut at = problem.evaluate(states, h, point, &self.start_under(&x.p), self.load);
        let pushed = problem.pressure_forces(&x.p, 1.0);
        axpy(1.0, &pushed, &mut at.residual[..pushed.len()]);
        let step = &step.controlled(&x.wells);
        let point = balance.evaluate(states, &at.jumps, &x.p, step);
        let point = point.beyond(balance.unseen(states, self.traction));
        let unit = problem.saddle().unit();
        at.residual.extend(point.residual.iter().map(|r| -unit * r));
        at.pushed = match norm2(&pushed) {
            0.0 => problem.resultants(x.p.iter().copied()),
            size => size,
        };
        at.flow = Some(point);
        at
    }

    /// The residual relative to loads and internal forces, or that of the fluid relative to its volumes, or what is lost of it, a thousand
    /// times as strictly; the largest.
    pub(super) fn relative(&self, at: &Evaluation) -> f64 {
        match &at.flow {
            None => relative(norm2(&at.residual), self.scale),
            Some(flow) => {
                let of_rock = &at.residual[..at.residual.len() - flow.residual.len()];
                let rock = relative(norm2(of_rock), self.scale.max(at.pushed));
                let fluid = flow.relative().max(STRICT * flow.loss());
                // NaN stays NaN
                match rock > fluid || rock.is_nan() {
                    true => rock,
                    false => fluid,
                }
            }
        }
    }

    /// True where no more of the fluid is lost than a solution may lose: errors that rounding leaves in pressures are no reason to.
    pub(super) fn keeps_fluid(&self, at: &Evaluation) -> bool {
        let tolerance = self.problem.body().solver.tolerance;
        (at.flow.as_ref()).is_none_or(|flow| STRICT * flow.loss() <= tolerance)
    }

    /// True where the equations at these states are linear.
    pub(super) fn is_linear(&self, states: &[ContactState]) -> bool {
        let widens = |s: &ContactState| self.flow.is_some() && *s == ContactState::Open;
        states.iter().all(|s| s.is_linear() && !widens(s)) && self.switches() == 0
    }

    /// Newton steps that wells may take to come to their controls, beside those that are counted.
    pub(super) fn switches(&self) -> usize {
        SWITCHES * self.flow.map_or(0, FlowStep::limited)
    }

    /// The equations at an iterate, after its wells have switched where its pressures ask for it, or the first of them `alone`; true where
    /// one has.
    pub(super) fn controlled(
        &self,
        (states, h): (&[ContactState], Option<&Csr<f64>>),
        at: Evaluation,
        x: &mut Iterate,
        alone: bool,
    ) -> (Evaluation, bool) {
        let (Some(step), Some(balance)) = (self.flow, self.problem.balance()) else {
            return (at, false);
        };
        let now = step.controlled(&x.wells);
        match balance.switched(states, &at.jumps, &x.p, &now, alone) {
            Some(wells) => {
                x.wells = wells;
                (self.evaluate(states, h, x), true)
            }
            None => (at, false),
        }
    }

    /// The Jacobian and `−r` of all fields, tractions and pressures in Pa.
    pub(super) fn assembled(
        &self,
        states: &[ContactState],
        (h, x): (Option<&Csr<f64>>, &Iterate),
        at: &Evaluation,
        lagged: bool,
    ) -> Result<SaddleBlocks, ElasticityError> {
        let stick = (self.problem.stick_blocks()?, 1.0);
        Ok(self.coupled(stick, states, (h, x), at, lagged))
    }

    /// The same from the blocks with every face in stick, tractions and pressures counted in `unit`.
    pub(super) fn coupled(
        &self,
        (stick, unit): (SaddleBlocks, f64),
        states: &[ContactState],
        (h, x): (Option<&Csr<f64>>, &Iterate),
        at: &Evaluation,
        lagged: bool,
    ) -> SaddleBlocks {
        let problem = self.problem;
        let flow = self
            .flow
            .and_then(|step| problem.flow_blocks((&stick.b1, unit), (states, at, &x.p), step));
        let flow = flow.map(|(flow, _)| flow);
        let blocks = problem.linearized((stick, unit), states, h, at, lagged);
        SaddleBlocks { flow, ..blocks }
    }

    /// Q1, Q2, T and −R, and K of `Q2 = K (B n)ᵀ`, where something flows.
    pub(super) fn flow_blocks(
        &self,
        b: (&SparseMatrix<f64>, f64),
        states: &[ContactState],
        at: &Evaluation,
        x: &Iterate,
    ) -> Option<(FlowBlocks, SparseMatrix<f64>)> {
        let step = self.flow?.controlled(&x.wells);
        self.problem.flow_blocks(b, (states, at, &x.p), &step)
    }

    /// The states at which the active set begins: where fluid has to go into sealed fractures, or goes before a well meets its limit, what
    /// it reaches first is open.
    pub(super) fn opened(&self, mut states: Vec<ContactState>, x: &Iterate) -> Vec<ContactState> {
        let (Some(step), Some(balance)) = (self.flow, self.problem.balance()) else {
            return states;
        };
        for part in balance.sealed(&states, step) {
            let fed = balance.to_open(&part, step);
            // what a closed face carries, and the fluid in it, hold it shut
            let gives_way = |f: &u32| {
                let f = *f as usize;
                part.reach + balance.fluid().head(self.problem.faces()[f].center)
                    > x.p[f] - x.t[3 * f]
            };
            if part.excess > 0.0 || part.asked > 0.0 && fed.iter().any(gives_way) {
                fed.iter()
                    .for_each(|f| states[*f as usize] = ContactState::Open);
            }
        }
        states
    }

    /// Changes of states, and those that fluid forces on sealed fractures that have none: what they cannot hold opens them.
    pub(super) fn with_openings(
        &self,
        states: &[ContactState],
        changes: Vec<(usize, ContactState)>,
    ) -> Result<Vec<(usize, ContactState)>, Failure> {
        let (Some(step), Some(balance)) = (self.flow, self.problem.balance()) else {
            return Ok(changes);
        };
        let mut next = states.to_vec();
        let opens = |(_, state): &&(usize, ContactState)| *state == ContactState::Open;
        let opening: Vec<usize> = changes.iter().filter(opens).map(|(f, _)| *f).collect();
        for (f, state) in changes.iter().filter(|change| !opens(change)) {
            next[*f] = *state;
        }
        for f in balance.front(&next, &opening, step) {
            next[f] = ContactState::Open;
        }
        let sealed = balance.sealed(&next, step);
        let drained = sealed.iter().find(|part| part.excess < 0.0);
        if let (Some(part), true) = (drained, changes.is_empty()) {
            return Err(self.drained(&part.faces, -part.excess));
        }
        for part in sealed.iter().filter(|part| part.excess > 0.0) {
            for f in balance.to_open(part, step) {
                next[f as usize] = ContactState::Open;
            }
        }
        let differs = |f: &usize| next[*f] != states[*f];
        let changed = (0..states.len()).filter(differs);
        Ok(changed.map(|f| (f, next[f])).collect())
    }

    /// What an attempt found, with where its fluid went; before anything flows, with the share of the initial pressures that is applied.
    pub(super) fn with_flow(&self, mut settled: Settled, share: f64) -> Settled {
        let problem = self.problem;
        match (self.flow, problem.balance()) {
            (Some(step), Some(balance)) => {
                let step = &step.joining(&settled.joined);
                let step = &step.controlled(&settled.x.wells);
                let jumps = problem.jumps(&settled.x.u, self.load);
                let record = balance.record(&settled.states, &jumps, &settled.x.p, step);
                settled.flow = Some(record);
                settled.wells = balance.wells(&settled.states, &jumps, &settled.x.p, step);
            }
            _ => settled.x.p = problem.initial_pressures(share),
        }
        settled
    }

    /// The start where H acts on what changes of the traction of the rock, `t_N − p`: it goes from face to face as smoothly as stress does,
    /// while t_N follows the pressure of its own face.
    fn start_under(&self, p: &[f64]) -> Start {
        let mut start = self.start.clone();
        let changed = p.iter().zip(self.problem.initial_pressures(1.0));
        for (t, (p, p0)) in start.t.chunks_exact_mut(3).zip(changed) {
            t[0] += p - p0;
        }
        start
    }

    /// The load with the pressures of an iterate among its forces, and the start under them; `None` where nothing flows.
    pub(super) fn pressed(&self, x: &Iterate) -> Option<(Load, Start)> {
        self.flow?;
        let mut load = self.load.clone();
        axpy(
            1.0,
            &self.problem.pressure_forces(&x.p, 1.0),
            &mut load.force,
        );
        Some((load, self.start_under(&x.p)))
    }

    /// The same attempt without flow under another load and from another start, if there are any.
    pub(super) fn at_load<'l>(&'l self, pressed: Option<&'l (Load, Start)>) -> Attempt<'l> {
        let Some((load, start)) = pressed else {
            return self.clone();
        };
        Attempt {
            load,
            start,
            flow: None,
            ..self.clone()
        }
    }
}

impl Simulation<'_> {
    /// C_f [m³] and the flow per width [m²/s] of every face; empty where the scene has no fluid.
    pub(super) fn flow_fields(&self, state: &State, jumps: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let problem = self.problem();
        let Some(balance) = problem.balance() else {
            return Default::default();
        };
        let histories = &problem.body().histories;
        let factor = |history: usize, time: f64| histories[history].at(time);
        let faces = state.p.len();
        // what is held at this time
        let now = [state.time; 2];
        let step = balance.step(now, state.p.clone(), vec![0.0; faces], factor);
        let of = |(f, face): (usize, &FractureFace)| {
            let [c, _] = (balance.fluid()).conductivity(face, state.states[f], jumps[3 * f]);
            c
        };
        let conductivity = problem.faces().iter().enumerate().map(of).collect();
        let flux = match state.time > 0.0 {
            true => balance.fluxes(&state.states, jumps, &state.p, &step),
            // at time 0 nothing flows yet
            false => vec![0.0; 3 * faces],
        };
        (conductivity, flux)
    }
}

mod drained;
mod limits;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
