//! Mutated command lines: parsed or refused; the harmless ones are run.

use crate::mutation::mutate;
use crate::room::{Verdict, count, scratch, trial};
use crate::scenes::RICH;
use clap::Parser;
use fracas::scene::Scene;
use fracas_experiments::command::{Arguments, outcome};
use fracas_operators::random::Random;

/// Nodes up to which a scene is checked.
const CHECKED: u128 = 400;

const LINES: [&str; 8] = [
    "run SCENE --out out --set mesh.x.cells=4 --set solver.max_newton=12 --steps 2 --fields-every 3 --clock",
    "run SCENE --restart out/checkpoint --threads 2",
    "check SCENE --set material.rock.young=20 GPa --set boundary.0.side=z+",
    "check --system out --threads 1",
    "export crossing --out out --step 3 --newton 1",
    "spectrum layered --stabilization 0 --modes smallest --augmentation local_h --json - --plot a.svg",
    "solve SCENE --method racp:0.1 --inner geometric:k:f64 --krylov fgmres --tolerance 1e-8 --json - --explain",
    "reproduce e01 e02 --level smoke --out out",
];

#[test]
fn mutated_command_lines_are_parsed_or_refused() {
    let folder = scratch("lines");
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, RICH).unwrap();
    let scene = scene.display().to_string();
    let whole = Scene::load(&scene).unwrap();
    trial("command lines", count(0.1, 10_000), |g| {
        let arguments = arguments(&scene, g);
        let parsed = Arguments::try_parse_from(&arguments);
        let sets: Vec<&String> = arguments
            .windows(2)
            .filter(|pair| pair[0] == "--set")
            .map(|pair| &pair[1])
            .collect();
        let small = whole
            .with_overrides(&sets)
            .map_or(true, |scene| scene.nodes() <= CHECKED);
        let is_check = arguments
            .get(1..3)
            .is_some_and(|a| a[0] == "check" && a[1] == scene);
        match parsed {
            Err(_) => Verdict::Refused,
            Ok(parsed) if is_check && small => match outcome(&parsed, &mut Vec::new()) {
                (0, None) => Verdict::Taken,
                (2..=4, Some(sentence)) if !sentence.is_empty() => Verdict::Refused,
                other => Verdict::Finding(format!("{arguments:?} ends with {other:?}")),
            },
            Ok(_) => Verdict::Taken,
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A line with up to three words changed, doubled, swapped or gone.
fn arguments(scene: &str, g: &mut Random) -> Vec<String> {
    let line = g.one_of(&LINES);
    let mut words: Vec<String> = line.split(' ').map(String::from).collect();
    // a value with a unit is one word
    if let Some(at) = words.iter().position(|w| w == "GPa") {
        let unit = words.remove(at);
        words[at - 1] += &format!(" {unit}");
    }
    for word in &mut words {
        if word == "SCENE" {
            *word = scene.into();
        }
    }
    for _ in 0..=g.below(3) {
        let (i, j) = (g.below(words.len()), g.below(words.len()));
        match g.below(6) {
            0 if words.len() > 1 => drop(words.remove(i)),
            1 => words.insert(j, words[i].clone()),
            2 => words.swap(i, j),
            _ => {
                let (bytes, _) = mutate(words[i].as_bytes(), g);
                words[i] = String::from_utf8_lossy(&bytes).replace('\0', "");
            }
        }
    }
    words.insert(0, "fracas".into());
    words
}
