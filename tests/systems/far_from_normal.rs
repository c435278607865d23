//! Claim: what `solve` calls converged has u and t within ten tolerances, too, where rows of B2 or H have multiples of other rows, so that 𝒜⁻¹ grows far
//! beyond what eigenvalues of M⁻¹𝒜 tell. The solution is of integers, and so are all entries: the load is exact.
//!
//! `NORMAL_CASES=300 NORMAL_SEED=7 cargo test --release --test systems far_from_normal:: -- --nocapture` tries more systems.

use super::accuracy::environment;
use super::foreign_accuracy::{INNER, errors, fixed, judged};
use fracas::solve::{End, Problem, Solve};
use fracas_operators::random::Random;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::Silent;
use fracas_solvers::saddle::SaddleBlocks;

/// Systems tried where nobody asks for more.
const CASES: u64 = 5;

const METHODS: [&str; 4] = ["racp", "racp:published", "mcp", "augmented_lagrangian"];

const TOLERANCES: [f64; 5] = [1e-4, 1e-5, 1e-6, 1e-8, 1e-10];

/// Errors allowed, in tolerances.
const ALLOWED: f64 = 10.0;

/// `M x`.
fn product(m: &SparseMatrix<f64>, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; m.rows()];
    for (v, (i, j)) in m {
        y[i as usize] += v * x[j as usize];
    }
    y
}

/// The Laplacian of a square of nodes, jumps between pairs of them, and chains of rows of B2 or H of which each has a multiple of the next; with the solution.
fn coupled(r: &mut Random) -> (SaddleBlocks, Vec<f64>) {
    let side = r.whole(33, 95) as usize;
    let n = side * side;
    let m = r.whole(40, n as u32 / 4) as usize;
    let mut a = Triplets::new((n, n));
    for i in 0..n {
        a.add_triplet(i, i, 4.0);
        let (row, column) = (i / side, i % side);
        for (next, is_inside) in [(i + side, row + 1 < side), (i + 1, column + 1 < side)] {
            if is_inside {
                a.add_triplet(i, next, -1.0);
                a.add_triplet(next, i, -1.0);
            }
        }
    }
    let mut nodes: Vec<usize> = (0..n).collect();
    for i in (1..n).rev() {
        nodes.swap(i, r.below(i + 1));
    }
    let mut b1 = Triplets::new((n, m));
    for (j, pair) in nodes.chunks_exact(2).take(m).enumerate() {
        b1.add_triplet(pair[0], j, 1.0);
        b1.add_triplet(pair[1], j, -1.0);
    }
    let b1: SparseMatrix<f64> = b1.to_csr();
    let of_b2 = r.chance(0.6);
    let unit = 2f64.powi(r.whole(0, 8) as i32);
    let mut rows = match of_b2 {
        true => Triplets::new((m, n)),
        false => Triplets::new((m, m)),
    };
    let entries: Vec<(usize, usize, f64)> = match of_b2 {
        true => (b1.iter())
            .map(|(v, (i, j))| (j as usize, i as usize, *v))
            .collect(),
        false => (0..m).map(|j| (j, j, unit)).collect(),
    };
    (entries.iter()).for_each(|(i, j, v)| rows.add_triplet(*i, *j, *v));
    let (chains, mut first) = (r.whole(1, 5), 0);
    for _ in 0..chains {
        let (length, times) = (r.whole(2, 6) as usize, f64::from(r.whole(3, 30)));
        if first + length >= m {
            break;
        }
        for (i, j, v) in entries
            .iter()
            .filter(|(i, ..)| (first + 1..=first + length).contains(i))
        {
            rows.add_triplet(i - 1, *j, times * v);
        }
        first += length + 1;
    }
    let rows: SparseMatrix<f64> = rows.to_csr();
    let share = r.one_of(&[1.0, 1.0, 0.05]);
    let mut whole = |count: usize| -> Vec<f64> {
        let entry = |_| match r.chance(share) {
            true => f64::from(r.whole(0, 10)) - 5.0,
            false => 0.0,
        };
        (0..count).map(entry).collect()
    };
    let (u, mut t) = (whole(n), whole(m));
    t[m - 1] = 1.0;
    let a: SparseMatrix<f64> = a.to_csr();
    let sum = |x: Vec<f64>, y: Vec<f64>| x.iter().zip(&y).map(|(x, y)| x + y).collect();
    let jump = match of_b2 {
        true => product(&rows, &u),
        false => {
            let of_b = product(&b1.transpose_view().to_csr(), &u);
            sum(of_b, product(&rows, &t).iter().map(|h| -h).collect())
        }
    };
    let blocks = SaddleBlocks {
        rhs_u: sum(product(&a, &u), product(&b1, &t)),
        rhs_t: jump,
        a,
        b1,
        b2: of_b2.then(|| rows.clone()),
        h: (!of_b2).then_some(rows),
        coordinates: None,
        flow: None,
    };
    (blocks, [u, t].concat())
}

#[test]
fn rows_that_hold_multiples_of_others_hide_no_errors() {
    let cases = environment("NORMAL_CASES", CASES);
    let first = environment("NORMAL_SEED", 1);
    let (mut tried, mut converged, mut wrong) = (0, 0, Vec::new());
    for seed in 0..cases {
        let r = &mut Random::new(first.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(seed));
        let (blocks, exact) = coupled(r);
        for _ in 0..2 {
            let (name, inner) = (r.one_of(&METHODS), r.one_of(&INNER));
            let settings = fixed(name, inner, r.one_of(&TOLERANCES));
            tried += 1;
            let Some(right) = judged(&blocks, &exact, &settings) else {
                continue;
            };
            converged += 1;
            if let Err(text) = right {
                wrong.push(format!("seed {first}+{seed}, {inner}, {text}"));
            }
        }
        let tolerance = r.one_of(&TOLERANCES);
        let settings = Solve {
            tolerance,
            ..Solve::default()
        };
        tried += 1;
        let Ok(solved) = settings.solve(&Problem::from(blocks.clone()), &mut Silent) else {
            continue;
        };
        if solved.outcome == End::Converged {
            converged += 1;
            let [u, t] = errors(&blocks, &solved.x, &exact).map(|error| error / tolerance);
            // NaN is wrong, too
            if !(u <= ALLOWED && t <= ALLOWED) {
                wrong.push(format!(
                    "seed {first}+{seed}, default, {tolerance:e}: {u:.1} and {t:.1} tolerances"
                ));
            }
        }
    }
    println!(
        "{tried} solves, {converged} converged, {} wrong",
        wrong.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(2 * converged > tried, "{converged} of {tried} converged");
}
