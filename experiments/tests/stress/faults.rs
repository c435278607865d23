//! Disks that are full or read-only, and memory that ends: a sentence and status 2, never a signal.

#![cfg(unix)]

use crate::folders::FILES;
use crate::random::{ended, fracas};
use crate::room::{Verdict, count, scratch, trial};
use crate::scenes::RICH;
use std::path::Path;
use std::process::{Command, Output};

/// The rich scene in a file of this folder.
fn rich_scene(folder: &Path) -> String {
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, RICH).unwrap();
    scene.display().to_string()
}

#[test]
fn what_cannot_be_written_is_said() {
    let folder = scratch("disk");
    let scene = rich_scene(&folder);
    let system = folder.join("system");
    std::fs::create_dir(&system).unwrap();
    for (name, text) in FILES {
        std::fs::write(system.join(name), text).unwrap();
    }
    let system = system.display().to_string();
    let mut lines = vec![
        vec!["run", &scene, "--out", "/proc/fracas"],
        vec!["run", &scene, "--out", &scene],
        vec!["export", &scene, "--out", "/proc/fracas"],
        vec!["export", &scene, "--out", "/dev/null"],
        vec!["solve", "--system", &system, "--json", "/proc/fracas.json"],
        vec![
            "spectrum",
            "--system",
            &system,
            "--plot",
            "/proc/fracas.svg",
        ],
    ];
    if Path::new("/dev/full").exists() {
        for option in ["--json", "--solution"] {
            lines.push(vec!["solve", "--system", &system, option, "/dev/full"]);
        }
    }
    for line in lines {
        let ran = fracas(&line);
        assert_eq!(ended(&ran), Ok(2), "{line:?}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// The program with at most so much address space.
fn within(kibibytes: usize, arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(["-c", "ulimit -v $0 && exec \"$@\"", &kibibytes.to_string()])
        .arg(env!("CARGO_BIN_EXE_fracas"))
        .args(arguments)
        .output()
        .unwrap()
}

/// Address space of threads as they begin, without which the standard library ends them [KiB].
const THREADS: usize = 6_000;

/// The least address space in which the program begins its work [KiB].
fn least() -> usize {
    let holds = |k: &usize| within(*k, &["--version"]).status.success();
    let some = (10_000..1_000_000).step_by(1_000).find(holds);
    THREADS + some.expect("the program begins within a gigabyte of addresses")
}

#[test]
fn memory_that_ends_is_said_with_the_number_asked_for() {
    let folder = scratch("memory");
    let scene = rich_scene(&folder);
    let out = folder.join("out");
    let to = out.display().to_string();
    let least = least();
    trial("memory", count(3e-5, 12), |g| {
        let _ = std::fs::remove_dir_all(&out);
        // multiples of the cells of the scene keep its fracture on lines of the grid
        let cells = 1 + g.below(12);
        let sets = [("x", 4), ("y", 2), ("z", 3)]
            .map(|(axis, n)| format!("mesh.{axis}.cells={}", n * cells));
        // from little more than the program to enough for all of it
        let kibibytes = least + g.below(60_000 + 400 * cells * cells * cells);
        let mut line = match g.below(3) {
            0 => vec!["run", &scene, "--out", &to],
            1 => vec!["export", &scene, "--out", &to],
            _ => vec!["solve", &scene, "--inner", "amg"],
        };
        line.extend(["--threads", "2"]);
        for set in &sets {
            line.extend(["--set", set]);
        }
        let ran = within(kibibytes, &line);
        match ended(&ran) {
            Ok(0) => Verdict::Taken,
            Ok(_) => Verdict::Refused,
            Err(what) => Verdict::Finding(format!("{line:?} within {kibibytes} KiB {what}")),
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A run that finishes within some addresses finishes within more of them. One thread works beside the one that starts it; of several it
/// is chance how many multiply dense matrices, for which `private-gemm-x86` reserves twice the third-level cache for each of them: 64 MiB
/// on one machine, a gigabyte on another. So the first limit that suffices is looked for, and what is held are the limits beyond it.
#[test]
fn more_memory_refuses_no_run() {
    /// Between two limits, and how many are tried beyond the first that suffices [KiB, 1].
    const STEP: usize = 8_000;
    const BEYOND: usize = 30;
    let folder = scratch("more_memory");
    let scene = rich_scene(&folder);
    let out = folder.join("out");
    let to = out.display().to_string();
    let ran = |kibibytes: usize| {
        let _ = std::fs::remove_dir_all(&out);
        let line = ["run", &scene, "--out", &to, "--threads", "1"];
        let output = within(kibibytes, &line);
        let status = ended(&output).unwrap();
        (status, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let Some(enough) = (80_000..8_000_000).step_by(STEP).find(|&k| ran(k).0 == 0) else {
        panic!("8 GB of addresses are too few: {}", ran(8_000_000).1)
    };
    for more in (1..=BEYOND).map(|i| enough + i * STEP) {
        let (status, said) = ran(more);
        assert_eq!(
            status, 0,
            "{more} KiB are too few, {enough} are not: {said}"
        );
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
