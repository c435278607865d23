//! Faces that open and close over and over within the rounds of a step with flow.

use super::cycling::Cycle;
use super::newton::{Attempt, Iterate};
use super::{Evaluation, Start};
use crate::contact::ContactState;
use crate::flow::FlowStep;

/// Times that a face opens or closes in rounds before it is held: it opens, closes and opens. With 4, 34 expensive runs of 188 random ones take
/// 8 % more Newton steps (of those that end within 40 s). Unit: 1.
const TURNS: u8 = 3;

/// What is held of faces that return, so that states settle.
///
/// H acts between closed faces and Y between open ones. Where a face opens, both change at once, and it may overlap when open and be in
/// tension when closed: no states solve that. Its rows of H stay those of the state among them that constrains least, or, where an attempt fails
/// so, of that which constrains most, and Y joins it to open faces. Runs that fail with one way mostly do not with the other: of 600 random networks
/// (`tests/known/flow_ends.rs`) 17 found no states with the second alone, 5 with both.
/// Faces that still return take turns: half of them change in a round, then a quarter, at last one, those farthest from
/// what they ask for first.
///
/// The limit of friction has such a jump, too: a closed face with cohesion holds shear up to a tension of nothing, an open one none. Closed it is
/// then in tension, and open, with its shear let go, it overlaps. A held face is torn: without cohesion to the end of the step.
///
/// # Source
/// Fewer changes where blocks of them return: J. Júdice, F. Pires, Comput. Oper. Res. 21 (1994) 587–596 (one at a time, for linear
/// complementarity); halves are a choice of this project.
#[derive(Clone, Debug, Default)]
pub(super) struct Returning {
    /// Of states that return, the one that constrains most counts for H, not the one that constrains least.
    most_constrained: bool,
    /// Where nothing flows states that return end the rounds, and nothing is held.
    pub(super) holds_nothing: bool,
    /// Per face the state whose rows of H it keeps; empty: none.
    form: Vec<Option<ContactState>>,
    /// Per face the state of whose rows of H it has no more; empty: none.
    free: Vec<Option<ContactState>>,
    /// [Joined](crate::flow::FlowStep::joined) faces; empty: none.
    pub(super) joined: Vec<bool>,
    /// Faces whose cohesion is lost; empty: none.
    torn: Vec<bool>,
    /// How often faces have opened or closed.
    turned: Vec<u8>,
    /// Held faces that open or close in a round, at most.
    most: Option<usize>,
}

/// The step and the start of an attempt with faces that are joined and torn.
pub(super) struct Kept {
    flow: Option<FlowStep>,
    start: Option<Start>,
}

impl Kept {
    /// The attempt with them.
    pub(super) fn attempt<'k>(&'k self, attempt: &Attempt<'k>) -> Attempt<'k> {
        Attempt {
            flow: self.flow.as_ref().or(attempt.flow),
            start: self.start.as_ref().unwrap_or(attempt.start),
            ..attempt.clone()
        }
    }
}

impl Returning {
    /// For an attempt.
    pub(super) fn new(attempt: &Attempt<'_>) -> Self {
        Self {
            most_constrained: attempt.holds,
            ..Self::default()
        }
    }

    /// Rounds begin anew; faces that are joined or torn stay so.
    pub(super) fn begin(&mut self) {
        *self = Self {
            most_constrained: self.most_constrained,
            holds_nothing: self.holds_nothing,
            joined: std::mem::take(&mut self.joined),
            torn: std::mem::take(&mut self.torn),
            ..Self::default()
        };
    }

    /// True where H of a face is held.
    pub(super) fn holds(&self) -> bool {
        !self.form.is_empty() || !self.free.is_empty()
    }

    /// What of it changes the equations of an attempt.
    pub(super) fn kept(&self, attempt: &Attempt<'_>) -> Kept {
        let flow = attempt.flow.filter(|_| !self.joined.is_empty());
        let torn = |start: &Start| {
            let torn = |f: usize| self.is_torn(f) || start.is_torn(f);
            (0..self.torn.len()).map(torn).collect()
        };
        let start = (!self.torn.is_empty()).then(|| Start {
            torn: torn(attempt.start),
            ..attempt.start.clone()
        });
        Kept {
            flow: flow.map(|step| step.joining(&self.joined)),
            start,
        }
    }

    /// Number of faces that are joined.
    pub(super) fn joins(&self) -> usize {
        self.joined.iter().filter(|joined| **joined).count()
    }

    /// States, or those that are held where these constrain more, or free where these constrain less: what H is that of.
    pub(super) fn form(&self, states: &[ContactState]) -> Vec<ContactState> {
        let of = |(f, state): (usize, &ContactState)| match (self.form.get(f), self.free.get(f)) {
            (Some(Some(form)), _) if form.constrained() > state.constrained() => *form,
            (_, Some(Some(free))) if free.constrained() < state.constrained() => *free,
            _ => *state,
        };
        states.iter().enumerate().map(of).collect()
    }

    /// Changes of states are made; true where faces have turned so often that more is held. Those that are `cohesive` are torn then.
    pub(super) fn see(
        &mut self,
        states: &[ContactState],
        changes: &[(usize, ContactState)],
        cohesive: impl Fn(usize) -> bool,
    ) -> bool {
        self.turned.resize(states.len(), 0);
        let mut grown = false;
        for (f, next) in changes.iter().filter(|c| turns(states, c)) {
            self.turned[*f] = self.turned[*f].saturating_add(1);
            if self.turned[*f] >= TURNS {
                let closed = match states[*f] {
                    ContactState::Open => *next,
                    closed => closed,
                };
                grown |= self.keep(*f, [ContactState::Open, closed], states.len());
                grown |= self.join(*f, states.len());
                grown |= cohesive(*f) && self.tear(*f, states.len());
            }
        }
        grown
    }

    /// States have returned: more is held, or fewer faces change in a round; false where one alone does already.
    pub(super) fn entered(&mut self, cycle: &Cycle, cohesive: impl Fn(usize) -> bool) -> bool {
        let faces = cycle.most_constrained.len();
        let mut grown = false;
        for f in &cycle.opened {
            grown |= self.join(*f, faces);
        }
        for f in &cycle.faces {
            let states = [cycle.least_constrained[*f], cycle.most_constrained[*f]];
            grown |= self.keep(*f, states, faces);
            let opens = cycle.opened.contains(f);
            grown |= opens && cohesive(*f) && self.tear(*f, faces);
        }
        if grown {
            return true;
        }
        let fewer = self.most.unwrap_or(cycle.faces.len()) / 2;
        self.most = Some(fewer.max(1));
        fewer > 0
    }

    /// States have returned where nothing flows: faces that change among them keep what H does in the state that constrains least. False
    /// where they have no more than that already.
    pub(super) fn freed(&mut self, cycle: &Cycle) -> bool {
        if self.holds_nothing {
            return false;
        }
        let mut grown = false;
        for f in &cycle.faces {
            let states = [cycle.least_constrained[*f], cycle.most_constrained[*f]];
            grown |= self.keep(*f, states, cycle.least_constrained.len());
        }
        grown
    }

    /// Of held faces, those that are to change: so many open or close as are farthest from what they ask for.
    pub(super) fn spare(
        &self,
        attempt: &Attempt<'_>,
        states: &[ContactState],
        (x, at): (&Iterate, &Evaluation),
        changes: &mut Vec<(usize, ContactState)>,
    ) {
        let Some(most) = self.most else {
            return;
        };
        let compliance = attempt.problem.compliance();
        // overlap, or what tension would open [m]
        let off = |f: usize| match states[f] {
            ContactState::Open => -at.jumps[3 * f],
            _ => x.t[3 * f] * compliance[f],
        };
        let is_kept = |f: usize| {
            let of = |kept: &[Option<ContactState>]| kept.get(f).is_some_and(Option::is_some);
            of(&self.form) || of(&self.free)
        };
        let held = changes
            .iter()
            .filter(|change| is_kept(change.0) && turns(states, change));
        let mut held: Vec<usize> = held.map(|change| change.0).collect();
        held.sort_by(|a, b| off(*b).total_cmp(&off(*a)));
        let later = &held[most.min(held.len())..];
        changes.retain(|(f, _)| !later.contains(f));
    }

    /// Keeps what H does of the least or the most constrained of the states of a face; true where it was not kept.
    fn keep(&mut self, f: usize, [least, most]: [ContactState; 2], faces: usize) -> bool {
        let (kept, state) = match self.most_constrained {
            true => (&mut self.form, most),
            false => (&mut self.free, least),
        };
        kept.resize(faces, None);
        let is_beyond = |own: ContactState| match self.most_constrained {
            true => state.constrained() > own.constrained(),
            false => state.constrained() < own.constrained(),
        };
        let grows = kept[f].is_none_or(is_beyond);
        if grows {
            kept[f] = Some(state);
        }
        grows
    }

    fn is_torn(&self, f: usize) -> bool {
        self.torn.get(f).copied().unwrap_or(false)
    }

    fn tear(&mut self, f: usize, faces: usize) -> bool {
        self.torn.resize(faces, false);
        !std::mem::replace(&mut self.torn[f], true)
    }

    fn join(&mut self, f: usize, faces: usize) -> bool {
        self.joined.resize(faces, false);
        !std::mem::replace(&mut self.joined[f], true)
    }
}

/// True where a face opens or closes.
fn turns(states: &[ContactState], (f, next): &(usize, ContactState)) -> bool {
    (*next == ContactState::Open) != (states[*f] == ContactState::Open)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ContactState::{Open, Slip, Stick};

    fn torn_faces(returning: &Returning) -> Vec<usize> {
        (0..returning.torn.len())
            .filter(|f| returning.is_torn(*f))
            .collect()
    }

    #[test]
    fn faces_that_turn_are_held_and_joined_once() {
        let mut returning = Returning {
            most_constrained: true,
            ..Returning::default()
        };
        assert!(!returning.see(&[Stick; 3], &[(1, Open), (2, Slip)], |_| false));
        assert!(!returning.see(&[Stick, Open, Slip], &[(1, Slip)], |_| false));
        assert_eq!(returning.form(&[Stick, Open, Open]), [Stick, Open, Open]);
        assert!(returning.see(&[Stick, Slip, Slip], &[(1, Open)], |_| false));
        assert_eq!(returning.form(&[Stick, Open, Open]), [Stick, Slip, Open]);
        assert_eq!((returning.joins(), returning.holds()), (1, true));
        // more constrained than what is held: it grows
        assert!(returning.see(&[Stick, Open, Slip], &[(1, Stick)], |_| false));
        assert!(!returning.see(&[Stick, Stick, Slip], &[(1, Open)], |_| false));
        assert_eq!(returning.form(&[Stick, Open, Open]), [Stick, Stick, Open]);
        returning.begin();
        assert_eq!((returning.joins(), returning.holds()), (1, false));
    }

    #[test]
    fn states_that_return_hold_more_and_then_change_fewer_faces() {
        let mut returning = Returning::default();
        let cycle = Cycle {
            period: 2,
            faces: vec![0, 1, 2, 3],
            most_constrained: vec![Stick, Slip, Slip, Stick, Open],
            least_constrained: vec![Open; 5],
            opened: vec![0, 1, 2, 3, 4],
        };
        assert!(returning.entered(&cycle, |_| false));
        assert_eq!((returning.joins(), returning.most), (5, None));
        for most in [2, 1] {
            assert!(returning.entered(&cycle, |_| false));
            assert_eq!(returning.most, Some(most));
        }
        assert!(!returning.entered(&cycle, |_| false));
    }

    #[test]
    fn what_opens_and_closes_over_and_over_is_torn_where_it_has_cohesion() {
        let cohesive = |f| f != 2;
        let mut returning = Returning::default();
        let changes = |state| [(1, state), (2, state)];
        assert!(!returning.see(&[Stick; 3], &changes(Open), cohesive));
        assert!(!returning.see(&[Stick, Open, Open], &changes(Slip), cohesive));
        assert!(returning.see(&[Stick, Slip, Slip], &changes(Open), cohesive));
        assert_eq!(torn_faces(&returning), [1]);
        let cycle = Cycle {
            period: 2,
            faces: vec![0, 1],
            most_constrained: vec![Stick, Slip, Slip],
            least_constrained: vec![Open, Slip, Slip],
            opened: vec![0],
        };
        // a face that only slips and sticks keeps its cohesion
        returning.begin();
        assert!(returning.entered(&cycle, cohesive));
        assert_eq!(torn_faces(&returning), [0, 1]);
    }
}
