//! Claim: no eigenvalue lies outside of what is not claimed of it; what a verdict rests on stands beside it.
#![allow(clippy::unwrap_used)]

use crate::run::{fracas, scratch, write};
use std::path::PathBuf;

const GENERAL: &str = "%%MatrixMarket matrix coordinate real general\n";

/// A = diag(2, −½), B = (1 1)ᵀ and H: S_u = [3 1; 1 ½] is definite for C = 1, A is not.
fn two_springs(h: f64) -> PathBuf {
    let folder = scratch(&format!("two-springs-{h}"));
    for (file, text) in [
        ("A.mtx", format!("{GENERAL}2 2 2\n1 1 2\n2 2 -0.5\n")),
        ("B1.mtx", format!("{GENERAL}2 1 2\n1 1 1\n2 1 1\n")),
        ("H.mtx", format!("{GENERAL}1 1 1\n1 1 {h}\n")),
    ] {
        write(&folder.join(file), &text);
    }
    folder
}

#[test]
fn an_indefinite_stiffness_is_a_hypothesis_that_fails_and_no_eigenvalue_outside() {
    for (h, expected) in [(5.0, -7.0), (0.0, 3.0)] {
        let folder = two_springs(h);
        let system = folder.to_str().unwrap();
        let published = ["--method", "racp:published", "--augmentation", "global"];
        let arguments = [&["spectrum", "--system", system][..], &published].concat();
        let ran = fracas(&[&arguments[..], &["--json", "-"]].concat());
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
        let found = report["eigenvalues"]["re"].as_array().unwrap();
        let mut sorted = [1.0, 1.0, expected];
        sorted.sort_by(f64::total_cmp);
        for (found, expected) in found.iter().zip(sorted) {
            assert!(
                (found.as_f64().unwrap() - expected).abs() < 1e-9,
                "{report}"
            );
        }
        assert!(report["contained"].is_null(), "{report}");
        assert_eq!(report["bounds"]["theorem"], "none");
        let hypotheses = report["hypotheses"].as_array().unwrap();
        let failing = hypotheses.iter().filter(|h| h["holds"] == false);
        let failing: Vec<_> = failing.map(|h| h["statement"].as_str().unwrap()).collect();
        assert_eq!(failing, ["A ⪰ 0"]);
        let ran = fracas(&arguments);
        let verdict = "hypothesis fails: A is indefinite (λ_min ≤ -5.0e-1";
        assert!(
            ran.status == 0 && ran.stdout.contains(verdict),
            "{}",
            ran.stdout
        );
        assert!(ran.stdout.contains("A ⪰ 0 FAILS"), "{}", ran.stdout);
    }
}

#[test]
fn hypotheses_that_hold_stand_beside_the_verdict() {
    let ran = fracas(&["spectrum", "patch"]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    for part in [
        "A ⪰ 0 holds",
        "S̃_u ≻ 0 holds",
        "every eigenvalue lies inside",
    ] {
        assert!(ran.stdout.contains(part), "{part}: {}", ran.stdout);
    }
}

/// `spectrum crossing`, small, as JSON.
fn crossing(arguments: &[&str]) -> serde_json::Value {
    let small = ["mesh.x.cells=8", "mesh.y.cells=2", "mesh.z.cells=8"];
    let small = small.iter().flat_map(|set| ["--set", set]);
    let all: Vec<&str> = ["spectrum", "crossing", "--json", "-"]
        .into_iter()
        .chain(small)
        .chain(arguments.iter().copied())
        .collect();
    let ran = fracas(&all);
    assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.stderr);
    serde_json::from_str(&ran.stdout).unwrap()
}

#[test]
fn a_name_means_one_method_and_multigrid_works_in_f64() {
    for (arguments, method, augmentation, inner) in [
        (&[][..], "racp", "fitted_h", "exact"),
        (
            &["--method", "racp:published"],
            "racp:published",
            "local_h",
            "exact",
        ),
        (
            &["--method", "racp:0"],
            "racp:published",
            "local_h",
            "exact",
        ),
        (&["--inner", "amg"], "racp", "fitted_h", "amg:f64"),
        (
            &["--inner", "amg:chebyshev:f64"],
            "racp",
            "fitted_h",
            "amg:chebyshev:f64",
        ),
        (
            &["--inner", "geometric"],
            "racp",
            "fitted_h",
            "geometric:f64",
        ),
    ] {
        let report = crossing(arguments);
        for (key, expected) in [
            ("preconditioner", method),
            ("augmentation", augmentation),
            ("inner", inner),
        ] {
            assert_eq!(report[key], expected, "{arguments:?}");
        }
        assert_eq!(report["contained"], true, "{arguments:?}");
        let low = report["bounds"]["real_low"].as_f64().unwrap();
        assert!(low > 0.0, "{arguments:?}: {low}");
        assert_eq!(report["region"][0]["low"], low, "{arguments:?}");
    }
}

#[test]
fn a_partial_spectrum_speaks_of_what_was_found() {
    let folder = scratch("partial");
    let plot = folder.join("part.svg");
    let figure = plot.to_str().unwrap();
    let report = crossing(&["--inner", "ssor", "--dense-limit", "10", "--plot", figure]);
    let n = report["eigenvalues"]["re"].as_array().unwrap().len();
    let verdict = format!("every one of the {n} found lies inside");
    assert_eq!(report["verdict"], verdict);
    assert_eq!(report["method"], "iterative");
    let seen = |file: &std::path::Path| {
        let svg = std::fs::read_to_string(file).unwrap();
        svg.split_once("</desc>").unwrap().1.to_owned()
    };
    assert!(seen(&plot).contains(&verdict));
    crossing(&["--inner", "ssor", "--plot", figure]);
    assert!(!seen(&plot).contains("found"));
}

#[test]
fn pseudospectra_stand_beside_gmres_and_its_bounds() {
    let folder = scratch("pseudospectra");
    let plot = folder.join("c.svg");
    let figure = plot.to_str().unwrap();
    let published = [
        "--method",
        "racp:published",
        "--pseudospectra",
        "--grid",
        "20",
        "--plot",
        figure,
    ];
    let report = crossing(&published);
    let found = &report["non_normal"];
    assert!(
        found["inner_product"]
            .as_str()
            .unwrap()
            .starts_with("energy")
    );
    let list = |key: &str| -> Vec<f64> {
        let values = found["gmres"][key].as_array().unwrap().iter();
        values.map(|v| v.as_f64().unwrap()).collect()
    };
    let (measured, resolvent, field) =
        (list("measured"), list("resolvent"), list("field_of_values"));
    assert!(measured.len() > 5 && measured.last().unwrap() < &1e-8);
    for (k, measured) in measured.iter().enumerate() {
        assert!(*measured <= resolvent[k] && *measured <= field[k], "{k}");
    }
    let steps: Vec<u64> = (0..3)
        .map(|k| found["gmres"]["steps"][k].as_u64().unwrap())
        .collect();
    assert!(steps[0] <= steps[1] && steps[1] < steps[2], "{steps:?}");
    for (file, part) in [
        ("c.svg", "field of values"),
        ("c.csv", "ε = "),
        ("c_gmres.svg", "bound by the resolvent"),
        ("c_gmres.csv", "GMRES"),
    ] {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        assert!(text.contains(part), "{file}");
    }
    let euclidean = crossing(&["--pseudospectra=euclidean", "--grid", "2"]);
    let name = euclidean["non_normal"]["inner_product"].as_str().unwrap();
    assert!(name.starts_with("Euclidean"), "{name}");
    let ran = fracas(&["spectrum", "patch", "--grid", "20"]);
    assert_eq!(ran.status, 2, "{}", ran.stderr);
}

#[test]
fn what_is_certified_is_said_and_what_cannot_be_is_refused_in_a_sentence() {
    let report = crossing(&["--method", "racp:published", "--certify"]);
    assert_eq!(report["certified"], true);
    assert_eq!(report["enclosures"]["contained"], true);
    for (key, ends) in [("real_min", "real_min"), ("real_max", "real_max")] {
        let value = report[key].as_f64().unwrap();
        let end = |k: usize| report["enclosures"][ends][k].as_f64().unwrap();
        assert!(end(0) <= value && value <= end(1), "{key}: {value}");
        assert!(end(1) - end(0) < 1e-7);
    }
    assert_eq!(
        crossing(&["--method", "racp:published"])["certified"],
        false
    );
    for (arguments, part) in [
        (&["--certify"][..], "take --method racp:published"),
        (
            &["--certify", "--method", "racp:published", "--inner", "ssor"],
            "take --inner exact",
        ),
        (&["--certify", "--method", "mcp"], "no explicit blocks"),
    ] {
        let small = ["spectrum", "crossing:small"];
        let all: Vec<&str> = small.into_iter().chain(arguments.iter().copied()).collect();
        let ran = fracas(&all);
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(part), "{arguments:?}: {}", ran.stderr);
    }
}
