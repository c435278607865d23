//! Claim: code solves and runs as the command line does: from a scene, a body or blocks, for one right-hand side after another, and
//! a run that its caller stops goes on with the same bits.

use fracas::prelude::*;
use fracas::run::RunError;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

fn small(name: &str) -> Scene {
    named(name).unwrap().small_scene().unwrap()
}

#[test]
fn a_scene_its_body_and_its_blocks_have_one_solution() {
    let scene = small("crossing");
    let body = Arc::new(scene.build().unwrap());
    let blocks = body.saddle_blocks(Some(body.jump_stabilization())).unwrap();
    let settings = Solve {
        traction_unit: Some(blocks.traction_unit()),
        ..Solve::default()
    };
    let problems: [Problem; 3] = [scene.into(), body.into(), blocks.into()];
    let [of_scene, of_body, of_blocks] =
        problems.map(|problem| settings.solve(&problem, &mut Silent).unwrap());
    assert!(of_scene.has_converged() && of_blocks.has_converged());
    assert_eq!(of_scene.x, of_body.x);
    assert_eq!(of_scene.iterations, of_body.iterations);
    let far = |a: &[f64], b: &[f64]| {
        let size = b.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
        let pairs = a.iter().zip(b);
        pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / size
    };
    assert!(far(of_blocks.displacements(), of_scene.displacements()) < 1e-6);
    assert!(far(of_blocks.tractions(), of_scene.tractions()) < 1e-6);
}

#[test]
fn a_preconditioner_serves_one_right_hand_side_after_another() {
    let settings = Solve {
        inner: InnerRule::Auto,
        ..Solve::default()
    };
    let mut solver = settings
        .set_up(&small("clamped").into(), &mut Silent)
        .unwrap();
    let first = solver.solve(&mut Silent).unwrap();
    assert_eq!(first.inner.as_deref(), Some("exact"));
    let twice: Vec<f64> = {
        let body = small("clamped").build().unwrap();
        let blocks = body.saddle_blocks(Some(body.jump_stabilization())).unwrap();
        blocks.rhs().iter().map(|b| 2.0 * b).collect()
    };
    solver.set_rhs(twice);
    let second = solver.solve(&mut Silent).unwrap();
    assert!(second.has_converged());
    let size = first.x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for (a, b) in first.x.iter().zip(&second.x) {
        assert!((2.0 * a - b).abs() < 1e-6 * size, "{a} {b}");
    }
}

/// To its end, or to where it is stopped.
fn run(settings: Run, stop: &AtomicBool, observer: &mut dyn Observer) -> Outcome {
    let mut folder = settings.open("cycle", small("cycle"), observer).unwrap();
    let mut run = folder.begin(observer).unwrap();
    loop {
        if let Taken::Ended(ended) = run.advance(stop, observer).unwrap() {
            let outcome = ended.outcome;
            run.close(&ended).unwrap();
            assert!(matches!(
                folder.begin(observer),
                Err(RunError::Begun { .. })
            ));
            return outcome;
        }
    }
}

fn scratch(name: &str) -> PathBuf {
    let name = format!("fracas-library-{}-{name}", std::process::id());
    std::env::temp_dir().join(name)
}

fn read(out: &Path, file: &str) -> Vec<u8> {
    fs::read(out.join(file)).unwrap()
}

#[test]
fn a_run_that_its_caller_stops_goes_on_with_the_same_bits() {
    let (whole, part) = (scratch("whole"), scratch("part"));
    let into = |out: &PathBuf| Run {
        out: Some(out.clone()),
        ..Run::default()
    };
    let stop = AtomicBool::new(false);
    assert_eq!(run(into(&whole), &stop, &mut Silent), Outcome::Finished);
    let mut left = 100;
    let mut observer = |step: &Step| {
        left -= i32::from(matches!(step, Step::Krylov { .. }));
        stop.store(left <= 0, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    assert_eq!(run(into(&part), &stop, &mut observer), Outcome::Interrupted);
    assert!(!part.join("run.lock").exists());
    let rows = |out: &Path| {
        read(out, "history.csv")
            .iter()
            .filter(|b| **b == b'\n')
            .count()
    };
    assert!((2..rows(&whole)).contains(&rows(&part)));
    let again = Run {
        restart: Some(part.clone()),
        ..Run::default()
    };
    stop.store(false, Ordering::Relaxed);
    assert_eq!(run(again, &stop, &mut Silent), Outcome::Finished);
    for file in ["history.csv", "energy.csv", "scene.pvd", "resolved.toml"] {
        assert!(read(&whole, file) == read(&part, file), "{file}");
    }
    for out in [whole, part] {
        fs::remove_dir_all(out).unwrap();
    }
}

/// Bindings keep them in objects of other languages, and pass them between threads.
#[test]
fn solvers_and_run_folders_may_change_threads() {
    fn may<T: Send + 'static>() {}
    may::<Solver>();
    may::<RunFolder>();
    may::<Solved>();
}
