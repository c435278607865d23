//! Claim: `run` leaves a folder that other programs read.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

use crate::block::{ROWS, done, names, read, run, scene};
use crate::run::{fracas, scratch, write};
use fracas::scene::Scene;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The time of a row [s].
fn time(row: usize) -> f64 {
    let hours = [0.0, 1.2, 2.4, 3.6, 4.8, 6.0, 7.0, 7.2, 8.4, 9.6, 10.8, 12.0];
    3600.0 * hours[row]
}

const HEADER: &str = "step,time_s,dt_s,active_it,newton_it,lin_it,lin_res,stick,newslip,slip,open,changed_area,max_pen,max_tau_viol,slip_max_m,h_jump_max_m,h_overlap_max_m,cuts,wall_s,max_slip_viol,arrested,error_u,error_t";

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
        assert_eq!((row.len(), row[0]), (23, k.to_string().as_str()));
        assert_eq!(row[18], "", "no clock was asked for");
        assert!(
            row[1..18].iter().all(|f| f.parse::<f64>().is_ok()),
            "{row:?}"
        );
        // slip follows the traction: what violates it is below the tolerance of states
        assert!(row[19].parse::<f64>().unwrap() <= 1e-6, "{row:?}");
        // u and t are as accurate as `tolerance` asks
        assert!(
            row[21..].iter().all(|e| e.parse::<f64>().unwrap() <= 1e-8),
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
        "stabilizationJump",
        "aperture",
        "fractureState",
        "criticality",
        "tauLimit",
        "pressure",
        "stateFlips",
        "normal",
        "t1",
        "t2",
        "fracture",
    ] {
        assert!(fields.contains(&format!("Name=\"{name}\"")), "{name}");
    }
    let fields = fs::read(out.join("domain_000003.vtu")).unwrap();
    let fields = String::from_utf8_lossy(&fields);
    for name in ["displacement", "stress", "material"] {
        assert!(fields.contains(&format!("Name=\"{name}\"")), "{name}");
    }
    for figure in ["states", "iterations", "slip", "energy"] {
        assert!(read(out.join(format!("figures/{figure}.svg"))).starts_with("<svg"));
        assert!(read(out.join(format!("figures/{figure}.csv"))).starts_with("layer,kind,"));
    }
    // the body, the fracture, and nothing else
    let [sections, maps] =
        ["section_1_", "fracture_0_"].map(|part| names(&out.join("figures"), part, ".svg").len());
    assert!(sections > 0 && maps > 0, "{sections} sections, {maps} maps");
    assert_eq!(
        read(out.join("report.html")).matches("<svg").count(),
        4 + sections + maps
    );
    assert_eq!(names(&out.join("checkpoint"), "", "").len(), 2);
    assert!(names(&out, ".", ".tmp").is_empty());
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
    // the equilibrium at time 0 is the first of two
    let numbers: Vec<&str> = (plain.lines().skip(1))
        .filter_map(|row| row.split(',').next())
        .collect();
    assert_eq!(numbers, ["0", "1"]);
    for (a, b) in plain.lines().zip(timed.lines()).skip(1) {
        let wall = b.split(',').nth(18).unwrap();
        assert_eq!(a, b.replacen(&format!(",{wall},"), ",,", 1));
        assert!(wall.parse::<f64>().unwrap() >= 0.0);
    }
}

/// Steps whose section is drawn.
fn steps_drawn(out: &Path) -> Vec<usize> {
    let part = "section_1_u_";
    let files = names(&out.join("figures"), part, ".svg");
    let step = |name: &String| name.strip_prefix(part)?.strip_suffix(".svg")?.parse().ok();
    let mut steps: Vec<usize> = files.iter().filter_map(step).collect();
    steps.sort_unstable();
    steps
}

#[test]
fn a_page_shows_the_body_at_steps_that_tell_and_at_those_asked_for() {
    let whole = scratch("output-page").join("out");
    let folder = whole.display().to_string();
    done(&fracas(&["run", "cycle:small", "--out", &folder]));
    let page = read(whole.join("report.html"));
    for text in [
        "The body in the section",
        "slip begins",
        "largest slip",
        "Contact state on fracture",
        "von Mises",
        "<math>",
        "instruction set",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let history = read(whole.join("history.csv"));
    let last = history.lines().count() - 2;
    let telling = steps_drawn(&whole);
    assert!(
        telling.len() <= 4 && telling.first() == Some(&0),
        "{telling:?}"
    );
    assert_eq!(telling.last(), Some(&last));
    // another page of a run that has ended
    let again = |steps: &str| {
        done(&fracas(&[
            "run",
            "cycle:small",
            "--restart",
            &folder,
            "--page-steps",
            steps,
        ]));
    };
    again("2,5,7");
    assert_eq!(steps_drawn(&whole), [2, 5, 7]);
    assert_eq!(history, read(whole.join("history.csv")));
    again("none");
    assert!(!read(whole.join("report.html")).contains("The body in the section"));
    let bad = fracas(&[
        "run",
        "cycle:small",
        "--restart",
        &folder,
        "--page-steps",
        "2-5",
    ]);
    assert_eq!(bad.status, 2);
    assert!(
        bad.stderr.contains("write steps, as in 0,4,12"),
        "{}",
        bad.stderr
    );
}

#[test]
fn a_step_without_fields_is_stood_for_and_a_body_that_sticks_is_said_to() {
    let out = scratch("output-sparse").join("out");
    let folder = out.display().to_string();
    let sticks = [
        "--set",
        "fracture.0.friction_angle=60 deg",
        "--set",
        "fracture.0.cohesion=1 GPa",
    ];
    let sparse = ["--fields-every", "100", "--steps", "3", "--page-steps", "1"];
    let run = [
        &["run", "cycle:small", "--out", &folder][..],
        &sparse,
        &sticks,
    ]
    .concat();
    done(&fracas(&run));
    let page = read(out.join("report.html"));
    assert_eq!(steps_drawn(&out), [2]);
    assert!(
        page.contains("No fields of step 1 are in this folder: step 2 stands for it"),
        "{page}"
    );
    assert!(page.contains("sticks at these steps"));
}

/// A page of a mesh of any size and of any number of steps has some megabytes.
#[test]
fn a_page_of_many_cells_is_bounded() {
    let out = scratch("output-many").join("out");
    let folder = out.display().to_string();
    // a sheet, all of whose cells lie in its section
    let cells = ["mesh.x.cells=160", "mesh.y.cells=1", "mesh.z.cells=160"];
    let cells = cells
        .iter()
        .flat_map(|set| ["--set", *set])
        .collect::<Vec<_>>();
    let run = [&["run", "crossing", "--out", &folder][..], &cells].concat();
    let ran = fracas(&run);
    assert!(matches!(ran.status, 0 | 3), "{}", ran.stderr);
    let page = read(out.join("report.html"));
    assert!(page.contains("Squares stand for what lies at their centres"));
    assert!(page.len() < 10 << 20, "{} bytes", page.len());
}

/// What `check` says of lines that have become one, `run` says on its console and in its log.
#[test]
fn run_says_as_check_does_what_lies_on_another_grid_line() {
    let folder = scratch("moved");
    let (path, out) = (folder.join("moved.toml"), folder.join("out"));
    let side = |side: &str| format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    let held: String = ["x-", "x+", "y-", "y+", "z-"].map(side).concat();
    let text = format!(
        "title = 'moved'\n[mesh]\nx = {{ from = '-1 km', to = '1 km', size = '200 m' }}\ny = {{ from = '0 m', to = '200 m', cells = 1 }}\n\
         z = {{ size = '200 m' }}\n[geology]\nbottom = '-2 km'\nlayers = [{{ top = '0 m', material = 'sand' }}, {{ top = '-1 km', material = 'rock' }}]\n\
         [[material]]\nname = 'sand'\nyoung = '1 GPa'\npoisson = 0.2\n[[material]]\nname = 'rock'\nyoung = '2 GPa'\npoisson = 0.2\n\
         [[fracture]]\nname = 'F'\nplane = 'x'\nat = '0 m'\nz = ['-1500 m', '-970 m']\nfriction_angle = '30 deg'\n\
         [time]\nend = '1 s'\nsteps = 1\n{held}"
    );
    write(&path, &text);
    let scene = path.to_str().unwrap();
    let moved = "an end of fracture \"F\" lies on the grid line z = -1000 m, and not at -970 m";
    let checked = fracas(&["check", scene]);
    assert!(checked.stdout.contains(moved), "{}", checked.stdout);
    let ran = fracas(&["run", scene, "--out", out.to_str().unwrap(), "--steps", "1"]);
    assert!(
        ran.stderr.contains(&format!("warning: {moved}")),
        "{}",
        ran.stderr
    );
    let log = read(out.join("log.jsonl"));
    assert!(log.contains(&moved.replace('"', "\\\"")), "{log}");
    fs::remove_dir_all(folder).unwrap();
}
