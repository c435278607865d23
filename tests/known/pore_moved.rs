//! Claim: a run whose folder moves with its scene and its fields of pressure goes on with the same bits, from either scene; one whose fields have
//! changed does not.

use crate::pore_fields::{scene, vtu};
use fracas::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

fn run(toml: &Path, settings: Run) -> Result<Outcome, String> {
    let scene = Scene::load(toml).map_err(|e| e.to_string())?;
    let folder = settings.open("moved", scene, &mut Silent);
    let mut folder = folder.map_err(|e| e.to_string())?;
    let mut run = folder.begin(&mut Silent).unwrap();
    loop {
        let stop = AtomicBool::new(false);
        if let Taken::Ended(ended) = run.advance(&stop, &mut Silent).unwrap() {
            run.close(&ended).unwrap();
            return Ok(ended.outcome);
        }
    }
}

fn write(folder: &Path, last: f64) {
    fs::create_dir_all(folder.join("data")).unwrap();
    let points = [[1.5, 3.0, -2.0], [1.5, 3.0, -1.0]];
    for (file, values) in [("p0.vtu", [3.0, 2.0]), ("p1.vtu", [1.0, last])] {
        fs::write(folder.join("data").join(file), vtu(&points, &values)).unwrap();
    }
    let form = "{ fields = [['0 day', 'data/p0.vtu'], ['5 day', 'data/p1.vtu']], unit = 'MPa', within = '2 m' }";
    fs::write(folder.join("scene.toml"), scene(form, "")).unwrap();
}

#[test]
fn a_run_that_moves_with_its_files_goes_on() {
    let base = std::env::temp_dir().join(format!("fracas-moved-{}", std::process::id()));
    let at = |name: &str| base.join(name);
    write(&at("whole"), 2.5);
    let into = |out: PathBuf, steps: Option<usize>| Run {
        out: Some(out),
        steps,
        ..Run::default()
    };
    let whole = run(&at("whole/scene.toml"), into(at("whole/out"), None));
    assert_eq!(whole, Ok(Outcome::Finished));
    let history = |name: &str| fs::read_to_string(at(name).join("out/history.csv")).unwrap();
    for (name, scene) in [("by_scene", "scene.toml"), ("by_run", "out/resolved.toml")] {
        let before = at(&format!("{name}_before"));
        write(&before, 2.5);
        let part = run(
            &before.join("scene.toml"),
            into(before.join("out"), Some(2)),
        );
        assert_eq!(part, Ok(Outcome::Stopped));
        fs::rename(&before, at(name)).unwrap();
        let again = || Run {
            restart: Some(at(name).join("out")),
            ..Run::default()
        };
        // the files are not those that the run began with
        write(&at(name), 2.25);
        let said = run(&at(name).join(scene), again()).unwrap_err();
        match scene {
            "scene.toml" => assert!(said.contains("checkpoint"), "{said}"),
            _ => assert!(said.contains("are not those that `digest`"), "{said}"),
        }
        write(&at(name), 2.5);
        assert_eq!(
            run(&at(name).join(scene), again()),
            Ok(Outcome::Finished),
            "{scene}"
        );
        assert_eq!(history(name), history("whole"), "{scene}");
        let resolved = fs::read_to_string(at(name).join("out/resolved.toml")).unwrap();
        assert!(!resolved.contains("before"), "{resolved}");
    }
    fs::remove_dir_all(base).unwrap();
}
