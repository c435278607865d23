//! Active sets that return to where they were.

use crate::contact::ContactState;

/// States that returned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cycle {
    /// Rounds until they repeat.
    pub(super) period: usize,
    /// Faces that differ within the cycle.
    pub(super) faces: Vec<usize>,
    /// Per face the state of the cycle that constrains most.
    pub(super) most_constrained: Vec<ContactState>,
    /// Per face the one that constrains least.
    pub(super) least_constrained: Vec<ContactState>,
    /// Faces that are open in some of it.
    pub(super) opened: Vec<usize>,
}

/// The states of rounds that follow each other.
#[derive(Debug, Default)]
pub(super) struct Rounds {
    seen: Vec<Vec<ContactState>>,
}

impl Rounds {
    /// Notes states; tells when they were there before.
    pub(super) fn enter(&mut self, states: &[ContactState]) -> Option<Cycle> {
        let Some(first) = self.seen.iter().position(|seen| seen == states) else {
            self.seen.push(states.to_vec());
            return None;
        };
        let cycle = self.seen.split_off(first);
        let differs = |f: &usize| cycle.iter().any(|round| round[*f] != states[*f]);
        let open = |f: usize| cycle.iter().any(|round| round[f] == ContactState::Open);
        let is_open = |f: &usize| open(*f);
        let of = |f: usize| cycle.iter().map(move |round| round[f]);
        let most = |f: usize| of(f).max_by_key(|s| s.constrained());
        let least = |f: usize| of(f).min_by_key(|s| s.constrained());
        Some(Cycle {
            period: cycle.len(),
            faces: (0..states.len()).filter(differs).collect(),
            most_constrained: (0..states.len()).filter_map(most).collect(),
            least_constrained: (0..states.len()).filter_map(least).collect(),
            opened: (0..states.len()).filter(is_open).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ContactState::{Open, Slip, Stick};

    #[test]
    fn a_cycle_names_its_period_its_faces_and_what_they_constrain() {
        let mut rounds = Rounds::default();
        let (a, b, c) = ([Stick, Slip, Open], [Slip, Slip, Open], [Open, Stick, Open]);
        assert_eq!(rounds.enter(&[Stick; 3]), None);
        assert_eq!(rounds.enter(&a), None);
        assert_eq!(rounds.enter(&b), None);
        assert_eq!(rounds.enter(&c), None);
        let cycle = Cycle {
            period: 3,
            faces: vec![0, 1],
            most_constrained: vec![Stick, Stick, Open],
            least_constrained: vec![Open, Slip, Open],
            opened: vec![0, 2],
        };
        assert_eq!(rounds.enter(&a), Some(cycle));
    }
}
