//! Claim: the rooms import each other in one direction only, files stay small, and nothing unfinished is left behind.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap().into()
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    rust_files(&root().join(folder), &mut files);
    files.sort();
    assert!(!files.is_empty(), "no sources in {folder}");
    files
        .into_iter()
        .map(|path| {
            let text = fs::read_to_string(&path).unwrap();
            (path, text)
        })
        .collect()
}

/// Code without the lines that are comments.
fn code(text: &str) -> String {
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn crates_form_a_chain() {
    for (folder, forbidden) in [
        (
            "operators/src",
            vec![
                "fracas_solvers",
                "fracas::",
                "fracas_figures",
                "faer::",
                "fracas_experiments",
            ],
        ),
        (
            "solvers/src",
            vec![
                "fracas::",
                "fracas_figures",
                "fracas_experiments",
                "HexMesh",
                "FractureMesh",
            ],
        ),
        (
            "src",
            vec!["fracas_experiments", "fracas_figures", "plotters", "clap::"],
        ),
        ("figures/src", vec!["fracas_experiments", "clap::"]),
    ] {
        for (path, text) in sources(folder) {
            for word in &forbidden {
                assert!(
                    !code(&text).contains(word),
                    "{} uses {word}",
                    path.display()
                );
            }
        }
    }
}

#[test]
fn rooms_of_the_model_form_a_chain() {
    // a room may import only rooms that stand before it
    let chain = [
        "analytic",
        "units",
        "nearest",
        "digest",
        "mesh",
        "elasticity",
        "creep",
        "contact",
        "flow",
        "scene",
        "system",
        "undetermined",
        "memory",
        "inner",
        "multigrid",
        "jacobian",
        "matrix_free",
        "nonlinear",
        "io",
        "solve",
        "run",
        "prelude",
    ];
    for (path, text) in sources("src") {
        let relative = path.strip_prefix(root().join("src")).unwrap();
        let first = relative.components().next().unwrap();
        let first = first.as_os_str().to_string_lossy();
        let room = first.trim_end_matches(".rs");
        if room == "lib" {
            continue;
        }
        let place = chain.iter().position(|name| *name == room);
        let place = place.unwrap_or_else(|| panic!("{room} has no place in the chain"));
        let code = code(&text);
        let after = chain[place + 1..]
            .iter()
            .find(|other| code.contains(&format!("crate::{other}")));
        assert_eq!(
            after,
            None,
            "{} imports what comes after it",
            path.display()
        );
    }
}

/// The cycle does not know who makes its levels.
#[test]
fn algebraic_multigrid_makes_levels_and_multigrid_does_not_know() {
    for (path, text) in sources("solvers/src/multigrid") {
        let imports = code(&text).contains("crate::amg");
        assert!(!imports, "{} imports amg", path.display());
    }
}

#[test]
fn files_are_small_and_finished() {
    let mut lengths = Vec::new();
    for folder in [
        "operators/src",
        "solvers/src",
        "src",
        "figures/src",
        "experiments/src",
        "python/src",
    ] {
        for (path, text) in sources(folder) {
            // a list of claims may be long: unit tests are not counted
            if path.ends_with("tests.rs") {
                continue;
            }
            let lines = text
                .split("#[cfg(test)]\nmod tests {")
                .next()
                .unwrap_or("")
                .lines()
                .count();
            assert!(
                lines <= 450,
                "{} has {lines} lines: one idea per file",
                path.display()
            );
            for word in ["todo!", "unimplemented!", "dbg!(", "FIXME"] {
                assert!(
                    !text.contains(word),
                    "{} is unfinished: {word}",
                    path.display()
                );
            }
            lengths.push(lines);
        }
    }
    lengths.sort_unstable();
    let median = lengths[lengths.len() / 2];
    assert!(median <= 180, "the median file has {median} lines");
}

/// What a library may not do: read the environment, write to the terminal.
#[test]
fn every_file_is_compiled_and_libraries_are_silent() {
    for folder in [
        "operators/src",
        "solvers/src",
        "src",
        "figures/src",
        "experiments/src",
        "python/src",
    ] {
        let files = sources(folder);
        let all: String = files.iter().map(|(_, text)| code(text)).collect();
        for (path, text) in &files {
            let stem = path.file_stem().unwrap().to_str().unwrap();
            let folder_name = path.parent().unwrap().file_name().unwrap();
            let module = match stem {
                "lib" | "main" => continue,
                "mod" => folder_name.to_str().unwrap(),
                stem => stem,
            };
            assert!(
                all.contains(&format!("mod {module};")),
                "{}: no module declares it, so nothing compiles it",
                path.display()
            );
            let library = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or("");
            if folder != "experiments/src" && module != "tests" {
                for word in ["env::var", "eprintln!(", "println!("] {
                    assert!(!code(library).contains(word), "{}: {word}", path.display());
                }
            }
        }
    }
}

/// A claim that no binary lists would never be run.
#[test]
fn every_claim_is_listed() {
    let manifests = ["Cargo.toml", "tests/Cargo.toml"];
    let manifests = manifests.map(|file| fs::read_to_string(root().join(file)).unwrap());
    let is_binary = |name: &str| {
        manifests
            .iter()
            .any(|m| m.contains(&format!("name = \"{name}\"")))
    };
    let mut folders = 0;
    for entry in fs::read_dir(root().join("tests")).unwrap() {
        let folder = entry.unwrap().path();
        let is_file = folder.extension().is_some_and(|e| e == "rs");
        if is_file || folder.join("main.rs").exists() {
            let name = folder.file_stem().unwrap().to_str().unwrap();
            assert!(
                is_binary(name),
                "{}: no manifest lists it",
                folder.display()
            );
        }
        if !folder.join("main.rs").exists() {
            continue;
        }
        folders += 1;
        let mut files = Vec::new();
        rust_files(&folder, &mut files);
        for path in files.iter().filter(|path| !path.ends_with("main.rs")) {
            // a part of a claim stands in its folder, which `mod.rs` lists
            let claim = match path.ends_with("mod.rs") {
                true => path.parent().unwrap(),
                false => path,
            };
            let lists = ["main.rs", "mod.rs"].map(|list| claim.with_file_name(list));
            let list: String = lists.iter().flat_map(fs::read_to_string).collect();
            let name = claim.file_stem().unwrap().to_str().unwrap();
            let listed = list.contains(&format!("mod {name};"));
            assert!(listed, "{}: nothing lists it", path.display());
        }
    }
    assert!(folders >= 5, "{folders} folders of claims");
}
