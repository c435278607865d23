//! Steps beside a flow that fail: faces that return are held, and pressures that are given, where they are too far from those of the fluid, are
//! raised in parts, each from what was found before.

use super::active_set::Log;
use super::{ContactProblem, Event, Failure};
use crate::flow::FlowStep;
use std::borrow::Cow;

/// Smallest part in which they are raised; smaller ones finish nothing more where fluid is held under faces that open. Unit: 1.
const SMALLEST: f64 = 1.0 / 32.0;

/// Attempts of a step beside the first. Unit: 1.
const ATTEMPTS: usize = 24;

/// These attempts are made while a step has spent no more than one in so many of the iterations at which it is given up. Unit: 1.
const BUDGET: usize = 4;

/// How far given pressures have come from those of the fluid at the start of the step, as shares of the way.
pub(super) struct Raising {
    /// At which a solution has been found.
    reached: f64,
    /// That is tried.
    tried: f64,
    /// Solutions that have been found on the way.
    parts: usize,
    /// Attempts that are left.
    left: usize,
    /// Why the whole way fails at once, where it does.
    reason: Option<Failure>,
    /// That of [`Attempt::holds`](super::newton::Attempt::holds): the second way of every part.
    pub(super) holds: bool,
}

impl Raising {
    /// The whole way at once.
    pub(super) fn new() -> Self {
        Self {
            reached: 0.0,
            tried: 1.0,
            parts: 0,
            left: ATTEMPTS,
            reason: None,
            holds: false,
        }
    }

    /// What is given in the attempt at hand.
    pub(super) fn given<'s>(
        &self,
        problem: &ContactProblem<'_>,
        step: Option<&'s FlowStep>,
    ) -> Option<Cow<'s, FlowStep>> {
        match problem.balance() {
            Some(balance) if self.is_partial() => {
                step.map(|step| Cow::Owned(balance.raised(step, self.tried)))
            }
            _ => step.map(Cow::Borrowed),
        }
    }

    /// True where an attempt goes a part of the way.
    pub(super) fn is_partial(&self) -> bool {
        self.tried < 1.0
    }

    /// An attempt has failed: nothing is left of it where something else is worth a try, else why the whole way at once fails. First faces that
    /// return are held, then, where pressures are given, half of the part is gone. A step is raised once, not once more after each
    /// halving: these leave what is given as it is.
    pub(super) fn goes_back(
        &mut self,
        problem: &ContactProblem<'_>,
        step: Option<&FlowStep>,
        (reason, log): (Failure, &mut Log),
    ) -> Option<Failure> {
        let most = problem.body().solver.max_krylov / BUDGET;
        let is_over = log.is_spent(most) || !reason.may_be_cut();
        let (Some(balance), Some(step), false) = (problem.balance(), step, is_over) else {
            let first = (self.reason.take()).filter(|_| !matches!(reason, Failure::Stopped));
            return Some(first.unwrap_or(reason));
        };
        self.reason.get_or_insert(reason);
        if !std::mem::replace(&mut self.holds, true) {
            return None;
        }
        let is_whole = self.reached == 0.0 && !self.is_partial();
        let worth = match is_whole {
            true => !log.raised && balance.raised(step, 0.0) != *step,
            false => self.left > 0 && self.part() >= 2.0 * SMALLEST,
        };
        if !worth {
            return self.reason.take();
        }
        log.raised = true;
        self.holds = false;
        self.tried = self.reached + 0.5 * self.part();
        self.left -= 1;
        None
    }

    fn part(&self) -> f64 {
        self.tried - self.reached
    }

    /// A part of the way has been gone: the next is twice as long, if so much is left.
    pub(super) fn goes_on(&mut self) {
        let part = self.part();
        self.reached = self.tried;
        self.tried = (self.reached + 2.0 * part).min(1.0);
        self.parts += 1;
        self.holds = false;
    }

    /// The whole way has been gone; it is told where it was in parts.
    pub(super) fn told(&mut self) -> Option<Event> {
        let reason = self.reason.take().filter(|_| self.parts > 0)?.to_string();
        let parts = self.parts + 1;
        Some(Event::Raised { parts, reason })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::elasticity::Elastic;
    use crate::flow::{Channel, Given, Place, Source};
    use crate::mesh::{BoxGrid, PlaneFracture};
    use crate::scene::sample::{Sample, Side, fluid};
    use crate::scene::{Body, TimeTable};

    /// A closed plane with a pressure or a rate on one of its faces.
    fn body(given: Given) -> Body {
        let mut grid = BoxGrid::uniform([0.0; 3], [2.0; 3], [2; 3]);
        grid.fractures = vec![PlaneFracture::through("f", 2, 1.0)];
        let sample = Sample {
            grid,
            rocks: vec![Elastic {
                young: 1e9,
                poisson: 0.2,
            }],
            sides: [0, 2, 4].map(|side| (side, Side::Roller)).into(),
            angle: 30.0,
        };
        let mut body = sample.body();
        let channel = Channel {
            conductivity: 1e-13,
            directed: None,
            storage: 1e-12,
            initial_pressure: 0.0,
        };
        let mut fluid = fluid(&body, 1e-3, channel);
        let at = |x: [f64; 3]| (0..2).all(|d| (x[d] - 0.5).abs() < 1e-9);
        let mut faces = body.fractures.faces.iter();
        let face = faces.position(|f| at(f.center)).unwrap();
        fluid.sources.push(Source {
            place: Place::Faces(vec![face as u32]),
            given,
            level: None,
            history: Body::ALWAYS,
        });
        body.fluid = Some(fluid);
        body.time = Some(TimeTable { end: 1.0, steps: 1 });
        body
    }

    fn failure() -> Failure {
        Failure::ActiveSet {
            rounds: 3,
            faces: vec![1],
        }
    }

    /// A share, and whether faces are held.
    type Way = (f64, bool);

    /// Ways that are tried where those fail that `fails`, and how it ends.
    fn tried(
        given: Given,
        fails: impl Fn(f64, bool) -> bool,
    ) -> (Vec<Way>, Result<Option<Event>, Failure>) {
        let body = body(given);
        let problem = ContactProblem::new(&body).unwrap();
        let states = vec![crate::contact::ContactState::Stick; 4];
        let step = problem.flow_step([0.0, 1.0], (&[0.0; 4], &states, &[0.0; 12]));
        let (mut raising, mut log, mut ways) = (Raising::new(), Log::default(), Vec::new());
        loop {
            ways.push((raising.tried, raising.holds));
            let given = raising.given(&problem, step.as_ref()).unwrap();
            let held = given.held.iter().flatten().next();
            assert!(held.is_none_or(|p| (p - 1e6 * raising.tried).abs() < 1e-6));
            if fails(raising.tried, raising.holds) {
                if let Some(reason) =
                    raising.goes_back(&problem, step.as_ref(), (failure(), &mut log))
                {
                    return (ways, Err(reason));
                }
            } else if raising.is_partial() {
                raising.goes_on();
            } else {
                return (ways, Ok(raising.told()));
            }
        }
    }

    #[test]
    fn a_step_that_fails_holds_faces_then_goes_parts_of_the_way_and_says_so() {
        let pressure = Given::Pressure(1e6);
        let (ways, end) = tried(pressure, |_, _| false);
        assert_eq!((&ways[..], end.unwrap()), (&[(1.0, false)][..], None));
        let (ways, end) = tried(pressure, |_, holds| !holds);
        assert_eq!((ways.len(), end.unwrap()), (2, None));
        // a quarter at a time goes
        let from = std::cell::Cell::new(0.0);
        let (ways, end) = tried(pressure, |share, _| {
            let fails = share - from.get() > 0.3;
            if !fails {
                from.set(share);
            }
            fails
        });
        let whole = [
            (1.0, false),
            (1.0, true),
            (0.5, false),
            (0.5, true),
            (0.25, false),
        ];
        assert_eq!(ways[..5], whole);
        assert_eq!(ways.last(), Some(&(1.0, false)));
        assert!(
            matches!(end, Ok(Some(Event::Raised { parts: 4, .. }))),
            "{end:?}"
        );
    }

    #[test]
    fn a_step_that_fails_in_every_part_fails_with_its_own_reason_after_a_bounded_number_of_attempts()
     {
        let (ways, end) = tried(Given::Pressure(1e6), |_, _| true);
        assert_eq!(end.unwrap_err().to_string(), failure().to_string());
        assert_eq!((ways.len(), ways.last()), (12, Some(&(SMALLEST, true))));
        // rates are not raised
        let (ways, end) = tried(Given::Rate(1e-9), |_, _| true);
        assert_eq!(
            (ways, end.is_err()),
            (vec![(1.0, false), (1.0, true)], true)
        );
    }
}
