//! Claim: the pages say what the program does: the keys of a scene are those of its schema, excerpts are those of the examples, and a
//! person can read them.

use crate::run::fracas;
use std::path::{Path, PathBuf};

const BEGIN: &str = "<!-- keys: begin -->\n";
const END: &str = "<!-- keys: end -->";
const PAGES: [&str; 15] = [
    "README.md",
    "docs/index.md",
    "docs/install.md",
    "docs/studies.md",
    "docs/stress.md",
    "docs/scenes.md",
    "docs/runs.md",
    "docs/methods.md",
    "docs/faults.md",
    "docs/performance.md",
    "docs/library.md",
    "docs/python.md",
    "docs/clusters.md",
    "docs/gas_storage.md",
    "docs/ground_ruptures.md",
];
const README_LINES: usize = 120;
const PARAGRAPH_WORDS: usize = 75;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[test]
fn the_keys_of_a_scene_are_those_of_its_schema() {
    let page = text("docs/scenes.md");
    let keys = page.split_once(BEGIN).and_then(|(_, after)| {
        let (keys, _) = after.split_once(END)?;
        Some(keys)
    });
    let ran = fracas(&["schema", "--page"]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    assert!(
        keys == Some(ran.stdout.as_str()),
        "docs/scenes.md is not what the schema says: between `{}` and `{END}` put what \
         `cargo run --release -- schema --page` prints",
        BEGIN.trim_end()
    );
}

#[test]
fn pages_are_short_and_their_links_lead_somewhere() {
    let lines = text("README.md").lines().count();
    assert!(lines <= README_LINES, "README.md has {lines} lines");
    for page in PAGES {
        let text = text(page);
        let blocks = prose(&text);
        for words in blocks.iter().flat_map(|block| parts(block)) {
            let n = words.split_whitespace().count();
            assert!(n <= PARAGRAPH_WORDS, "{page}: {n} words in\n{words}");
        }
        let folder = root().join(page).parent().map(Path::to_owned);
        for link in text.split("](").skip(1).filter_map(|s| s.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            let is_here = file.is_empty() || folder.as_ref().is_some_and(|f| f.join(file).exists());
            assert!(link.starts_with("https://") || is_here, "{page}: {link}");
        }
    }
}

/// Blocks between empty lines, without those of code.
fn prose(text: &str) -> Vec<String> {
    let outside = text.split("```").step_by(2);
    let blocks = outside.flat_map(|part| part.split("\n\n"));
    blocks.map(str::to_owned).collect()
}

/// Cells of a table, items of a list, or the block itself.
fn parts(block: &str) -> Vec<&str> {
    match block.trim_start().chars().next() {
        Some('|') => block.split('|').collect(),
        Some('-') => block.split("\n- ").collect(),
        _ => vec![block],
    }
}

/// The summary of the book lists every page.
#[test]
fn every_page_is_in_the_book() {
    let summary = text("docs/SUMMARY.md");
    for entry in std::fs::read_dir(root().join("docs")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let is_page = name.ends_with(".md") && name != "SUMMARY.md";
        assert!(!is_page || summary.contains(&format!("({name})")), "{name}");
    }
}

#[test]
fn excerpts_of_the_library_page_stand_in_the_sources() {
    let sources = [
        "from_code",
        "own_augmentation",
        "own_inner",
        "own_method",
        "own_krylov",
        "own_scene",
    ]
    .map(|name| text(&format!("examples/{name}.rs")))
    .concat();
    let page = text("docs/library.md");
    let excerpts = page.split("```rust\n").skip(1);
    let excerpts: Vec<_> = excerpts.filter_map(|s| s.split("```").next()).collect();
    assert!(excerpts.len() >= 5, "{} excerpts", excerpts.len());
    for excerpt in excerpts {
        assert!(sources.contains(excerpt), "no example has\n{excerpt}");
    }
}
