//! Claim: plates of thin cells between two cuts take few iterations of geometric multigrid, however thin they are.

use super::geometric_family::{ENOUGH, Sample};
use fracas_solvers::amg::Amg;
use fracas_solvers::multigrid::Geometric;
use fracas_solvers::saddle::InnerChoice;
use std::fmt::Write;

/// 4 m of rock, so many thin cells between two cuts, and 4 m of rock; cells of 1 m elsewhere.
fn scene(count: usize, width: f64) -> String {
    let thick = count as f64 * width;
    let thin = (1..count).map(|i| 4.0 + i as f64 * width);
    let rock = (0..=4).map(f64::from);
    let x = rock
        .clone()
        .chain(thin)
        .chain(rock.map(|x| x + 4.0 + thick));
    let lines: Vec<String> = x.map(|x| format!("'{x:.6} m'")).collect();
    let mut toml = format!(
        "title = 'plate'\n[mesh]\nx = {{ lines = [{}] }}\n",
        lines.join(", ")
    );
    for axis in ["y", "z"] {
        let _ = writeln!(toml, "{axis} = {{ from = '0 m', to = '8 m', cells = 8 }}");
    }
    toml += "[[material]]\nname = 'rock'\nyoung = '25 GPa'\npoisson = 0.25\n";
    for (name, at) in [("a", 4.0), ("b", 4.0 + thick)] {
        let _ = writeln!(
            toml,
            "[[fracture]]\nname = '{name}'\nplane = 'x'\nat = '{at:.6} m'\nfriction_angle = '30 deg'"
        );
    }
    for (side, condition) in [
        ("z-", "hold = 'fixed'"),
        ("x-", "hold = 'roller'"),
        ("x+", "hold = 'fixed'"),
        ("z+", "pressure = '10 MPa'"),
        ("y+", "pressure = '5 MPa'"),
    ] {
        let _ = writeln!(toml, "[[boundary]]\nside = '{side}'\n{condition}");
    }
    toml
}

/// One cell of 1:10 and 1:200 took 62 and 924 iterations, where AMG takes 28 and 78; four of 1:10 took 52 for 19.
#[test]
fn plates_between_cuts_take_few_iterations() {
    for count in [1, 2, 4, 6] {
        for width in [0.1, 0.02, 0.005] {
            let sample = Sample::new(&scene(count, width)).unwrap();
            let found = sample.geometric(Geometric::default()).unwrap();
            let amg = || sample.assembled(InnerChoice::Amg(Amg::default())).unwrap();
            println!("{count} cells of {width} m: {found}");
            assert!(
                found <= ENOUGH || found <= 2 * amg(),
                "{count} cells of {width} m: {found} iterations"
            );
        }
    }
}
