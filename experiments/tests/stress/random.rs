//! Random scenes through `run` and random systems through `solve`: a right answer or a sentence.

use crate::folders;
use crate::room::{Verdict, count, scratch, trial};
use crate::scenes;
use std::path::Path;
use std::process::{Command, Output};

/// Largest error of a solution in units of the largest entry, for a residual of 1e-10 of systems with a condition of 1e8.
const RIGHT: f64 = 1e-5;

/// The program with these arguments.
pub(crate) fn fracas(arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_fracas");
    Command::new(program).args(arguments).output().unwrap()
}

/// A status of the interface, and a sentence with each that is not 0; what is wrong otherwise.
pub(crate) fn ended(output: &Output) -> Result<i32, String> {
    let said = String::from_utf8_lossy(&output.stderr);
    match output.status.code() {
        Some(0) => Ok(0),
        Some(2) if said.lines().any(|l| l.starts_with("error: ")) => Ok(2),
        Some(3 | 4) if !said.trim().is_empty() => Ok(3),
        other => Err(format!("ends with {other:?} ({:?}): {said}", output.status)),
    }
}

#[test]
fn random_scenes_run_or_say_why_not() {
    let folder = scratch("random-scenes");
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    let [scene_name, out_name] = [&scene, &out].map(|p| p.display().to_string());
    trial("random scenes", count(1e-4, 20), |g| {
        let text = scenes::random(g);
        std::fs::write(&scene, &text).unwrap();
        let _ = std::fs::remove_dir_all(&out);
        let ran = fracas(&["run", &scene_name, "--out", &out_name, "--threads", "1"]);
        match ended(&ran) {
            Ok(0) => Verdict::Taken,
            Ok(_) => Verdict::Refused,
            Err(what) => Verdict::Finding(format!("{what}\n{text}")),
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn random_systems_are_solved_rightly_or_say_why_not() {
    let folder = scratch("random-systems");
    let solution = folder.join("solution.mtx");
    let [system, file] = [&folder, &solution].map(|p| p.display().to_string());
    trial("random systems", count(2e-4, 40), |g| {
        for (name, _) in folders::FILES {
            let _ = std::fs::remove_file(folder.join(name));
        }
        let _ = std::fs::remove_file(&solution);
        let (n_u, n_t) = folders::random(&folder, g);
        let method = g.one_of(&[
            "racp",
            "racp:0",
            "mcp",
            "direct",
            "simple",
            "block_triangular",
        ]);
        let inner = g.one_of(&["exact", "amg", "fsai", "ssor", "jacobi"]);
        let mut line = vec![
            "solve",
            "--system",
            &system,
            "--method",
            method,
            "--threads",
            "1",
        ];
        if method != "direct" {
            line.extend(["--inner", inner]);
        }
        line.extend(["--tolerance", "1e-10", "--solution", &file]);
        match ended(&fracas(&line)) {
            Ok(0) => {
                let error = error(&folder, &solution, n_u, n_t);
                match error <= RIGHT {
                    true => Verdict::Taken,
                    false => Verdict::Finding(format!("{line:?}: wrong by {error:e}")),
                }
            }
            Ok(_) => Verdict::Refused,
            Err(what) => Verdict::Finding(format!("{line:?}: {what}")),
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Largest difference from elimination with row pivoting, in units of the largest entry of its part.
fn error(folder: &Path, solution: &Path, n_u: usize, n_t: usize) -> f64 {
    let read = |name: &str| {
        let bytes = std::fs::read(folder.join(name)).ok()?;
        Some(folders::plain(&bytes).unwrap().2)
    };
    let n = n_u + n_t;
    let mut m = vec![vec![0.0; n + 1]; n];
    for (&(i, j), v) in &read("A.mtx").unwrap() {
        m[i][j] = *v;
    }
    for (&(i, j), v) in &read("B1.mtx").unwrap() {
        m[i][n_u + j] = *v;
        m[n_u + j][i] = *v;
    }
    for (&(i, j), v) in read("H.mtx").iter().flatten() {
        m[n_u + i][n_u + j] = -v;
    }
    for (name, shift) in [("rhs_u.mtx", 0), ("rhs_t.mtx", n_u)] {
        for (&(i, _), v) in &read(name).unwrap() {
            m[shift + i][n] = *v;
        }
    }
    let exact = eliminate(m);
    let found = folders::plain(&std::fs::read(solution).unwrap()).unwrap().2;
    let part = |range: std::ops::Range<usize>| {
        let size = range.clone().fold(0.0, |s: f64, i| s.max(exact[i].abs()));
        let worst = range.fold(0.0, |s: f64, i| {
            s.max((exact[i] - found.get(&(i, 0)).copied().unwrap_or(0.0)).abs())
        });
        worst / size
    };
    part(0..n_u).max(part(n_u..n))
}

/// Solves `[M | b]`, pivots by rows scaled to their largest entry.
fn eliminate(mut m: Vec<Vec<f64>>) -> Vec<f64> {
    let n = m.len();
    for row in &mut m {
        let size = row[..n].iter().fold(0.0, |s: f64, v| s.max(v.abs()));
        row.iter_mut().for_each(|v| *v /= size);
    }
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|a, b| m[*a][k].abs().total_cmp(&m[*b][k].abs()))
            .unwrap();
        m.swap(k, pivot);
        let (head, tail) = m.split_at_mut(k + 1);
        for row in tail {
            let factor = row[k] / head[k][k];
            for j in k..=n {
                row[j] -= factor * head[k][j];
            }
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| m[k][j] * x[j]).sum();
        x[k] = (m[k][n] - known) / m[k][k];
    }
    x
}
