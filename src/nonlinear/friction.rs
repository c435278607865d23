//! The friction of faces within a step, and the slip that it follows.

use super::{ContactProblem, Start};
use crate::contact::{Friction, SlipSoFar, WeakeningBy};
use crate::scene::{Body, Profile};

/// True where the friction of a fracture weakens with slip.
pub(super) fn weakens(body: &Body) -> bool {
    let profiles = body.friction.iter().flatten();
    profiles
        .flat_map(Profile::values)
        .any(|f| f.weakening.is_some())
}

/// True for each fracture whose friction follows the path of its slip.
pub(super) fn by_path(body: &Body) -> Vec<bool> {
    let follows = |f: Friction| f.weakening.is_some_and(|w| w.by == WeakeningBy::Path);
    (body.friction.iter())
        .map(|profile| profile.iter().flat_map(Profile::values).any(follows))
        .collect()
}

impl ContactProblem<'_> {
    /// Friction of a face; none where the scene gives none.
    pub fn friction(&self, face: usize) -> Friction {
        let friction = self.body().friction_of(&self.faces()[face]);
        friction.unwrap_or(Friction::NONE)
    }

    /// Friction of a face within a step: without cohesion where it is torn, without weakening where its limit stays.
    pub(super) fn friction_in(&self, face: usize, start: &Start) -> Friction {
        let friction = match start.limits_at.get(face) {
            Some(slip) => self.friction(face).at_slip(*slip),
            None => self.friction(face),
        };
        match start.is_torn(face) {
            true => friction.torn(),
            false => friction,
        }
    }

    /// The slip that the friction of a face has followed up to the start of a step.
    pub(super) fn so_far(&self, f: usize, start: &Start) -> SlipSoFar {
        self.slipped(f, [&start.slip, &start.path])
    }

    /// The same from γ and its path of all faces.
    pub(super) fn slipped(&self, f: usize, [slip, path]: [&[f64]; 2]) -> SlipSoFar {
        match self.by_path[usize::from(self.faces()[f].fracture)] {
            true => SlipSoFar::Path(path[f]),
            false => SlipSoFar::Vector([slip[2 * f], slip[2 * f + 1]]),
        }
    }

    /// True where the friction of a fracture follows the path of its slip.
    pub fn follows_paths(&self) -> bool {
        self.by_path.contains(&true)
    }

    /// The paths of slip of faces that have not slipped; empty where no friction follows them.
    pub(super) fn no_path(&self) -> Vec<f64> {
        match self.follows_paths() {
            true => vec![0.0; self.faces().len()],
            false => Vec::new(),
        }
    }

    /// True where the friction of a fracture weakens with slip.
    pub fn weakens(&self) -> bool {
        self.weakens
    }
}
