//! Claim: what `solve` calls converged has u and t within ten tolerances, too, where fractures cross and an H of 1e-3 to 1e-9 of what it
//! is by default alone holds tractions that each move something and together move nothing.
//!
//! `HELD_CASES=500 HELD_SEED=7 cargo test --release --test systems held_by_h:: -- --nocapture` tries more systems.

use super::accuracy::environment;
use super::foreign_accuracy::{fixed, judged};
use super::reference::reference;
use fracas::contact::JumpStabilization;
use fracas::scene::Scene;
use fracas_operators::random::Random;
use fracas_solvers::saddle::SaddleBlocks;

/// Systems tried where nobody asks for more.
const CASES: u64 = 16;

/// Inner solvers of RACP, each with every system.
const INNER: [&str; 3] = ["exact", "amg", "amg:fsai"];

/// A small box that two or three planes cut, every column of B1 with its own load.
fn system(r: &mut Random) -> Option<SaddleBlocks> {
    let mut toml = "title = 'crossing'\n[mesh]\n".to_owned();
    let cells = [0; 3].map(|_| r.whole(2, 4));
    let size = r.one_of(&[1.0, 1.0, 0.1]);
    for ((axis, n), size) in ["x", "y", "z"].iter().zip(cells).zip([1.0, size, 1.0]) {
        let to = size * f64::from(n);
        toml += &format!("{axis} = {{ from = '0 m', to = '{to} m', cells = {n} }}\n");
    }
    toml += &format!(
        "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = {}\n",
        r.between(0.0, 0.45)
    );
    let planes = if r.chance(0.5) { "xy" } else { "xyz" };
    for axis in planes.chars() {
        toml += &format!(
            "[[fracture]]\nname = '{axis}'\nplane = '{axis}'\nevery = {}\nfriction_angle = '30 deg'\n",
            r.whole(1, 2)
        );
    }
    toml += "[[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'z+'\npressure = '5 MPa'\n";
    for side in ["x-", "x+", "y-", "y+"] {
        if r.chance(0.7) {
            toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
        }
    }
    let body = Scene::from_toml(&toml, "scene.toml")
        .unwrap()
        .build()
        .ok()?;
    let mut blocks = body
        .saddle_blocks(Some(JumpStabilization::default()))
        .ok()?;
    let less = 10f64.powi(-r.one_of(&[3, 6, 9]));
    let h = blocks.h.as_mut()?;
    h.data_mut().iter_mut().for_each(|h| *h *= less);
    let unit = 1e6 * blocks.contact_compliance().iter().sum::<f64>() / blocks.n_t() as f64;
    blocks
        .rhs_t
        .fill_with(|| unit * less * r.between(-1.0, 1.0));
    Some(blocks)
}

#[test]
fn tractions_that_h_alone_holds_are_right_or_refused() {
    let (first, cases) = (
        environment("HELD_SEED", 1),
        environment("HELD_CASES", CASES),
    );
    let (mut tried, mut converged, mut wrong) = (0, 0, Vec::new());
    for seed in 0..cases {
        let r = &mut Random::new(first.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(seed));
        let Some(blocks) = system(r) else {
            continue;
        };
        let Some(exact) = reference(&blocks, &blocks.rhs()) else {
            continue;
        };
        for inner in INNER {
            let tolerance = r.one_of(&[1e-3, 1e-5, 1e-7]);
            tried += 1;
            let Some(right) = judged(&blocks, &exact, &fixed("racp", inner, tolerance)) else {
                continue;
            };
            converged += 1;
            if let Err(text) = right {
                wrong.push(format!("seed {first}+{seed}, {text}"));
            }
        }
    }
    println!(
        "{tried} solves, {converged} converged, {} wrong",
        wrong.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(
        10 * converged > 7 * tried,
        "{converged} of {tried} converged"
    );
}
