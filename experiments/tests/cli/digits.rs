//! Claim: contrasts that leave an inner solver no digits end neither in a refusal of a sound scene nor in a wrong answer.
#![allow(clippy::unwrap_used, reason = "a test that cannot read a report fails")]

use crate::run::{fracas, scratch, write};
use fracas_operators::matrix_market::read_vector;
use serde_json::Value;
use std::path::Path;

/// Soft and stiff rock: a layer between these heights with its modulus [Pa] and Poisson ratio.
fn scene(cells: &str, rock: [&str; 2], layer: [&str; 4], rest: &str) -> String {
    let [young, poisson] = rock;
    let [from, to, other, ratio] = layer;
    format!(
        "title = 'contrast'\n[mesh]\n{cells}\n[[material]]\nname = 'rock'\nyoung = '{young} Pa'\npoisson = {poisson}\n\
         [[material]]\nname = 'layer'\nyoung = '{other} Pa'\npoisson = {ratio}\nlayers = [['{from} m', '{to} m']]\n\
         [[fracture]]\nname = 'f'\nfriction_angle = '30 deg'\n{rest}"
    )
}

/// The report and the solution.
fn solved(scene: &Path, options: &[&str]) -> (Value, Vec<f64>) {
    let file = scene.with_extension("mtx");
    let fixed = ["solve", scene.to_str().unwrap(), "--json", "-"];
    let solution = ["--solution", file.to_str().unwrap()];
    let ran = fracas(&[&fixed[..], &solution, options].concat());
    assert!(matches!(ran.status, 0 | 3), "{options:?}: {}", ran.stderr);
    (
        serde_json::from_str(&ran.stdout).unwrap(),
        read_vector(&file).unwrap(),
    )
}

/// S_u of rock 10⁸ times as stiff as what it stands on is singular in f64 to a factorization, and was refused.
#[test]
fn without_an_inner_solver_a_scene_goes_on_where_s_u_cannot_be_factorized() {
    let cells = "x = { from = '0 m', to = '6 m', cells = 6 }\ny = { from = '0 m', to = '13.4 m', cells = 8 }\n\
                 z = { from = '0 m', to = '8 m', cells = 8 }";
    let rest = "plane = 'x'\nat = '3 m'\ny = ['1.675 m', '11.725 m']\n\
                [[boundary]]\nside = 'z-'\nhold = 'fixed'\n\
                [[boundary]]\nside = 'z+'\ndisplacement = { x = '0 m', z = '-0.8 mm' }\n";
    let rock = ["7.57666229553214e9", "0.25"];
    let text = scene(
        cells,
        rock,
        ["6", "8", "7.57666229553214e17", "0.4999"],
        rest,
    );
    let file = scratch("digits-stiff").join("stiff.toml");
    write(&file, &text);
    let (report, _) = solved(&file, &["--tolerance", "1e-6"]);
    assert_eq!(report["outcome"], "converged");
    assert_eq!(report["inner_fallbacks"], 1);
    assert_eq!(report["inner"], "geometric:f64");
    let findings = report["findings"].to_string();
    assert!(findings.contains("geometric instead"), "{findings}");
}

/// Tractions within rock 10⁸ times softer than what moves it were wrong by 3e-4 with AMG in f32, and called converged: the iteration does
/// not see the small eigenvalue that f32 leaves.
#[test]
fn rock_that_spreads_over_the_digits_of_f32_is_solved_in_f64() {
    let cells = "x = { from = '0 m', to = '4 m', cells = 4 }\ny = { from = '0 m', to = '2.8745997850184906 m', cells = 4 }\n\
                 z = { from = '0 m', to = '40 m', cells = 4 }";
    let rest = "plane = 'y'\nat = '0.7186499462546226 m'\nx = ['1 m', '3 m']\nz = ['10 m', '30 m']\n\
                [[boundary]]\nside = 'z-'\nhold = 'fixed'\n\
                [[boundary]]\nside = 'z+'\ndisplacement = { x = '4 mm', z = '-4 mm' }\n\
                [[boundary]]\nside = 'x-'\nhold = 'roller'\n\
                [[boundary]]\nside = 'x+'\ndisplacement = { x = '4 mm' }\n";
    let rock = ["24950037057.181892", "0.499"];
    let text = scene(
        cells,
        rock,
        ["10", "30", "249.50037057181893", "0.25"],
        rest,
    );
    let file = scratch("digits-soft").join("soft.toml");
    write(&file, &text);
    let (report, x) = solved(&file, &["--inner", "amg"]);
    let (exact, y) = solved(&file, &["--inner", "geometric"]);
    assert_eq!(exact["outcome"], "converged");
    let n_u = report["n_u"].as_u64().unwrap() as usize;
    let size = |v: &mut dyn Iterator<Item = f64>| v.map(|v| v * v).sum::<f64>().sqrt();
    let pairs = || x.iter().zip(&y).skip(n_u);
    let error = size(&mut pairs().map(|(x, y)| x - y)) / size(&mut pairs().map(|(_, y)| *y));
    // in f64 there are digits enough for an answer that is right, or for saying that it is not
    assert!(
        report["outcome"] != "converged" || error < 1e-6,
        "{error:e}: {report}"
    );
    assert_eq!(report["precision_fallbacks"], 1);
    assert_eq!(report["inner"], "amg (f64)");
}
