//! The order of inner solvers.

use crate::memory::{self, NoRoomToFactorize};
use fracas_solvers::amg::Amg;
use fracas_solvers::multigrid::Geometric;
use fracas_solvers::saddle::InnerChoice;

/// Algebraic multigrid as it comes.
pub(crate) fn amg() -> InnerChoice {
    InnerChoice::Amg(Amg::default())
}

/// Geometric multigrid as it comes.
pub(crate) fn geometric() -> InnerChoice {
    InnerChoice::Geometric(Geometric::default())
}

/// What takes the place of `first` where it cannot be set up, in turn: what comes behind it of geometric multigrid, where the mesh has
/// a `grid`, AMG and a factorization; of a factorization the other two.
pub(crate) fn others(first: InnerChoice, grid: bool) -> Vec<InnerChoice> {
    let multigrid = || grid.then(geometric).into_iter().chain([amg()]);
    match first {
        InnerChoice::Geometric(_) => vec![amg(), InnerChoice::default()],
        InnerChoice::Amg(_) => vec![InnerChoice::default()],
        _ => multigrid().collect(),
    }
}

/// Which of those `left` takes the place of one with which an iteration over `displacements` gets nowhere: the factorization, where it
/// fits into the memory that is `available`, else the first; `None` where none is left.
///
/// Of 66 dense flat networks (7,000 to 41,000 displacements, cells of 1:10 to 1:500) geometric multigrid got nowhere in 7; AMG then got nowhere in 4 of
/// these, a factorization in none.
///
/// # Errors
/// [`NoRoomToFactorize`] where the factorization is all that is left, and does not fit.
pub(crate) fn without_stagnation(
    left: &[InnerChoice],
    displacements: usize,
    available: Option<u64>,
) -> Result<Option<usize>, NoRoomToFactorize> {
    let is_exact = |inner: &InnerChoice| matches!(inner, InnerChoice::Exact { .. });
    let Some(exact) = left.iter().position(is_exact) else {
        return Ok((!left.is_empty()).then_some(0));
    };
    match memory::room_to_factorize(displacements, available) {
        Ok(()) => Ok(Some(exact)),
        Err(_) if exact > 0 => Ok(Some(0)),
        Err(none) => Err(none),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn every_inner_solver_is_tried_once() {
        let names = |first, grid| -> Vec<&str> {
            let others = others(first, grid);
            others.iter().map(|inner| inner.name()).collect()
        };
        let exact = InnerChoice::default();
        assert_eq!(names(exact, true), ["geometric", "amg"]);
        assert_eq!(names(exact, false), ["amg"]);
        assert_eq!(names(geometric(), true), ["amg", "exact"]);
        assert_eq!(names(amg(), true), ["exact"]);
        assert_eq!(names(amg(), false), ["exact"]);
    }

    #[test]
    fn a_factorization_ends_a_standstill_where_it_fits() {
        let exact = InnerChoice::default();
        let next = |left: &[InnerChoice], free| without_stagnation(left, 100_000, free);
        let (gigabyte, all) = (Some(1_000_000_000), [amg(), exact]);
        for (left, free, expected) in [
            (&all[..], None, Some(1)),
            (&all, Some(u64::MAX), Some(1)),
            // it takes some 1.6 GB
            (&all, gigabyte, Some(0)),
            (&all[..1], gigabyte, Some(0)),
            (&[], gigabyte, None),
        ] {
            assert_eq!(next(left, free).unwrap(), expected);
        }
        let refusal = next(&[exact], gigabyte).unwrap_err().to_string();
        assert!(refusal.contains("100000 displacements"), "{refusal}");
    }
}
