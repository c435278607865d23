//! The iteration whose vectors fit into memory.

use super::{Gmres, KrylovChoice, Sqmr};
use fracas_operators::Preconditioner;

/// Iterations that a good preconditioner needs, twice over: a basis for so many counts as a full one.
const FULL: usize = 40;

/// Shortest restart that is worth its products.
const SHORT: usize = 8;

/// An iteration, and how it was chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fitted {
    /// The iteration.
    pub choice: KrylovChoice,
    /// One sentence, where memory decided.
    pub reason: Option<String>,
}

impl KrylovChoice {
    /// GMRES where `vectors` of the length of the system hold 40 steps of it; else SQMR (7 vectors), if both the matrix and
    /// the preconditioner are `symmetric` and the latter is a linear map; else GMRES with as long a restart as fits. `None` where
    /// nothing fits.
    ///
    /// A preconditioner that is no linear map, or one rounded to 32 bits, makes it FGMRES, with two vectors per step.
    pub fn fitted(
        vectors: usize,
        symmetric: bool,
        preconditioner: &dyn Preconditioner<f64>,
    ) -> Option<Fitted> {
        let default = Self::default().flexible_for(preconditioner);
        let per_step = match default {
            Self::Fgmres(_) => 2,
            _ => 1,
        };
        let steps = vectors.saturating_sub(4) / per_step;
        if steps >= FULL {
            return Some(Fitted {
                choice: Self::Gmres(Gmres::restarted(steps.min(100))).flexible_for(preconditioner),
                reason: None,
            });
        }
        let full = per_step * FULL + 4;
        let choice = if symmetric && preconditioner.properties().linear && vectors >= 8 {
            Self::Sqmr(Sqmr {})
        } else if steps >= SHORT {
            Self::Gmres(Gmres::restarted(steps)).flexible_for(preconditioner)
        } else {
            return None;
        };
        let reason = format!(
            "{choice}, because memory holds {vectors} vectors and a full basis of {} would take {full}",
            default.name()
        );
        Some(Fitted {
            choice,
            reason: Some(reason),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::laws::Part;
    use fracas_operators::{Identity, Properties};

    fn name(vectors: usize, symmetric: bool, m: &dyn Preconditioner<f64>) -> Option<String> {
        Some(
            KrylovChoice::fitted(vectors, symmetric, m)?
                .choice
                .to_string(),
        )
    }

    #[test]
    fn the_basis_shrinks_with_memory_and_short_recurrences_take_over() {
        let m = Identity { n: 3 };
        let [single, nonlinear] =
            [Properties::SINGLE, Properties::NONLINEAR].map(|properties| Part { n: 3, properties });
        let some = |name: &str| Some(name.to_owned());
        assert_eq!(name(1000, true, &m), some("gmres:100"));
        assert_eq!(name(64, true, &m), some("gmres:60"));
        assert_eq!(name(1000, true, &single), some("fgmres:100"));
        assert_eq!(name(104, false, &single), some("fgmres:50"));
        assert_eq!(name(60, true, &single), some("sqmr"));
        assert_eq!(name(60, false, &single), some("fgmres:28"));
        assert_eq!(name(60, true, &nonlinear), some("fgmres:28"));
        assert_eq!(name(30, true, &m), some("sqmr"));
        assert_eq!(name(30, false, &m), some("gmres:26"));
        assert_eq!(name(7, true, &m), None);
        assert_eq!(name(11, false, &m), None);
    }

    #[test]
    fn the_choice_is_explained_where_memory_made_it() {
        let m = Identity { n: 3 };
        assert_eq!(KrylovChoice::fitted(90, true, &m).unwrap().reason, None);
        let reason = KrylovChoice::fitted(20, true, &m).unwrap().reason.unwrap();
        assert!(
            reason.contains("20 vectors") && reason.contains("44"),
            "{reason}"
        );
    }
}
