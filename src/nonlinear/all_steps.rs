//! From the unloaded body to the last time: the one loop over steps of whoever keeps no folder.

use super::active_set::Log;
use super::{Accepted, Failure, Simulation, State, StepFailure};
use fracas_solvers::{Observer, Step};

impl Simulation<'_> {
    /// All steps; `visit` sees the state before each, and what was accepted.
    ///
    /// # Errors
    /// That of the step that fails; `visit` has seen those before it.
    pub fn run(
        &mut self,
        observer: &mut dyn Observer,
        mut visit: impl FnMut(&Self, &State, &Accepted),
    ) -> Result<State, Box<StepFailure>> {
        let total = 1 + self.problem().body().time.map_or(0, |t| t.steps as usize);
        let mut state = self.initial_state();
        while !self.is_finished(&state) {
            let (stage, done) = ("steps", state.step.min(total));
            let step = Step::Progress { stage, done, total };
            if observer.observe(&step).is_break() {
                let target = self.times.target(&state, state.next);
                let log = Log::default();
                return Err(StepFailure::new(&state, target, 0, Failure::Stopped, log));
            }
            let accepted = self.advance(&state, observer)?;
            visit(self, &state, &accepted);
            state = accepted.state;
        }
        Ok(state)
    }
}
