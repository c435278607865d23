//! Claim: the last digits of a processor do not decide which levels multigrid makes of a matrix: connections that rounding alone tells
//! apart count as equal.
#![allow(clippy::unwrap_used, reason = "a test that cannot read a report fails")]

use crate::run::fracas;
use fracas_operators::simd::Level;
use serde_json::Value;

fn levels(arguments: &[&str]) -> (Value, Value) {
    let ran = fracas(&[arguments, &["--json", "-"]].concat());
    assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.stderr);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    let sizes = &report["amg"]["levels"];
    assert!(sizes.is_array(), "{report}");
    (report["instructions"].clone(), sizes.clone())
}

#[test]
fn every_processor_makes_the_same_levels() {
    let hard: &[&str] = &[
        "layered_crossing:small",
        "--set",
        "material.1.young=40 MPa",
        "--set",
        "mesh.map.distort.amplitude=0.2",
    ];
    for scene in [
        hard,
        &["layered_crossing:small"],
        &["analogue_b:small"],
        &["analogue_c:small"],
    ] {
        for inner in ["amg", "amg:f64"] {
            let solve = [&["solve"], scene, &["--inner", inner]].concat();
            let (_, best) = levels(&solve);
            for level in Level::supported() {
                let name = level.name().split(' ').next().unwrap();
                let (used, sizes) = levels(&[&["--instructions", name], &solve[..]].concat());
                assert_eq!(used, level.name());
                assert_eq!(best, sizes, "{name} {solve:?}");
            }
        }
    }
}
