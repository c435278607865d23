//! Claim: `run` leaves a folder that other programs read.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

use crate::block::{ROWS, done, names, read, run, scene};
use crate::run::fracas;
use fracas::scene::Scene;
use serde_json::Value;
use std::fs;

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
    let maps = names(&out.join("figures"), "fracture_0_", ".svg").len();
    assert!(maps > 0, "no map of the fracture");
    assert_eq!(
        read(out.join("report.html")).matches("<svg").count(),
        4 + maps
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
    for (a, b) in plain.lines().zip(timed.lines()).skip(1) {
        let wall = b.split(',').nth(18).unwrap();
        assert_eq!(a, b.replacen(&format!(",{wall},"), ",,", 1));
        assert!(wall.parse::<f64>().unwrap() >= 0.0);
    }
}
