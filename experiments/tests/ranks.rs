//! Claim: `mpirun -n N fracas solve … --engine petsc` finds on 1, 2 and 4 ranks what one process finds, in as many iterations, the same bits
//! in every run, and ends with one sentence and no deadlock where something is wrong on some rank.
//!
//! `OPENBLAS_NUM_THREADS=1 cargo test --release --features petsc -p fracas-experiments --test ranks`; without `mpirun` it says so and tests
//! nothing.
#![allow(clippy::unwrap_used)]

use fracas_operators::matrix_market::read_vector;
use fracas_operators::random::Random;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const FRACAS: &str = env!("CARGO_BIN_EXE_fracas");

/// Seconds after which ranks that should have ended wait for each other.
const DEADLOCK: u64 = 120;

/// A folder of one test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("ranks")
        .join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// True where ranks can be started; says so where they cannot.
fn has_mpirun() -> bool {
    let found = Command::new("mpirun").arg("--version").output().is_ok();
    if !found {
        println!("there is no mpirun: ranks are not tested here");
    }
    found
}

fn on_ranks(ranks: usize, arguments: &[&str]) -> Child {
    let mut command = Command::new("mpirun");
    command.args([
        "--oversubscribe",
        "--allow-run-as-root",
        "--bind-to",
        "none",
        "-n",
    ]);
    command.arg(ranks.to_string()).arg(FRACAS).args(arguments);
    command.env("OPENBLAS_NUM_THREADS", "1");
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().unwrap()
}

/// What it leaves, within the time that a deadlock has not.
fn ended(mut child: Child) -> Output {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(DEADLOCK) {
            child.kill().unwrap();
            panic!("ranks wait for each other");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

/// A system that was solved.
struct Solved {
    report: Value,
    x: Vec<f64>,
    bytes: Vec<u8>,
}

impl Solved {
    fn iterations(&self) -> i64 {
        self.report["iterations"].as_i64().unwrap()
    }
}

/// `fracas solve` in one process (0 ranks), or on ranks.
fn solve(ranks: usize, system: &[&str], inner: &str, room: &Path) -> Solved {
    let [json, mtx] = ["json", "mtx"].map(|end| room.join(format!("x.{end}")));
    let mut arguments = vec!["solve"];
    arguments.extend(system);
    arguments.extend(["--inner", inner, "--tolerance", "1e-10"]);
    arguments.extend([
        "--json",
        json.to_str().unwrap(),
        "--solution",
        mtx.to_str().unwrap(),
    ]);
    let output = match ranks {
        0 => Command::new(FRACAS).args(&arguments).output().unwrap(),
        _ => {
            arguments.extend(["--engine", "petsc"]);
            ended(on_ranks(ranks, &arguments))
        }
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{ranks} ranks, {inner}: {said}");
    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    if ranks > 0 {
        let memory = report["engine"]["peak_memory_bytes"].as_array().unwrap();
        assert_eq!(memory.len(), ranks);
        let n_u = report["engine"]["n_u"].as_array().unwrap();
        let n_u: i64 = n_u.iter().map(|n| n.as_i64().unwrap()).sum();
        assert_eq!(report["n_u"].as_i64(), Some(n_u));
    }
    Solved {
        report,
        x: read_vector(&mtx).unwrap(),
        bytes: std::fs::read(&mtx).unwrap(),
    }
}

/// The largest difference of two solutions, of u and of t, each relative to its largest entry.
fn far(a: &Solved, b: &Solved) -> f64 {
    assert_eq!(a.x.len(), b.x.len());
    let n_u = b.report["n_u"].as_u64().unwrap() as usize;
    let of = |a: &[f64], b: &[f64]| {
        let size = b.iter().fold(0.0f64, |m, b| m.max(b.abs()));
        let pairs = a.iter().zip(b);
        let off = pairs.fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        if off == 0.0 { 0.0 } else { off / size }
    };
    of(&a.x[..n_u], &b.x[..n_u]).max(of(&a.x[n_u..], &b.x[n_u..]))
}

/// Two fractures that cross, two rocks, sides held by rollers, one pushed by a displacement or a pressure.
fn random_scene(case: u64) -> String {
    let mut g = Random::new(7_000 + case);
    let cells: [u32; 3] = std::array::from_fn(|_| 2 * g.whole(2, 4));
    let (stiff, soft) = (g.between(20.0, 60.0), g.scale(0.05, 20.0));
    let push = match g.below(2) {
        0 => format!("pressure = \"{} MPa\"", g.between(1.0, 20.0)),
        _ => format!("displacement = {{ z = \"-{} mm\" }}", g.between(1.0, 5.0)),
    };
    let [x, y, z] = cells;
    format!(
        r#"
title = "Case {case}"
[mesh]
x = {{ from = "-4 m", to = "4 m", cells = {x} }}
y = {{ from = "0 m", to = "6 m", cells = {y} }}
z = {{ from = "-4 m", to = "4 m", cells = {z} }}
[[material]]
name = "stiff"
young = "{stiff} GPa"
poisson = 0.25
[[material]]
name = "soft"
young = "{soft} GPa"
poisson = 0.3
layers = [["-4 m", "0 m"]]
[[fracture]]
name = "upright"
plane = "x"
at = "0 m"
friction_angle = "30 deg"
[[fracture]]
name = "flat"
plane = "z"
at = "0 m"
friction_angle = "30 deg"
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "x-"
hold = "roller"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "x+"
pressure = "3 MPa"
[[boundary]]
side = "z+"
{push}
"#
    )
}

#[test]
fn random_scenes_have_the_same_answers_and_iterations_on_any_number_of_ranks() {
    if !has_mpirun() {
        return;
    }
    let room = folder("random");
    for case in 0..4 {
        let file = room.join(format!("case_{case}.toml"));
        std::fs::write(&file, random_scene(case)).unwrap();
        let scene = [file.to_str().unwrap()];
        let exact = solve(0, &scene, "mumps", &room);
        for inner in ["mumps", "gamg", "boomeramg"] {
            let one = solve(0, &scene, inner, &room);
            for ranks in [1, 2, 4] {
                let many = solve(ranks, &scene, inner, &room);
                let off = far(&many, &exact);
                println!(
                    "case {case}, {inner}, {ranks} ranks: {} iterations, {} in one process, off by {off:.1e}",
                    many.iterations(),
                    one.iterations()
                );
                assert!(off < 1e-8, "case {case}, {inner}, {ranks} ranks: {off:e}");
                // an aggregate ends where the rows of a rank end
                let allowed = if inner == "mumps" { 1 } else { 3 };
                let more = many.iterations() - one.iterations();
                assert!(
                    more.abs() <= allowed,
                    "case {case}, {inner}, {ranks} ranks: {more:+}"
                );
            }
        }
    }
}

#[test]
fn a_folder_is_solved_by_rows_and_every_run_repeats_every_bit() {
    if !has_mpirun() {
        return;
    }
    let room = folder("folder");
    let system = room.join("system");
    let system = system.to_str().unwrap();
    let exported = Command::new(FRACAS)
        .args([
            "export",
            "crossing",
            "--set",
            "mesh.y.cells=3",
            "--out",
            system,
        ])
        .output()
        .unwrap();
    assert!(exported.status.success());
    let system = ["--system", system];
    let one = solve(0, &system, "mumps", &room);
    // MUMPS, which hands tasks out as they come, repeats to rounding only
    for inner in ["gamg", "boomeramg", "mumps"] {
        for ranks in [2, 4] {
            let [first, again] = [(); 2].map(|()| solve(ranks, &system, inner, &room));
            assert!(far(&first, &one) < 1e-8);
            let is_same = first.bytes == again.bytes;
            assert!(is_same || inner == "mumps", "{inner}, {ranks} ranks");
            assert_eq!(first.iterations(), again.iterations());
        }
    }
}

/// Standard error of ranks that are asked for what there is not.
fn refused(ranks: usize, arguments: &[&str]) -> String {
    let mut all = vec!["solve"];
    all.extend(arguments);
    all.extend(["--engine", "petsc"]);
    let output = ended(on_ranks(ranks, &all));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    said
}

#[test]
fn what_is_wrong_is_said_once_and_all_ranks_end() {
    if !has_mpirun() {
        return;
    }
    for (arguments, sentence) in [
        (&["nowhere.toml"][..], "nowhere.toml"),
        (&["crossing", "--inner", "amg"], "take --inner gamg"),
        (&["crossing", "--method", "mcp"], "take --method racp"),
        (
            &["crossing", "--augmentation", "exact_h"],
            "take --augmentation fitted_h",
        ),
        (
            &["crossing", "--set", "mesh.x.cells=0"],
            "positive whole number",
        ),
        (&["--system", "nowhere"], "nowhere"),
        (
            &["crossing", "--json", "/proc/nothing/x.json"],
            "/proc/nothing",
        ),
    ] {
        let said = refused(2, arguments);
        assert!(said.contains(sentence), "{arguments:?}: {said}");
        let errors = said
            .lines()
            .filter(|line| line.starts_with("error:"))
            .count();
        assert_eq!(errors, 1, "{arguments:?}: {said}");
    }
    // more ranks than nodes
    let cells = ["mesh.x.cells=2", "mesh.y.cells=1", "mesh.z.cells=1"];
    let mut few = vec!["clamped"];
    cells.iter().for_each(|c| few.extend(["--set", c]));
    let said = refused(10, &few);
    assert!(said.contains("fewer ranks"), "{said}");
}

/// The matrix market text with the sign of diagonal entry `row` changed.
fn negated(text: &str, row: &str) -> String {
    let lines = text.lines().map(|line| match line.split_once(' ') {
        Some((i, rest)) if i == row && rest.starts_with(&format!("{row} ")) => {
            let value = rest.split_once(' ').unwrap().1;
            format!("{row} {row} -{value}\n")
        }
        _ => format!("{line}\n"),
    });
    lines.collect()
}

#[test]
fn an_indefinite_matrix_is_refused_by_mumps_over_ranks() {
    if !has_mpirun() {
        return;
    }
    let room = folder("indefinite");
    let system = room.join("system");
    let arguments = ["--set", "mesh.y.cells=2", "--out", system.to_str().unwrap()];
    let exported = Command::new(FRACAS)
        .args(["export", "crossing"])
        .args(arguments)
        .output();
    assert!(exported.unwrap().status.success());
    let a = system.join("A.mtx");
    let text = std::fs::read_to_string(&a).unwrap();
    let changed = negated(&text, "300");
    assert!(changed.contains("300 300 -"));
    std::fs::write(&a, changed).unwrap();
    let said = refused(
        2,
        &["--system", system.to_str().unwrap(), "--inner", "mumps"],
    );
    assert!(said.contains("S_u") && said.contains("negative"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn the_end_of_one_rank_is_the_end_of_all() {
    if !has_mpirun() {
        return;
    }
    let cells = ["x", "y", "z"].map(|d| format!("mesh.{d}.cells=40"));
    let mut arguments = vec!["solve", "layered_crossing", "--engine", "petsc"];
    cells.iter().for_each(|c| arguments.extend(["--set", c]));
    let mpirun = on_ranks(2, &arguments);
    let children = || -> Vec<i32> {
        let path = format!("/proc/{0}/task/{0}/children", mpirun.id());
        let listed = std::fs::read_to_string(path).unwrap_or_default();
        listed
            .split_whitespace()
            .map(|pid| pid.parse().unwrap())
            .collect()
    };
    let start = Instant::now();
    while children().len() < 2 {
        assert!(start.elapsed() < Duration::from_secs(30), "no ranks");
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(1500));
    let ranks = children();
    let killed = Command::new("kill")
        .args(["-9", &ranks[1].to_string()])
        .status();
    assert!(killed.unwrap().success());
    let output = ended(mpirun);
    assert!(!output.status.success());
    for pid in ranks {
        let is_gone = || !Path::new(&format!("/proc/{pid}")).exists();
        let start = Instant::now();
        while !is_gone() {
            assert!(
                start.elapsed() < Duration::from_secs(20),
                "rank {pid} goes on"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}
