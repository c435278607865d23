//! Claim: `fault` solves the file of its page, the same on any number of threads, and says in one sentence what is wrong with another.
#![allow(clippy::unwrap_used)]

use crate::run::{fracas, scratch, write};
use std::path::Path;

/// The file that the page shows.
fn shown() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/faults.md");
    let text = std::fs::read_to_string(page).unwrap();
    let (_, after) = text.split_once("```toml\n").unwrap();
    let (file, _) = after.split_once("```").unwrap();
    file.to_owned()
}

#[test]
fn the_file_of_the_page_runs_and_writes_its_folder() {
    let folder = scratch("fault");
    let file = folder.join("fault.toml");
    write(&file, &shown().replace("samples = 1000", "samples = 40"));
    let run = |threads: &str, out: &Path| {
        let ran = fracas(&[
            "--threads",
            threads,
            "fault",
            file.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        ran.stdout
    };
    let (one, two) = (folder.join("one"), folder.join("two"));
    let lines = run("1", &one);
    for row in ["slips", "runs away", "nucleation", "in the end", "samples"] {
        assert!(lines.contains(row), "no row {row} in\n{lines}");
    }
    run("2", &two);
    for name in [
        "curve.csv",
        "profiles.csv",
        "quantiles.csv",
        "length.svg",
        "runaway.csv",
    ] {
        let read = |out: &Path| std::fs::read(out.join("figures").join(name)).unwrap();
        assert_eq!(read(&one), read(&two), "{name}");
    }
    assert!(one.join("report.html").is_file());
}

#[test]
fn what_is_wrong_is_one_sentence() {
    let folder = scratch("fault-bad");
    for (k, (old, new, sentence)) in [
        (
            "dip = \"70 deg\"",
            "dip = \"0 deg\"",
            "fault.dip = 0 deg: the dip lies between",
        ),
        ("dip = \"70 deg\"", "dip = \"70 m\"", "an angle"),
        ("dip =", "dipp =", "dip"),
        (
            "dynamic = 0.45\n",
            "dynamic = 0.7\n",
            "is not above the static one",
        ),
        (
            "dynamic = 0.45\n",
            "",
            "dynamic and critical_slip go together",
        ),
        ("\"5 mm\"", "\"0 mm\"", "friction would fall at once"),
        (
            "[reservoir]",
            "[[block]]\ncorners = []\n[reservoir]",
            "exclude each other",
        ),
        ("depth = \"3 km\"", "depth = \"300 m\"", "out of the ground"),
        (
            "from = \"-400 m\"",
            "from = \"500 m\"",
            "is not below fault.to",
        ),
        (
            "change = \"-35 MPa\"",
            "change = \"0 MPa\"",
            "nothing happens",
        ),
        (
            "static = [0.5, 0.65]",
            "static = [0.7, 0.65]",
            "not above the second",
        ),
        ("samples = 1000", "samples = 0", "take one or more"),
    ]
    .into_iter()
    .enumerate()
    {
        let text = shown();
        assert!(text.contains(old), "{old}");
        let file = folder.join(format!("{k}.toml"));
        write(&file, &text.replacen(old, new, 1));
        let ran = fracas(&["fault", file.to_str().unwrap()]);
        assert_eq!(ran.status, 2, "{new}: {}", ran.stdout);
        assert!(ran.stderr.contains(sentence), "{new}: {}", ran.stderr);
        assert!(ran.stderr.contains(&format!("{k}.toml")), "{}", ran.stderr);
    }
    let ran = fracas(&["fault", "nowhere.toml"]);
    assert!(ran.status == 2 && ran.stderr.contains("cannot read nowhere.toml"));
}
