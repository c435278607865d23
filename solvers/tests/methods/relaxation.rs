//! Claim: the relaxation of H is the polynomial that the bounds ask for.

use crate::samples::{random, sparse};
use faer::Mat;
use fracas_operators::sparse::Csr;
use fracas_operators::{Dense, Preconditioner, Properties};
use fracas_solvers::Prepare;
use fracas_solvers::eigen::dense;
use fracas_solvers::saddle::relaxation::{POLYNOMIALS, Polynomial};
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, InnerChoice, REACH, RELAXATION, Racp, RacpInverse,
    Relaxation, SaddleBlocks, SaddleOperator,
};
use fracas_solvers::smoothers::JacobiInverse;

/// A random system with an H of entries beside its diagonal.
fn blocks() -> SaddleBlocks {
    random(12, 5, 0.7, 11)
}

fn racp(relaxation: f64) -> Racp {
    Racp {
        augmentation: AugmentationChoice::LocalH,
        relaxation,
        ..Racp::default()
    }
}

/// M⁻¹, entry by entry.
fn inverse(racp: Racp, blocks: &SaddleBlocks) -> Dense<f64> {
    Dense::of_preconditioner(&racp.prepare(blocks).unwrap())
}

#[test]
fn it_is_w_from_both_sides() {
    let blocks = blocks();
    let (n_u, n) = (blocks.n_u(), blocks.n_u() + blocks.n_t());
    let direct = fracas_solvers::direct::DirectChoice::Faer.solver().unwrap();
    let choice = AugmentationChoice::LocalH;
    let c = choice.compute(&blocks, direct.as_ref()).unwrap().matrix;
    let c = c.diagonal_entries();
    let h = |i: usize, j: usize| blocks.h.as_ref().unwrap().get(i, j).copied().unwrap_or(0.0);
    let gamma = 0.15;
    let w = |i: usize, j: usize| {
        let one = if i == j { 1.0 } else { 0.0 };
        match (i.checked_sub(n_u), j.checked_sub(n_u)) {
            (Some(i), Some(j)) => one - gamma / c[i] * h(i, j),
            _ => one,
        }
    };
    let (plain, relaxed) = (inverse(racp(0.0), &blocks), inverse(racp(gamma), &blocks));
    for i in 0..n {
        for j in 0..n {
            let mut sum = 0.0;
            for k in 0..n {
                for l in 0..n {
                    sum += w(i, k) * plain.entry(k, l) * w(j, l);
                }
            }
            let found = relaxed.entry(i, j);
            assert!((found - sum).abs() < 1e-12 * plain.max_abs(), "{i} {j}");
        }
    }
}

/// p of the degree that [0, x] needs, at x.
fn p_at(x: f64) -> f64 {
    // λ_max is estimated from above, by 5 % for one mode
    value(Polynomial::up_to(1.05 * x), x)
}

/// p(x).
fn value(p: &Polynomial, x: f64) -> f64 {
    let powers = p.coefficients.iter().zip(1..);
    1.0 + powers.map(|(c, k)| c * x.powi(k)).sum::<f64>()
}

#[test]
fn polynomials_are_best_approximations_to_an_inverse_root() {
    for (p, degree) in POLYNOMIALS.iter().zip(1..) {
        assert_eq!(p.degree(), degree);
        let x = |k: i32| p.end * f64::from(k) / 100_000.0;
        let g = |x: f64| x * value(p, x) * value(p, x);
        // x p² rises from zero through 1/2
        let mut touched = vec![0.5];
        for k in 1..=100_000 {
            assert!(value(p, x(k)) > 0.0 && value(p, x(k)) < 1.0);
            assert!(g(x(k)) <= 1.0 + 1e-9, "degree {degree}, x = {}", x(k));
            if x(k) >= 0.63 {
                assert!(g(x(k)) >= 0.5 - 1e-9, "degree {degree}, x = {}", x(k));
            }
            let bound = [0.5, 1.0].into_iter().find(|b| (g(x(k)) - b).abs() < 1e-6);
            if bound.is_some_and(|b| touched.last() != Some(&b)) {
                touched.extend(bound);
            }
        }
        // d + 2 points, one bound and the other in turn
        let expected = (0..degree + 2).map(|k| [0.5, 1.0][k % 2]);
        assert_eq!(touched.len(), degree + 2, "degree {degree}: {touched:?}");
        assert!(touched.iter().copied().eq(expected), "{touched:?}");
    }
    assert_eq!(Polynomial::up_to(4.0).degree(), 1);
    assert_eq!(Polynomial::up_to(4.6).degree(), 2);
    assert_eq!(Polynomial::up_to(1e9).degree(), 4);
}

#[test]
fn modes_that_a_h_and_c_share_have_the_eigenvalues_of_the_formula() {
    // one displacement, one traction: S̃_u exact, A = 1, B = √s
    for (s, h, c, gamma) in [
        (0.3f64, 1.8f64, 1.4f64, 0.2f64),
        (5.0, 0.2, 1.2, 0.2),
        (0.1, 2.0, 1.1, 0.1),
        // degrees two to four
        (0.1, 2.0, 0.2, RELAXATION),
        (0.2, 3.0, 0.15, RELAXATION),
        (0.02, 3.0, 0.1, RELAXATION),
    ] {
        let b = s.sqrt();
        let one = |v: f64| sparse(1, 1, |_, _| v);
        let c_matrix = AugmentationMatrix::from_diagonal(vec![c]).unwrap();
        // 1 × 1: Jacobi is exact
        let s_u = JacobiInverse::new(&one(1.0 + s / c), Default::default()).unwrap();
        let m = RacpInverse::new(one(b), c_matrix, s_u).relaxed(Box::new(Csr::new(one(h))), gamma);
        let m = Dense::of_preconditioner(&m);
        let a = [[1.0, b], [b, -h]];
        let product = |i: usize, j: usize| (0..2).map(|k| m.entry(i, k) * a[k][j]).sum::<f64>();
        let determinant = product(0, 0) * product(1, 1) - product(0, 1) * product(1, 0);
        let q = p_at(gamma / RELAXATION * h / c);
        let expected = [
            q * q * (s + h) / (s + c),
            (c + 2.0 * s * q + h * q * q) / (s + c),
        ];
        assert!((determinant - expected[0]).abs() < 1e-13);
        assert!((product(0, 0) + product(1, 1) - expected[1]).abs() < 1e-13);
    }
}

/// S̃_u⁻¹ = S_u⁻¹/3.
struct Third<M>(M);

impl<M: Preconditioner<f64>> Preconditioner<f64> for Third<M> {
    fn size(&self) -> usize {
        self.0.size()
    }
    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.0.solve(r, z, work);
        z.iter_mut().for_each(|z| *z /= 3.0);
    }
    fn work_len(&self) -> usize {
        self.0.work_len()
    }
    fn flops(&self) -> u64 {
        self.0.flops()
    }
    fn properties(&self) -> Properties {
        self.0.properties()
    }
}

#[test]
fn with_the_chosen_factor_no_real_part_exceeds_beta_u_and_one() {
    let mut beyond = 0;
    // H up to 4 C, and up to 10, 20 and 30 C
    for (seed, times) in (0..20).flat_map(|seed| [4.0, 10.0, 20.0, 30.0].map(|t| (seed, t))) {
        let blocks = random(10, 5, 0.7, seed);
        let h = blocks.h.clone().unwrap();
        // C is no multiple of I, and β_u of 3 S_u is below 2/3
        let shape = [1.0, 2.0, 0.5, 3.0, 0.7];
        let h_of = dense::to_dense(&h);
        let scaled = Mat::from_fn(5, 5, |i, j| h_of[(i, j)] / f64::sqrt(shape[i] * shape[j]));
        let largest = dense::symmetric_eigenvalues(scaled.as_ref()).unwrap()[4];
        let c = shape.map(|c| largest / times * c).to_vec();
        let c = AugmentationMatrix::from_diagonal(c).unwrap();
        let real_parts = |gamma: f64| {
            let s_u = InnerChoice::default().prepare(&blocks, &c).unwrap().inverse;
            let m = RacpInverse::new(blocks.b1.clone(), c.clone(), Third(s_u));
            let m = m.relaxed(Box::new(Csr::new(h.clone())), gamma);
            let matrix = |m: Dense<f64>| Mat::from_fn(15, 15, |i, j| m.entry(i, j));
            let m = matrix(Dense::of_preconditioner(&m));
            let a = matrix(Dense::of_operator(&SaddleOperator::new(&blocks)));
            let values =
                dense::general_eigenvalues(dense::multiply(m.as_ref(), a.as_ref()).as_ref());
            let values = values.unwrap();
            let ends = values.iter().map(|v| v.re);
            ends.fold([f64::INFINITY, 0.0], |[low, high], re| {
                [low.min(re), high.max(re)]
            })
        };
        beyond += usize::from(real_parts(0.0)[1] > 1.5);
        let [low, high] = real_parts(RELAXATION);
        assert!(
            // proved for degree one; beyond it, seen
            low > -1e-9 && high < 1.0 + 1e-9,
            "seed {seed}, {times}: {low} {high}"
        );
    }
    assert!(beyond > 40, "{beyond} of 80 without relaxation");
}

#[test]
fn its_degree_rises_as_c_falls_below_h_until_it_gives_way() {
    let h = || {
        Csr::new(sparse(4, 4, |i, j| {
            if i == j {
                2.0
            } else if i.abs_diff(j) == 1 {
                -1.0
            } else {
                0.0
            }
        }))
    };
    // λ_max(H) = 2 + 2 cos 36° = 3.618
    let of = |gamma, c: f64| {
        let c = AugmentationMatrix::from_diagonal(vec![c; 4]).unwrap();
        Relaxation::new(Box::new(h()), gamma, &c)
    };
    assert!(of(0.0, 1.0).is_none());
    let summary = |gamma, c| of(gamma, c).unwrap().summary();
    let found = summary(0.1, 1.0);
    assert!(
        (found.gamma - 0.1).abs() < 1e-15 && found.degree == 1,
        "{found:?}"
    );
    for (c, degree) in [(1.0, 1), (0.5, 2), (0.2, 3), (0.12, 4)] {
        let found = summary(RELAXATION, c);
        assert_eq!((found.gamma, found.degree), (RELAXATION, degree), "C = {c}");
    }
    let least = 0.01 * REACH * RELAXATION / 3.618;
    let found = summary(0.2, 0.01);
    assert_eq!(found.degree, 4);
    assert!(
        found.gamma > 0.9 * least && found.gamma < 1.0001 * least,
        "{found:?} {least}"
    );
}

#[test]
fn without_h_nothing_is_relaxed_and_nothing_costs() {
    let blocks = random(12, 5, 0.0, 11);
    let (plain, relaxed) = (
        racp(0.0).prepare(&blocks).unwrap(),
        racp(0.2).prepare(&blocks).unwrap(),
    );
    assert_eq!(plain.flops(), relaxed.flops());
    assert_eq!(plain.work_len(), relaxed.work_len());
}

#[test]
fn a_factor_outside_is_refused() {
    for bad in ["-0.1", "1.5", "\"much\""] {
        let text = format!(r#"{{"relaxation": {bad}}}"#);
        assert!(serde_json::from_str::<Racp>(&text).is_err(), "{bad}");
    }
    let error = serde_json::from_str::<Racp>(r#"{"relaxation": 2}"#).unwrap_err();
    assert!(error.to_string().contains("from 0 (none) to 1"), "{error}");
}
