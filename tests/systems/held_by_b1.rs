//! Claim: unknowns that A does not hold at all, rows of zeros that B1 alone holds, are solved by methods that do not need A itself, and what
//! `solve` calls converged is right in all tractions, not only in those that act there.
//!
//! `HELD_CASES=500 HELD_SEED=7 cargo test --release --test systems held_by_b1:: -- --nocapture` tries more systems.

use super::accuracy::environment;
use super::foreign_accuracy::{ALLOWED, INNER, TOLERANCES, errors, fixed, judged, system};
use super::reference::reference;
use fracas::solve::{End, Problem, Solve};
use fracas_operators::random::Random;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::Silent;
use fracas_solvers::saddle::SaddleBlocks;

/// Systems tried where nobody asks for more.
const CASES: u64 = 40;

/// Methods that do without A⁻¹.
const METHODS: [&str; 4] = ["racp", "racp:published", "mcp", "augmented_lagrangian"];

/// One to four unknowns more that A does not hold, each held by a traction of its own that moves up to three of the others as well, in a unit of its own.
fn with_rows_of_zeros(r: &mut Random, of: &SaddleBlocks) -> SaddleBlocks {
    let (n, m, more) = (of.n_u(), of.n_t(), r.whole(1, 4) as usize);
    let unit = 10f64.powi(r.one_of(&[-6, 0, 6]));
    let largest = of.b1.data().iter().fold(0.0f64, |b, v| b.max(v.abs()));
    let mut own = Vec::new();
    for k in 0..more {
        own.push((n + k, m + k, largest * unit * r.between(0.5, 2.0)));
        for _ in 0..r.whole(0, 3) {
            own.push((r.below(n), m + k, largest * unit * r.between(-1.0, 1.0)));
        }
        // a traction of the others moves it, too
        if r.chance(0.5) {
            own.push((n + k, r.below(m), largest * r.between(-1.0, 1.0)));
        }
    }
    let grown = |block: &SparseMatrix<f64>, more: &[(usize, usize, f64)], shape| {
        let mut grown = Triplets::new(shape);
        for (v, (i, j)) in block {
            grown.add_triplet(i as usize, j as usize, *v);
        }
        (more.iter()).for_each(|(i, j, v)| grown.add_triplet(*i, *j, *v));
        grown.to_csr()
    };
    let transposed: Vec<_> = own.iter().map(|(i, j, v)| (*j, *i, *v)).collect();
    let (rows, columns) = (n + more, m + more);
    let size = |v: &[f64]| v.iter().fold(0.0f64, |b, v| b.max(v.abs()));
    let mut load = |v: &[f64]| -> Vec<f64> {
        let size = size(v);
        let own = (0..more).map(|_| size * r.between(-1.0, 1.0));
        v.iter().copied().chain(own).collect()
    };
    SaddleBlocks {
        rhs_u: load(&of.rhs_u),
        rhs_t: load(&of.rhs_t),
        a: grown(&of.a, &[], (rows, rows)),
        b1: grown(&of.b1, &own, (rows, columns)),
        b2: (of.b2.as_ref()).map(|b2| grown(b2, &transposed, (columns, rows))),
        h: (of.h.as_ref()).map(|h| grown(h, &[], (columns, columns))),
        coordinates: None,
        flow: None,
    }
}

#[test]
fn what_a_does_not_hold_is_solved_and_right() {
    let cases = environment("HELD_CASES", CASES);
    let first = environment("HELD_SEED", 1);
    let (mut known, mut converged, mut wrong) = (0, 0, Vec::new());
    let mut defaults = 0;
    for seed in 0..cases {
        let r = &mut Random::new(first.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(seed));
        let of = system(r);
        let blocks = with_rows_of_zeros(r, &of);
        let Some(exact) = reference(&blocks, &blocks.rhs()) else {
            continue;
        };
        let by_default = |blocks: &SaddleBlocks| {
            let solved = Solve::default().solve(&Problem::from(blocks.clone()), &mut Silent);
            solved
                .ok()
                .filter(|solved| solved.outcome == End::Converged)
        };
        known += u64::from(by_default(&of).is_some());
        for name in METHODS {
            let (inner, tolerance) = (r.one_of(&INNER), r.one_of(&TOLERANCES));
            let right = judged(&blocks, &exact, &fixed(name, inner, tolerance));
            converged += u64::from(right.is_some());
            if let Some(Err(text)) = right {
                wrong.push(format!("seed {first}+{seed}, {text}"));
            }
        }
        if let Some(solved) = by_default(&blocks) {
            defaults += 1;
            let [u, t] = errors(&blocks, &solved.x, &exact);
            let most = ALLOWED * Solve::default().tolerance;
            // NaN is wrong, too
            if !(u <= most && t <= most) {
                wrong.push(format!("seed {first}+{seed}, default: {u:.1e} and {t:.1e}"));
            }
        }
    }
    println!(
        "{defaults} converged by default, {known} without such rows; of four other solves each {converged}; {} wrong",
        wrong.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(10 * defaults > 9 * known, "{defaults} of {known} converged");
    assert!(
        converged > 2 * known,
        "too few were solved: {converged} of {known}"
    );
}
