//! Claim: every command that a page shows runs as it stands there, on the files that the page shows.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

use crate::run::{fracas_in, scratch, write};
use std::collections::HashSet;
use std::path::Path;

const PAGES: [&str; 7] = [
    "README.md",
    "docs/install.md",
    "docs/scenes.md",
    "docs/runs.md",
    "docs/methods.md",
    "docs/faults.md",
    "docs/studies.md",
];

/// Commands that take minutes, or that other tests run.
const LONG: [&str; 3] = [
    "reproduce",
    "solve layered_crossing --inner geometric",
    "solve analogue_b --method mcp --inner fsai",
];

fn text(page: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(page);
    std::fs::read_to_string(path).unwrap()
}

/// Blocks of a page in this language, in their order, from this heading on.
fn blocks(page: &str, heading: &str, language: &str) -> Vec<String> {
    let text = text(page);
    let (_, after) = text.split_once(heading).unwrap();
    let fence = format!("```{language}\n");
    let parts = after.split(&fence).skip(1);
    parts
        .filter_map(|part| part.split("```").next())
        .map(str::to_owned)
        .collect()
}

/// Arguments of the commands of a page; `DIR` is the folder that an earlier command has written.
fn commands(page: &str) -> Vec<Vec<String>> {
    let lines = blocks(page, "\n", "sh").concat().replace("\\\n", " ");
    let arguments = lines.lines().filter_map(|line| {
        let line = line.split('#').next()?.trim();
        let line = line
            .strip_prefix("fracas ")
            .or_else(|| line.strip_prefix("cargo run --release -- "))?;
        let is_long = LONG.iter().any(|start| line.starts_with(start));
        (!is_long).then(|| {
            let words = line.split_whitespace();
            words
                .map(|word| word.replace("DIR", "layered_system"))
                .collect()
        })
    });
    arguments.collect()
}

#[test]
fn commands_of_the_pages_run_as_they_stand_there() {
    let folder = scratch("commands");
    let first = |page, heading| blocks(page, heading, "toml").swap_remove(0);
    let scene = first("docs/scenes.md", "## A small scene");
    write(&folder.join("my_scene.toml"), &scene);
    // fewer samples and meshes than a reader takes, for time
    let fault = first("docs/faults.md", "\n");
    assert!(fault.contains("samples = 1000"), "{fault}");
    let fault = fault.replace("samples = 1000", "samples = 10");
    write(&folder.join("fault.toml"), &fault);
    let study = first("docs/studies.md", "\n");
    let study = [
        (
            r#""crossing", "layered", "my_scene.toml""#,
            r#""my_scene.toml""#,
        ),
        ("refine = [1, 2, 4]", "refine = [1, 2]"),
        ("[[skip]]\nmethod = \"mcp\"\nrefine = 4\n", ""),
    ]
    .iter()
    .fold(study, |study, (of_page, smaller)| {
        assert!(study.contains(of_page), "{study}");
        study.replace(of_page, smaller)
    });
    write(&folder.join("mesh.toml"), &study);
    let reservoir = "examples/reservoir";
    std::fs::create_dir_all(folder.join(reservoir)).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for file in std::fs::read_dir(root.join(reservoir)).unwrap() {
        let file = file.unwrap();
        let to = folder.join(reservoir).join(file.file_name());
        std::fs::copy(file.path(), to).unwrap();
    }
    let mut seen = HashSet::new();
    for page in PAGES {
        for mut arguments in commands(page) {
            if arguments[0] == "compare" {
                arguments.retain(|word| word != "layered");
                let refine = arguments.iter_mut().find(|word| *word == "1,2,4");
                *refine.unwrap() = "1".into();
            }
            if !seen.insert(arguments.clone()) {
                continue;
            }
            let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let done = fracas_in(&folder, &words);
            assert_eq!(done.status, 0, "{page}: {arguments:?}\n{}", done.stderr);
        }
    }
    assert!(seen.len() >= 18, "{} commands", seen.len());
    std::fs::remove_dir_all(&folder).unwrap();
}
