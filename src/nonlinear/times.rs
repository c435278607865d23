//! The times of a run: a table, the corners of histories, and halves of their steps.

use super::stability::COMPARED;
use super::{Failure, Simulation, State};
use crate::scene::{Body, TimeTable};

/// Relative distance of two times that counts as none.
pub(super) const SAME_TIME: f64 = 1e-9;

/// Halvings beyond which a step has no length left.
const MAX_HALVINGS: usize = 60;

/// Distance to a time that counts as none [s]: relative to it, or to the nominal step where that is shorter.
fn apart(time: f64, nominal: f64) -> f64 {
    SAME_TIME * time.abs().min(nominal)
}

/// Where a step goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub(super) time: f64,
    pub(super) loaded: f64,
    /// The increment that was planned, where steps before have halved it: time [s] or share of the loads of time 0.
    pub(super) planned: Option<f64>,
}

/// How short the halvings of a step may leave it: time [s] or share of the loads of time 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// In general.
    pub(super) shortest: f64,
    /// Where slip may run away, which shorter steps show.
    pub(super) compared: f64,
}

impl Limits {
    pub(super) fn new(shortest: f64) -> Self {
        Self {
            shortest,
            compared: shortest * 0.5f64.powi(COMPARED as i32),
        }
    }

    /// The same for a step that is as short as `increment` for another reason.
    pub(super) fn below(self, increment: f64) -> Self {
        Self::new(self.shortest.min(increment))
    }

    /// What is left of a step that failed for a reason; states may settle closer to slip that `weakens` a fault.
    pub(super) fn least(self, reason: &Failure, weakens: bool) -> f64 {
        match weakens && reason.is_of_states() {
            true => self.compared,
            false => self.shortest,
        }
    }
}

/// Times that steps land on.
pub(super) struct Times {
    table: Option<TimeTable>,
    /// Times at which a history bends, increasing [s].
    corners: Vec<f64>,
    /// Those at which one jumps [s].
    jumps: Vec<f64>,
}

impl Times {
    pub(super) fn new(body: &Body) -> Self {
        let of_pores = body.pore_fields.iter();
        let corners = body.histories.iter().flat_map(|h| h.corners());
        let mut corners: Vec<f64> =
            (corners.chain(of_pores.clone().flat_map(|p| p.corners()))).collect();
        corners.sort_by(f64::total_cmp);
        let jumps = body.histories.iter().flat_map(|h| h.jumps());
        Self {
            jumps: jumps.chain(of_pores.flat_map(|p| p.jumps())).collect(),
            table: body.time,
            corners,
        }
    }

    /// True at the last time.
    pub(super) fn is_finished(&self, state: &State) -> bool {
        let end = self.table.map_or(0.0, |time| time.end);
        state.loaded >= 1.0 && state.time >= end
    }

    /// Steps from this time [s] and share of the loads of time 0 to the last time, where none is cut.
    pub(super) fn left(&self, time: f64, loaded: f64) -> usize {
        let (end, nominal) = self.table();
        let apart = |t: f64| apart(t, nominal);
        let is_ahead = |t: &f64| *t > time + apart(*t) && *t <= end + apart(*t);
        let steps = self.table.map_or(0, |time| time.steps);
        let of_table = |n: u32| end * f64::from(n) / f64::from(steps);
        // those of the table that are not ahead come first, and corners beside one of the table are none
        let (mut behind, mut ahead) = (0, steps);
        while behind < ahead {
            let n = behind + (ahead - behind) / 2 + 1;
            match is_ahead(&of_table(n)) {
                true => ahead = n - 1,
                false => behind = n,
            }
        }
        let is_alone = |c: &f64| {
            let near = (c / nominal).round().clamp(0.0, f64::from(steps)) as u32;
            near == 0 || (c - of_table(near)).abs() > apart(*c)
        };
        let mut corners: Vec<f64> = self.corners.clone();
        corners.retain(|c| is_ahead(c) && is_alone(c));
        corners.dedup_by(|a, b| *a - *b <= apart(*a));
        (steps - behind) as usize + corners.len() + usize::from(loaded < 1.0)
    }

    /// Last time and length of a nominal step [s].
    fn table(&self) -> (f64, f64) {
        self.table.map_or((0.0, 1.0), |time| {
            (time.end, time.end / f64::from(time.steps))
        })
    }

    /// The shortest step after `cuts` halvings: time [s] or share of the loads of time 0. A run that comes closer and closer
    /// to a time without equilibrium ends there.
    pub(super) fn shortest(&self, state: &State, cuts: usize) -> f64 {
        let share = 0.5f64.powi(cuts.min(MAX_HALVINGS) as i32);
        match state.loaded < 1.0 {
            true => share,
            false => self.table().1 * share,
        }
    }

    /// The state after `increment`, not beyond the next time of the table or corner of a history.
    pub(super) fn target(&self, state: &State, increment: f64) -> Target {
        let (end, nominal) = self.table();
        let whole = [1.0, nominal][usize::from(state.loaded >= 1.0)];
        let planned = (state.next < (1.0 - SAME_TIME) * whole).then_some(whole);
        if state.loaded < 1.0 {
            return Target {
                time: 0.0,
                loaded: (state.loaded + increment).min(1.0),
                planned,
            };
        }
        let apart = |t: f64| apart(t, nominal);
        let done = (state.time / nominal + SAME_TIME).floor();
        let steps = self.table.map_or(1.0, |time| f64::from(time.steps));
        // end · n/steps, the last one exactly the end, or a corner before it
        let next = end * ((done + 1.0) / steps).min(1.0);
        let is_ahead = |c: &&f64| **c > state.time + apart(**c);
        let corner = self.corners.iter().find(is_ahead);
        let next = corner
            .copied()
            .filter(|c| *c < next - apart(next))
            .unwrap_or(next);
        let time = state.time + increment;
        // a time of the table that rounding puts before a jump lies behind it
        let behind = |time: f64| {
            let is_own = |jump: &&f64| (*jump - time).abs() <= apart(**jump);
            let own = self.jumps.iter().find(is_own);
            own.map_or(time, |jump| time.max(*jump))
        };
        Target {
            time: if time >= next - apart(next) {
                behind(next)
            } else {
                time
            },
            loaded: 1.0,
            planned,
        }
    }

    /// The increment that the step after tries: twice this one unless it was cut.
    pub(super) fn next(&self, state: &State, target: Target, increment: f64, cuts: usize) -> f64 {
        let nominal = self.table().1;
        if state.loaded < 1.0 && target.loaded >= 1.0 {
            return nominal;
        }
        let longest = if state.loaded < 1.0 { 1.0 } else { nominal };
        let grown = if cuts == 0 {
            2.0 * increment
        } else {
            increment
        };
        grown.min(longest)
    }
}

impl Simulation<'_> {
    /// Steps from a state to the last time, where none is cut.
    pub fn steps_left(&self, state: &State) -> usize {
        self.times.left(state.time, state.loaded)
    }
}

/// Increment from a state to a target: time [s] or share of the loads of time 0.
pub(super) fn length(state: &State, target: Target) -> f64 {
    match state.loaded < 1.0 {
        true => target.loaded - state.loaded,
        false => target.time - state.time,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::active_set::Log;
    use super::super::{Failure, StepFailure};
    use super::*;
    use crate::scene::sample::Sample;
    use fracas_operators::random::Random;

    /// All times as a list, which a table of a thousand million steps has no room for.
    #[test]
    fn the_steps_that_are_left_are_those_of_all_times() {
        let r = &mut Random::new(3);
        for _ in 0..300 {
            let (end, steps) = (r.between(0.1, 1e3), 1 + r.below(30) as u32);
            let of_table = |n: u32| end * f64::from(n) / f64::from(steps);
            let mut corners: Vec<f64> = (0..r.below(6))
                .map(|_| match r.chance(0.5) {
                    true => of_table(r.below(steps as usize + 1) as u32) * (1.0 + 1e-12),
                    false => r.between(-0.1, 1.2) * end,
                })
                .collect();
            corners.sort_by(f64::total_cmp);
            let mut all: Vec<f64> = (1..=steps).map(of_table).chain(corners.clone()).collect();
            let nominal = end / f64::from(steps);
            let times = Times {
                table: Some(TimeTable { end, steps }),
                corners,
                jumps: Vec::new(),
            };
            let time = match r.chance(0.3) {
                true => 0.0,
                false => r.one_of(&all).max(0.0),
            };
            let apart = |t: f64| apart(t, nominal);
            all.retain(|t| *t > time + apart(*t) && *t <= end + apart(*t));
            all.sort_by(f64::total_cmp);
            all.dedup_by(|a, b| *a - *b <= apart(*a));
            assert_eq!(times.left(time, 1.0), all.len());
        }
        let many = Times {
            table: Some(TimeTable {
                end: 1.0,
                steps: 4_000_000_000,
            }),
            corners: vec![0.3],
            jumps: Vec::new(),
        };
        assert_eq!(many.left(0.0, 0.0), 4_000_000_001);
        assert_eq!(many.left(0.5, 1.0), 2_000_000_000);
    }

    #[test]
    fn a_step_that_halvings_before_have_shortened_knows_what_was_planned() {
        let mut body = Sample::cycle().body();
        body.time = Some(Sample::CYCLE);
        let simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        let nominal = simulation.times.table().1;
        for (loaded, whole) in [(0.0, 1.0), (1.0, nominal)] {
            state.loaded = loaded;
            for (share, planned) in [(1.0, None), (0.25, Some(whole))] {
                state.next = share * whole;
                let target = simulation.times.target(&state, state.next);
                assert_eq!(target.planned, planned);
                let reason = Failure::Stopped;
                let failure = StepFailure::new(&state, target, 0, reason, Log::default());
                let told = failure.to_string();
                let beside = told.contains("after 0 halvings beside those of steps before");
                assert_eq!(beside, planned.is_some(), "{told}");
            }
        }
    }
}
