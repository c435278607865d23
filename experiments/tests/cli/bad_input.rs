//! Claim: every bad input ends with status 2 and one sentence that says what is wrong and where.

use crate::run::{fracas, system_folder, write};

/// Runs, and checks status 2, an empty standard output, and the end of standard error.
fn refused(arguments: &[&str], sentence: &str) {
    let ran = fracas(arguments);
    assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.stderr);
    assert_eq!(ran.stdout, "", "{arguments:?}");
    let last = ran
        .stderr
        .lines()
        .rev()
        .find(|l| l.starts_with("error: "))
        .unwrap_or_default();
    assert!(
        last.contains(sentence),
        "{arguments:?}: `{last}` should contain `{sentence}`"
    );
    assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
}

#[test]
fn arguments_that_do_not_exist() {
    refused(
        &["solve", "--system", "x", "--krylov", "gmers"],
        "no Krylov method `gmers`",
    );
    refused(
        &["solve", "--system", "x", "--tolerance", "2"],
        "the tolerance is a number between 0 and 1",
    );
    refused(
        &["solve", "--system", "x", "--tolerance", "nan"],
        "the tolerance is a number between 0 and 1",
    );
    refused(
        &["solve", "--system", "x", "--rhs", "zeros"],
        "invalid value 'zeros'",
    );
    refused(&["--threads", "0", "list"], "invalid value '0'");
    refused(&["--threads", "100000", "list"], "is not in 1..=1024");
    refused(&["--instructions", "mmx", "list"], "this machine has ");
    refused(
        &["spectrum", "patch", "--plot", "figure.png"],
        "let the name end in .svg or .pdf",
    );
    refused(&["reproduce", "e99999"], "no experiment `e99999`");
    assert_eq!(fracas(&[]).status, 2);
    assert_eq!(fracas(&["reprodcue"]).status, 2);
}

#[test]
fn folders_that_are_no_system() {
    refused(
        &["solve", "--system", "/no/such/folder"],
        "/no/such/folder is not a folder",
    );
    let folder = system_folder("no-b");
    std::fs::remove_file(folder.join("B1.mtx")).unwrap();
    refused(
        &["solve", "--system", folder.to_str().unwrap()],
        "holds no B1.mtx",
    );
}

#[test]
fn what_makes_a_system_of_a_scene_is_refused_beside_a_folder() {
    let folder = system_folder("left-alone");
    let system = folder.to_str().unwrap();
    let set = "--set mesh.x.cells=8 has no effect on a system folder";
    for command in ["solve", "spectrum", "check"] {
        let line = [command, "--system", system, "--set", "mesh.x.cells=8"];
        refused(&line, set);
    }
    for command in ["solve", "spectrum"] {
        let line = [command, "--system", system, "--stabilization", "0"];
        refused(
            &line,
            "--stabilization has no effect on a system folder, whose H is in H.mtx",
        );
    }
    for (key, value) in [("state", "'stick', 'slip:0.25'"), ("stabilization", "1, 0")] {
        let study = format!(
            "title = 'Folders'\nmeasures = ['n_it']\n[axes]\nsystem = ['{system}']\n{key} = [{value}]\n"
        );
        let file = folder.join(format!("{key}.toml"));
        std::fs::write(&file, study).unwrap();
        refused(
            &["study", file.to_str().unwrap()],
            &format!("`{key}` has no effect on a system folder"),
        );
    }
}

#[test]
fn files_with_defects() {
    const HEAD: &str = "%%MatrixMarket matrix coordinate real general\n";
    let cases = [
        ("A.mtx", "hello\n", "A.mtx, line 1: expected the banner"),
        (
            "A.mtx",
            &format!("{HEAD}4 4 2\n1 1 1\n"),
            "A.mtx, line 3: truncated: the sizes announce 2 entries",
        ),
        (
            "A.mtx",
            &format!("{HEAD}4 4 1\n1 2 1\n"),
            "A.mtx is not symmetric: entry (1, 2) is 1e0, entry (2, 1) is 0e0",
        ),
        (
            "A.mtx",
            &format!("{HEAD}5 5 0\n"),
            "B1.mtx is 4×2, expected 5×2 because A.mtx is 5×5",
        ),
        (
            "B1.mtx",
            &format!("{HEAD}4 2 1\n5 1 1\n"),
            "B1.mtx, line 3: the entry (5, 1) lies outside the 4×2 matrix",
        ),
        (
            "H.mtx",
            &format!("{HEAD}2 2 1\n1 1 NaN\n"),
            "H.mtx, line 3: the value `NaN` in row 1, column 1",
        ),
        (
            "H.mtx",
            "%%MatrixMarket matrix coordinate complex general\n",
            "the field `complex` is not supported",
        ),
        (
            "Q1.mtx",
            &format!("{HEAD}4 1 0\n"),
            "holds Q1.mtx but no Q2.mtx",
        ),
        (
            "rhs_u.mtx",
            "%%MatrixMarket matrix array real general\n3 1\n1\n1\n1\n",
            "rhs_u.mtx is 3×1, expected 4×1",
        ),
        (
            "coords.mtx",
            "%%MatrixMarket matrix array real general\n1 1\n1\n",
            "coords.mtx is 1×1, expected 4×4",
        ),
        ("manifest.json", "{", "manifest.json: "),
        (
            "manifest.json",
            r#"{"n_u": 9}"#,
            "manifest.json says n_u = 9, but A.mtx gives 4",
        ),
    ];
    for (k, (file, text, sentence)) in cases.iter().enumerate() {
        let folder = system_folder(&format!("defect-{k}"));
        write(&folder.join(file), text);
        refused(&["solve", "--system", folder.to_str().unwrap()], sentence);
    }
}

#[test]
fn blocks_that_are_there_and_cannot_be_opened() {
    for (k, file) in [
        "H.mtx",
        "B2.mtx",
        "rhs_t.mtx",
        "coords.mtx",
        "manifest.json",
    ]
    .iter()
    .enumerate()
    {
        let folder = system_folder(&format!("closed-{k}"));
        let (path, system) = (folder.join(file), folder.to_str().unwrap());
        let _ = std::fs::remove_file(&path);
        std::os::unix::fs::symlink("nowhere", &path).unwrap();
        let sentence =
            format!("{file} is a link to nowhere, which leads to no file; mend it, or remove it");
        for command in ["solve", "spectrum", "check"] {
            refused(&[command, "--system", system], &sentence);
        }
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        refused(
            &["solve", "--system", system],
            &format!("{file} is a folder and no file"),
        );
    }
}

#[test]
fn an_exported_folder_that_has_lost_its_stabilization() {
    let folder = crate::run::scratch("lost-h");
    let out = folder.to_str().unwrap();
    assert_eq!(fracas(&["export", "patch", "--out", out]).status, 0);
    assert_eq!(fracas(&["solve", "--system", out]).status, 0);
    std::fs::rename(folder.join("H.mtx"), folder.join("h")).unwrap();
    refused(&["solve", "--system", out], "but the folder holds no H.mtx");
    std::fs::rename(folder.join("h"), folder.join("H.mtx")).unwrap();
    let manifest = std::fs::read_to_string(folder.join("manifest.json")).unwrap();
    let denied = manifest.replace(r#""stabilization": 1.0"#, r#""stabilization": 0.0"#);
    assert_ne!(manifest, denied);
    write(&folder.join("manifest.json"), &denied);
    refused(
        &["solve", "--system", out],
        "says stabilization = 0.0, but H.mtx holds",
    );
}

#[test]
fn output_that_cannot_be_written() {
    let folder = system_folder("output");
    let system = folder.to_str().unwrap();
    refused(
        &[
            "solve",
            "--system",
            system,
            "--json",
            "/proc/none/report.json",
        ],
        "/proc/none",
    );
    refused(
        &[
            "solve",
            "--system",
            system,
            "--solution",
            "/proc/none/x.mtx",
        ],
        "cannot create the folder /proc/none",
    );
    refused(
        &["export", "patch", "--out", "/proc/none"],
        "cannot create the folder /proc/none",
    );
}
