//! Mutated checkpoints: none is taken.

use crate::mutation::mutate;
use crate::room::{Verdict, count, scratch, trial};
use crate::scenes::RICH;
use fracas::io::{Checkpoints, Fingerprint, read_checkpoint};
use fracas::nonlinear::Simulation;
use fracas::scene::Scene;

#[test]
fn no_mutated_checkpoint_is_taken() {
    let folder = scratch("checkpoints");
    let scene = Scene::from_toml(RICH, "rich.toml").unwrap();
    let body = scene.build().unwrap();
    let fingerprint = Fingerprint::new(&body, RICH);
    let simulation = Simulation::new(&body).unwrap();
    let mut state = simulation.initial_state();
    state
        .u
        .iter_mut()
        .enumerate()
        .for_each(|(i, u)| *u = 1e-3 * (i as f64).sin());
    let path = Checkpoints::new(folder.clone(), fingerprint)
        .save(&state)
        .unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(read_checkpoint(&path, fingerprint).unwrap(), state);
    trial("checkpoints", count(0.1, 10_000), |g| {
        let (mutated, _) = mutate(&bytes, g);
        std::fs::write(&path, &mutated).unwrap();
        match read_checkpoint(&path, fingerprint) {
            Err(_) => Verdict::Refused,
            Ok(_) if mutated == bytes => Verdict::Taken,
            Ok(_) => Verdict::Finding("a changed checkpoint is taken".into()),
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}
