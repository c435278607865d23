//! What the room found, as fixed cases.

use crate::folders::FILES;
use crate::random::{ended, fracas};
use crate::room::{Verdict, scratch};
use crate::scenes::{RICH, judge};

/// Status 2 and this sentence.
fn refused(arguments: &[&str], sentence: &str) {
    let ran = fracas(arguments);
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ended(&ran), Ok(2), "{arguments:?}");
    assert!(said.contains(sentence), "{arguments:?}: {said}");
}

/// A header of a few bytes must not decide how much memory is taken.
#[test]
fn sizes_in_headers_are_held_against_the_other_blocks() {
    let folder = scratch("headers");
    let at = folder.display().to_string();
    let solve = ["solve", "--system", &at];
    let cases = [
        (
            "rhs_t.mtx",
            "2 1 1",
            "4000000000 1 1",
            "rhs_t.mtx is 4000000000×1, expected 2×1 because B1.mtx is 6×2",
        ),
        (
            "H.mtx",
            "2 2 4",
            "4000000000 4000000000 4",
            "expected 2×2 because B1.mtx is 6×2",
        ),
        (
            "B1.mtx",
            "6 2 4",
            "4000000000 2 4",
            "B1.mtx is 4000000000×2, expected 6×2 because A.mtx is 6×6",
        ),
        (
            "A.mtx",
            "6 6 11",
            "4000000000 4000000000 11",
            "expected 4000000000×2 because A.mtx is 4000000000×4000000000",
        ),
    ];
    for (name, from, to, sentence) in cases {
        for (file, text) in FILES {
            std::fs::write(folder.join(file), text).unwrap();
        }
        let text = FILES.iter().find(|(n, _)| *n == name).unwrap().1;
        std::fs::write(folder.join(name), text.replace(from, to)).unwrap();
        refused(&solve, sentence);
    }
    // they agree, and nothing bears them out
    for (file, _) in FILES {
        std::fs::remove_file(folder.join(file)).unwrap();
    }
    let rewritten = |(file, from, to): (&str, &str, &str)| {
        let text = FILES.iter().find(|(n, _)| *n == file).unwrap().1;
        std::fs::write(folder.join(file), text.replace(from, to)).unwrap();
    };
    rewritten(("A.mtx", "6 6 11", "4000000000 4000000000 11"));
    rewritten(("B1.mtx", "6 2 4", "4000000000 2 4"));
    refused(
        &solve,
        "A.mtx says 4000000000 rows, but it and B1.mtx list only 15 entries",
    );
    rewritten(("A.mtx", "", ""));
    rewritten(("B1.mtx", "6 2 4", "6 4000000000 4"));
    refused(
        &solve,
        "B1.mtx says 4000000000 columns, but it lists only 4 entries",
    );
    std::fs::remove_dir_all(&folder).unwrap();
}

/// `solver.max_newton` beyond the integers of TOML was taken by `--set` and could not be written.
#[test]
fn integers_too_large_for_a_scene_name_their_line() {
    let text = RICH.replace("max_newton = 15", "max_newton = 18446744073709551615");
    assert!(matches!(judge(&text), Verdict::Refused));
    let folder = scratch("integers");
    let file = folder.join("scene.toml");
    std::fs::write(&file, &text).unwrap();
    let line = 1 + text
        .lines()
        .position(|l| l.starts_with("max_newton"))
        .unwrap();
    let file = file.display().to_string();
    refused(&["check", &file], &format!("scene.toml:{line}:"));
    std::fs::remove_dir_all(&folder).unwrap();
}
