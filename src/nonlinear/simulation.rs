//! Steps: from the unloaded body to the last time of its scene.

use super::active_set::{Log, Settled};
use super::creeping::step_from;
use super::linear::Linear;
use super::loads::{Opened, initial_traction};
use super::newton::{Attempt, Iterate};
use super::onset::Search;
use super::raising::Raising;
use super::springs::SpringMethod;
use super::stability::{COMPARED, is_shown, stable};
use super::times::{Limits, Target, Times, length};
use super::workspace::{Resources, Workspace};
use super::{
    Accepted, ContactProblem, Event, Failure, FreeMemory, Load, NewtonSystem, SimulationError,
    Start, State, StepFailure,
};
use crate::contact::ContactState;
use crate::scene::{Body, Unstable};
use fracas_operators::vector::axpy;
use fracas_solvers::Observer;
use fracas_solvers::saddle::{InnerChoice, Racp};
use fracas_solvers::steering::Steering;

/// What begins in the step at hand, where the scene looks for it.
fn begun(simulation: &Simulation<'_>, search: &Option<Search>) -> Vec<Event> {
    let events = search.as_ref().map(|search| search.events(simulation));
    events.unwrap_or_default()
}

/// A body in contact, stepped through time.
pub struct Simulation<'a> {
    pub(super) problem: ContactProblem<'a>,
    pub(super) linear: Linear,
    /// What takes the place of multipliers, if anything does.
    pub(super) springs: Option<SpringMethod>,
    pub(super) times: Times,
    /// Tractions of the initial stress: the start of the equilibrium at time 0 [Pa].
    initial_traction: Vec<f64>,
}

impl<'a> Simulation<'a> {
    /// Everything that depends on neither states nor time; the preconditioner waits for the first linear system.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub fn new(body: &'a Body) -> Result<Self, SimulationError> {
        let missing = body.friction.iter().position(Option::is_none);
        if let Some(fracture) = missing {
            let names = &body.fractures.names;
            return Err(SimulationError::NoFriction {
                fracture: names.get(fracture).cloned().unwrap_or_default(),
            });
        }
        body.solver.rounds.checked()?;
        let problem = ContactProblem::new(body)?;
        problem.require_multipliers()?;
        let linear = Linear::new(&problem);
        let racp = linear.settings();
        problem.require_surface(racp.flow.schur)?;
        if let InnerChoice::Geometric(geometric) = racp.inner {
            let checked = geometric.checked();
            checked.map_err(SimulationError::Geometric)?;
            if body.mesh.grid.is_none() {
                return Err(SimulationError::NoGrid);
            }
            let local = racp.augmentation.require_local();
            local.map_err(SimulationError::Augmentation)?;
        }
        Ok(Self {
            springs: SpringMethod::new(&problem, linear.settings()),
            linear,
            initial_traction: initial_traction(body),
            times: Times::new(body),
            problem,
        })
    }

    /// The same with no more Krylov vectors than fit into `free`, asked once: a shorter basis or a short recurrence where a full one
    /// does not.
    #[must_use]
    pub fn limited_by(mut self, free: FreeMemory) -> Self {
        self.resources_mut().work = Workspace::limited_by(free);
        self
    }

    /// The equations.
    pub fn problem(&self) -> &ContactProblem<'a> {
        &self.problem
    }

    /// The preconditioner in use, in f64 where f32 gave way to it.
    pub fn preconditioner(&self) -> Racp {
        (self.resources().fallbacks).effective(self.linear.settings())
    }

    /// Times that a preconditioner in f32 gave way to one in f64; [`Event::Precision`] says why.
    pub fn precision_fallbacks(&self) -> usize {
        self.resources().fallbacks.count
    }

    /// Times that an inner solver could not be set up, or got nowhere, and another took its place; [`Event::Inner`] says why.
    pub fn inner_fallbacks(&self) -> usize {
        self.resources().fallbacks.inner
    }

    fn resources(&self) -> &Resources {
        match &self.springs {
            Some(springs) => &springs.resources,
            None => &self.linear.resources,
        }
    }

    fn resources_mut(&mut self) -> &mut Resources {
        match &mut self.springs {
            Some(springs) => &mut springs.resources,
            None => &mut self.linear.resources,
        }
    }

    /// True at the last time.
    pub fn is_finished(&self, state: &State) -> bool {
        self.times.is_finished(state)
    }

    /// The next step: the equilibrium at time 0 first, then time by time. A failed attempt is repeated from all-stick, then
    /// the step is halved; so is one in which slip may have run away, until that shows or there is a step without, and one in which slip
    /// begins whose time is looked for. What the initial stress
    /// pulls at the sides of faces beyond its mean ends where they open: the step goes on from what it found until both agree.
    ///
    /// # Errors
    /// [`StepFailure`] with the reason of the last attempt; `state` is still good.
    pub fn advance(
        &mut self,
        state: &State,
        observer: &mut dyn Observer,
    ) -> Result<Accepted, Box<StepFailure>> {
        let solver = self.problem.body().solver;
        let weakens = self.problem.weakens();
        let mut limits = Limits::new(self.times.shortest(state, solver.max_cuts));
        let cuts_are_many = solver.max_cuts >= COMPARED;
        let (mut log, mut attempts, mut cuts) = (Log::default(), 0, 0);
        let mut increment = state.next;
        let mut search = Search::new(self, state);
        if let Some(search) = search.as_ref().filter(|search| search.narrows()) {
            increment = search.increment(state, increment);
            limits = limits.below(increment);
        }
        // increments of attempts in which slip ran away, and its largest slip
        let mut runaways: Vec<[f64; 2]> = Vec::new();
        let mut runs_away = None;
        let primed = match &state.creep {
            Some(own) => self.take_step(own.step),
            None => Ok(()),
        };
        match &mut self.springs {
            Some(springs) => springs.begin_step(state.prepared.as_ref()),
            None => self.linear.begin_step(state),
        }
        if let Err(reason) = primed {
            let target = self.times.target(state, increment);
            return Err(StepFailure::new(state, target, cuts, reason, log));
        }
        loop {
            let target = self.times.target(state, increment);
            let is_shortest = 0.5 * length(state, target) < limits.shortest;
            log.asks = is_shortest && cuts_are_many && solver.unstable == Unstable::Stop;
            let outcome = self.attempt_twice(state, target, &mut attempts, &mut log, observer);
            match outcome {
                Ok((mut settled, load)) => {
                    let at = length(state, target);
                    let own = (state, target);
                    let looks = search.as_mut();
                    let halved = looks.and_then(|s| s.halved(self, own, &settled, increment));
                    if let (Some(half), Some(search)) = (halved, &search) {
                        increment = half;
                        limits = limits.below(half);
                        cuts += 1;
                        log.events.push(Event::Cut {
                            reason: search.reason(self),
                            next: half,
                        });
                        if let Some(patch) = settled.unstable.take() {
                            runaways.push([at, patch.slip]);
                            runs_away = Some(patch);
                        }
                        continue;
                    }
                    if let Some(patch) = settled.unstable.take() {
                        runaways.push([at, patch.slip]);
                        let compare = runaways.len() <= COMPARED && 0.5 * at >= limits.compared;
                        if 0.5 * at >= limits.shortest || compare {
                            increment = 0.5 * at;
                            cuts += 1;
                            log.events.push(Event::Cut {
                                reason: Failure::Unstable(patch.clone()).to_string(),
                                next: increment,
                            });
                            runs_away = Some(patch);
                            continue;
                        }
                        if is_shown(&runaways) {
                            match solver.unstable {
                                Unstable::Stop => {
                                    log.events.extend(begun(self, &search));
                                    let reason = Failure::Unstable(patch);
                                    return Err(StepFailure::new(state, target, cuts, reason, log));
                                }
                                Unstable::Arrest => {
                                    log.events.push(Event::Arrested {
                                        patch: patch.clone(),
                                    });
                                    settled.unstable = Some(patch);
                                }
                            }
                        }
                    }
                    let next = self.times.next(state, target, increment, cuts);
                    let mut done = self.accept(state, target, settled, &load, log, cuts, next);
                    if let Some(search) = search {
                        search.accepts(self, &mut done);
                    }
                    return Ok(done);
                }
                Err(reason)
                    if reason.may_be_shortened(weakens)
                        && !log.is_spent(solver.max_krylov)
                        && 0.5 * length(state, target) >= limits.least(&reason, weakens) =>
                {
                    increment = 0.5 * length(state, target);
                    cuts += 1;
                    log.events.push(Event::Cut {
                        reason: reason.to_string(),
                        next: increment,
                    });
                }
                Err(reason)
                    if reason.may_be_cut()
                        && (runs_away.is_none() || solver.unstable == Unstable::Arrest)
                        && search.as_ref().is_some_and(Search::narrows) =>
                {
                    // no shorter step settles: the time of the onset stays as it is known
                    let longer = search.as_mut().map(|search| search.gives_up(state));
                    increment = longer.unwrap_or(state.next);
                    limits = Limits::new(self.times.shortest(state, solver.max_cuts));
                    log.events.push(Event::Retry {
                        reason: reason.to_string(),
                    });
                }
                Err(reason) => {
                    // one that no halving has avoided
                    let stops = solver.unstable == Unstable::Stop && cuts_are_many;
                    let tried = log.unstable.take();
                    let settled = runs_away.filter(|_| stops && is_shown(&runaways));
                    let patch = tried.or(settled.filter(|_| reason.is_of_states()));
                    // where f64 has no digits to set up the stuck body, failing says nothing of what slipping faces hold
                    let is_firm = !self.resources().fallbacks.lacks_digits();
                    let reason = reason.explained(self.problem.body(), &log.states, is_firm);
                    let reason = match (reason, patch) {
                        // what open faces let go is free whatever slips
                        (loose @ Failure::Loose { slipping: 0, .. }, _) => loose,
                        (_, Some(patch)) => {
                            log.events.extend(begun(self, &search));
                            Failure::Unstable(patch)
                        }
                        (reason, None) => reason,
                    };
                    return Err(StepFailure::new(state, target, cuts, reason, log));
                }
            }
        }
    }

    /// Closed faces in stick; if that fails, every face in stick.
    fn attempt_twice(
        &mut self,
        state: &State,
        target: Target,
        attempts: &mut usize,
        log: &mut Log,
        observer: &mut dyn Observer,
    ) -> Result<(Settled, Load), Failure> {
        let closed_stick: Vec<ContactState> = state
            .states
            .iter()
            .map(|s| match s {
                ContactState::Open => ContactState::Open,
                _ => ContactState::Stick,
            })
            .collect();
        let any_open = closed_stick.contains(&ContactState::Open);
        let first = self.attempt(state, target, closed_stick, attempts, log, observer);
        match first {
            Err(reason) if any_open && reason.may_be_projected() => {
                log.events.push(Event::Retry {
                    reason: reason.to_string(),
                });
                let all_stick = vec![ContactState::Stick; state.states.len()];
                self.attempt(state, target, all_stick, attempts, log, observer)
            }
            outcome => outcome,
        }
    }

    fn attempt(
        &mut self,
        state: &State,
        target: Target,
        states: Vec<ContactState>,
        attempts: &mut usize,
        log: &mut Log,
        observer: &mut dyn Observer,
    ) -> Result<(Settled, Load), Failure> {
        self.take_step(step_from(state, target))?;
        let problem = &self.problem;
        let before = problem.loads().at(state.time, state.loaded);
        let crept = state.creep.is_some().then(|| self.displacement(state));
        let load_beside = |opened: &Opened| {
            let mut load = (problem.loads()).beside(opened, target.time, target.loaded);
            if let Some(u) = &crept {
                problem.remember(state, u, &mut load);
            }
            load
        };
        let mut opened = problem.loads().released(&state.released);
        let mut load = load_beside(&opened);
        // tractions of the initial stress come with the loads of time 0
        let mut t = state.t.clone();
        axpy(target.loaded - state.loaded, &self.initial_traction, &mut t);
        let mut reference = t.clone();
        for (r, t0) in reference.iter_mut().zip(&self.initial_traction).step_by(3) {
            *r = target.loaded * t0;
        }
        // H acts on the traction of the rock, which knows nothing of pressures that differ from face to face
        let uneven = problem.body().uneven_pressures(target.time);
        for (r, p) in reference.iter_mut().step_by(3).zip(uneven.iter().flatten()) {
            *r += target.loaded * p;
        }
        let mut start = Start {
            jump: problem.jumps(&state.u, &before),
            slip: state.slip.clone(),
            path: state.path.clone(),
            t: reference,
            torn: Vec::new(),
            limits_at: Vec::new(),
        };
        let times = [state.time, target.time];
        let from = (&state.p[..], &state.states[..], &start.jump[..]);
        let flow = problem.flow_step(times, from);
        let mut raising = Raising::new();
        let pressures = flow.as_ref().map(|_| &state.p[..]);
        let loads = [&before, &load];
        let scale = problem.scale(&t, loads, pressures).max(state.force);
        let mut from = (
            states,
            Iterate::new([&state.u, &t, &state.p], flow.as_ref()),
        );
        let mut turned = Vec::new();
        // what was found with faces torn, while it is tried whether they hold with their cohesion from there on
        let mut without: Option<Settled> = None;
        let mut tries = true;
        loop {
            let given = raising.given(problem, flow.as_ref());
            let attempt = Attempt {
                problem,
                start: &start,
                load: &load,
                scale,
                traction: state.traction,
                size: state.size,
                held: problem.loads().held_at(target.time, target.loaded),
                flow: given.as_deref(),
                holds: raising.holds,
                step: state.step,
                attempt: *attempts,
            };
            *attempts += 1;
            let (states, x) = from.clone();
            let settled = match &mut self.springs {
                Some(springs) => stable(&attempt, states, x, springs, log, observer),
                None => stable(&attempt, states, x, &mut self.linear, log, observer),
            };
            let told = match &mut self.springs {
                Some(springs) => &mut springs.resources.fallbacks.events,
                None => &mut self.linear.resources.fallbacks.events,
            };
            log.events.append(told);
            let settled = match (settled, without.take()) {
                (Ok(whole), Some(torn)) if whole.torn_faces().len() < torn.torn_faces().len() => {
                    Ok(whole)
                }
                (Ok(_), Some(torn)) => Ok(torn),
                (Err(reason), Some(torn)) if !matches!(reason, Failure::Stopped) => Ok(torn),
                (settled, _) => settled,
            };
            match settled {
                Err(Failure::Torn { faces }) => {
                    start.torn.resize(problem.faces().len(), false);
                    faces.iter().for_each(|f| start.torn[*f] = true);
                }
                Err(reason) => {
                    if let Some(reason) = raising.goes_back(problem, flow.as_ref(), (reason, log)) {
                        return Err(reason);
                    }
                }
                Ok(settled) if raising.is_partial() => {
                    raising.goes_on();
                    from = (settled.states, settled.x);
                }
                Ok(settled)
                    if tries && !settled.torn_faces().is_empty() && settled.unstable.is_none() =>
                {
                    tries = false;
                    start.torn.clear();
                    from = (settled.states.clone(), settled.x.clone());
                    without = Some(settled);
                }
                Ok(mut settled) => {
                    attempt.require_mass(&settled.x.p)?;
                    let now = problem.loads().opened(&settled.states);
                    let is_last = settled.unstable.is_some();
                    if is_last || !opened.follow(&now, &mut turned) {
                        settled.released = problem.loads().by_face(&opened);
                        log.events.extend(raising.told());
                        let faces = settled.torn_faces();
                        if !faces.is_empty() {
                            log.events.push(Event::Torn { faces });
                        }
                        return Ok((attempt.with_flow(settled, target.loaded), load));
                    }
                    load = load_beside(&opened);
                    start.torn = settled.torn;
                    from = (settled.states, settled.x);
                }
            }
        }
    }

    /// Where the number of the linear system to stop at is written; none with springs.
    pub(super) fn wanted_system(&mut self) -> Option<&mut Option<usize>> {
        self.springs.is_none().then_some(&mut self.linear.wanted)
    }

    /// The system that the last step stopped at.
    pub(super) fn take_system(&mut self) -> Option<NewtonSystem> {
        self.linear.wanted = None;
        self.linear.found.take()
    }
}
