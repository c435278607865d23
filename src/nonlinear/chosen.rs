//! The preconditioner of a run that the scene leaves open.

use super::ContactProblem;
use crate::mesh::Grid;
use crate::scene::{FACTORIZED, RunInner};
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, Racp};

/// C where the scene does not choose: half of H also where cells are flat. S̃_u is kept while faces slip and open, and less of H in
/// C leaves stiffer springs in it: flat cells of 1:50 all opening take 91 iterations with fitted_h, 48 with this.
const AUGMENTATION: AugmentationChoice = AugmentationChoice::HalfH;

/// The preconditioner that the scene asks for, or that its size suggests.
pub(super) fn chosen(problem: &ContactProblem<'_>) -> Racp {
    let body = problem.body();
    let around = |inner| Racp {
        augmentation: AUGMENTATION,
        inner,
        ..Racp::default()
    };
    let amg = InnerChoice::Amg(Default::default());
    let small = body.constraints.free_len() <= FACTORIZED;
    match (body.solver.racp, body.solver.inner) {
        (Some(racp), _) => racp,
        (None, RunInner::Exact) => around(InnerChoice::default()),
        (None, RunInner::Auto) if small => around(InnerChoice::default()),
        (None, RunInner::Auto) if body.mesh.grid.as_ref().is_none_or(Grid::is_thin) => around(amg),
        (None, RunInner::Amg) => around(amg),
        (None, RunInner::Auto | RunInner::Geometric) => {
            around(InnerChoice::Geometric(Default::default()))
        }
    }
}
