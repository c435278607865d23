//! Claim: `run` leaves a folder that other programs read, and that survives its process at any time.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

use crate::run::{Ran, fracas, scratch, write};
use fracas::scene::Scene;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Two blocks of rock, pressed together and sheared along an embedded fracture until it slips from its middle.
const SCENE: &str = r#"
title = "sheared block"
[mesh]
x = { from = "0 m", to = "4 m", cells = 4 }
y = { from = "0 m", to = "3 m", cells = 3 }
z = { from = "0 m", to = "4 m", cells = 6 }
[[material]]
name = "rock"
young = "10 GPa"
poisson = 0.25
[[fracture]]
name = "joint"
plane = "x"
at = "2 m"
z = ["0 m", "2.6666666666666665 m"]
friction_angle = "20 deg"
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "x+"
pressure = "5 MPa"
history = [["0 s", 1.0]]
[[boundary]]
side = "x+"
traction = { z = "4 MPa" }
[time]
end = "12 h"
steps = 10
history = [["0 s", 0.0], ["7 h", 1.0], ["12 h", -0.6]]
"#;

/// Rows of the history: time 0, ten steps and the corner of the load at 7 h between two of them.
const ROWS: usize = 12;

/// The time of a row [s].
fn time(row: usize) -> f64 {
    let hours = [0.0, 1.2, 2.4, 3.6, 4.8, 6.0, 7.0, 7.2, 8.4, 9.6, 10.8, 12.0];
    3600.0 * hours[row]
}

const HEADER: &str = "step,time_s,dt_s,active_it,newton_it,lin_it,lin_res,stick,newslip,slip,open,changed_area,max_pen,max_tau_viol,slip_max_m,cuts,wall_s";

/// A fresh folder with the scene in it.
fn scene(name: &str) -> (PathBuf, String) {
    let folder = scratch(&format!("output-{name}"));
    let file = folder.join("scene.toml");
    write(&file, SCENE);
    (folder, file.display().to_string())
}

/// `fracas run SCENE --out OUT MORE`.
fn run(scene: &str, out: &Path, more: &[&str]) -> Ran {
    let out = out.display().to_string();
    fracas(&[&["run", scene, "--out", &out][..], more].concat())
}

fn done(ran: &Ran) {
    assert_eq!(ran.status, 0, "{}", ran.stderr);
}

fn read(path: impl AsRef<Path>) -> String {
    let path = path.as_ref();
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Names in a folder that match a beginning and an end, sorted.
fn names(folder: &Path, begin: &str, end: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| n.starts_with(begin) && n.ends_with(end))
        .collect();
    names.sort();
    names
}

/// Everything of a finished run that must not depend on how it got there.
fn content(out: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = names(out, "", ".vtu");
    files.extend(["history.csv", "energy.csv", "scene.pvd", "resolved.toml"].map(String::from));
    let figures = names(&out.join("figures"), "", "");
    files.extend(figures.iter().map(|f| format!("figures/{f}")));
    let last = names(&out.join("checkpoint"), "", "").pop();
    files.extend(last.map(|f| format!("checkpoint/{f}")));
    let read = |f: String| {
        let bytes = fs::read(out.join(&f)).unwrap();
        (f, bytes)
    };
    files.into_iter().map(read).collect()
}

/// Equal files, named one by one where they are not.
fn same(ours: &Path, theirs: &Path, what: &str) {
    let (ours, theirs) = (content(ours), content(theirs));
    let list = |c: &[(String, Vec<u8>)]| c.iter().map(|(f, _)| f.clone()).collect::<Vec<_>>();
    assert_eq!(list(&ours), list(&theirs), "{what}");
    for ((file, a), (_, b)) in ours.iter().zip(&theirs) {
        assert!(a == b, "{what}: {file} differs");
    }
}

#[test]
fn a_run_leaves_its_tree() {
    let (folder, scene) = scene("tree");
    let out = folder.join("out");
    let ran = run(&scene, &out, &[]);
    done(&ran);
    assert!(ran.stdout.trim().ends_with("report.html"), "{}", ran.stdout);
    let lines = |l: &&str| l.starts_with("step ");
    assert_eq!(ran.stderr.lines().filter(lines).count(), ROWS);

    let history = read(out.join("history.csv"));
    assert_eq!(history.lines().next(), Some(HEADER));
    let rows: Vec<Vec<&str>> = history
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect())
        .collect();
    assert_eq!(rows.len(), ROWS);
    for (k, row) in rows.iter().enumerate() {
        assert_eq!((row.len(), row[0]), (17, k.to_string().as_str()));
        assert_eq!(row[16], "", "no clock was asked for");
        assert!(
            row[1..16].iter().all(|f| f.parse::<f64>().is_ok()),
            "{row:?}"
        );
        assert!((row[1].parse::<f64>().unwrap() - time(k)).abs() < 1e-6);
    }
    // the scene is one in which something happens
    let column = |k: usize| rows.iter().map(move |r| r[k].parse::<f64>().unwrap());
    assert!(
        column(9).any(|n| n > 0.0) && column(7).any(|n| n > 0.0),
        "{history}"
    );

    let solver = read(out.join("solver.csv"));
    assert!(solver.starts_with("step,attempt,active,newton,krylov,iterations,tolerance,"));
    let solves = column(4).sum::<f64>() as usize;
    assert_eq!(solver.lines().count(), 1 + solves);
    let energy = read(out.join("energy.csv"));
    assert_eq!(energy.lines().count(), 1 + ROWS);
    for row in energy.lines().skip(1) {
        let row: Vec<f64> = row.split(',').map(|v| v.parse().unwrap()).collect();
        let [external, elastic, dissipation, error] = [row[2], row[4], row[7], row[8]];
        assert!(dissipation >= 0.0, "{row:?}");
        assert!(error.abs() <= 1e-6 * external.abs().max(elastic), "{row:?}");
    }

    let log: Vec<Value> = read(out.join("log.jsonl"))
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    let events = |name: &str| log.iter().filter(|l| l["event"] == name).count();
    assert_eq!(
        (events("start"), events("accepted"), events("finished")),
        (1, ROWS, 1)
    );

    let state: Value = serde_json::from_str(&read(out.join("run.json"))).unwrap();
    assert_eq!(state["outcome"], "finished");
    assert_eq!(state["steps"], ROWS);
    assert!(state["sizes"]["n_t"].as_u64().unwrap() > 0);
    assert!(state["tolerances"][0]["relative_to"].is_string());
    assert!(state["tolerances"][1]["scale"].as_f64().unwrap() > 1e6);

    let text = read(out.join("resolved.toml"));
    let again = Scene::from_toml(&text, "resolved.toml").unwrap();
    assert_eq!(again.to_toml().unwrap(), text);

    let pvd = read(out.join("scene.pvd"));
    for k in 0..ROWS {
        for part in ["domain", "fracture"] {
            let name = format!("{part}_{k:06}.vtu");
            assert!(out.join(&name).is_file());
            let time = rows[k][1];
            let entry = format!("timestep=\"{time}\" part=");
            assert!(
                pvd.lines().any(|l| l.contains(&entry) && l.contains(&name)),
                "{pvd}"
            );
        }
    }
    let fields = fs::read(out.join("fracture_000003.vtu")).unwrap();
    let fields = String::from_utf8_lossy(&fields);
    for name in [
        "traction",
        "displacementJump",
        "slip",
        "aperture",
        "fractureState",
        "criticality",
        "tauLimit",
        "pressure",
        "stateFlips",
        "normal",
        "fracture",
    ] {
        assert!(fields.contains(&format!("Name=\"{name}\"")), "{name}");
    }
    let fields = fs::read(out.join("domain_000003.vtu")).unwrap();
    let fields = String::from_utf8_lossy(&fields);
    for name in ["displacement", "stress", "material"] {
        assert!(fields.contains(&format!("Name=\"{name}\"")), "{name}");
    }
    for figure in ["states", "iterations", "slip"] {
        assert!(read(out.join(format!("figures/{figure}.svg"))).starts_with("<svg"));
        assert!(read(out.join(format!("figures/{figure}.csv"))).starts_with("layer,kind,"));
    }
    assert!(read(out.join("report.html")).matches("<svg").count() == 3);
    assert_eq!(names(&out.join("checkpoint"), "", "").len(), 2);
    assert!(names(&out, ".", ".tmp").is_empty());
}

#[test]
fn a_restart_at_every_step_writes_the_same_files() {
    let (folder, scene) = scene("restart");
    let whole = folder.join("whole");
    done(&run(&scene, &whole, &["--threads", "2"]));
    for k in 1..ROWS {
        let out = folder.join(format!("after-{k}"));
        let n = k.to_string();
        let first = run(&scene, &out, &["--threads", "1", "--steps", &n]);
        done(&first);
        assert!(read(out.join("run.json")).contains("\"outcome\": \"stopped\""));
        assert_eq!(read(out.join("history.csv")).lines().count(), 1 + k);
        let from = out.display().to_string();
        let second = fracas(&["--threads", "1", "run", &scene, "--restart", &from]);
        done(&second);
        same(&out, &whole, &format!("restart after {k} steps"));
    }
}

#[test]
fn a_restart_from_the_checkpoint_before_takes_a_step_back() {
    let (folder, scene) = scene("back");
    let (whole, out) = (folder.join("whole"), folder.join("out"));
    done(&run(&scene, &whole, &[]));
    done(&run(&scene, &out, &["--steps", "6"]));
    let before = out.join("checkpoint/step_000005.checkpoint");
    let from = before.display().to_string();
    // stops at once: what belongs to step 5 is gone
    done(&fracas(&[
        "run",
        &scene,
        "--restart",
        &from,
        "--steps",
        "1",
    ]));
    assert_eq!(read(out.join("history.csv")).lines().count(), 1 + 6);
    done(&run(&scene, &out, &["--restart", &from]));
    same(&out, &whole, "restart from step 5 of 6");
    // elsewhere, the history begins with the step of the checkpoint
    let other = folder.join("other");
    let last = out.join("checkpoint/step_000011.checkpoint");
    done(&run(&scene, &other, &["--restart", last.to_str().unwrap()]));
    let history = read(other.join("history.csv"));
    assert_eq!(
        history.lines().nth(1),
        read(whole.join("history.csv")).lines().last()
    );
    assert_eq!(history.lines().count(), 2);
}

#[test]
fn a_folder_has_one_process_and_a_checkpoint_an_end_after_it() {
    let (folder, scene) = scene("owner");
    let out = folder.join("out");
    done(&run(&scene, &out, &["--steps", "6"]));
    assert!(
        names(&out, "run", ".lock").is_empty(),
        "the lock goes with its process"
    );
    let from = out.display().to_string();
    // 6 h are done
    let early = run(&scene, &out, &["--restart", &from, "--set", "time.end=5 h"]);
    assert_eq!(early.status, 2);
    let said = "the checkpoint stands at 21600 s, after the end of the scene at 18000 s";
    assert!(early.stderr.contains(said), "{}", early.stderr);
    // another process at work: this one
    let lock = fs::File::create(out.join("run.lock")).unwrap();
    lock.lock().unwrap();
    write(&out.join("run.lock"), "12345");
    let busy = run(&scene, &out, &["--restart", &from]);
    assert_eq!(busy.status, 2);
    assert!(
        busy.stderr.contains("process 12345 is running in"),
        "{}",
        busy.stderr
    );
    drop(lock);
    // it is gone and left its lock
    let taken = run(&scene, &out, &["--restart", &from]);
    done(&taken);
    assert!(
        taken
            .stderr
            .contains("taking over from process 12345, which is gone"),
        "{}",
        taken.stderr
    );
}

/// Kills runs after shares of the time that one takes, and goes on until the end.
fn killed_runs_lose_nothing(name: &str, kills: usize) {
    let (folder, scene) = scene(name);
    write(
        Path::new(&scene),
        &SCENE.replace("steps = 10", "steps = 20"),
    );
    let whole = folder.join("whole");
    let clock = Instant::now();
    done(&run(&scene, &whole, &[]));
    let takes = clock.elapsed();
    let (mut share, mut restarts) = (0.0_f64, 0);
    for k in 0..kills {
        // fractions of the golden ratio: spread over the whole run, whatever their number
        share = (share + 0.618_033_988_749_894_9).fract();
        let out = folder.join(format!("killed-{k}"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_fracas"))
            .args(["run", &scene, "--out", out.to_str().unwrap()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(takes.mul_f64(share) + Duration::from_micros(k as u64));
        child.kill().unwrap();
        child.wait().unwrap();
        let from = out.display().to_string();
        let done_steps = names(&out.join("checkpoint"), "step_", ".checkpoint");
        if done_steps.is_empty() {
            // before the first checkpoint there is nothing to lose
            let ran = fracas(&["run", &scene, "--restart", &from]);
            assert_eq!(ran.status, 2, "{}", ran.stderr);
            fs::remove_dir_all(&out).unwrap();
            done(&run(&scene, &out, &[]));
        } else {
            restarts += 1;
            let ran = fracas(&["run", &scene, "--restart", &from]);
            assert_eq!(ran.status, 0, "{done_steps:?}: {}", ran.stderr);
        }
        same(
            &out,
            &whole,
            &format!("killed after {share:.3} of {takes:?}"),
        );
        fs::remove_dir_all(&out).unwrap();
    }
    assert!(restarts > 0, "no kill hit a run with a checkpoint");
}

#[test]
fn a_killed_run_goes_on() {
    killed_runs_lose_nothing("killed", 8);
}

/// `cargo test --release -p fracas-experiments --test cli fifty -- --ignored`
#[test]
#[ignore = "two minutes of kills"]
fn fifty_killed_runs_go_on() {
    killed_runs_lose_nothing("fifty", 50);
}

#[test]
fn a_step_that_does_not_converge_leaves_the_state_before_it() {
    let (folder, scene) = scene("fails");
    let out = folder.join("out");
    done(&run(
        &scene,
        &out,
        &["--steps", "3", "--fields-every", "100"],
    ));
    let from = out.display().to_string();
    let bad = ["--set", "solver.max_active=1", "--set", "solver.max_cuts=1"];
    let ran = fracas(&[&["run", &scene, "--restart", &from][..], &bad].concat());
    assert_eq!(ran.status, 3, "{}", ran.stderr);
    assert!(
        ran.stderr.contains("failed after 1 halvings: active set"),
        "{}",
        ran.stderr
    );
    let state: Value = serde_json::from_str(&read(out.join("run.json"))).unwrap();
    assert_eq!(state["outcome"], "not_converged");
    assert!(state["reason"].as_str().unwrap().contains("halvings"));
    assert_eq!(read(out.join("history.csv")).lines().count(), 1 + 3);
    // the solves that failed and the fields of the last good state are there
    assert!(
        read(out.join("solver.csv"))
            .lines()
            .last()
            .unwrap()
            .starts_with("3,")
    );
    assert!(out.join("fracture_000002.vtu").is_file());
    assert!(read(out.join("report.html")).contains("halvings"));
    // and with better settings the run goes on from there
    done(&fracas(&["run", &scene, "--restart", &from]));
    let whole = folder.join("whole");
    done(&run(&scene, &whole, &[]));
    assert_eq!(
        read(out.join("history.csv")),
        read(whole.join("history.csv"))
    );
}

#[test]
fn the_clock_fills_its_column_and_no_other() {
    let (folder, scene) = scene("clock");
    let (plain, timed) = (folder.join("plain"), folder.join("timed"));
    done(&run(&scene, &plain, &["--steps", "2"]));
    done(&run(&scene, &timed, &["--steps", "2", "--clock"]));
    let (plain, timed) = (
        read(plain.join("history.csv")),
        read(timed.join("history.csv")),
    );
    for (a, b) in plain.lines().zip(timed.lines()).skip(1) {
        let (rest, wall) = b.rsplit_once(',').unwrap();
        assert_eq!(a, format!("{rest},"));
        assert!(wall.parse::<f64>().unwrap() >= 0.0);
    }
}

#[test]
fn what_cannot_be_continued_is_said() {
    let (folder, scene) = scene("refused");
    let out = folder.join("out");
    done(&run(&scene, &out, &["--steps", "2"]));
    let before = content(&out);
    let refused = |arguments: &[&str], sentence: &str| {
        let ran = fracas(arguments);
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.stderr);
        let last = ran.stderr.lines().last().unwrap_or_default();
        assert!(
            last.starts_with("error: ") && last.contains(sentence),
            "{arguments:?}: `{last}` should contain `{sentence}`"
        );
    };
    let from = out.display().to_string();
    let again = ["run", &scene, "--out", &from];
    refused(
        &again,
        &format!("{from} holds a run: go on with --restart {from}"),
    );
    let occupied = folder.display().to_string();
    refused(&["run", &scene, "--out", &occupied], "is not empty");
    refused(
        &["run", &scene, "--restart", &occupied],
        "holds no checkpoint",
    );
    refused(
        &["run", &scene, "--restart", "/no/such"],
        "cannot read the checkpoint /no/such",
    );

    let other = |set: &str, sentence: &str| {
        refused(&["run", &scene, "--restart", &from, "--set", set], sentence);
    };
    other("mesh.y.cells=4", "belongs to another mesh");
    other("mesh.y.to=4 m", "belongs to another mesh");
    other(
        "material.rock.young=11 GPa",
        "other materials, friction or loads",
    );
    other(
        "boundary.1.pressure=6 MPa",
        "other materials, friction or loads",
    );
    let solver = run(
        &scene,
        &folder.join("solver"),
        &[
            "--restart",
            &from,
            "--set",
            "solver.max_newton=20",
            "--steps",
            "1",
        ],
    );
    done(&solver);

    let file = out.join("checkpoint/step_000002.checkpoint");
    let good = fs::read(&file).unwrap();
    fs::write(&file, &good[..good.len() - 9]).unwrap();
    refused(&["run", &scene, "--restart", &from], "is damaged: it has");
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 4;
    fs::write(&file, &flipped).unwrap();
    refused(
        &["run", &scene, "--restart", &from],
        "its checksum does not fit",
    );
    fs::write(&file, SCENE).unwrap();
    refused(
        &["run", &scene, "--restart", &from],
        "is no checkpoint of fracas",
    );
    fs::write(&file, &good).unwrap();

    // a folder whose history leads elsewhere
    let shorter = folder.join("shorter");
    done(&run(&scene, &shorter, &["--steps", "1"]));
    let elsewhere = shorter.display().to_string();
    let mixed = ["run", &scene, "--restart", &from, "--out", &elsewhere];
    refused(
        &mixed,
        "does not lead up to the checkpoint, which starts step 2: it has steps 0 to 0",
    );
    // nothing of this has changed anything
    assert!(content(&out) == before);
}
