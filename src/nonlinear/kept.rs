//! A preconditioner that outlives its step.

use super::Prepared;
use crate::contact::ContactState;
use fracas_operators::Preconditioner;

/// S̃_u⁻¹ and what it was built for.
pub(super) struct Ready {
    pub(super) of: Prepared,
    pub(super) inverse: Box<dyn Preconditioner<f64>>,
}

impl Ready {
    /// Jumps that these states constrain and those that it was built for do not, or the other way round: slip and new-slip count as one.
    pub(super) fn distance(&self, states: &[ContactState]) -> usize {
        let pairs = self.of.states.iter().zip(states);
        (pairs.map(|(a, b)| a.constrained().abs_diff(b.constrained()))).sum()
    }
}

/// A preconditioner that steps hand on, or what a restart has to build it from again.
#[derive(Default)]
pub(super) struct Kept {
    pub(super) ready: Option<Ready>,
    /// What a restart has to build again.
    pub(super) pending: Option<Prepared>,
}

impl Kept {
    /// A step begins, with the preconditioner that was kept for it.
    pub(super) fn begin_step(&mut self, prepared: Option<&Prepared>) {
        self.pending = None;
        if self.ready.as_ref().map(|ready| &ready.of) != prepared {
            self.ready = None;
            self.pending = prepared.cloned();
        }
    }

    /// What the preconditioner that the next step finds was built for.
    pub(super) fn carried(&self) -> Option<Prepared> {
        let ready = self.ready.as_ref().map(|ready| &ready.of);
        ready.or(self.pending.as_ref()).cloned()
    }
}
