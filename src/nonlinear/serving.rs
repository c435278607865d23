//! Which preconditioner serves the states at hand.

use super::kept::Ready;
use super::linear::Linear;
use crate::contact::ContactState;

impl Linear {
    /// Whether no S̃_u was made for these states.
    pub(super) fn is_of_others(&self, states: &[ContactState]) -> bool {
        let is_other = |ready: &Option<Ready>| {
            let of = ready.as_ref().map(|ready| ready.of.states.as_slice());
            of != Some(states)
        };
        is_other(&self.stick) && is_other(&self.present.ready)
    }

    /// The S̃_u made for the states nearest to these.
    pub(super) fn nearest(&self, states: &[ContactState]) -> Option<&Ready> {
        let far = |ready: &Option<Ready>| match ready {
            Some(ready) => ready.distance(states),
            None => usize::MAX,
        };
        match far(&self.present.ready) < far(&self.stick) {
            true => self.present.ready.as_ref(),
            false => self.stick.as_ref(),
        }
    }

    /// Faces of which S̃_u holds jumps that these states leave free.
    pub(super) fn freed(&self, states: &[ContactState]) -> Vec<usize> {
        let Some(Ready { of, .. }) = self.nearest(states) else {
            return Vec::new();
        };
        let pairs = of.states.iter().zip(states).enumerate();
        pairs
            .filter(|(_, (held, now))| held.constrained() > now.constrained())
            .map(|(f, _)| f)
            .collect()
    }
}
