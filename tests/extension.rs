//! Claim: whoever uses the crates brings an augmentation, an inner solver, a preconditioner, a Krylov method or a scene of their own
//! in some sixty lines, and the laboratory, `solve` and runs take it by its name: the examples hold.
#![allow(clippy::unwrap_used)]

use fracas::nonlinear::Simulation;
use fracas::scene::named;
use fracas_solvers::direct::DirectSolver;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, AugmentationRule, SaddleBlocks,
};
use fracas_solvers::{Named, SetupError, Silent};

#[path = "../examples/from_code.rs"]
mod from_code;
#[path = "../examples/own_augmentation.rs"]
mod own_augmentation;
#[path = "../examples/own_inner.rs"]
mod own_inner;
#[path = "../examples/own_krylov.rs"]
mod own_krylov;
#[path = "../examples/own_method.rs"]
mod own_method;
#[path = "../examples/own_scene.rs"]
mod own_scene;

#[test]
fn an_augmentation_that_couples_faces_goes_into_the_laboratory_and_a_run() {
    own_augmentation::main().unwrap();
}

#[test]
fn an_inner_solver_goes_into_a_run() {
    own_inner::main().unwrap();
}

#[test]
fn a_preconditioner_solves_to_the_accuracy_asked_for() {
    own_method::main().unwrap();
}

#[test]
fn a_krylov_method_stands_on_the_bookkeeping_of_the_house() {
    own_krylov::main().unwrap();
}

#[test]
fn a_scene_comes_from_code() {
    own_scene::main().unwrap();
}

#[test]
fn a_system_is_solved_and_a_scene_run_from_code() {
    from_code::main().unwrap();
}

/// `half_h`, given by its entries.
#[derive(Debug)]
struct ByEntries;

impl Named for ByEntries {
    fn name(&self) -> &'static str {
        "half_h_by_entries"
    }
}

impl AugmentationRule for ByEntries {
    fn is_local(&self) -> bool {
        false
    }

    fn compute(
        &self,
        blocks: &SaddleBlocks,
        direct: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError> {
        let by_faces = AugmentationChoice::HalfH.compute(blocks, direct)?.matrix;
        AugmentationMatrix::from_sparse(by_faces.entries())
    }
}

/// Krylov iterations, tractions and slip at the end of a scene of the gallery that sticks, slips, opens and closes.
fn run(solver: &str) -> (usize, Vec<f64>, Vec<f64>) {
    let scene = named("cycle").unwrap().small_scene().unwrap();
    let body = scene.with_overrides(&[solver]).unwrap().build().unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let mut krylov = 0;
    let end = simulation.run(&mut Silent, |_, _, done| krylov += done.record.lin_it);
    let state = end.unwrap();
    (krylov, state.t, state.slip)
}

#[test]
fn a_c_of_faces_given_by_its_entries_makes_the_same_run() {
    AugmentationChoice::register(&ByEntries).unwrap();
    for inner in ["exact", "amg"] {
        let with = |c: &str| {
            run(&format!(
                "solver.racp={{ augmentation='{c}', inner='{inner}' }}"
            ))
        };
        let (krylov, t, slip) = with("half_h_by_entries");
        let (expected, t_faces, slip_faces) = with("half_h");
        // S_u from factors of [A B; Bᵀ −C] in place of its own, and sums in another order
        assert!(
            krylov.abs_diff(expected) * 50 <= expected,
            "{inner}: {krylov}, {expected}"
        );
        for (a, b) in [(t, t_faces), (slip, slip_faces)] {
            let far = a
                .iter()
                .zip(&b)
                .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
            let size = b.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
            assert!(far <= 1e-6 * size, "{inner}: {far:e} of {size:e}");
        }
    }
}
