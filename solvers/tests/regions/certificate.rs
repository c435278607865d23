//! Claim: the local certificate lies below the inf-sup constant of random systems, A singular or not, and not far below.
//!
//! `REGIONS_FAMILY=10000 REGIONS_SEED=1 cargo test --release -p fracas-solvers --test regions certificate -- --nocapture` tries that many.

use super::{FEW, of_environment, random, scaled, solved, sparse};
use faer::Mat;
use fracas_operators::random::Random;
use fracas_solvers::eigen::dense;
use fracas_solvers::saddle::SaddleBlocks;
use fracas_solvers::spectrum::certificate;

/// What is added to a singular A, in units of its diagonal: S is then smaller by no more than this times ω.
const REGULAR: f64 = 1e-6;

/// Blocks of a random system, and `λ_min(C₀⁻¹(S + H))`, S = BᵀA⁻¹B, by its definition, with what rounding makes of it at most.
fn case(seed: u64) -> (SaddleBlocks, f64, f64) {
    let dice = &mut Random::new(seed);
    let (n_u, n_t) = (3 + dice.below(12), 1 + dice.below(6));
    let rank = if dice.once_in(3) { n_u - 1 } else { n_u + 2 };
    let r = random(dice, n_u, rank);
    // rows in scales of their own
    let scales: Vec<f64> = (0..n_u).map(|_| dice.scale(1e-3, 1e3)).collect();
    let r = Mat::from_fn(n_u, rank, |i, k| scales[i] * r[(i, k)]);
    let a = &r * r.transpose();
    let b = random(dice, n_u, n_t);
    let b = Mat::from_fn(n_u, n_t, |i, k| scales[i] * b[(i, k)]);
    let rank = 1 + dice.below(n_t);
    let q = random(dice, n_t, rank);
    let h = &q * q.transpose() * dice.scale(1e-3, 30.0);
    let has_h = !dice.once_in(3);
    let c_0: Vec<f64> = (0..n_t)
        .map(|k| (0..n_u).map(|i| b[(i, k)].powi(2) / a[(i, i)]).sum())
        .collect();
    let mut regular = a.clone();
    (0..n_u).for_each(|i| regular[(i, i)] *= 1.0 + REGULAR);
    let half = solved(&dense::cholesky(regular).unwrap(), &b);
    let mut sum = half.transpose() * &half;
    if has_h {
        sum += &h;
    }
    let root = Mat::from_fn(n_t, n_t, |i, j| if i == j { c_0[i].sqrt() } else { 0.0 });
    let values = dense::symmetric_eigenvalues(scaled(&root, &sum).as_ref()).unwrap();
    // of an eigenvalue solver that is backward stable, some n_t units of the largest
    let rounding = 10.0 * n_t as f64 * f64::EPSILON * values[n_t - 1];
    let blocks = SaddleBlocks {
        a: sparse(n_u, n_u, |i, j| a[(i, j)]),
        b1: sparse(n_u, n_t, |i, j| b[(i, j)]),
        b2: None,
        h: has_h.then(|| sparse(n_t, n_t, |i, j| h[(i, j)])),
        rhs_u: vec![0.0; n_u],
        rhs_t: vec![0.0; n_t],
        coordinates: None,
        flow: None,
    };
    (blocks, values[0], rounding)
}

#[test]
fn the_certificate_lies_below_the_inf_sup_constant_of_random_systems() {
    let count = of_environment("REGIONS_FAMILY", FEW);
    let first = of_environment("REGIONS_SEED", 0) * 1_000_000;
    let mut shares: Vec<f64> = Vec::new();
    for seed in first..first + count {
        let (blocks, beta, rounding) = case(seed);
        // S of a singular A is large, and what is left below its rounding is not known here
        if beta < 1e3 * rounding {
            continue;
        }
        let found = certificate(&blocks).unwrap().unwrap();
        // what is added to A, and the eigenvalues of the bound
        let slack = 2.0 * (REGULAR + 1e-10) * beta + rounding;
        assert!(
            found.beta_squared <= beta + slack,
            "seed {seed}: {found:?} is not below {beta}"
        );
        shares.push(found.beta_squared / beta);
    }
    shares.sort_by(f64::total_cmp);
    let positive = shares.iter().filter(|share| **share > 0.0).count();
    println!(
        "{count} systems, {} judged, {positive} with a positive certificate; bound over truth: median {:.3}, largest {:.3}",
        shares.len(),
        shares[shares.len() / 2],
        shares[shares.len() - 1]
    );
    // a bound of zero would be none, and one much too small would be no use
    assert!(shares.len() as u64 > 9 * count / 10);
    assert!(positive as u64 > count / 2 && shares[shares.len() - 1] > 0.5);
}

#[test]
fn half_of_omega_would_break_it() {
    let broken = (0..FEW).filter(|seed| {
        let (blocks, beta, rounding) = case(*seed);
        let found = certificate(&blocks).unwrap().unwrap();
        blocks.h.is_none()
            && beta > 1e3 * rounding
            && 2.0 * found.beta_squared > beta * (1.0 + 1e-3)
    });
    assert!(broken.count() > 0);
}
