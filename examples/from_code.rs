//! A system solved and a scene run from code, as the command line does.
//!
//! `cargo run --release --example from_code`

use fracas::prelude::*;
use std::sync::atomic::AtomicBool;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = named("cycle")
        .ok_or("a scene of the gallery")?
        .small_scene()?;
    let settings = Solve {
        inner: InnerRule::Auto,
        ..Solve::default()
    };
    let solved = settings.solve(&scene.clone().into(), &mut Silent)?;
    println!("{:?}: {} iterations", solved.inner, solved.iterations);
    assert!(solved.has_converged() && solved.error_t.is_some_and(|e| e < 1e-8));

    let out = std::env::temp_dir().join(format!("fracas-from-code-{}", std::process::id()));
    let settings = Run {
        out: Some(out.clone()),
        ..Run::default()
    };
    let stop = AtomicBool::new(false);
    let mut folder = settings.open("cycle", scene, &mut Silent)?;
    let mut run = folder.begin(&mut Silent)?;
    let mut slipping = 0;
    let ended = loop {
        match run.advance(&stop, &mut Silent)? {
            Taken::Step(done) => slipping += usize::from(done.record.faces[2] > 0),
            Taken::Ended(ended) => break ended,
        }
    };
    println!("{} {slipping} steps with slip", ended);
    assert!(ended.outcome == Outcome::Finished && slipping > 0);
    run.close(&ended)?;
    assert!(out.join("history.csv").is_file());
    drop(folder);
    std::fs::remove_dir_all(out)?;
    Ok(())
}
