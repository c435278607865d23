//! Claim: what `solve` calls converged has u and t within ten tolerances, too, where a system is larger than those that are eliminated to
//! know its errors: of rock with friction in its rows (B2 ≠ B1ᵀ), or beside a small system of which the load has hardly anything.
//!
//! `LARGE_CASES=200 LARGE_SEED=7 cargo test --release --test systems large:: -- --nocapture` tries more systems, and `LARGE_SKIP=17` begins
//! with that number.

use super::accuracy::{environment, flat_scene, scene};
use super::foreign_accuracy::{beside, fixed, hidden_beside, judged, system};
use super::reference::reference;
use fracas::contact::JumpStabilization;
use fracas::scene::Scene;
use fracas_operators::random::Random;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::saddle::SaddleBlocks;

/// Systems tried where nobody asks for more.
const CASES: u64 = 6;

/// Cells up to which a box has twice as many along every axis, and up to which three times as many: a thousand to ten thousand unknowns.
const CELLS: [u32; 2] = [400, 60];

/// Methods, those of the house more often.
const METHODS: [&str; 5] = ["racp", "racp", "racp", "racp:published", "mcp"];

const INNER: [&str; 4] = ["exact", "exact", "exact", "amg"];

const TOLERANCES: [f64; 3] = [1e-4, 1e-6, 1e-8];

/// The same box with two or three times as many cells along every axis.
fn refined(toml: &str) -> String {
    let mut parts = toml.split("cells = ");
    let first = parts.next().unwrap();
    let parts: Vec<(u32, &str)> = parts
        .map(|part| {
            let end = part.find(|c: char| !c.is_ascii_digit()).unwrap();
            (part[..end].parse().unwrap(), &part[end..])
        })
        .collect();
    let cells: u32 = parts.iter().map(|(n, _)| n).product();
    let times = 1 + CELLS.iter().filter(|most| cells <= **most).count() as u32;
    let more = |(n, rest): &(u32, &str)| format!("cells = {}{rest}", times * n);
    first.to_owned() + &parts.iter().map(more).collect::<String>()
}

/// Rows of tractions as friction couples them: the jump along a face comes with a part of that across it, on faces that slip.
fn sliding(b1: &SparseMatrix<f64>, r: &mut Random) -> SparseMatrix<f64> {
    let friction = r.between(0.0, 1.0);
    let share = r.one_of(&[0.1, 0.5, 1.0]);
    let faces = b1.cols() / 3;
    let slip: Vec<[f64; 2]> = (0..faces)
        .map(|_| match r.chance(share) {
            true => [0; 2].map(|_| friction * r.between(-1.0, 1.0)),
            false => [0.0; 2],
        })
        .collect();
    let mut rows = Triplets::new((b1.cols(), b1.rows()));
    for (b, (i, j)) in b1 {
        let (i, j) = (i as usize, j as usize);
        rows.add_triplet(j, i, *b);
        if j % 3 == 0 {
            for (k, slip) in slip[j / 3].iter().enumerate().filter(|(_, s)| **s != 0.0) {
                rows.add_triplet(j + 1 + k, i, slip * b);
            }
        }
    }
    rows.to_csr()
}

/// A system of rock, in a unit of tractions that balances it.
fn of_rock(r: &mut Random) -> Option<SaddleBlocks> {
    let text = match r.chance(0.6) {
        true => scene(r.below(1 << 30) as u64),
        false => flat_scene(r.below(1 << 30) as u64),
    };
    let body = Scene::from_toml(&refined(&text), "scene.toml")
        .unwrap()
        .build()
        .ok()?;
    let stabilization = Some(JumpStabilization::default());
    let unit = body.stick_system(stabilization).magnitude().ok()?.unit;
    let blocks = body.saddle_blocks(stabilization).ok()?;
    Some(blocks.into_traction_unit(unit))
}

#[test]
fn converged_means_accurate_for_large_systems() {
    let (first, cases) = (
        environment("LARGE_SEED", 1),
        environment("LARGE_CASES", CASES),
    );
    let skip = environment("LARGE_SKIP", 0);
    let (mut tried, mut converged, mut wrong) = (0, 0, Vec::new());
    for seed in skip..skip + cases {
        let r = &mut Random::new(first.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(seed));
        let Some(mut blocks) = of_rock(r) else {
            continue;
        };
        let kind = r.below(3);
        if kind != 1 {
            blocks.b2 = Some(sliding(&blocks.b1, r));
        }
        let tolerance = r.one_of(&TOLERANCES);
        let Some(mut exact) = reference(&blocks, &blocks.rhs()) else {
            continue;
        };
        if kind != 0 {
            let other = system(r);
            let Some(y) = reference(&other, &other.rhs()) else {
                continue;
            };
            let pair = [(&blocks, &*exact), (&other, &*y)];
            let Some(both) = hidden_beside(r, pair, tolerance) else {
                continue;
            };
            (blocks, exact) = both;
        }
        let n = blocks.n_u() + blocks.n_t();
        for _ in 0..2 {
            let (method, inner) = (r.one_of(&METHODS), r.one_of(&INNER));
            tried += 1;
            let Some(right) = judged(&blocks, &exact, &fixed(method, inner, tolerance)) else {
                continue;
            };
            converged += 1;
            if let Err(text) = right {
                println!("seed {first}+{seed}, kind {kind}, n {n}, {inner}: {text}");
                wrong.push(format!("seed {first}+{seed}, {text}"));
            }
        }
    }
    println!(
        "{tried} solves, {converged} converged, {} wrong",
        wrong.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(3 * converged > tried, "{converged} of {tried} converged");
}

/// A chain of springs, and tractions between some of its nodes.
fn chain(r: &mut Random) -> SaddleBlocks {
    let n = r.whole(1_000, 6_000) as usize;
    let m = (f64::from(n as u32) * r.between(0.1, 0.6)) as usize;
    let coupling = r.between(-0.99, 0.99);
    let [mut a, mut b1] = [(n, n), (n, m)].map(Triplets::new);
    for i in 0..n {
        a.add_triplet(i, i, 2.0);
        if i + 1 < n {
            a.add_triplet(i, i + 1, coupling);
            a.add_triplet(i + 1, i, coupling);
        }
    }
    let is_jump = r.chance(0.5);
    for j in 0..m {
        b1.add_triplet(j, j, 1.0);
        if is_jump {
            b1.add_triplet(n - 1 - j / 2, j, -1.0);
        }
    }
    let mut loads = |count: usize| (0..count).map(|_| r.between(-1.0, 1.0)).collect();
    SaddleBlocks {
        rhs_u: loads(n),
        rhs_t: loads(m),
        a: a.to_csr(),
        b1: b1.to_csr(),
        b2: None,
        h: None,
        coordinates: None,
        flow: None,
    }
}

/// Tractions of which the last pushes as all others together, but for a share of 1e-4 to 0.1, and the load of equal and opposite ones.
fn alike(r: &mut Random) -> SaddleBlocks {
    let others = r.whole(1, 2) as usize;
    let own = r.scale(1e-4, 0.1);
    let (n, m) = (others + 1, others + 1);
    let [mut a, mut b1] = [(n, n), (n, m)].map(Triplets::new);
    (0..n).for_each(|i| a.add_triplet(i, i, 2.0));
    for k in 0..others {
        b1.add_triplet(k, k, 1.0);
        b1.add_triplet(k, others, 1.0);
    }
    b1.add_triplet(others, others, own);
    let mut rhs_u = vec![0.0; n];
    rhs_u[others] = -own;
    SaddleBlocks {
        rhs_u,
        rhs_t: vec![0.0; m],
        a: a.to_csr(),
        b1: b1.to_csr(),
        b2: None,
        h: None,
        coordinates: None,
        flow: None,
    }
}

/// Eight steps of the power method saw nothing of the largest eigenvalue of what such tractions move together, among thousands of others, and what
/// looks for the smallest found that one.
#[test]
fn tractions_that_push_nearly_alike_are_found_among_thousands() {
    let first = environment("LARGE_SEED", 1);
    let cases = environment("LARGE_CASES", CASES);
    let (mut tried, mut converged, mut wrong) = (0, 0, Vec::new());
    for seed in 0..cases {
        let r = &mut Random::new(first.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(seed));
        let (mut one, other) = (chain(r), alike(r));
        if r.chance(0.3) {
            let rows: SparseMatrix<f64> = one.b1.transpose_view().to_csr();
            one.b2 = Some(rows.map(|b| b * 1.25));
        }
        let tolerance = r.one_of(&TOLERANCES);
        // both in the norm of C_0; a chain has tractions of about 1
        let share = tolerance * 10f64.powf(r.between(0.5, 3.0));
        let blocks = beside(&one, &other, share * (one.n_t() as f64).sqrt());
        let Some(exact) = reference(&blocks, &blocks.rhs()) else {
            continue;
        };
        for _ in 0..3 {
            let (method, inner) = (r.one_of(&METHODS), r.one_of(&INNER));
            tried += 1;
            let Some(right) = judged(&blocks, &exact, &fixed(method, inner, tolerance)) else {
                continue;
            };
            converged += 1;
            if let Err(text) = right {
                println!("seed {first}+{seed}, {inner}: {text}");
                wrong.push(format!("seed {first}+{seed}, {text}"));
            }
        }
    }
    println!(
        "{tried} solves, {converged} converged, {} wrong",
        wrong.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(4 * converged > tried, "{converged} of {tried} converged");
}
