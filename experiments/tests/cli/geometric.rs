//! Claim: `solve --inner geometric` gives the solution of the assembled path without its matrix, `auto` says what it took
//! and why, and what cannot be is refused in one sentence.
#![allow(clippy::unwrap_used, reason = "a test that cannot read a report fails")]

use crate::run::{Ran, fracas, scratch, system_folder, write};
use fracas_operators::matrix_market::read_vector;
use serde_json::Value;
use std::path::Path;

/// Solves to 1e-11 and returns the report and the solution.
fn solved(arguments: &[&str], file: &Path) -> (Value, Vec<f64>) {
    let fixed = [
        "--tolerance",
        "1e-11",
        "--json",
        "-",
        "--solution",
        file.to_str().unwrap(),
    ];
    let ran = fracas(&[arguments, &fixed[..]].concat());
    assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.stderr);
    let report = serde_json::from_str(&ran.stdout).unwrap();
    (report, read_vector(file).unwrap())
}

/// `max |x − y| / max |y|`.
fn deviation(x: &[f64], y: &[f64]) -> f64 {
    let size = |v: f64, w: &f64| v.max(w.abs());
    let difference: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
    difference.iter().fold(0.0, size) / y.iter().fold(0.0, size)
}

#[test]
fn f32_that_does_not_serve_gives_way_to_f64_and_the_report_says_so() {
    let report = |arguments: &[&str]| -> Value {
        let ran = fracas(&[&["solve", "layered_crossing", "--json", "-"], arguments].concat());
        serde_json::from_str(&ran.stdout).unwrap()
    };
    let said = |report: &Value| {
        let findings = report["findings"].as_array().unwrap();
        let is_said = |f: &&Value| f.as_str().unwrap().starts_with("precision: ");
        findings.iter().filter(is_said).count()
    };
    let small = ["x", "y", "z"].map(|axis| format!("mesh.{axis}.cells=8"));
    let soft = |young: &str| {
        let mut sets = small.to_vec();
        sets.push(format!("material.soft.young='{young} GPa'"));
        sets.into_iter()
            .flat_map(|s| ["--set".to_owned(), s])
            .collect::<Vec<_>>()
    };
    let of = |young: &str, more: &[&str]| {
        let sets = soft(young);
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        report(&[&sets[..], more].concat())
    };
    // seen while setting up
    let seen = of("4e-3", &["--inner", "geometric"]);
    assert_eq!(
        (seen["precision_fallbacks"].as_u64(), said(&seen)),
        (Some(1), 1)
    );
    assert_eq!(seen["outcome"], "converged");
    assert_eq!(seen["inner"], "geometric:f64");
    let none = of("4", &["--inner", "geometric"]);
    assert_eq!(
        (none["precision_fallbacks"].as_u64(), said(&none)),
        (Some(0), 0)
    );
    assert_eq!(none["inner"], "geometric");
    let asked = of("4e-3", &["--inner", "geometric:f64"]);
    assert_eq!(
        (asked["precision_fallbacks"].as_u64(), said(&asked)),
        (Some(0), 0)
    );
    // a set-up that fails in f32 alone
    let failed = of("4e-7", &["--inner", "amg"]);
    assert_eq!(
        (failed["precision_fallbacks"].as_u64(), said(&failed)),
        (Some(1), 1)
    );
    assert_eq!(failed["inner"], "amg (f64)");
    // an iteration that is merely too short says nothing of its precision, and f64 is not tried
    let short = of("4", &["--inner", "amg", "--max-iterations", "3"]);
    assert_eq!(
        (short["precision_fallbacks"].as_u64(), said(&short)),
        (Some(0), 0)
    );
    assert_eq!(
        (&short["outcome"], &short["iterations"]),
        (&"iteration_limit".into(), &3.into())
    );
    assert_eq!(short["inner"], "amg");
    // one that stands still: f64 gets the iterations that are left
    let flat = of("4e-6", &["--inner", "amg", "--max-iterations", "120"]);
    assert_eq!(
        (flat["precision_fallbacks"].as_u64(), said(&flat)),
        (Some(1), 1)
    );
    assert_eq!(flat["iterations"], 120);
    assert_eq!(flat["inner"], "amg (f64)");
}

/// A stiff block over soft rock is moved: residuals in f64 are rounding before errors are small, and were refused.
#[test]
fn residuals_in_twice_the_digits_finish_what_f64_cannot() {
    let directory = scratch("twice_the_digits");
    let scene = directory.join("moved.toml");
    let text = "title = 'moved'
[mesh]
x = { from = '0 m', to = '5 m', cells = 5 }
y = { from = '0 m', to = '0.05 m', cells = 4 }
z = { from = '0 m', to = '6 m', cells = 6 }
[[material]]
name = 'rock'
young = '10 GPa'
poisson = 0.45
[[material]]
name = 'layer'
young = '250000 GPa'
poisson = 0.3
layers = [['1 m', '5 m']]
[[fracture]]
name = 'a'
plane = 'x'
at = '2 m'
friction_angle = '30 deg'
z = ['0 m', '5 m']
[[boundary]]
side = 'z-'
hold = 'fixed'
[[boundary]]
side = 'z+'
displacement = { x = '6 mm', z = '-12 mm' }
";
    write(&scene, text);
    let solution = |inner: &str| {
        let file = directory.join(format!("{inner}.mtx"));
        let scene = scene.to_str().unwrap();
        let options = ["--inner", inner, "--max-iterations", "800"];
        let (report, x) = solved(&[&["solve", scene], &options[..]].concat(), &file);
        let findings = report["findings"].to_string();
        (findings.contains("twice the digits"), report, x)
    };
    let (refined, report, x) = solution("geometric");
    assert!(refined, "{report}");
    let (_, exact, y) = solution("exact");
    assert_eq!(exact["outcome"], "converged");
    let n_u = report["n_u"].as_u64().unwrap() as usize;
    for part in [0..n_u, n_u..x.len()] {
        let deviation = deviation(&x[part.clone()], &y[part]);
        assert!(deviation < 1e-8, "{deviation:e}");
    }
}

#[test]
fn a_run_says_that_f32_gave_way_to_f64() {
    let cases = [
        ("geometric", "0.004", 1, "f64", 0),
        ("geometric", "4", 0, "f32", 0),
        ("amg", "4", 0, "f32", 0),
        // rock a million times softer: the preconditioner gives way, and the run ends with what it lacks
        ("amg", "4e-5", 1, "f64", 3),
    ];
    let small = ["x", "y", "z"].map(|axis| format!("mesh.{axis}.cells=8"));
    for (inner, young, fallbacks, precision, status) in cases {
        let out = scratch("geometric-run").join(format!("{inner}-{young}"));
        let young = format!("material.soft.young='{young} GPa'");
        let solver = format!("solver.inner='{inner}'");
        let mut arguments = vec!["run", "layered_crossing", "--out", out.to_str().unwrap()];
        for set in [&solver, &young].into_iter().chain(&small) {
            arguments.extend(["--set", set]);
        }
        let ran = fracas(&arguments);
        assert_eq!(ran.status, status, "{}", ran.stderr);
        let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
        let state: Value = serde_json::from_str(&read("run.json")).unwrap();
        assert_eq!(state["precision_fallbacks"], fallbacks);
        let settings = &state["preconditioner"]["inner"][inner];
        assert_eq!(settings["precision"], precision, "{state}");
        let events: Vec<Value> = read("log.jsonl")
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .filter(|event: &Value| event["event"] == "precision")
            .collect();
        assert_eq!(events.len(), fallbacks);
        for event in &events {
            let reason = event["reason"].as_str().unwrap();
            assert!(reason.contains("f32"), "{reason}");
            assert!(ran.stderr.contains(reason), "{}", ran.stderr);
        }
    }
}

#[test]
fn the_solution_is_that_of_the_assembled_path() {
    let file = scratch("geometric").join("x.mtx");
    for scene in ["crossing", "layered_crossing", "inclined", "tee", "patch"] {
        for c in ["local_h", "face_block"] {
            let common = ["solve", scene, "--augmentation", c];
            let run = |inner| solved(&[&common[..], &["--inner", inner]].concat(), &file);
            let ((free, x), (assembled, y)) = (run("geometric"), run("exact"));
            assert_eq!(free["inner"], "geometric");
            for key in ["n_u", "n_t", "traction_unit", "augmentation"] {
                assert_eq!(free[key], assembled[key], "{scene} {key}");
            }
            let n_u = free["n_u"].as_u64().unwrap() as usize;
            for part in [0..n_u, n_u..x.len()] {
                let difference = deviation(&x[part.clone()], &y[part]);
                assert!(difference < 1e-6, "{scene} {c}: {difference:e}");
            }
            let number = |report: &Value, key: &str| report[key].as_f64().unwrap();
            assert!(number(&free, "relative_residual") <= 1e-11);
            // its norm of 𝒜 is a lower bound: the error is never understated
            assert!(number(&free, "backward_error") < 1e-10, "{scene}");
            assert!(number(&free, "contact_residual") < 1e-8, "{scene}");
            assert!(free["amg"]["levels"].as_array().unwrap().len() > 1);
        }
    }
}

#[test]
fn every_cycle_gives_the_solution_and_one_that_is_not_linear_needs_a_flexible_iteration() {
    let file = scratch("geometric-cycles").join("x.mtx");
    let run = |inner| solved(&["solve", "layered_crossing", "--inner", inner], &file);
    let (_, y) = run("exact");
    for inner in [
        "geometric:v",
        "geometric:w:f64",
        "geometric:k",
        "geometric:k:f64",
    ] {
        let (report, x) = run(inner);
        assert_eq!(report["inner"], inner);
        let is_flexible = report["krylov"].as_str().unwrap().starts_with("fgmres");
        assert_eq!(is_flexible, inner != "geometric:w:f64");
        let difference = deviation(&x, &y);
        assert!(difference < 1e-6, "{inner}: {difference:e}");
    }
    for krylov in ["sqmr", "minres", "bicgstab", "cg"] {
        let inner = ["solve", "layered_crossing", "--inner", "geometric:k"];
        let ran = fracas(&[&inner[..], &["--krylov", krylov]].concat());
        assert_eq!(ran.status, 2);
        let why = format!(
            "--krylov {krylov} needs a linear preconditioner, and --inner geometric:k is none; take gmres or fgmres"
        );
        assert!(ran.stderr.contains(&why), "{}", ran.stderr);
    }
    let ran = fracas(&["solve", "crossing", "--inner", "geometric:x"]);
    assert_eq!(ran.status, 2);
    assert!(ran.stderr.contains("geometric:k:f64"), "{}", ran.stderr);
    let [ours, others] = ["geometric:k", "amg"]
        .map(|inner| fracas(&["solve", "crossing", "--method", "direct", "--inner", inner]));
    assert_eq!((ours.status, ours.stderr), (2, others.stderr));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let folder = scratch("geometric-threads");
    let bits = |threads: &str| {
        let file = folder.join(threads);
        let arguments = ["--threads", threads, "solve", "layered_crossing"];
        solved(&[&arguments[..], &["--inner", "geometric"]].concat(), &file);
        std::fs::read(file).unwrap()
    };
    assert_eq!(bits("1"), bits("2"));
}

#[test]
fn prescribed_displacements_reach_the_right_hand_side() {
    let folder = scratch("geometric-pushed");
    let scene = folder.join("pushed.toml");
    let gallery = fracas::scene::named("crossing").unwrap().toml;
    let pushed = "\n[[boundary]]\nside = \"x-\"\ndisplacement = { x = \"1 mm\" }\n";
    write(&scene, &format!("{gallery}{pushed}"));
    let run = |inner| {
        let arguments = ["solve", scene.to_str().unwrap(), "--inner", inner];
        solved(&arguments, &folder.join("x.mtx")).1
    };
    assert!(deviation(&run("geometric"), &run("exact")) < 1e-6);
}

#[test]
fn auto_says_what_it_took_and_why() {
    let folder = system_folder("geometric-auto");
    let system = ["--system", folder.to_str().unwrap()];
    for (arguments, inner, why) in [
        (
            &["crossing"][..],
            "geometric",
            "the mesh of the scene is a grid",
        ),
        (&system[..], "exact", "displacements are no more than 5000"),
        (
            &["crossing", "--augmentation", "global"],
            "amg",
            "C = global needs all of A",
        ),
        (&["crossing", "--explain"], "exact", "an explanation reads"),
        (
            &["crossing", "--method", "simple"],
            "amg",
            "simple is made from assembled blocks",
        ),
    ] {
        let ran = fracas(&[&["solve"], arguments, &["--inner", "auto", "--json", "-"]].concat());
        assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.stderr);
        let report: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(report["inner"], inner, "{arguments:?}");
        let noted = report["findings"].to_string();
        assert!(noted.contains(why) && ran.stderr.contains(why), "{noted}");
    }
}

#[test]
fn what_cannot_be_is_refused_in_one_sentence() {
    let folder = system_folder("geometric-refused");
    let system = ["--system", folder.to_str().unwrap()];
    let huge = [
        "crossing",
        "--set",
        "mesh.x.cells=1000",
        "--set",
        "mesh.y.cells=1000",
        "--set",
        "mesh.z.cells=400",
    ];
    for (arguments, sentence) in [
        (&system[..], "needs a scene, whose mesh is a grid"),
        (
            &["crossing", "--augmentation", "exact"],
            "exact needs all of A; take local, local_h, half_h, fitted_h or face_block",
        ),
        (&["crossing", "--method", "mcp"], "belongs to --method racp"),
        (&huge[..], "grid nodes take about"),
    ] {
        let ran = fracas(&[&["solve"], arguments, &["--inner", "geometric"]].concat());
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.stderr);
        let last = ran.stderr.lines().last().unwrap();
        assert!(
            last.starts_with("error: ") && last.contains(sentence),
            "{arguments:?}: {last}"
        );
    }
    let folder = crate::run::system_folder("geometric-spectrum");
    let system = folder.to_str().unwrap();
    let spectrum = fracas(&["spectrum", "--system", system, "--inner", "geometric"]);
    assert!(spectrum.status == 2 && spectrum.stderr.contains("needs a scene"));
}

/// `run cycle` into this folder with these settings.
fn run_cycle(out: &Path, settings: &[&str]) -> Ran {
    let mut arguments = vec!["run", "cycle", "--out", out.to_str().unwrap()];
    arguments.extend(settings.iter().flat_map(|set| ["--set", set]));
    fracas(&arguments)
}

#[test]
fn a_run_takes_geometric_multigrid_with_settings_of_its_own_as_by_its_name() {
    let history = |name: &str, solver: &str| {
        let out = scratch("geometric-racp").join(name);
        let ran = run_cycle(&out, &[solver, "mesh.y.cells=4", "mesh.z.cells=4"]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        std::fs::read_to_string(out.join("history.csv")).unwrap()
    };
    let named = history("named", "solver.inner='geometric'");
    let settings = "solver.racp={ augmentation = 'half_h', inner = 'geometric' }";
    assert_eq!(history("settings", settings), named);
}

#[test]
fn a_run_whose_geometric_multigrid_cannot_be_is_refused_before_its_first_step() {
    let out = scratch("geometric-refused");
    let inner = |key: &str| format!("solver.racp={{ inner = {{ geometric = {{ {key} }} }} }}");
    let dense = "solver.racp={ augmentation = 'exact_h', inner = 'geometric' }".to_owned();
    for (settings, said) in [
        (dense, "exact_h needs all of A"),
        (inner("over_correction = -1.0"), "over_correction"),
        (inner("degree = 0"), "degree"),
        (inner("lines = { left = 2.0 }"), "left = 2"),
    ] {
        let ran = run_cycle(&out, &[&settings]);
        assert_eq!(ran.status, 2, "{}", ran.stderr);
        assert!(ran.stderr.contains(said), "{}", ran.stderr);
    }
    let own = fracas(&["solve", "crossing", "--inner", "geometri"]);
    assert_eq!(own.status, 2);
    assert!(own.stderr.contains("geometric:k:f64"), "{}", own.stderr);
}
