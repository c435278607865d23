//! Faces that open and close over and over.

use super::newton::Attempt;
use crate::contact::ContactState;

/// Iterations before which none is looked for. With none, 150 random networks take 41,406 Krylov iterations for 41,524, and another 150
/// 60,446 for 52,940; where no face is taken for torn, 108,757.
const PATIENCE: usize = 20;

/// Times that a face opens or closes before its cohesion is taken to be lost.
const TURNS: usize = 4;

/// How often faces have opened or closed within an attempt.
///
/// Some do so without end because their limit has a jump there: the cohesion, which an open face has not. No limit at all settles
/// them; what opens has let go of its shear, so that it closes without cohesion.
pub(super) struct Turns {
    count: Vec<usize>,
    is_open: Vec<bool>,
    seen: usize,
}

impl Turns {
    /// Of closed faces.
    pub(super) fn new(faces: usize) -> Self {
        Self {
            count: vec![0; faces],
            is_open: vec![false; faces],
            seen: 0,
        }
    }

    /// An iteration has found these states.
    pub(super) fn see(&mut self, states: impl Iterator<Item = ContactState>) {
        self.seen += 1;
        for ((count, was_open), state) in self.count.iter_mut().zip(&mut self.is_open).zip(states) {
            let is_open = state == ContactState::Open;
            *count += usize::from(is_open != *was_open);
            *was_open = is_open;
        }
    }

    /// Faces whose cohesion is lost.
    pub(super) fn torn(&self, attempt: &Attempt<'_>) -> Vec<usize> {
        if self.seen < PATIENCE {
            return Vec::new();
        }
        (0..self.count.len())
            .filter(|f| self.count[*f] >= TURNS && attempt.has_cohesion(*f))
            .collect()
    }
}

impl Attempt<'_> {
    /// True for a closed face that holds shear without any pressure on it.
    pub(super) fn has_cohesion(&self, f: usize) -> bool {
        let friction = self.problem.friction_in(f, self.start);
        friction.limit(0.0, self.problem.so_far(f, self.start).slip()) > 0.0
    }
}
