//! Claim: whoever uses the crates brings an augmentation, an inner solver, a preconditioner, a Krylov method or a scene of their own
//! in some sixty lines, and the laboratory, `solve` and runs take it by its name: the examples hold.
#![allow(clippy::unwrap_used)]

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
