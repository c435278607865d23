//! How far rounds and Newton steps may go where fluid opens fractures.

use super::Attempt;
use crate::contact::ContactState;
use crate::nonlinear::Evaluation;
use fracas_solvers::saddle::U;

/// Newton steps between two judgements of the faces where something flows. Unit: 1.
const LOOSE_STEPS: usize = 1;

/// The same where faces that return are held: with 1 and 3, 34 expensive runs of 188 random ones take 8,208 and 12,580 Newton steps,
/// with this 7,266. Unit: 1.
const HELD_STEPS: usize = 2;

/// Newton steps after which faces that no longer changed are looked at again. Unit: 1.
const TIGHT_STEPS: usize = 3;

/// Largest change of an aperture in a Newton step over the widest one at hand: as much as doubles it. Unit: 1.
const WIDENING: f64 = 2.0;

impl Attempt<'_> {
    /// Newton steps between two judgements of the faces, of those that the scene allows: with flow the states settle sooner than the
    /// conductivities of wrong ones.
    pub(in crate::nonlinear) fn loose_steps(&self, allowed: usize, holds: bool) -> usize {
        match self.flow {
            Some(_) if holds => allowed.min(HELD_STEPS),
            Some(_) => allowed.min(LOOSE_STEPS),
            None => allowed,
        }
    }

    /// The same once no face changes: what is slow there is a face in slip that nearly sticks, and the faces tell.
    pub(in crate::nonlinear) fn tight_steps(&self, allowed: usize) -> usize {
        match self.flow {
            Some(_) => allowed.min(TIGHT_STEPS),
            None => allowed,
        }
    }

    /// The share of a correction that the line search begins with: no open face is to widen by more than [`WIDENING`] times the largest
    /// aperture at hand or before the step, or what its fluid would give to one face alone, or what counts as zero beside the tractions; 1
    /// where nothing flows.
    ///
    /// Conductivity goes with the cube of the aperture: where that of a face was next to nothing, the tangent does not see what it will be,
    /// and asks for metres.
    pub(in crate::nonlinear) fn first_length(
        &self,
        states: &[ContactState],
        at: &Evaluation,
        correction: &[f64],
    ) -> f64 {
        let (Some(step), Some(balance)) = (self.flow, self.problem.balance()) else {
            return 1.0;
        };
        let open = |f: &usize| states[*f] == ContactState::Open;
        let open = || (0..states.len()).filter(open);
        let zero = self.problem.body().solver.state_tolerance * self.traction;
        let compliance = self.problem.compliance();
        let before = step.aperture.iter().copied().fold(0.0, f64::max);
        let wide = open()
            .map(|f| at.jumps[3 * f].max(zero * compliance[f]))
            .fold(before, f64::max);
        let wide = wide.max(balance.widest(step));
        let [d_u] = self.layout().split([U], correction);
        let change = self.problem.jump_changes(d_u);
        let most = open().map(|f| change[3 * f].abs()).fold(0.0, f64::max);
        match most > WIDENING * wide && wide > 0.0 {
            true => WIDENING * wide / most,
            false => 1.0,
        }
    }
}
