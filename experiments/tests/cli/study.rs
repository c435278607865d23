//! Claim: a study is a product of axes whose rows are on the disk one by one, fail as rows, and outlive a killed process.
#![allow(clippy::unwrap_used)]

use crate::run::{fracas, scratch, system_folder, write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Two scenes, two meshes, three variants.
const STUDY: &str = r#"
title = "Two scenes"
question = "Do iterations grow with the mesh?"

[axes]
scene = ["clamped", "floating"]
set = { "mesh.x.cells" = [6], "mesh.y.cells" = [3], "mesh.z.cells" = [3] }
refine = [1, 2]
method = ["racp", "mcp", "block_diagonal"]

[[figure]]
x = "n"
y = "n_it"
log_x = true
line = [{ y = 17, label = "published", source = "test B" }]

[[figure]]
x = "method"
y = "C_s"
"#;

/// Fields of every row, with the heading first.
pub(crate) fn rows(out: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(out.join("rows.csv")).unwrap();
    let fields = |line: &str| line.split(',').map(String::from).collect();
    text.lines().map(fields).collect()
}

pub(crate) fn column(rows: &[Vec<String>], name: &str) -> Vec<String> {
    let k = rows[0].iter().position(|heading| heading == name).unwrap();
    rows[1..].iter().map(|row| row[k].clone()).collect()
}

/// What no second run repeats left out.
fn without_times(rows: &[Vec<String>]) -> Vec<Vec<String>> {
    let measured = ["mesh_s", "assembly_s", "setup_s", "solve_s", "memory"];
    let keep: Vec<bool> = (rows[0].iter())
        .map(|heading| !measured.contains(&heading.as_str()))
        .collect();
    let kept = |row: &Vec<String>| -> Vec<String> {
        let fields = row.iter().zip(keep.iter().chain(std::iter::repeat(&true)));
        fields
            .filter(|(_, keep)| **keep)
            .map(|(field, _)| field.clone())
            .collect()
    };
    rows.iter().map(kept).collect()
}

fn study(name: &str, text: &str) -> (String, std::path::PathBuf) {
    let folder = scratch(name);
    let file = folder.join("study.toml");
    write(&file, text);
    (file.to_str().unwrap().to_owned(), folder.join("out"))
}

fn refused(text: &str, sentence: &str) {
    let (file, out) = study("study-refused", text);
    let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 2, "{}", ran.stderr);
    assert!(
        ran.stderr.contains(sentence),
        "{} should say {sentence}",
        ran.stderr
    );
    assert!(
        !out.exists(),
        "nothing is written before the study is understood"
    );
}

#[test]
fn every_row_has_an_outcome_and_figures_have_their_series() {
    let (file, out) = study("study-whole", STUDY);
    let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let rows = rows(&out);
    assert_eq!(rows.len(), 1 + 2 * 2 * 3);
    let outcomes = column(&rows, "outcome");
    // A of floating blocks is singular, and this method inverts it
    let expected = |k: usize| match k {
        8 | 11 => "not_applicable",
        _ => "converged",
    };
    let expected: Vec<&str> = (0..12).map(expected).collect();
    assert_eq!(outcomes, expected);
    let reason = &column(&rows, "reason")[8];
    assert!(reason.contains("block A is singular"), "{reason}");
    let solved = fracas(&[
        "solve",
        "floating",
        "--set",
        "mesh.x.cells=12",
        "--set",
        "mesh.y.cells=6",
        "--set",
        "mesh.z.cells=6",
        "--method",
        "mcp",
        "--json",
        "-",
    ]);
    let solved: serde_json::Value = serde_json::from_str(&solved.stdout).unwrap();
    assert_eq!(column(&rows, "n_it")[10], solved["iterations"].to_string());
    for name in ["n_it_over_n", "C_s_over_method"] {
        let csv = std::fs::read_to_string(out.join(format!("figures/{name}.csv"))).unwrap();
        assert!(csv.contains("clamped") && csv.contains("floating"), "{csv}");
        assert!(out.join(format!("figures/{name}.svg")).exists());
    }
    let csv = std::fs::read_to_string(out.join("figures/n_it_over_n.csv")).unwrap();
    assert!(csv.contains("published (test B),dashed"), "{csv}");
    assert!(
        !csv.contains("refine"),
        "a curve is a method on all meshes: {csv}"
    );
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Do iterations grow with the mesh?") && page.contains("not_applicable"));
    let manifest = std::fs::read_to_string(out.join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(manifest["outcomes"]["converged"], 10);
}

#[test]
fn a_study_that_is_killed_twice_goes_on_to_the_same_rows() {
    let (file, whole) = study("study-killed", STUDY);
    let torn = whole.with_file_name("torn");
    let at = |out: &Path| {
        [
            "study".to_owned(),
            file.clone(),
            "--out".into(),
            out.to_str().unwrap().into(),
        ]
    };
    let kept_of = |out: &Path| std::fs::read_to_string(out.join("rows.csv")).unwrap_or_default();
    for rows in [3, 6] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_fracas"))
            .args(at(&torn))
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while kept_of(&torn).lines().count() < rows && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        // and a row that did not come to its end
        let text = kept_of(&torn);
        if text.lines().count() < 13 {
            write(&torn.join("rows.csv"), &format!("{text}12,floa"));
        }
    }
    let before = kept_of(&torn);
    let before = before.strip_suffix("12,floa").unwrap_or(&before);
    for out in [&torn, &whole] {
        let arguments = at(out);
        let ran = fracas(&arguments.each_ref().map(String::as_str));
        assert_eq!(ran.status, 0, "{}", ran.stderr);
    }
    assert!(kept_of(&torn).starts_with(before), "rows were solved again");
    assert_eq!(without_times(&rows(&torn)), without_times(&rows(&whole)));
    // figures and words change no row
    let shown = STUDY.replace("log_x = true", "log_x = false")
        + "\n[[table]]\nid = \"counts\"\ncolumns = [\"n\", \"n_it\"]\n";
    let before = kept_of(&torn);
    write(Path::new(&file), &shown);
    let arguments = at(&torn);
    let ran = fracas(&arguments.each_ref().map(String::as_str));
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    assert_eq!(kept_of(&torn), before);
    assert!(torn.join("figures/counts.csv").exists());
    // a measure that nobody took is another matter
    write(
        Path::new(&file),
        &shown.replace("\"n\", \"n_it\"", "\"n\", \"cond_A\""),
    );
    let ran = fracas(&arguments.each_ref().map(String::as_str));
    assert_eq!(ran.status, 2);
    assert!(
        ran.stderr.contains("its rows have no `cond_A`"),
        "{}",
        ran.stderr
    );
    // another study does not go into the same folder
    write(Path::new(&file), &STUDY.replace("[1, 2]", "[1, 3]"));
    let arguments = at(&torn);
    let ran = fracas(&arguments.each_ref().map(String::as_str));
    assert_eq!(ran.status, 2);
    assert!(
        ran.stderr
            .contains("its `axes.refine` is [1, 2], not [1, 3]"),
        "{}",
        ran.stderr
    );
}

#[test]
fn several_rows_at_once_end_in_the_same_order() {
    let (file, out) = study("study-jobs", STUDY);
    let one = out.with_file_name("one");
    for (out, jobs) in [(&out, "3"), (&one, "1")] {
        let ran = fracas(&[
            "study",
            &file,
            "--jobs",
            jobs,
            "--out",
            out.to_str().unwrap(),
        ]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
    }
    assert_eq!(without_times(&rows(&out)), without_times(&rows(&one)));
}

#[test]
fn systems_references_seeds_and_eigenvalues_from_the_command_line() {
    let system = system_folder("study-system");
    let out = system.with_file_name("cli-compared");
    let _ = std::fs::remove_dir_all(&out);
    let ran = fracas(&[
        "compare",
        "--system",
        system.to_str().unwrap(),
        "--method",
        "racp,mcp",
        "--rhs",
        "ones,random:7",
        "--tolerance",
        "1e-4,1e-8",
        "--reference",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let found = rows(&out);
    assert_eq!(found.len(), 9);
    for (error, tolerance) in column(&found, "error_t")
        .iter()
        .zip(column(&found, "tolerance"))
    {
        let [error, tolerance] = [error, &tolerance].map(|text| text.parse::<f64>().unwrap());
        assert!(error <= 10.0 * tolerance, "{error:e} with {tolerance:e}");
    }
    let drawn = out.join("figures/error_u_over_solve_s.svg");
    let on_paper = drawn.with_extension("pdf");
    assert!(drawn.exists() && !on_paper.exists());
    // what it wrote is a study that goes on by itself, draws again, and one that asks for eigenvalues
    let file = out.join("study.toml");
    let before = std::fs::read(out.join("rows.csv")).unwrap();
    let again = fracas(&[
        "study",
        file.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
        "--pdf",
    ]);
    assert_eq!(again.status, 0, "{}", again.stderr);
    assert_eq!(std::fs::read(out.join("rows.csv")).unwrap(), before);
    assert!(std::fs::read(on_paper).unwrap().starts_with(b"%PDF-"));
    let text = std::fs::read_to_string(&file).unwrap();
    let text = text.replace("measures = [", "measures = [\"real_min\", \"contained\", ");
    let (file, out) = study("study-spectrum", &text);
    let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let least = column(&rows(&out), "real_min");
    assert!(
        least
            .iter()
            .all(|value| value.parse::<f64>().unwrap() > 0.0),
        "{least:?}"
    );
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    refused(
        &STUDY.replace("refine =", "refien ="),
        "study.toml:8:1: unknown key `refien`, did you mean `refine`?",
    );
    refused(
        &STUDY.replace("mesh.x.cells", "mesh.x.cell"),
        "unknown key `cell`, did you mean `cells`?",
    );
    refused(&STUDY.replace("\"mcp\"", "\"mpc\""), "study.toml:9:");
    refused(
        &STUDY.replace("\"clamped\"", "\"clampd\""),
        "did you mean `clamped`?",
    );
    refused(
        &STUDY.replace("y = \"n_it\"", "y = \"n_its\""),
        "study.toml:11: [[figure]] 1: `y` is `n_its` (did you mean `n_it`?); there are: n, n_u",
    );
    let with = |section: &str| format!("{STUDY}\n{section}\n");
    refused(
        &with("[[check]]\nclaim = \"few\"\nof = \"n_it / n_x\"\nmax = 1"),
        "study.toml:21: [[check]] 1: `of` is `n_x` (did you mean `n_u`?)",
    );
    refused(
        &with("[[check]]\nclaim = \"few\"\nof = \"n_it\""),
        "[[check]] 1: it needs one of min, max, equals, is",
    );
    refused(
        &with("[[check]]\nclaim = \"few\"\nof = \"n_it\"\nmaks = 1"),
        "study.toml:24:1: unknown key `maks`, did you mean `max`?",
    );
    refused(
        &with("[[table]]\nid = \"t\"\ncolumns = [\"a = (n_it\"]"),
        "[[table]] 1: `columns` is `(n_it`: a bracket is not closed",
    );
    let with_axis = |line: &str| STUDY.replace("refine =", &format!("{line}\nrefine ="));
    let variant = |name: &str, keys: &str| {
        with_axis(&format!(
            "together = [{{ name = \"{name}\", values = [{{ name = \"a\", {keys} }}] }}]"
        ))
    };
    refused(
        &with_axis("threads = [0]"),
        "a row has at least one of `threads`",
    );
    refused(
        &with_axis("stabilization = [-1.0]"),
        "`stabilization` is -1, and factors of H",
    );
    refused(
        &variant("method", "inner = \"amg\""),
        "variants cannot be called `method`",
    );
    refused(
        &variant("own", "method = \"racp\""),
        "`method` is an axis, and a variant says it, too",
    );
    refused(&variant("own", "metod = \"racp\""), "study.toml:8:");
    refused(
        &STUDY.replace("refine =", "state = [\"slip:1.5\"]\nrefine ="),
        "no contact state `slip:1.5`",
    );
    refused(
        &format!("{STUDY}\n[[skip]]\nmethod = \"direct\"\n"),
        "[[skip]] 1 matches no row",
    );
}

/// Variants with their own C, a contact state, a pivot and claims.
const VARIANTS: &str = r#"
title = "Variants"
counts = "published"
published = [{ where = { variant = "relaxed" }, source = "a table", n_it = 100 }]

[axes]
scene = ["analogue_b:small"]
state = ["stick", "slip:0.5"]
together = [{ name = "variant", values = [
  { name = "relaxed", augmentation = "fitted_h", inner = "amg" },
  { name = "as published", method = "racp:0", augmentation = "local_h", inner = "exact", largest = 100 },
] }]

[[table]]
id = "pivot"
rows = ["state"]
columns = ["state", "slip [%] = slip", { name = "relaxed", of = "n_it", where = { variant = "relaxed" } }, { name = "published", of = "n_it", where = { variant = "as published" } }, "share = n_it / published.n_it"]

[[check]]
claim = "{state}: fewer than published"
of = "n_it"
where = { variant = "relaxed" }
max = "published.n_it"

[[check]]
claim = "slip costs little"
of = "n_it"
where = { variant = "relaxed" }
pair = "variant"
over = { where = { state = "stick" } }
take = "max"
max = 2
"#;

#[test]
fn variants_states_pivots_and_claims_are_data() {
    let (file, out) = study("study-variants", VARIANTS);
    let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let outcomes = column(&rows(&out), "outcome");
    assert_eq!(
        outcomes,
        ["converged", "not_tried", "converged", "not_tried"]
    );
    let pivot = std::fs::read_to_string(out.join("figures/pivot.csv")).unwrap();
    let lines: Vec<Vec<&str>> = pivot
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    assert_eq!(
        lines[0],
        ["state", "slip [%]", "relaxed", "published", "share"]
    );
    assert_eq!([lines[1][0], lines[1][1], lines[1][3]], ["stick", "0", ""]);
    assert_eq!([lines[2][0], lines[2][1]], ["slip:0.5", "50"]);
    let [n_it, share] = [2, 4].map(|k| lines[2][k].parse::<f64>().unwrap());
    assert_eq!(share, n_it / 100.0);
    // the same claim with a bound that cannot hold
    let text = VARIANTS.replace("max = 2\n", "max = 0.5\n");
    let (file, out) = study("study-fails", &text);
    let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 4, "{}", ran.stderr);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("slip costs little") && page.contains("fails"));
}

#[test]
fn a_study_of_the_gallery_is_known_by_name_and_goes_on_as_reproduce_prints_it() {
    let out = scratch("study-gallery");
    let [own, chapter] = ["own", "chapter"].map(|name| out.join(name));
    let level = ["--level", "smoke", "--out"];
    let at = |command: &str, out: &Path| {
        let arguments = [&[command, "e02"], &level[..], &[out.to_str().unwrap()]].concat();
        let ran = fracas(&arguments);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
    };
    at("study", &own);
    // eigenvalues of the rows come back from the disk
    std::fs::remove_dir_all(own.join("figures")).unwrap();
    at("study", &own);
    at("reproduce", &chapter);
    for name in [
        "e02_spectra.csv",
        "e02_exact_h.csv",
        "e02_ssor_local_h_h.csv",
    ] {
        let read = |folder: std::path::PathBuf| std::fs::read_to_string(folder.join(name)).unwrap();
        assert_eq!(
            read(own.join("figures")),
            read(chapter.join("e02")),
            "{name}"
        );
    }
    let ran = fracas(&["study", "e99", "--out", "nowhere"]);
    assert!(
        ran.stderr
            .contains("no study of the gallery is called `e99`"),
        "{}",
        ran.stderr
    );
    let ran = fracas(&["study", "e02", "--level", "smok", "--out", "nowhere"]);
    assert!(
        ran.stderr
            .contains("e02.toml has no level `smok`; there are: smoke"),
        "{}",
        ran.stderr
    );
}

/// Runs, which are killed, maps, swings and residuals.
const RUNS: &str = r#"
title = "Runs"

[[axes]]
part = "runs"
measures = ["run_steps", "run_newton", "run_krylov", "run_slip", "run_onset"]
scene = ["cycle:small"]
set."solver.racp.inner" = ["exact", "amg"]

[[axes]]
part = "solves"
measures = ["n_it"]
scene = ["layered:small"]
inner = ["exact", "amg"]
method = ["racp", "racp:0"]

[[axes]]
part = "changes"
measures = ["run_slip", "run_moment"]
scene = ["cycle:small"]
together = [{ name = "changed", values = [
    { name = "as it is" },
    { name = "friction angle [deg] = 20", set."fracture.cut.friction_angle" = "20 deg" },
    { name = "friction angle [deg] = 40", set."fracture.cut.friction_angle" = "40 deg" },
    { name = "ν = 0.1", set."material.0.poisson" = 0.1 },
] }]

[[figure]]
id = "tornado"
kind = "tornado"
where = { part = "changes" }
x = "run_moment"
y = "changed"
log_x = true

[[figure]]
id = "map"
kind = "map"
where = { part = "solves" }
x = "inner"
y = "method"
color = "log10(n_it)"

[[figure]]
id = "residuals"
kind = "residuals"
where = { part = "solves" }
"#;

#[test]
fn runs_are_rows_that_go_on_from_their_checkpoints() {
    let (file, out) = study("study-runs", RUNS);
    let arguments = ["study", &file, "--out", out.to_str().unwrap()];
    let mut child = Command::new(env!("CARGO_BIN_EXE_fracas"))
        .args(arguments)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let history = out.join("runs/1/history.csv");
    let steps = || std::fs::read_to_string(&history).map_or(0, |text| text.lines().count());
    let start = Instant::now();
    while steps() < 5 && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = std::fs::read_to_string(&history).unwrap();
    let ran = fracas(&arguments);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let after = std::fs::read_to_string(&history).unwrap();
    let whole = before
        .lines()
        .next_back()
        .is_some_and(|last| after.contains(last));
    assert!(whole, "the run went on");
    let found = rows(&out);
    assert_eq!(column(&found, "outcome"), ["converged"; 10]);
    let number = |text: &String| text.parse::<usize>().unwrap();
    let sum = |name: &str| -> usize {
        let head: Vec<&str> = after.lines().next().unwrap().split(',').collect();
        let k = head.iter().position(|heading| *heading == name).unwrap();
        after
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(k).unwrap().parse::<usize>().unwrap())
            .sum()
    };
    assert_eq!(number(&column(&found, "run_krylov")[0]), sum("lin_it"));
    assert_eq!(number(&column(&found, "run_newton")[0]), sum("newton_it"));
    // a map has a cell per row, a curve its iterations and the residual that it starts from
    let csv =
        |name: &str| std::fs::read_to_string(out.join(format!("figures/{name}.csv"))).unwrap();
    assert_eq!(csv("map").matches(",cell,").count(), 4);
    let real = |text: &String| text.parse::<f64>().unwrap();
    let slip: Vec<f64> = column(&found, "run_slip")[..2].iter().map(real).collect();
    let faults = std::fs::read_to_string(out.join("runs/1/fault.csv")).unwrap();
    let rows_of = |name: &str| -> Vec<f64> {
        let head: Vec<&str> = faults.lines().next().unwrap().split(',').collect();
        let k = head.iter().position(|heading| *heading == name).unwrap();
        let fields = faults
            .lines()
            .skip(1)
            .map(|row| row.split(',').nth(k).unwrap());
        fields.map(|field| field.parse().unwrap()).collect()
    };
    let (slips, moments, times) = (
        rows_of("slip_max_m"),
        rows_of("moment_step_Nm"),
        rows_of("time_s"),
    );
    assert_eq!(slip[0], slips.iter().copied().fold(0.0, f64::max));
    let first = moments.iter().position(|moment| *moment > 0.0).unwrap();
    assert!(first > 0, "nothing slips at time 0");
    assert_eq!(real(&column(&found, "run_onset")[0]), times[first]);
    // a mark per change, and the line of the one that changes nothing
    let tornado = csv("tornado");
    assert_eq!(tornado.matches(",points,").count(), 3, "{tornado}");
    let base = &column(&found, "run_moment")[6];
    assert!(
        tornado.contains(&format!("nothing changed,dashed,{}", real(base))),
        "{tornado}"
    );
    let n_it: usize = column(&found, "n_it")[2..6].iter().map(number).sum();
    assert!(csv("residuals").matches(",line,").count() >= n_it);
    refused(
        &RUNS.replace(
            "scene = [\"cycle:small\"]",
            "scene = [\"cycle:small\"]\ninner = [\"amg\"]",
        ),
        "`inner` has no effect on a run",
    );
    let unchanged = "    { name = \"as it is\" },\n";
    refused(
        &RUNS.replace(unchanged, ""),
        "one without `=` that changes nothing",
    );
}

/// Every axis alone, each in a product of its own.
const AXES: &str = r#"
title = "Every axis"
clock = false
measures = ["n_it", "slip"]
"#;

#[test]
fn every_axis_that_the_page_lists_changes_what_it_should() {
    let [system, other] = ["study-axes-system", "study-axes-other"].map(system_folder);
    let [system, other] = [&system, &other].map(|folder| folder.to_str().unwrap());
    let small = "set = { \"mesh.x.cells\" = [6], \"mesh.y.cells\" = [3], \"mesh.z.cells\" = [3] }";
    let clamped = format!("scene = [\"clamped\"]\n{small}");
    // axis, its section, and the column that differs between its rows
    let axes = [
        (
            "scene",
            format!("scene = [\"clamped\", \"floating\"]\n{small}"),
            "digest",
        ),
        (
            "system",
            format!("system = [\"{system}\", \"{other}\"]\nrhs = [\"ones\"]"),
            "system",
        ),
        (
            "set",
            format!("{clamped}\nset.\"material.0.poisson\" = [0.2, 0.4]"),
            "digest",
        ),
        ("refine", format!("{clamped}\nrefine = [1, 2]"), "n_u"),
        (
            "axes.together",
            format!(
                "{clamped}\ntogether = [{{ name = \"variant\", values = [{{ name = \"a\", method = \"racp\", inner = \"exact\" }}, {{ name = \"b\", method = \"mcp\", inner = \"exact\" }}] }}]"
            ),
            "ran",
        ),
        (
            "state",
            "scene = [\"analogue_b:small\"]\nstate = [\"stick\", \"slip:0.25\"]".to_owned(),
            "slip",
        ),
        (
            "stabilization",
            format!("{clamped}\nstabilization = [0.0, 1.0]"),
            "digest",
        ),
        (
            "rhs",
            format!("{clamped}\nrhs = [\"sin\", \"random:3\"]"),
            "digest",
        ),
        (
            "method",
            format!("{clamped}\nmethod = [\"racp\", \"mcp\"]"),
            "ran",
        ),
        (
            "augmentation",
            format!("{clamped}\naugmentation = [\"local\", \"local_h\"]"),
            "C",
        ),
        (
            "inner",
            format!("{clamped}\ninner = [\"exact\", \"ssor\"]"),
            "n_it",
        ),
        (
            "krylov",
            format!("{clamped}\nkrylov = [\"gmres\", \"sqmr\"]\ninner = [\"exact\"]"),
            "iteration",
        ),
        (
            "tolerance",
            format!("{clamped}\ntolerance = [1e-3, 1e-10]"),
            "n_it",
        ),
        ("threads", format!("{clamped}\nthreads = [1, 2]"), "threads"),
    ];
    for (axis, section, differs) in &axes {
        let section = section.replace("\nset.\"", "\n# set\nset.\"");
        let section = match *axis {
            // one table of keys
            "set" => section.replace(
                " }\n# set\nset.\"material.0.poisson\" = [0.2, 0.4]",
                ", \"material.0.poisson\" = [0.2, 0.4] }",
            ),
            _ => section,
        };
        let (file, out) = study("study-axes", &format!("{AXES}\n[axes]\n{section}\n"));
        let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
        assert_eq!(ran.status, 0, "{axis}: {}", ran.stderr);
        let found = rows(&out);
        let fields = column(&found, differs);
        assert_eq!(fields.len(), 2, "{axis}");
        assert!(fields[0] != fields[1], "{axis}: {differs} is {fields:?}");
        let outcomes = column(&found, "outcome");
        assert!(
            outcomes.iter().all(|o| o == "converged"),
            "{axis}: {outcomes:?}"
        );
    }
    // those that the page lists, but for what only variants know
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/studies.md");
    let page = std::fs::read_to_string(page).unwrap();
    let listed = page
        .split("### Axes")
        .nth(1)
        .unwrap()
        .split("### ")
        .next()
        .unwrap();
    let cells = listed.lines().filter(|line| line.starts_with("| `"));
    let names = cells.flat_map(|line| {
        line.split('|')
            .nth(1)
            .unwrap()
            .split('`')
            .skip(1)
            .step_by(2)
    });
    for name in names.filter(|name| !["matrix_free", "single", "repetitions"].contains(name)) {
        let name = name.trim_matches(['[', ']']);
        assert!(
            axes.iter().any(|(axis, ..)| *axis == name),
            "{name} is not tried"
        );
    }
}

#[test]
fn a_table_shows_the_least_of_rows_that_agree() {
    let table = "\n[[table]]\nid = \"best\"\nrows = [\"scene\"]\nleast = \"C_s\"\ncolumns = [\"scene\", \"method\", \"C_s\"]\n";
    let (file, out) = study(
        "study-least",
        &format!(
            "{}{table}",
            STUDY.replace("refine = [1, 2]", "refine = [1]")
        ),
    );
    let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let found = rows(&out);
    let best = std::fs::read_to_string(out.join("figures/best.csv")).unwrap();
    let [scenes, costs] = ["scene", "C_s"].map(|name| column(&found, name));
    assert_eq!(best.lines().count(), 3);
    for line in best.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let of_scene = scenes
            .iter()
            .zip(&costs)
            .filter(|(scene, _)| *scene == fields[0]);
        let least = of_scene
            .filter_map(|(_, c)| c.parse().ok())
            .fold(f64::INFINITY, f64::min);
        assert_eq!(fields[2].parse::<f64>().unwrap(), least, "{line}");
    }
    refused(
        &format!(
            "{STUDY}{}",
            table.replace("least = \"C_s\"", "least = \"C_z\"")
        ),
        "C_z",
    );
}
