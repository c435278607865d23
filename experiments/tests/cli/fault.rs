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

const RESERVOIR: &str = "[reservoir]\nthickness = \"200 m\"\nthrow = \"75 m\"\n";

const SQUARE: &str = "[0, -100], [5000, -100], [5000, 100], [0, 100]";

/// Blocks of corners in metres.
fn blocks(all: &[&str]) -> String {
    let block = |corners: &&str| {
        let numbers = corners.split_inclusive(|c: char| "[], ".contains(c));
        let quoted: String = numbers
            .map(|piece| {
                let number = piece.trim_end_matches(['[', ']', ',', ' ']);
                match number.is_empty() {
                    true => piece.to_owned(),
                    false => format!("\"{number} m\"{}", &piece[number.len()..]),
                }
            })
            .collect();
        format!("[[block]]\ncorners = [{quoted}]\n")
    };
    all.iter().map(block).collect()
}

/// The number after a name in the lines of a fault.
fn number_after(lines: &str, name: &str) -> f64 {
    let (_, after) = lines.split_once(name).unwrap_or_else(|| panic!("{lines}"));
    after.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn sums_are_those_of_many_elements_whatever_the_throw() {
    let folder = scratch("fault-throws");
    let file = folder.join("fault.toml");
    let (shown, _) = shown()
        .split_once("[sampling]")
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .unwrap();
    let weakens = "dynamic = 0.45\ncritical_slip = \"5 mm\"\n";
    let text = shown.replace(weakens, "").replace("-35 MPa", "-25 MPa");
    // at even throws the middle of one of 400 elements meets a corner
    for throw in [40, 57, 74, 75, 92, 118] {
        let with = |elements: &str| {
            let text = text.replace("throw = \"75 m\"", &format!("throw = \"{throw} m\""));
            write(
                &file,
                &text.replace("to = \"400 m\"", &format!("to = \"400 m\"\n{elements}")),
            );
            let ran = fracas(&["fault", file.to_str().unwrap()]);
            assert_eq!(ran.status, 0, "{}", ran.stderr);
            number_after(&ran.stdout, "∫|δ| = ")
        };
        let [found, fine] = ["", "elements = 5000"].map(with);
        assert!(
            fine > 1e-3 && (found / fine - 1.0).abs() < 0.04,
            "{throw} m: {found} {fine}"
        );
    }
}

#[test]
fn blocks_may_touch_and_samples_out_of_equilibrium_are_said() {
    let folder = scratch("fault-touch");
    let file = folder.join("fault.toml");
    let ran = |old: &str, new: &str| {
        let text = shown().replace("samples = 1000", "samples = 60");
        assert!(text.contains(old), "{old}");
        write(&file, &text.replacen(old, new, 1));
        let ran = fracas(&["fault", file.to_str().unwrap()]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        ran.stdout
    };
    let right = "[37, 100], [37, -100], [5000, -100], [5000, 100]";
    let left = "[37, -100], [37, 100], [-5000, 100], [-5000, -100]";
    ran(RESERVOIR, &blocks(&[right, left]));
    let lines = ran("static = [0.5, 0.65]", "static = [0.0, 0.65]");
    assert!(
        lines.contains(
            "samples are not in equilibrium before the pressure changes and are left out"
        ),
        "{lines}"
    );
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
        (
            "throw = \"75 m\"",
            "throw = \"75 m\"\nwidth = \"10 m\"",
            "reservoir.width = 10 m: the fault leans over 50.0 m",
        ),
        (
            "horizontal_ratio = 0.74",
            "horizontal_ratio = 0.3",
            "not in equilibrium before the pressure changes: at a height of -399",
        ),
        (
            RESERVOIR,
            &blocks(&[SQUARE, SQUARE]),
            "blocks 1 and 2 overlap by 1.0000e6 m^2",
        ),
        (
            RESERVOIR,
            &blocks(&[
                SQUARE,
                "[5000, 100], [6000, 100], [6000, 0], [5000, 0]",
                "[4000, 50], [7000, 90], [7000, 150]",
            ]),
            "blocks 1 and 3 overlap by",
        ),
        (
            RESERVOIR,
            &blocks(&["[0, -100], [5000, 100], [5000, -100], [0, 200]"]),
            "block 1: its edges from corner 1 to 2 and from corner 3 to 4 meet",
        ),
        (
            RESERVOIR,
            &blocks(&[SQUARE, "[-9, 0], [-8, 0]"]),
            "block 2: a block is a polygon",
        ),
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
