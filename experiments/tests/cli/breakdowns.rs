//! Claim: a method that cannot be set up, or that breaks down, says which block and row, or which iteration, in one
//! sentence; it never panics.

#![allow(clippy::unwrap_used, reason = "a test that cannot read a report fails")]

use crate::run::{Ran, fracas, scratch, system_folder, write};
use serde_json::Value;

const HEAD: &str = "%%MatrixMarket matrix coordinate real general\n";

/// `solve --system FOLDER --json -` with more arguments, on the folder of four displacements with one file replaced.
fn solve(name: &str, file: &str, text: &str, more: &[&str]) -> Ran {
    let folder = system_folder(&format!("breakdown-{name}"));
    write(&folder.join(file), text);
    let fixed = ["solve", "--system", folder.to_str().unwrap(), "--json", "-"];
    let ran = fracas(&[&fixed, more].concat());
    assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
    ran
}

/// Status 2 and one sentence that contains all of these.
#[track_caller]
fn refused(ran: &Ran, words: &[&str]) {
    assert_eq!((ran.status, ran.stdout.as_str()), (2, ""), "{}", ran.stderr);
    let errors: Vec<&str> = ran
        .stderr
        .lines()
        .filter(|l| l.starts_with("error: "))
        .collect();
    assert_eq!(errors.len(), 1, "{}", ran.stderr);
    for word in words {
        assert!(errors[0].contains(word), "`{}` lacks `{word}`", errors[0]);
    }
}

/// Status 3, outcome `breakdown` and a reason that contains this.
#[track_caller]
fn broke_down(ran: &Ran, sentence: &str) {
    assert_eq!(ran.status, 3, "{}", ran.stderr);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(report["outcome"], "breakdown", "{report}");
    assert!(report["C_s"].is_null());
    let reason = report["reason"].as_str().unwrap();
    assert!(reason.contains(sentence), "{reason}");
}

/// A of the folder with the diagonal entry of one row replaced.
fn with_diagonal(row: usize, value: &str) -> String {
    let mut text = format!("{HEAD}4 4 10\n");
    for i in 1..=4 {
        let d = if i == row { value } else { "4" };
        text += &format!("{i} {i} {d}\n");
    }
    text + "2 1 -1\n1 2 -1\n3 2 -1\n2 3 -1\n4 3 -1\n3 4 -1\n"
}

#[test]
fn a_negative_diagonal_names_block_and_row() {
    let a = with_diagonal(3, "-40");
    for (k, more) in [
        &["--method", "racp"][..],
        &["--inner", "amg"],
        &["--inner", "fsai"],
        &["--inner", "jacobi"],
        &["--inner", "ssor"],
        &["--method", "mcp"],
        &["--method", "augmented_lagrangian"],
        &["--method", "block_diagonal"],
        &["--method", "block_triangular"],
        &["--method", "simple"],
    ]
    .iter()
    .enumerate()
    {
        let ran = solve(&format!("negative-{k}"), "A.mtx", &a, more);
        refused(&ran, &["block ", "row 3"]);
    }
    let ran = solve("negative-note", "A.mtx", &a, &["--method", "direct"]);
    assert_eq!(ran.status, 0);
    assert!(
        ran.stderr.contains(
            "A.mtx, row 3: 1 diagonal entry is negative, or zero in a nonzero row (first: -4e1)"
        ),
        "{}",
        ran.stderr
    );
}

#[test]
fn an_indefinite_matrix_with_a_positive_diagonal_names_block_and_row() {
    // eigenvalues 4 ± 9 in the first two rows
    let a = format!("{HEAD}4 4 6\n1 1 4\n2 2 4\n3 3 4\n4 4 4\n1 2 9\n2 1 9\n");
    for (k, more) in [
        &["--method", "simple"][..],
        &["--method", "mcp:0", "--inner", "fsai"],
        &["--method", "block_diagonal"],
    ]
    .iter()
    .enumerate()
    {
        let ran = solve(&format!("indefinite-{k}"), "A.mtx", &a, more);
        refused(&ran, &["block A", "row "]);
    }
}

#[test]
fn a_zero_diagonal_is_named_by_the_methods_on_a_and_held_by_those_on_s_u() {
    // row 4 holds nothing: only B1 holds this unknown
    let a = format!("{HEAD}4 4 3\n1 1 4\n2 2 4\n3 3 4\n");
    for (k, method) in ["mcp:0", "block_diagonal", "block_triangular", "simple"]
        .iter()
        .enumerate()
    {
        let ran = solve(
            &format!("zero-{k}"),
            "A.mtx",
            &a,
            &["--method", method, "--inner", "jacobi"],
        );
        refused(&ran, &["block A", "row 4"]);
    }
    for (k, more) in [
        &["--method", "racp"][..],
        &["--method", "mcp"],
        &["--method", "augmented_lagrangian"],
        &["--method", "block_diagonal", "--augmentation", "global"],
    ]
    .iter()
    .enumerate()
    {
        let ran = solve(&format!("held-{k}"), "A.mtx", &a, more);
        assert_eq!(ran.status, 0, "{more:?}: {}", ran.stderr);
    }
}

#[test]
fn nan_and_what_leaves_the_range_of_numbers_are_found_before_the_iteration() {
    let ran = solve("nan", "A.mtx", &with_diagonal(2, "nan"), &[]);
    refused(&ran, &["A.mtx, line 4", "row 2, column 2"]);
    let rhs = "%%MatrixMarket matrix array real general\n4 1\n1e300\n1\n1\n1\n";
    let ran = solve("overflow", "rhs_u.mtx", rhs, &[]);
    refused(
        &ran,
        &["rhs_u.mtx, row 1", "the entry 1e300 is out of range"],
    );
}

#[test]
fn a_right_hand_side_outside_the_range_stagnates_or_is_singular() {
    // the second traction touches nothing
    let b = format!("{HEAD}4 2 2\n1 1 -1\n2 1 1\n");
    let ran = solve("stagnation", "B1.mtx", &b, &[]);
    broke_down(&ran, "the true residual stays at");
    let ran = solve("singular", "B1.mtx", &b, &["--method", "direct"]);
    refused(&ran, &["block [A B1; B2 −H] is singular"]);
    for (k, method) in ["mcp", "block_diagonal", "simple"].iter().enumerate() {
        let ran = solve(&format!("schur-{k}"), "B1.mtx", &b, &["--method", method]);
        refused(&ran, &["block S = H + "]);
    }
}

#[test]
fn an_iteration_that_needs_a_definite_preconditioner_says_so() {
    let h = format!("{HEAD}2 2 2\n1 1 0.1\n2 2 0.1\n");
    for krylov in ["minres", "cg"] {
        let ran = solve(
            &format!("definite-{krylov}"),
            "H.mtx",
            &h,
            &["--krylov", krylov],
        );
        broke_down(&ran, "is not positive definite");
    }
    let more = ["--krylov", "minres", "--method", "block_diagonal"];
    assert_eq!(solve("definite-diagonal", "H.mtx", &h, &more).status, 0);
}

#[test]
fn parts_that_mean_nothing_to_a_method_are_refused() {
    refused(
        &fracas(&["solve", "patch", "--method", "direct", "--inner", "fsai"]),
        &["method direct has no inner solver; methods with one: racp"],
    );
    refused(
        &fracas(&[
            "spectrum",
            "patch",
            "--method",
            "mcp",
            "--augmentation",
            "local",
        ]),
        &["method mcp has no augmentation C; methods with one: racp"],
    );
    let unknown = fracas(&["solve", "patch", "--method", "racpp"]);
    assert_eq!(unknown.status, 2);
    assert!(
        unknown
            .stderr
            .contains("expected racp, mcp, augmented_lagrangian, block_diagonal")
    );
    let help = fracas(&["solve", "--help"]).stdout;
    for name in [
        "racp",
        "mcp",
        "augmented_lagrangian",
        "block_diagonal",
        "block_triangular",
        "simple",
        "direct",
    ] {
        assert!(help.contains(name), "{name}");
    }
}

#[test]
fn mcp_without_augmentation_does_not_apply_to_a_floating_block() {
    refused(
        &fracas(&["solve", "floating", "--method", "mcp:0"]),
        &["mcp with γ = 0 does not apply", "block A", "take γ > 0"],
    );
}

#[test]
fn coordinates_that_do_not_fit_are_a_finding() {
    let folder = crate::run::scratch("breakdown-coordinates");
    let path = folder.to_str().unwrap();
    assert_eq!(fracas(&["export", "crossing", "--out", path]).status, 0);
    let check = || fracas(&["check", "--system", path]).stdout;
    assert!(!check().contains("cost force"), "{}", check());
    let file = folder.join("coords.mtx");
    let text = std::fs::read_to_string(&file).unwrap();
    let mut values = text.lines().skip_while(|l| l.starts_with('%'));
    let size = values.next().unwrap();
    // the first column holds x: twice as long
    let n: usize = size.split_whitespace().next().unwrap().parse().unwrap();
    let stretched = values.enumerate().map(|(k, l)| {
        let value: f64 = l.trim().parse().unwrap();
        format!("{:e}\n", if k < n { 2.0 * value } else { value })
    });
    let all: String = stretched.collect();
    write(
        &file,
        &format!("%%MatrixMarket matrix array real general\n{size}\n{all}"),
    );
    assert!(
        check().contains(
            "the coordinates do not fit A, and multigrid would build on wrong rigid-body modes"
        ),
        "{}",
        check()
    );
}

/// A bar of 1:1e6 bends with 1e-24 of its stiffness: beyond f64, but it is held.
#[test]
fn rounding_is_not_blamed_on_supports() {
    let folder = scratch("slender");
    let scene = folder.join("bar.toml");
    let axis = |name: &str, to: &str, cells: usize| {
        format!("{name} = {{ from = '0 m', to = '{to}', cells = {cells} }}\n")
    };
    let text = [
        "title = 'bar'\n[mesh]\n",
        &axis("x", "1000 km", 40),
        &axis("y", "1 m", 4),
        &axis("z", "1 m", 4),
        "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n",
        "[[fracture]]\nname = 'f'\nplane = 'x'\nat = '500 km'\nfriction_angle = '30 deg'\n",
        "[[boundary]]\nside = 'x-'\nhold = 'fixed'\n[[boundary]]\nside = 'x+'\npressure = '1 MPa'\n",
    ];
    write(&scene, &text.concat());
    let path = scene.to_str().unwrap();
    let checked = fracas(&["check", path]);
    assert_eq!(checked.status, 0, "{}", checked.stderr);
    let solved = fracas(&["solve", path, "--inner", "exact"]);
    assert_eq!(solved.status, 2, "{}", solved.stdout);
    assert!(
        solved.stderr.contains("every body is held"),
        "{}",
        solved.stderr
    );
    let out = folder.join("out");
    let ran = fracas(&["run", path, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 3, "{}", ran.stderr);
    assert!(ran.stderr.contains("every body is held"), "{}", ran.stderr);
    let gave_way = "the inner solver is geometric instead";
    assert!(ran.stderr.contains(gave_way), "{}", ran.stderr);
    let blamed = ran.stderr.contains("rigid motions are free");
    assert!(!blamed, "{}", ran.stderr);
}
