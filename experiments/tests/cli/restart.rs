//! Claim: what `run` leaves survives its process at any time, and a restart goes on with the same bits.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

use crate::block::{ROWS, SCENE, done, names, read, run, scene};
use crate::run::{fracas, write};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Everything of a finished run that must not depend on how it got there.
fn content(out: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = names(out, "", ".vtu");
    files.extend(
        [
            "history.csv",
            "energy.csv",
            "fault.csv",
            "scene.pvd",
            "resolved.toml",
        ]
        .map(String::from),
    );
    files.extend(names(out, "onset", ".csv"));
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
fn a_restart_at_every_step_writes_the_same_files() {
    restarted("restart", &[]);
}

/// Fault that weakens by the path of its slip, whose onset is looked for.
const ONSET: [&str; 10] = [
    "--set",
    "fracture.0.dynamic_friction_angle=15 deg",
    "--set",
    "fracture.0.weakening_distance=20 mm",
    "--set",
    "fracture.0.weakening_by=path",
    "--set",
    "time.onset={within=\"2 min\",patch=\"4 m2\"}",
    "--set",
    "solver.inner=exact",
];

/// Also between two halves of a step in which slip begins.
#[test]
fn a_restart_within_the_search_for_an_onset_writes_the_same_files() {
    restarted("restart-onset", &ONSET);
}

#[test]
fn the_onset_of_slip_is_told_in_every_place() {
    let (folder, scene) = scene("onset");
    let out = folder.join("out");
    let ran = run(&scene, &out, &ONSET);
    done(&ran);
    let table = read(out.join("onset.csv"));
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 3, "{table}");
    let column = |name: &str| rows[0].iter().position(|c| *c == name).unwrap();
    let whole: serde_json::Value = serde_json::from_str(&read(out.join("run.json"))).unwrap();
    let log = read(out.join("log.jsonl"));
    let log: Vec<serde_json::Value> = (log.lines())
        .map(|line| serde_json::from_str(line).unwrap())
        .filter(|line: &serde_json::Value| line["event"] == "onset")
        .collect();
    for (k, begins) in ["face", "patch"].into_iter().enumerate() {
        let (row, told) = (&rows[k + 1], &whole["onset"][k]);
        assert_eq!(row[column("begins")], begins);
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        let [before, after] = ["time_before_s", "time_after_s"].map(number);
        assert!(
            after > before && after - before <= 120.0 * (1.0 + 1e-9),
            "{before} {after}"
        );
        assert_eq!(told["time_before_s"], before);
        assert_eq!(told["time_after_s"], after);
        assert_eq!(number("area_m2") >= 4.0 * (1.0 - 1e-9), begins == "patch");
        assert_eq!(
            (&log[k]["begins"], &log[k]["text"]),
            (&told["begins"], &told["text"])
        );
        let text = told["text"].as_str().unwrap();
        assert!(
            ran.stderr.contains(&format!("onset: {text}")),
            "{}",
            ran.stderr
        );
        assert!(
            ran.stderr.contains(&format!("; {text}")) || k == 1,
            "{}",
            ran.stderr
        );
    }
    let page = read(out.join("report.html"));
    assert!(page.contains("When slip begins on a fracture"));
    let faults = read(out.join("fault.csv"));
    let heading = faults.lines().next().unwrap();
    assert!(
        heading.ends_with(",cumulated_slip_mean_m,cumulated_slip_max_m"),
        "{heading}"
    );
    let fields = fs::read(out.join(names(&out, "fracture", ".vtu").pop().unwrap())).unwrap();
    assert!(String::from_utf8_lossy(&fields).contains("Name=\"cumulatedSlip\""));
}

/// A run that is asked for it late says that slip had begun, and what begins later as ever.
#[test]
fn an_onset_may_be_asked_for_at_a_restart() {
    let (folder, scene) = scene("onset-late");
    let (out, plain) = (folder.join("out"), &ONSET[..6]);
    done(&run(&scene, &out, plain));
    assert!(!out.join("onset.csv").exists());
    let faults = read(out.join("fault.csv"));
    let slips = |line: &&str| line.split(',').nth(3).is_some_and(|a| a != "0.0");
    let first = faults.lines().skip(1).find(slips).unwrap();
    let first: usize = first.split(',').next().unwrap().parse().unwrap();
    fs::remove_dir_all(&out).unwrap();
    done(&run(
        &scene,
        &out,
        &[&["--steps", &(first + 1).to_string()], plain].concat(),
    ));
    let from = out.display().to_string();
    let late = "time.onset={within=\"1 h\",patch=\"8 m2\"}";
    done(&fracas(
        &[&["run", &scene, "--restart", &from, "--set", late], plain].concat(),
    ));
    let table = read(out.join("onset.csv"));
    let row: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    assert_eq!((row[2], row[3]), ("face", ""), "{table}");
}

/// What has crept is there again.
#[test]
fn a_restart_of_rock_that_creeps_writes_the_same_files() {
    restarted(
        "restart-creep",
        &["--set", "material.0.viscosity=4e13 Pa*s"],
    );
}

/// Multigrid refreshes the hierarchy of the stuck body for other states, before the restart and after it.
#[test]
fn a_restart_with_multigrid_writes_the_same_files() {
    restarted("restart-amg", &["--set", "solver.inner=amg"]);
}

/// Pressures that vary in space, from a file and by diffusion, under rock that creeps.
#[test]
fn a_restart_of_pressures_in_space_writes_the_same_files() {
    let grid = "x [m],y [m],z [m],0 h [bar],3 h [bar],12 h [bar]\n1,1,1,50,30,60\n3,1,1,50,50,20\n2,2,3,40,44,41\n";
    let drawdown = "material.rock.pore_pressure={ drawdown = { diffusivity = '1e-4 m2/s', from = 'both', z = ['0 m', '4 m'], points = [['0 h', '50 bar'], ['12 h', '20 bar']] } }";
    for (name, pressure) in [
        (
            "restart-grid",
            "material.rock.pore_pressure={ grid = 'p.csv', within = '5 m' }",
        ),
        ("restart-drawdown", drawdown),
    ] {
        let more = [
            "--set",
            pressure,
            "--set",
            "material.rock.viscosity=4e14 Pa*s",
            "--set",
            "time.steps=4",
            "--set",
            "solver.inner=geometric",
        ];
        let (folder, scene) = scene(name);
        write(&folder.join("p.csv"), grid);
        let whole = folder.join("whole");
        done(&run(&scene, &whole, &more));
        let rows = read(whole.join("history.csv")).lines().count() - 1;
        let domain = names(&whole, "domain", ".vtu").pop().unwrap();
        let fields = fs::read(whole.join(domain)).unwrap();
        assert!(String::from_utf8_lossy(&fields).contains("Name=\"alphaDeltaP\""));
        for k in [1, rows / 2, rows - 1] {
            let out = folder.join(format!("after-{k}"));
            done(&run(
                &scene,
                &out,
                &[&["--steps", &k.to_string()], &more[..]].concat(),
            ));
            let from = out.display().to_string();
            done(&fracas(
                &[&["run", &scene, "--restart", &from], &more[..]].concat(),
            ));
            same(&out, &whole, &format!("{name}, restart after {k} steps"));
        }
        let from = whole.display().to_string();
        write(&folder.join("p.csv"), &grid.replace("60", "61"));
        let ran = fracas(&[&["run", &scene, "--restart", &from], &more[..]].concat());
        let is_other = ran
            .stderr
            .contains("belongs to a scene with the same mesh but other materials");
        assert_eq!(is_other, name == "restart-grid", "{}", ran.stderr);
    }
}

fn restarted(name: &str, more: &[&str]) {
    let (folder, scene) = scene(name);
    let whole = folder.join("whole");
    done(&run(&scene, &whole, &[&["--threads", "2"], more].concat()));
    let rows = read(whole.join("history.csv")).lines().count() - 1;
    assert!(rows >= ROWS);
    // a restart after every step, and some that go on for two steps and three
    for lengths in [&["1"][..], &["1", "2", "3"]] {
        let out = folder.join(format!("by-{}", lengths.len()));
        let from = out.display().to_string();
        let mut lengths = lengths.iter().cycle();
        let mut steps = || ["--threads", "1", "--steps", lengths.next().unwrap()];
        done(&run(&scene, &out, &[&steps(), more].concat()));
        let mut restarts = 0;
        while read(out.join("run.json")).contains("\"outcome\": \"stopped\"") {
            let again = ["run", &scene, "--restart", &from];
            done(&fracas(&[&again[..], &steps(), more].concat()));
            restarts += 1;
            assert!(restarts <= rows, "a restart takes no step");
        }
        same(&out, &whole, &format!("{restarts} restarts"));
        assert!(restarts >= rows / 2 - 2, "{restarts} restarts");
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
fn a_restart_with_another_setting_says_so() {
    let (folder, scene) = scene("settings");
    let out = folder.join("out");
    done(&run(&scene, &out, &["--steps", "1"]));
    let from = out.display().to_string();
    let more = |more: &[&str]| {
        let ran = fracas(&[&["run", &scene, "--restart", &from, "--steps", "1"], more].concat());
        done(&ran);
        let logged = read(out.join("log.jsonl"));
        let warnings = logged.lines().filter(|line| line.contains("\"warning\""));
        (ran.stderr, warnings.count())
    };
    let (said, warnings) = more(&[]);
    assert!(!said.contains("from here on"), "{said}");
    let (said, now) = more(&["--set", "solver.tolerance=1e-7"]);
    let expected =
        "warning: solver.tolerance is 1e-7 from here on, resolved.toml beside the checkpoint says ";
    assert!(said.contains(expected), "{said}");
    assert_eq!(now, warnings + 1);
    // what only one of the scenes has
    let set = [
        "--set",
        "solver.tolerance=1e-7",
        "--set",
        "solver.racp.relaxation=0.1",
    ];
    let (said, _) = more(&set);
    assert!(said.contains("checkpoint says not given"), "{said}");
    let (said, _) = more(&set[..2]);
    assert!(said.contains("warning: solver.racp is not given"), "{said}");
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
        // one that died before its first checkpoint begins again
        restarts += usize::from(!done_steps.is_empty());
        let ran = fracas(&["run", &scene, "--restart", &from]);
        assert_eq!(ran.status, 0, "{done_steps:?}: {}", ran.stderr);
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
fn a_run_that_died_before_its_first_checkpoint_begins_again() {
    let (folder, scene) = scene("stillborn");
    let whole = folder.join("whole");
    done(&run(&scene, &whole, &[]));
    let heading = |file: &str| read(whole.join(file)).lines().next().unwrap().to_owned() + "\n";
    for (k, again) in ["--out", "--restart"].into_iter().enumerate() {
        let out = folder.join(format!("begun-{k}"));
        fs::create_dir_all(out.join("checkpoint")).unwrap();
        for file in ["history.csv", "solver.csv", "energy.csv"] {
            write(&out.join(file), &heading(file));
        }
        for file in [
            "log.jsonl",
            "run.lock",
            "checkpoint/.step_000000.checkpoint.tmp",
        ] {
            write(&out.join(file), "");
        }
        done(&fracas(&["run", &scene, again, out.to_str().unwrap()]));
        same(&out, &whole, again);
    }
    // a step was done, and its checkpoint is gone: nothing is written over
    fs::remove_dir_all(whole.join("checkpoint")).unwrap();
    assert_eq!(run(&scene, &whole, &[]).status, 2);
    let other = folder.join("other");
    fs::create_dir(&other).unwrap();
    write(&other.join("run.json"), "{}");
    assert_eq!(run(&scene, &other, &[]).status, 2);
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
