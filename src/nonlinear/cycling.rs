//! Active sets that return to where they were: noticed, explained, broken.

use crate::contact::ContactState;

/// What is done about states that repeat, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// The faces of the cycle change between stick and slip only beyond the band of hysteresis, and those that close do so in
    /// slip; so it stays with the later remedies.
    Hysteresis,
    /// Of the faces of the cycle only the one that violates its state most changes in a round.
    OneFace,
    /// The faces of the cycle keep their state while they violate it by less than the share of hysteresis of the largest
    /// traction. H of open faces drops out of their neighbours' rows, so that a face may be in slight tension when closed
    /// and overlap slightly when open: then no state of it is exact.
    Keep,
}

impl Remedy {
    /// In words, for logs.
    pub fn text(self) -> &'static str {
        match self {
            Self::Hysteresis => {
                "these faces change between stick and slip only beyond the hysteresis, and close in slip"
            }
            Self::Keep => {
                "these faces keep their state while they violate it by less than the share of hysteresis"
            }
            Self::OneFace => {
                "of these faces only the one that violates its state most changes in a round"
            }
        }
    }
}

/// States that returned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cycle {
    /// Rounds until they repeat.
    pub(super) period: usize,
    /// Faces that differ within the cycle.
    pub(super) faces: Vec<usize>,
    /// What to do; `None` when everything has been tried.
    pub(super) remedy: Option<Remedy>,
}

/// The states of the rounds of one attempt since the last remedy.
#[derive(Debug, Default)]
pub(super) struct Rounds {
    seen: Vec<Vec<ContactState>>,
    remedies: usize,
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
        let faces = (0..states.len()).filter(differs).collect();
        let remedy = [Remedy::Hysteresis, Remedy::OneFace, Remedy::Keep]
            .get(self.remedies)
            .copied();
        self.remedies += 1;
        self.seen = vec![states.to_vec()];
        Some(Cycle {
            period: cycle.len(),
            faces,
            remedy,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ContactState::{Open, Slip, Stick};

    #[test]
    fn a_cycle_names_its_period_its_faces_and_the_next_remedy() {
        let mut rounds = Rounds::default();
        let (a, b, c) = ([Stick, Slip, Open], [Slip, Slip, Open], [Slip, Stick, Open]);
        assert_eq!(rounds.enter(&[Stick; 3]), None);
        assert_eq!(rounds.enter(&a), None);
        assert_eq!(rounds.enter(&b), None);
        assert_eq!(rounds.enter(&c), None);
        let cycle = |period, remedy| {
            Some(Cycle {
                period,
                faces: vec![0, 1],
                remedy,
            })
        };
        assert_eq!(rounds.enter(&a), cycle(3, Some(Remedy::Hysteresis)));
        assert_eq!(rounds.enter(&c), None);
        assert_eq!(rounds.enter(&a), cycle(2, Some(Remedy::OneFace)));
        assert_eq!(rounds.enter(&c), None);
        assert_eq!(rounds.enter(&a), cycle(2, Some(Remedy::Keep)));
        assert_eq!(rounds.enter(&c), None);
        assert_eq!(rounds.enter(&a), cycle(2, None));
    }
}
