//! Claim: a scene asks for the onset of slip as closely as steps can tell it.

use fracas::scene::{Scene, named};

fn with(set: &[&str]) -> Scene {
    let scene = named("cycle").unwrap().small_scene().unwrap();
    scene.with_overrides(set).unwrap()
}

#[test]
fn what_is_written_is_what_is_looked_for() {
    let onset = with(&["time.onset.within=2 ms"]).build().unwrap().onset;
    let onset = onset.unwrap();
    assert_eq!((onset.within, onset.patch), (2e-3, None));
    let whole = "time.onset={within=\"1 h\",patch=\"400 m2\"}";
    let onset = with(&[whole]).build().unwrap().onset.unwrap();
    assert_eq!((onset.within, onset.patch), (3600.0, Some(400.0)));
    assert!(onset.has_patch(400.0 * (1.0 - 1e-12)) && !onset.has_patch(399.9));
    assert_eq!(with(&[]).build().unwrap().onset, None);
}

#[test]
fn what_cannot_be_looked_for_is_told() {
    let said = |set: &[&str]| with(set).build().unwrap_err().to_string();
    let close = said(&["time.onset.within=0 s"]);
    assert!(close.contains("less than a millionth of a step"), "{close}");
    let large = said(&["time.onset={within=\"1 ms\",patch=\"1 km2\"}"]);
    assert!(large.contains("\"cut\", has 400.000000 m2"), "{large}");
}
