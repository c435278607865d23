//! The active set: states change until every face agrees with its own.

use super::accuracy::Accuracy;
use super::judge::{Judge, or_closing};
use super::linear::Linear;
use super::newton::{Attempt, Iterate};
use super::proximal::Proximal;
use super::rounds::{Ended, Search};
use super::{Event, Failure, Instability, LinearRecord};
use crate::contact::ContactState;
use crate::flow::{FlowRecord, WellRecord};
use fracas_operators::Fields;
use fracas_solvers::{Observer, Step};

/// Krylov iterations of a step, over the most of one system, from which on it is given up. Unit: 1.
const SPENT: usize = 50;

/// Traction that would close the widest jump, over the largest traction, beyond which a body is taken to fly away. Unit: 1.
const AWAY: f64 = 1e5;

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
    /// What wells did.
    pub(super) wells: Vec<WellRecord>,
}

/// What an attempt costs and tells, also when it fails.
#[derive(Default)]
pub(super) struct Log {
    pub(super) rounds: usize,
    pub(super) linear: Vec<LinearRecord>,
    pub(super) events: Vec<Event>,
    /// States of the last round.
    pub(super) states: Vec<ContactState>,
    /// Faces that changed in the last round in which some did.
    pub(super) changing: Vec<usize>,
    /// What would run away at the states of an attempt that failed.
    pub(super) unstable: Option<Box<Instability>>,
}

impl Log {
    /// True where a step has taken so many Krylov iterations that it is given up; `most` are those of one system.
    pub(super) fn is_spent(&self, most: usize) -> bool {
        let iterations = self.linear.iter().map(|l| l.iterations);
        iterations.sum::<usize>() >= SPENT * most
    }

    /// A round failed: proximal iterations take over, or go on.
    pub(super) fn failed(&mut self, round: usize, failure: &Failure) {
        self.events.push(Event::Projection {
            round: round + 1,
            reason: failure.to_string(),
        });
    }
}

/// Rounds of Newton and new states; where states return, still change after `patience` rounds, or Newton fails at those at
/// hand, proximal iterations towards tractions in Coulomb's cones, after whose states the rounds go on.
///
/// There H does not lose what it had: it acts on every jump that a state since then constrained. Rounds return where H of
/// a face that opens drops out of its neighbours' rows, so that it is in slight tension when closed and overlaps when open.
pub(super) fn active_set(
    attempt: &Attempt<'_>,
    states: Vec<ContactState>,
    mut x: Iterate,
    linear: &mut Linear,
    log: &mut Log,
    observer: &mut dyn Observer,
) -> Result<Settled, Failure> {
    let problem = attempt.problem;
    let states = attempt.opened(states);
    let most = problem.body().solver.max_active;
    let settings = problem.body().solver.rounds;
    let mut judge = Judge::new(attempt, states.len());
    let mut search = Search {
        attempt,
        judge: &mut judge,
        accuracy: Accuracy::new(attempt),
        linear,
        observer,
    };
    let (from, first) = (x.clone(), log.rounds + 1);
    let patience = settings.patience.min(most);
    let (mut form, why) = match search.rounds(states, &mut x, None, patience, log)? {
        Ended::Settled(found) => return Ok(search.settled(*found, x)),
        // linear equations that cannot be solved are no matter of states, and those at the start no matter of the load
        Ended::Not(_, Some(why)) if attempt.is_linear(&log.states) => {
            return Err(match log.rounds == first && why.may_be_cut() {
                true => Failure::Unsolvable(Box::new(why)),
                false => why,
            });
        }
        Ended::Not(form, why) => (form, why),
    };
    // an iterate that Newton left is no better than the start
    if !x.u.iter().chain(&x.t).chain(&x.p).all(|v| v.is_finite()) {
        x = from;
    }
    // pressures stay where they are until a round settles
    let pressed = attempt.pressed(&x);
    let frozen = attempt.at_load(pressed.as_ref());
    let mut proximal = Proximal::new(&frozen, search.linear, &mut x);
    let mut h = problem.stabilization(&form);
    let (mut before, mut tried, mut since) = (Vec::new(), Vec::new(), 0);
    let last = log.rounds + most - patience;
    let max_krylov = problem.body().solver.max_krylov;
    while log.rounds < last && !log.is_spent(max_krylov) {
        let round = log.rounds;
        log.rounds += 1;
        let found = proximal.iterate(
            h.as_ref(),
            round,
            &mut x,
            &mut log.linear,
            &mut search.linear.resources,
            search.observer,
        )?;
        let torn = proximal.torn();
        if !torn.is_empty() {
            return Err(Failure::Torn { faces: torn });
        }
        let changed = count_changes(&found, &before);
        log.states.clone_from(&found);
        let step = Step::Round {
            round: round + 1,
            changed,
        };
        if search.observer.observe(&step).is_break() {
            return Err(Failure::Stopped);
        }
        let jumps = problem.jumps(&x.u, attempt.load);
        if or_closing(0.0, &jumps, problem.compliance()) > AWAY * search.judge.traction {
            break;
        }
        let grown = grow(&mut form, &found);
        if grown {
            h = problem.stabilization(&form);
        }
        since += 1;
        let again = changed == 0 && !grown && (found != tried || since >= settings.again);
        before = found;
        if !again {
            continue;
        }
        tried.clone_from(&before);
        since = 0;
        let mut y = x.clone();
        let fixed = Some(h.as_ref());
        match search.rounds(before.clone(), &mut y, fixed, settings.finishing, log)? {
            // H acts on all that these states constrain
            Ended::Settled(found) if !grow(&mut form, &found.states) => {
                return Ok(search.settled(*found, y));
            }
            Ended::Settled(..) => h = problem.stabilization(&form),
            Ended::Not(..) => {}
        }
    }
    Err(why.unwrap_or_else(|| Failure::ActiveSet {
        rounds: log.rounds,
        faces: log.changing.clone(),
    }))
}

/// Faces whose states differ; all where there was none before.
fn count_changes(states: &[ContactState], before: &[ContactState]) -> usize {
    match before.len() == states.len() {
        true => states.iter().zip(before).filter(|(a, b)| a != b).count(),
        false => states.len(),
    }
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
