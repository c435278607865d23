//! A preconditioner that outlives its step.

use super::Prepared;
use fracas_operators::Preconditioner;

/// S̃_u⁻¹ and what it was built for.
pub(super) struct Ready {
    pub(super) of: Prepared,
    pub(super) inverse: Box<dyn Preconditioner<f64>>,
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
