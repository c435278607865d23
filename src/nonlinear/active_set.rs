//! The active set: states change until every face agrees with its own.

use super::accuracy::Accuracy;
use super::judge::Judge;
use super::linear::Linear;
use super::newton::{Attempt, Iterate};
use super::returning::Returning;
use super::rounds::{Ended, Found, Search};
use super::{Event, Failure, Instability, LinearRecord};
use crate::contact::ContactState;
use crate::flow::{FlowRecord, WellRecord};
use fracas_operators::Fields;
use fracas_operators::sparse::Csr;
use fracas_solvers::Observer;

/// Krylov iterations of a step, over the most of one system, from which on it is given up. Unit: 1.
const SPENT: usize = 50;

/// Rounds that finish where a fluid opens fractures, at least: its front goes a ring or two in one. Unit: 1.
const FRONTS: usize = 40;

/// Times that what H is held on may grow before another remedy is taken.
const FORMS: usize = 4;

/// What an attempt found.
pub(super) struct Settled {
    pub(super) states: Vec<ContactState>,
    pub(super) x: Iterate,
    /// Largest force and traction so far.
    pub(super) force: f64,
    pub(super) traction: f64,
    /// Jumps that the laws of the faces see, three per face [m].
    pub(super) effective: Vec<f64>,
    /// [`slip_violation`](super::judge::slip_violation()).
    pub(super) slip_violation: f64,
    /// Largest norm of every field so far.
    pub(super) size: Fields<f64>,
    /// Errors of the fields relative to them; NaN where only residuals are judged.
    pub(super) error: Fields<f64>,
    /// What ran away on the way there.
    pub(super) unstable: Option<Box<Instability>>,
    /// Where the fluid went, where one flows.
    pub(super) flow: Option<FlowRecord>,
    /// [Joined](crate::flow::FlowStep::joined) faces.
    pub(super) joined: Vec<bool>,
    /// That of [`State::released`](super::State::released), once the load agrees with the states.
    pub(super) released: Vec<bool>,
    /// Faces whose cohesion is lost; empty: none.
    pub(super) torn: Vec<bool>,
    /// What wells did.
    pub(super) wells: Vec<WellRecord>,
}

impl Settled {
    /// Closed faces without their cohesion.
    pub(super) fn torn_faces(&self) -> Vec<usize> {
        let holds_less = |f: &usize| self.torn[*f] && self.states[*f] != ContactState::Open;
        (0..self.torn.len()).filter(holds_less).collect()
    }
}

/// What an attempt costs and tells, also when it fails.
#[derive(Default)]
pub(super) struct Log {
    pub(super) rounds: usize,
    pub(super) linear: Vec<LinearRecord>,
    pub(super) events: Vec<Event>,
    /// States of the last round.
    pub(super) states: Vec<ContactState>,
    /// What fails is asked whether slip runs away: no shorter step follows.
    pub(super) asks: bool,
    /// The states of the attempt in which most faces that weaken slip, where that is asked.
    pub(super) most_slipping: Vec<ContactState>,
    /// Faces that changed in the last round in which some did.
    pub(super) changing: Vec<usize>,
    /// What would run away at the states of an attempt that failed.
    pub(super) unstable: Option<Box<Instability>>,
    /// Given pressures have been [raised](super::raising::Raising) in parts.
    pub(super) raised: bool,
}

impl Log {
    /// True where a step has taken so many Krylov iterations that it is given up; `most` are those of one system.
    pub(super) fn is_spent(&self, most: usize) -> bool {
        let iterations = self.linear.iter().map(|l| l.iterations);
        iterations.sum::<usize>() >= SPENT * most
    }

    /// States that a round tries, or that a step of Newton on all faces has led to.
    pub(super) fn tries(&mut self, attempt: &Attempt<'_>, states: &[ContactState]) {
        self.states.clear();
        self.states.extend_from_slice(states);
        if !self.asks {
            return;
        }
        let weakens =
            |f: &usize| (attempt.problem.friction_in(*f, attempt.start).weakening).is_some();
        let slipping = |states: &[ContactState]| {
            let slip = (0..states.len()).filter(|f| states[*f].constrained() == 1);
            slip.filter(weakens).count()
        };
        if self.most_slipping.is_empty() || slipping(states) > slipping(&self.most_slipping) {
            self.most_slipping.clone_from(&self.states);
        }
    }

    /// The states of rounds, as they stand.
    fn tried(&self) -> [Vec<ContactState>; 2] {
        [self.states.clone(), self.most_slipping.clone()]
    }

    /// Those of before stand again.
    fn restore(&mut self, [states, most_slipping]: [Vec<ContactState>; 2]) {
        (self.states, self.most_slipping) = (states, most_slipping);
    }

    /// A round failed: another remedy takes over.
    pub(super) fn failed(&mut self, round: usize, failure: &Failure) {
        self.events.push(Event::Projection {
            round: round + 1,
            reason: failure.to_string(),
        });
    }
}

/// Rounds of Newton and new states, which end where no face changes.
///
/// They return where H of a face that opens or slips drops out of its neighbours' rows, so that it is in slight tension when closed and
/// overlaps when open: then H is held on all that the states that return constrain, with flow at once ([`Returning`]). Where this does not settle,
/// or states still change after `patience` rounds, or Newton fails at those at hand, Newton on the [natural](super::natural::Natural) map solves the law of all
/// faces, H held on all of them, and rounds with the H of the states themselves follow. Where rounds settle with less than the H of their states,
/// or with faces that slip against their shear, they go on from there ([`made_better`](Search::made_better)). On how many faces H acts beyond
/// their states at last is told.
pub(super) fn active_set(
    attempt: &Attempt<'_>,
    states: Vec<ContactState>,
    mut x: Iterate,
    linear: &mut Linear,
    log: &mut Log,
    observer: &mut dyn Observer,
) -> Result<Settled, Failure> {
    let problem = attempt.problem;
    let states = attempt.opened(states, &x);
    let most = problem.body().solver.max_active;
    let settings = problem.body().solver.rounds;
    let mut judge = Judge::new(attempt, states.len());
    let mut search = Search {
        attempt,
        judge: &mut judge,
        accuracy: Accuracy::new(attempt),
        linear,
        damped: false,
        returning: Returning::new(attempt),
        rounding: None,
        observer,
    };
    let (from, first) = (x.clone(), log.rounds + 1);
    let held = states.iter().map(|state| match state {
        ContactState::Open => ContactState::Open,
        _ => ContactState::Stick,
    });
    let held: Vec<ContactState> = held.collect();
    let patience = settings.patience.min(most);
    let (form, why) = match search.rounds(states, &mut x, None, patience, log)? {
        Ended::Settled(found) => {
            let form = search.returning.form(&found.states);
            return search.made_better(*found, x, &form, log);
        }
        // linear equations that cannot be solved are no matter of states, and those at the start no matter of the load
        Ended::Not(_, Some(why)) if attempt.is_linear(&log.states) => {
            return Err(match log.rounds == first && why.may_be_projected() {
                true => Failure::Unsolvable(Box::new(why)),
                false => why,
            });
        }
        Ended::Not(form, why) => (form, why),
    };
    let returned = why.is_none() && log.rounds < first + patience - 1;
    // with flow it has been held while they did
    let holds = returned && attempt.flow.is_none();
    if holds && let Some(settled) = search.by_held_form(form, &x, log)? {
        return Ok(settled);
    }
    // pressures stay where they are until a round settles
    let is_finite = x.p.iter().all(|p| p.is_finite());
    let kept = search.returning.kept(attempt);
    let frozen = kept.attempt(attempt);
    let pressed = frozen.pressed(if is_finite { &x } else { &from });
    let frozen = frozen.at_load(pressed.as_ref());
    let last = log.rounds + most - patience;
    match search.by_natural_map(&frozen, (held, from), last, log)? {
        Some(settled) => Ok(settled),
        None => Err(attempt
            .overdrawn()
            .or(search.rounding)
            .or(why)
            .unwrap_or_else(|| Failure::ActiveSet {
                rounds: log.rounds,
                faces: log.changing.clone(),
            })),
    }
}

impl Search<'_, '_> {
    /// Rounds from these states with this H of all faces, and from there with that of the states they end at, or of those that return.
    pub(super) fn finished(
        &mut self,
        states: &[ContactState],
        x: &Iterate,
        h: Option<&Csr<f64>>,
        log: &mut Log,
    ) -> Result<Option<Settled>, Failure> {
        let most = self.finishing();
        let mut y = x.clone();
        let found = match self.rounds(states.to_vec(), &mut y, Some(h), most, log)? {
            Ended::Settled(found) => found,
            Ended::Not(_, why) => {
                self.rounding = why.filter(|why| matches!(why, Failure::Inaccurate { .. }));
                return Ok(None);
            }
        };
        let all = vec![ContactState::Stick; states.len()];
        let told = log.events.len();
        if beyond(&all, &found.states) > 0 {
            let mut z = y.clone();
            match self.rounds(found.states.clone(), &mut z, None, most, log) {
                Ok(Ended::Settled(own)) => {
                    let form = self.returning.form(&own.states);
                    return self.made_better(*own, z, &form, log).map(Some);
                }
                Ok(Ended::Not(form, None)) => {
                    if let Some(settled) = self.by_held_form(form, &y, log)? {
                        return Ok(Some(settled));
                    }
                }
                Err(Failure::Stopped) => return Err(Failure::Stopped),
                Ok(Ended::Not(..)) | Err(_) => {}
            }
            log.events.truncate(told);
        }
        Ok(Some(self.accepted(*found, y, &all, log)))
    }

    /// Rounds from x with H of what `form` constrains, and of what they constrain then.
    fn by_held_form(
        &mut self,
        mut form: Vec<ContactState>,
        x: &Iterate,
        log: &mut Log,
    ) -> Result<Option<Settled>, Failure> {
        let problem = self.attempt.problem;
        let most = self.finishing();
        for _ in 0..FORMS {
            let h = problem.stabilization(&form);
            let mut y = x.clone();
            let joined = self.returning.joins();
            match self.rounds(form.clone(), &mut y, Some(h.as_ref()), most, log) {
                Ok(Ended::Settled(found)) if !grow(&mut form, &found.states) => {
                    return Ok(Some(self.accepted(*found, y, &form, log)));
                }
                Ok(Ended::Settled(_)) => {}
                Ok(Ended::Not(other, None))
                    if grow(&mut form, &other) || self.returning.joins() > joined => {}
                Err(Failure::Stopped) => return Err(Failure::Stopped),
                Ok(Ended::Not(..)) | Err(_) => break,
            }
        }
        Ok(None)
    }

    /// What settles with H of the states themselves, from where rounds settled with less of it (states that return far from equilibrium may
    /// settle beside it), and with faces in stick that slip against their shear by less than their state is judged by. H acts on shear in stick
    /// alone: in slip the traction of such a face was another one by 13 % of the largest. Else what was found. With flow H is held from the
    /// first return on, and this is left out.
    fn made_better(
        &mut self,
        found: Found,
        x: Iterate,
        form: &[ContactState],
        log: &mut Log,
    ) -> Result<Settled, Failure> {
        if self.attempt.flow.is_some() {
            return Ok(self.accepted(found, x, form, log));
        }
        let mut better = found.states.clone();
        for f in found.against_shear(self, &x) {
            better[f] = ContactState::Stick;
        }
        if beyond(&better, form) == 0 {
            return Ok(self.accepted(found, x, form, log));
        }
        let (told, mut y) = (log.events.len(), x.clone());
        let size = self.accuracy.as_ref().map(|accuracy| accuracy.size);
        let (judge, damped, tried) = (self.judge.clone(), self.damped, log.tried());
        self.returning.holds_nothing = true;
        let most = self.finishing();
        let ended = self.rounds(better, &mut y, None, most, log);
        self.returning.holds_nothing = false;
        match ended {
            Ok(Ended::Settled(own)) => {
                // what was told of the rounding of another solution
                let events = log.events.split_off(told);
                log.events.retain(|e| !matches!(e, Event::Rounding { .. }));
                log.events.extend(events);
                let form = own.states.clone();
                Ok(self.accepted(*own, y, &form, log))
            }
            Err(Failure::Stopped) => Err(Failure::Stopped),
            Ok(Ended::Not(..)) | Err(_) => {
                log.events.truncate(told);
                log.restore(tried);
                (*self.judge, self.damped) = (judge, damped);
                if let (Some(accuracy), Some(size)) = (&mut self.accuracy, size) {
                    accuracy.size = size;
                }
                Ok(self.accepted(found, x, form, log))
            }
        }
    }

    /// Rounds that finish: front by front where a fluid opens fractures.
    fn finishing(&self) -> usize {
        let most = self.attempt.problem.body().solver.rounds.finishing;
        match self.attempt.flow {
            Some(_) => most.max(FRONTS),
            None => most,
        }
    }

    /// What was found with an H that acts on all that `form` constrains, and with faces that are joined or torn.
    fn accepted(&self, found: Found, x: Iterate, form: &[ContactState], log: &mut Log) -> Settled {
        let joined = self.returning.joined.iter().zip(&found.states);
        let joined = joined.filter(|(joined, s)| **joined && **s != ContactState::Open);
        let faces = beyond(form, &found.states).max(joined.count());
        if faces > 0 {
            log.events.push(Event::Stabilized { faces });
        }
        let faces = beyond(&found.states, form);
        if faces > 0 {
            log.events.push(Event::Unstabilized { faces });
        }
        self.settled(found, x)
    }
}

/// Number of faces of which `form` constrains more than their state.
fn beyond(form: &[ContactState], states: &[ContactState]) -> usize {
    let pairs = form.iter().zip(states);
    pairs
        .filter(|(form, s)| form.constrained() > s.constrained())
        .count()
}

/// `form` then constrains what `states` constrain, too; true where it did not.
fn grow(form: &mut [ContactState], states: &[ContactState]) -> bool {
    let mut grown = false;
    for (form, state) in form.iter_mut().zip(states) {
        if state.constrained() > form.constrained() {
            *form = *state;
            grown = true;
        }
    }
    grown
}
