//! Claim: plates of thin cells between two cuts take few iterations of geometric multigrid, however thin they are, and so do slabs that bend.
//!
//! `SLABS=40 SLABS_SEED=7 cargo test --release --test multigrid plates:: -- --nocapture` tries more slabs.

use super::geometric_family::{ENOUGH, Sample, of_environment};
use fracas_operators::random::Random;
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

/// Blocks of 1:5 to 1:40, one to two cells each, cut on all sides: 30,492 displacements.
const BLOCKS: &str = r#"
title = "blocks"
[mesh]
x = { lines = ["0 m", "1 m", "1.5 m", "5.5 m", "7.5 m", "8 m", "8.5 m", "12.5 m", "13.5 m", "14.5 m", "15 m", "15.5 m", "16 m", "18 m", "22 m", "24 m"] }
y = { from = "0 m", to = "1.1 m", cells = 11 }
z = { lines = ["0 m", "0.5 m", "2.5 m", "4.5 m", "5 m", "6 m", "6.5 m", "7 m", "11 m", "11.5 m", "15.5 m", "19.5 m"] }
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.4
[[fracture]]
name = "x"
plane = "x"
every = 2
friction_angle = "30 deg"
[[fracture]]
name = "y"
plane = "y"
every = 1
friction_angle = "30 deg"
[[fracture]]
name = "z"
plane = "z"
every = 1
friction_angle = "30 deg"
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "y+"
pressure = "5 MPa"
[[boundary]]
side = "z-"
hold = "fixed"
"#;

/// They took 163 iterations, where AMG takes 46, below a coarse grid that kept all nodes.
#[test]
fn blocks_that_keep_their_nodes_are_not_coarsened() {
    let sample = Sample::new(BLOCKS).unwrap();
    let found = sample.geometric(Geometric::default()).unwrap();
    println!("blocks: {found}");
    assert!(found <= 40, "{found} iterations");
}

/// A slab with cells of 1 m in its plane, two to four much thinner ones across, cut once to three times, that what pulls at one side bends.
fn slab(r: &mut Random) -> String {
    let (across, thickness) = (r.whole(2, 4), r.scale(0.1, 2.0));
    let sides = [0; 2].map(|_| r.whole(48, 64));
    let mut toml = format!(
        "title = 'slab'\n[mesh]\nz = {{ from = '0 m', to = '{thickness} m', cells = {across} }}\n"
    );
    for (axis, cells) in ["x", "y"].iter().zip(sides) {
        let _ = writeln!(
            toml,
            "{axis} = {{ from = '0 m', to = '{cells} m', cells = {cells} }}"
        );
    }
    let poisson = r.between(0.0, 0.45);
    let _ = writeln!(
        toml,
        "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = {poisson}"
    );
    for k in 0..r.whole(1, 3) {
        let axis = r.below(2);
        let (plane, at) = (["x", "y"][axis], r.whole(8, sides[axis] - 8));
        let _ = writeln!(
            toml,
            "[[fracture]]\nname = 'f{k}'\nplane = '{plane}'\nat = '{at} m'\nfriction_angle = '30 deg'"
        );
    }
    let opposite = match r.chance(0.3) {
        true => "hold = 'roller'",
        false => "traction = { z = '-1 kPa', x = '-1 MPa' }",
    };
    let held = r.one_of(&["x-", "y-"]);
    let other = held.replace('-', "+");
    toml + &format!(
        "[[boundary]]\nside = '{held}'\nhold = 'fixed'\n[[boundary]]\nside = '{other}'\n{opposite}\n"
    )
}

/// 60 × 60 × 2 cells of 1:10 over a cut.
const BENT: &str = r#"title = "slab"
[mesh]
x = { from = "0 m", to = "60 m", cells = 60 }
y = { from = "0 m", to = "60 m", cells = 60 }
z = { from = "0 m", to = "0.2 m", cells = 2 }
[[material]]
name = "rock"
young = "10 GPa"
poisson = 0.25
[[fracture]]
name = "f"
plane = "x"
at = "30 m"
friction_angle = "30 deg"
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "x+"
traction = { z = "-1 kPa", x = "-1 MPa" }
"#;

/// Wide cells cannot bend without shear, and those of every coarser grid are four times as stiff: these took 1,000 iterations.
#[test]
fn a_slab_that_bends_takes_few_iterations() {
    let sample = Sample::new(BENT).unwrap();
    let found = sample.geometric(Geometric::default()).unwrap();
    println!("slab: {found}");
    assert!(found <= ENOUGH, "{found} iterations");
}

/// 30 × 6 × 30 cells, graded by 40, over a cut.
const GRADED: &str = r#"title = "thin plate"
[mesh]
x = { from = "0 m", to = "10 m", cells = 30, ratio = 40.0 }
y = { from = "0 m", to = "0.13 m", cells = 6 }
z = { from = "0 m", to = "100 m", cells = 30 }
[[material]]
name = "rock"
young = "6.73 GPa"
poisson = 0.499
[[fracture]]
name = "f0"
plane = "z"
at = "50 m"
friction_angle = "30 deg"
[[boundary]]
side = "x+"
hold = "fixed"
[[boundary]]
side = "y+"
pressure = "11 MPa"
[[boundary]]
side = "z+"
pressure = "5.09 MPa"
"#;

/// It took 1,000 iterations, AMG takes 378, and S_u factorized 45.
#[test]
fn a_graded_plate_that_hardly_changes_its_volume_takes_few_iterations() {
    let sample = Sample::new(GRADED).unwrap();
    let found = sample.geometric(Geometric::default()).unwrap();
    println!("graded plate: {found}");
    assert!(found <= 60, "{found} iterations");
}

/// Of a random slab with cells of 1:4 AMG took 75 iterations and geometric multigrid 155.
#[test]
fn random_slabs_that_bend_take_few_iterations() {
    let (cases, first) = (of_environment("SLABS", 1), of_environment("SLABS_SEED", 4));
    let mut missed = Vec::new();
    for seed in 0..cases {
        let r = &mut Random::new(first.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(seed));
        let text = slab(r);
        // two cuts in one plane
        let Some(sample) = Sample::new(&text) else {
            continue;
        };
        let found = sample.geometric(Geometric::default()).unwrap();
        println!("seed {first}+{seed}: {found}");
        let amg = || sample.assembled(InnerChoice::Amg(Amg::default()));
        if found > ENOUGH && amg().is_ok_and(|amg| found > 2 * amg) {
            missed.push(format!("seed {first}+{seed}: {found}\n{text}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
