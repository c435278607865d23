//! Runs that are killed, terminated or interrupted at any moment: nothing is lost, and going on leaves what an unbroken run leaves.

#![cfg(unix)]

use crate::random::fracas;
use crate::room::{Verdict, count, scratch, trial};
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A sheared block that sticks, slips and slips back.
const SCENE: &str = include_str!("../sheared_block.toml");

#[test]
fn a_run_with_many_short_steps_survives_every_signal() {
    survives("signals", 1, 20, count(2e-5, 5));
}

/// Most of its time goes into METIS and the factorization.
#[test]
fn a_run_that_factorizes_survives_every_signal() {
    survives("signals in factorizations", 3, 2, count(2e-5, 3));
}

/// A pipe that nobody writes into, in the place of a scene and of a checkpoint: there is no state to write, so nothing to wait for.
#[test]
fn a_run_that_waits_for_its_input_ends_at_the_first_signal() {
    let folder = scratch("waiting");
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&scene, SCENE).unwrap();
    let pipe = folder.join("pipe.toml");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let name = |path: &Path| path.display().to_string();
    let of_scene = vec!["run".into(), name(&pipe), "--out".into(), name(&out)];
    let mut of_checkpoint = vec!["run".into(), name(&scene), "--out".into(), name(&out)];
    of_checkpoint.extend(["--restart".into(), name(&pipe)]);
    let of_study = vec!["study".into(), name(&pipe), "--out".into(), name(&out)];
    for arguments in [of_scene, of_checkpoint, of_study] {
        for (signal, number) in [("TERM", 15), ("INT", 2)] {
            if is_ignored(number) {
                eprintln!("SIG{signal} is ignored where this test was started, and not tried");
                continue;
            }
            let mut child = Command::new(env!("CARGO_BIN_EXE_fracas"))
                .args(&arguments)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(Duration::from_millis(300));
            send(&child, signal);
            let clock = Instant::now();
            let ended = loop {
                match child.try_wait().unwrap() {
                    None if clock.elapsed() < Duration::from_secs(20) => {
                        std::thread::sleep(Duration::from_millis(10));
                    }
                    ended => break ended,
                }
            };
            if ended.is_none() {
                child.kill().unwrap();
                child.wait().unwrap();
            }
            let by = ended.and_then(|status| status.signal());
            assert_eq!(by, Some(number), "{arguments:?} by {signal}: {ended:?}");
        }
    }
    fs::remove_dir_all(&folder).unwrap();
}

/// True where this process was started with a signal ignored, as a shell without a terminal does for Ctrl-C of what runs in its
/// background; its children inherit that.
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// The block with its cells divided into this many along each axis.
fn survives(kind: &'static str, refined: usize, steps: usize, cases: u64) {
    let folder = scratch(&kind.replace(' ', "-"));
    let scene = folder.join("scene.toml");
    let mut text = SCENE.replace("steps = 10", &format!("steps = {steps}"));
    for cells in [6, 4, 3] {
        let of = |n: usize| format!("m\", cells = {n} }}");
        text = text.replace(&of(cells), &of(cells * refined));
    }
    text += "[solver]\ninner = \"exact\"\n";
    fs::write(&scene, text).unwrap();
    let scene = scene.display().to_string();
    let whole = folder.join("whole");
    let clock = Instant::now();
    let ran = fracas(&["run", &scene, "--out", &whole.display().to_string()]);
    assert_eq!(
        ran.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let takes = clock.elapsed();
    let out = folder.join("out");
    trial(kind, cases, |g| {
        let _ = fs::remove_dir_all(&out);
        let signal = g.one_of(&["TERM", "INT", "KILL", "TERM"]);
        let moment = takes.mul_f64(g.unit());
        let to = out.display().to_string();
        let mut child = Command::new(env!("CARGO_BIN_EXE_fracas"))
            .args(["run", &scene, "--out", &to])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(moment);
        send(&child, signal);
        let hasty = g.once_in(4);
        if hasty {
            std::thread::sleep(Duration::from_millis(1));
            send(&child, signal);
        }
        let status = child.wait().unwrap();
        let what = format!("{signal} after {moment:?} of {takes:?}, {status:?}");
        match judge(signal, hasty, (status.code(), status.signal()), &out) {
            Err(finding) => return Verdict::Finding(format!("{what}: {finding}")),
            Ok(true) => return compare(&out, &whole, &what),
            Ok(false) => {}
        }
        let again = match out.exists() {
            true => fracas(&["run", &scene, "--restart", &to]),
            // it was ended before it began
            false => fracas(&["run", &scene, "--out", &to]),
        };
        match again.status.code() {
            Some(0) => compare(&out, &whole, &what),
            _ => Verdict::Finding(format!(
                "{what}: {}",
                String::from_utf8_lossy(&again.stderr)
            )),
        }
    });
    fs::remove_dir_all(&folder).unwrap();
}

fn send(child: &Child, signal: &str) {
    // it may be gone already
    let _ = Command::new("kill")
        .args([&format!("-{signal}"), &child.id().to_string()])
        .stderr(Stdio::null())
        .status()
        .unwrap();
}

/// Whether the run had come to its end, or what is wrong with how it ended.
fn judge(
    signal: &str,
    hasty: bool,
    ended: (Option<i32>, Option<i32>),
    out: &Path,
) -> Result<bool, String> {
    let (number, polite) = match signal {
        "TERM" => (15, true),
        "INT" => (2, true),
        _ => (9, false),
    };
    let outcome = fs::read_to_string(out.join("run.json")).unwrap_or_default();
    match ended {
        (Some(0), None) => Ok(true),
        (Some(code), None) if polite && code == 128 + number => {
            let said = outcome.contains("\"outcome\": \"interrupted\"")
                && outcome.contains("go on with")
                && outcome.contains("--restart");
            said.then_some(false)
                .ok_or(format!("run.json says {outcome}"))
        }
        // before the handlers are there, or by the second one
        (None, Some(by))
            if by == number && (!polite || hasty || !out.exists() || outcome.is_empty()) =>
        {
            Ok(false)
        }
        other => Err(format!("ends with {other:?}")),
    }
}

/// Everything of a finished run that must not depend on how it got there.
fn compare(out: &Path, whole: &Path, what: &str) -> Verdict {
    let ours = content(out);
    let theirs = content(whole);
    if ours.len() != theirs.len() {
        return Verdict::Finding(format!(
            "{what}: {} files in place of {}",
            ours.len(),
            theirs.len()
        ));
    }
    let differs = ours.iter().zip(&theirs).find(|(a, b)| a != b);
    match differs {
        Some((a, _)) => Verdict::Finding(format!("{what}: {} differs", a.0)),
        None => Verdict::Taken,
    }
}

/// Names and bytes; of `solver.csv` all columns but `setup`, which counts what a restart builds again.
fn content(out: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for folder in ["", "figures"] {
        for entry in fs::read_dir(out.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let own = ["run.json", "log.jsonl", "run.lock"].contains(&name.as_str());
            // what a killed process did not finish
            let unfinished = name.starts_with('.');
            if path.is_file() && !own && !unfinished {
                found.push((format!("{folder}/{name}"), fs::read(&path).unwrap()));
            }
        }
    }
    let newest = fs::read_dir(out.join("checkpoint")).unwrap();
    let newest = newest
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "checkpoint"));
    if let Some(path) = newest.max() {
        found.push((
            path.file_name().unwrap().to_string_lossy().into_owned(),
            fs::read(&path).unwrap(),
        ));
    }
    for (name, bytes) in &mut found {
        if name == "/solver.csv" {
            *bytes = without_setup(&String::from_utf8_lossy(bytes)).into_bytes();
        }
    }
    found.sort();
    found
}

fn without_setup(text: &str) -> String {
    let at = text
        .lines()
        .next()
        .and_then(|h| h.split(',').position(|c| c == "setup"));
    let rows = text.lines().map(|row| {
        let fields = row.split(',').enumerate().filter(|(k, _)| Some(*k) != at);
        fields.map(|(_, f)| f).collect::<Vec<_>>().join(",") + "\n"
    });
    rows.collect()
}
