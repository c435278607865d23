//! Claim: the manuscript's data are what the experiments write today: same tables, same columns, numbers that parse.
#![allow(clippy::unwrap_used)]

mod csv;

use csv::cells;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const REFRESH: &str =
    "refresh with `fracas reproduce all --level paper --out out` and `python paper/collect.py out`";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}; {REFRESH}", path.display()))
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&read(path)).unwrap()
}

/// Experiments whose data are committed.
fn present() -> Vec<String> {
    let index = json(&root().join("paper/data/index.json"));
    let ids = index["experiments"].as_array().unwrap();
    ids.iter().map(|id| id.as_str().unwrap().into()).collect()
}

/// Names of the tables of an experiment.
fn tables(id: &str) -> Vec<String> {
    let manifest = json(&root().join("paper/data").join(id).join("manifest.json"));
    let tables = manifest["tables"].as_array().unwrap();
    tables
        .iter()
        .map(|t| t["id"].as_str().unwrap().into())
        .collect()
}

#[test]
fn data_come_from_runs_at_paper_level_whose_checks_hold() {
    let ids = present();
    assert!(!ids.is_empty());
    for id in ids {
        let manifest = json(&root().join("paper/data").join(&id).join("manifest.json"));
        assert_eq!(manifest["id"], id.as_str());
        assert_eq!(manifest["level"], "paper", "{id}");
        for check in manifest["checks"].as_array().unwrap() {
            assert_eq!(check["pass"], true, "{id}: {}", check["claim"]);
        }
    }
}

#[test]
fn tables_have_the_columns_that_the_experiments_write_and_numbers_that_parse() {
    for id in present() {
        for table in tables(&id) {
            let name = format!("{id}/{table}.csv");
            let text = read(&root().join("paper/data").join(&name));
            let mut lines = text.lines();
            let header = lines.next().unwrap();
            // what the experiment writes today: held by the test of the smoke level
            let expected = read(&root().join("experiments/expected").join(&name));
            assert_eq!(
                header,
                expected.lines().next().unwrap(),
                "{name}: {REFRESH}"
            );
            let rows: Vec<_> = lines.map(cells).collect();
            assert!(!rows.is_empty(), "{name} has no rows");
            assert!(
                rows.iter().all(|row| row.len() == cells(header).len()),
                "{name}: a line is short or long"
            );
            let known: Vec<_> = expected.lines().skip(1).map(cells).collect();
            let is_number = |v: &str| v.parse::<f64>().is_ok_and(f64::is_finite);
            let stands_for_none = |v: &str| ["", "X"].contains(&v);
            for (k, column) in cells(header).iter().enumerate() {
                // a column of numbers is one that holds nothing else where the experiment was checked
                if known
                    .iter()
                    .all(|row| is_number(&row[k]) || stands_for_none(&row[k]))
                {
                    for row in &rows {
                        assert!(
                            is_number(&row[k]) || stands_for_none(&row[k]),
                            "{name}: {column} is {:?}",
                            row[k]
                        );
                    }
                }
            }
        }
    }
}

/// Quoted strings of a source that follow `before`.
fn quoted_after<'a>(text: &'a str, before: &str) -> Vec<&'a str> {
    text.split(before)
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect()
}

#[test]
fn the_text_names_only_files_and_columns_that_exist() {
    let ids = present();
    let studies = root().join("paper/sections/studies");
    let mut named = 0;
    for id in &ids {
        let text = read(&studies.join(format!("{id}.typ")));
        let data = root().join("paper/data").join(id);
        // e02_spectra, e02_exact …: a table or a figure
        for name in quoted_after(&text, &format!("\"{id}_")) {
            let found = ["csv", "column.svg"].map(|e| data.join(format!("{id}_{name}.{e}")));
            assert!(
                found.iter().any(|file| file.exists()),
                "{id}.typ names {id}_{name}: {REFRESH}"
            );
            named += 1;
        }
        let columns: BTreeSet<String> = tables(id)
            .iter()
            .flat_map(|t| cells(read(&data.join(format!("{t}.csv"))).lines().next().unwrap()))
            .collect();
        // see("column", …), val("column", …) and the lines ("column", heading, format) of a table
        for before in ["see(\"", "val(\"", "\n    (\"", "\n  (\""] {
            for column in quoted_after(&text, before) {
                assert!(columns.contains(column), "{id}.typ names column {column:?}");
                named += 1;
            }
        }
    }
    assert!(named > 30, "only {named} names were found");
    let sections = ["studies.typ", "supplement.typ"];
    let main = sections.map(|s| read(&root().join("paper/sections").join(s)));
    let main = main.concat();
    for id in &ids {
        assert!(
            main.contains(&format!("studies/{id}.typ")),
            "{id} has data and no place in the text"
        );
    }
}
