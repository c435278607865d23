//! Which wells are at their rate, at their limit of pressure, or shut.

use super::sealed::is_closed;
use super::{Balance, Control, FlowStep, WellStep};
use crate::contact::ContactState;

/// Roundings of a potential that are no reason to switch. Unit: 1.
const ROUNDINGS: f64 = 16.0;

/// A well with a limit at the pressures at hand; all of it in the direction in which the well works.
#[derive(Clone, Copy)]
struct Room {
    /// Sign of the rate.
    sign: f64,
    /// How far the well could press if it brought nothing [Pa].
    left: f64,
    /// How far it has to press for its rate [Pa].
    needed: f64,
    /// What of these is rounding [Pa].
    noise: f64,
}

impl Room {
    /// The control that this asks for, from the one at hand to the next.
    fn control(&self, now: Control) -> Control {
        match now {
            Control::Rate if self.left < self.needed - self.noise => Control::Limit,
            Control::Limit if self.left > self.needed + self.noise => Control::Rate,
            Control::Limit if self.left < -self.noise => Control::Shut,
            Control::Shut if self.left > self.noise => Control::Limit,
            now => now,
        }
    }

    /// How far the pressure of the part is from where the well comes to its limit.
    fn distance(&self, now: Control) -> f64 {
        match now {
            Control::Rate => self.left - self.needed,
            _ => -self.left,
        }
    }
}

impl Balance<'_> {
    /// The controls that the wells of a step take at these pressures, all at once or the first `alone`; `None` where none switches.
    ///
    /// Each goes one step from rate over limit to shut, or back. In a sealed part, whose pressure nothing else gives, that well goes to its
    /// limit which comes to it first as the pressure rises where too much comes in, or falls where too little does. Where what comes in is
    /// what goes out at many pressures, the mean one is that nearest to the one before, the limit of a storage that goes to nothing.
    ///
    /// # Cost
    /// A visit of every edge, where wells have limits.
    ///
    /// # Source
    /// M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2002) 865–888 (primal–dual active sets, all at once); K. G. Murty, Linear
    /// Algebra Appl. 9 (1974) 65–108 (the first alone, which ends where all at once return); sealed parts are a choice of this project.
    pub(crate) fn switched(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
        alone: bool,
    ) -> Option<Vec<Control>> {
        if step.limited() == 0 {
            return None;
        }
        let rooms = self.rooms(states, jumps, p, step);
        let before = step.controls();
        let mut next = before.clone();
        for ((next, room), now) in next.iter_mut().zip(&rooms).zip(&before) {
            if let Some(room) = room {
                *next = room.control(*next);
            }
            if alone && next != now {
                break;
            }
        }
        let closed = self.closable.iter().filter(|part| is_closed(part, states));
        for part in closed {
            self.pin(part, (p, step), &rooms, &mut next);
        }
        (next != before).then_some(next)
    }

    /// Per well that has a limit.
    fn rooms(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> Vec<Option<Room>> {
        let mut rooms = vec![None; step.wells.len()];
        let [mobility, _] = self.mobility(states, jumps);
        let (potential, driven) = self.potentials(p, step);
        self.network.visit(&mobility, &potential, &driven, |edge| {
            let Some(number) = edge.well else { return };
            let well = &step.wells[number];
            rooms[number] = well.limit().map(|limit| Room {
                sign: well.rate.signum(),
                left: well.rate.signum() * (limit - edge.shut),
                needed: well.rate.abs() / edge.total,
                noise: ROUNDINGS * f64::EPSILON * (limit.abs() + edge.shut.abs()),
            });
        });
        rooms
    }

    /// Has a well at its limit give a closed part its pressure, where nothing else would.
    fn pin(
        &self,
        part: &[u32],
        (p, step): (&[f64], &FlowStep),
        rooms: &[Option<Room>],
        next: &mut [Control],
    ) {
        let wells: Vec<usize> = (step.wells_in(&self.fluid().wells, part))
            .map(|(i, _)| i)
            .collect();
        if wells.iter().any(|i| next[*i] == Control::Limit) {
            return;
        }
        let now = step.controlled(next);
        let brought = self.brought(part, &now, WellStep::inflow);
        let room = |i: &usize| rooms[*i].map(|room| (*i, room));
        let rooms = || wells.iter().filter_map(room);
        if brought == 0.0 {
            let rise = |f: &u32| {
                let f = *f as usize;
                self.faces[f].area * (p[f] - step.pressure[f])
            };
            let rise: f64 = part.iter().map(rise).sum();
            // one well alone was as good as at its rate, or shut: it leaves its limit where the pressure is to go back to the one before
            let was_at_limit = |(i, _): &(usize, Room)| step.wells[*i].control == Control::Limit;
            let left: Vec<(usize, Room)> = rooms().filter(was_at_limit).collect();
            if let [(i, room)] = left[..] {
                let falls = (room.sign > 0.0) == (next[i] == Control::Rate);
                if !(falls && rise > 0.0 || !falls && rise < 0.0) {
                    next[i] = Control::Limit;
                }
            }
            return;
        }
        // with more pressure wells bring less
        let rises = brought > 0.0;
        let may = rooms().filter(|(i, room)| {
            next[*i]
                == if rises == (room.sign > 0.0) {
                    Control::Rate
                } else {
                    Control::Shut
                }
        });
        let first =
            may.min_by(|(i, a), (j, b)| a.distance(next[*i]).total_cmp(&b.distance(next[*j])));
        if let Some((i, _)) = first {
            next[i] = Control::Limit;
        }
    }
}
