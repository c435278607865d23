//! Systems of any code: A definite, singular and indefinite, H of either sign, B of any rank.

use super::*;
use faer::Mat;
use faer::linalg::solvers::{FullPivLu, Solve};
use fracas_operators::Dense;
use fracas_operators::random::Random;
use fracas_solvers::Silent;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, SaddleBlocks};

/// What a seeded system is like.
struct Sample {
    blocks: SaddleBlocks,
    choice: AugmentationChoice,
    inner: InnerChoice,
    /// λ_min(A) relative to λ_max(|A|): by construction.
    lowest: f64,
}

/// `Σ λ_k q_k q_kᵀ` with random orthonormal q_k, to the last bit symmetric.
fn with_eigenvalues(values: &[f64], random: &mut Random) -> Mat<f64> {
    let n = values.len();
    let mut gram = Mat::from_fn(n, n, |_, _| random.between(-1.0, 1.0));
    gram = &gram + gram.transpose();
    let (_, q) = dense::symmetric_eigen(gram.as_ref()).unwrap();
    let mut a = Mat::from_fn(n, n, |i, j| {
        (0..n).map(|k| values[k] * q[(i, k)] * q[(j, k)]).sum()
    });
    dense::symmetrize(&mut a);
    a
}

fn sample(seed: u64) -> Sample {
    let mut random = Random::new(seed);
    let (n_u, n_t) = (2 + random.below(7), 1 + random.below(5));
    let positive = |random: &mut Random| 10f64.powf(random.between(-2.0, 1.0));
    let mut values: Vec<f64> = (0..n_u).map(|_| positive(&mut random)).collect();
    match random.below(4) {
        0 => {}
        1 => values[0] = 0.0,
        2 => values[0] = -10f64.powf(random.between(-7.0, 0.5)),
        _ => values.iter_mut().take(2).for_each(|v| *v = -*v),
    }
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min) / largest;
    let a = with_eigenvalues(&values, &mut random);
    let is_deficient = random.once_in(3);
    let b = Mat::from_fn(n_u, n_t, |_, _| random.between(-2.0, 2.0));
    let h: Option<Vec<f64>> = match random.below(4) {
        0 => None,
        1 => Some((0..n_t).map(|_| random.between(0.0, 8.0)).collect()),
        2 => Some((0..n_t).map(|k| if k == 0 { 5.0 } else { 0.0 }).collect()),
        _ => Some((0..n_t).map(|_| random.between(-3.0, 6.0)).collect()),
    };
    let h = h.map(|values| with_eigenvalues(&values, &mut random));
    let choices = [
        AugmentationChoice::Local,
        AugmentationChoice::LocalH,
        AugmentationChoice::Global,
        AugmentationChoice::GlobalTimes(10f64.powf(random.between(-2.0, 1.0))),
        AugmentationChoice::HalfH,
    ];
    let choice = choices[random.below(choices.len())];
    let inner = ["exact", "exact", "jacobi", "ssor"][random.below(4)];
    Sample {
        blocks: SaddleBlocks {
            a: sparse(n_u, n_u, |i, j| a[(i, j)]),
            b1: sparse(n_u, n_t, |i, k| b[(i, if is_deficient { 0 } else { k })]),
            b2: None,
            h: h.map(|h| sparse(n_t, n_t, |k, l| h[(k, l)])),
            rhs_u: vec![0.0; n_u],
            rhs_t: vec![0.0; n_t],
            coordinates: None,
            flow: None,
        },
        choice,
        inner: inner.parse().unwrap(),
        lowest,
    }
}

/// Eigenvalues of `M⁻¹𝒜` from both matrices in full: `M = [S̃_u − BC⁻¹Bᵀ, B; Bᵀ, −C]`, which is `[A B; Bᵀ −C]` for exact S_u.
/// Nothing of the laboratory is used. `None` where M is singular to working precision.
fn brute_force(sample: &Sample) -> Option<Eigenvalues> {
    let Sample {
        blocks,
        choice,
        inner,
        ..
    } = sample;
    let direct = DirectChoice::Faer.solver().unwrap();
    let c = choice
        .compute(blocks, direct.as_ref())
        .unwrap()
        .matrix
        .to_dense();
    let (a, b) = (dense::to_dense(&blocks.a), dense::to_dense(&blocks.b1));
    let (n_u, n_t) = (b.nrows(), b.ncols());
    let bt = b.transpose().to_owned();
    let augmentation = &b * FullPivLu::new(c.as_ref()).solve(&bt);
    let s_u = &a + &augmentation;
    let approximation = match inner {
        InnerChoice::Exact { .. } => s_u,
        _ => {
            let c = choice.compute(blocks, direct.as_ref()).unwrap().matrix;
            let columns =
                Dense::of_preconditioner(inner.prepare(blocks, &c).unwrap().inverse.as_ref());
            let inverse = Mat::from_fn(n_u, n_u, |i, j| columns.entry(i, j));
            FullPivLu::new(inverse.as_ref()).solve(&Mat::<f64>::identity(n_u, n_u))
        }
    };
    let h = blocks.h.as_ref().map(dense::to_dense);
    let n = n_u + n_t;
    let whole = |corner: &Mat<f64>, last: &dyn Fn(usize, usize) -> f64| {
        Mat::from_fn(n, n, |i, j| match (i < n_u, j < n_u) {
            (true, true) => corner[(i, j)],
            (true, false) => b[(i, j - n_u)],
            (false, true) => b[(j, i - n_u)],
            (false, false) => -last(i - n_u, j - n_u),
        })
    };
    let saddle = whole(&a, &|k, l| h.as_ref().map_or(0.0, |h| h[(k, l)]));
    let m = whole(&(approximation - augmentation), &|k, l| c[(k, l)]);
    let singular = dense::singular_values(m.as_ref()).unwrap();
    if singular[n - 1] < 1e-6 * singular[0] {
        return None;
    }
    let product = FullPivLu::new(m.as_ref()).solve(&saddle);
    Some(Eigenvalues::sorted(
        dense::general_eigenvalues(product.as_ref()).unwrap(),
    ))
}

/// What a sweep has met.
#[derive(Debug, Default)]
struct Met {
    compared: usize,
    indefinite: usize,
    indefinite_with_h: usize,
    complex: usize,
    refused: usize,
}

/// Compares and judges the systems of these seeds.
fn sweep(seeds: std::ops::Range<u64>) -> Met {
    let mut met = Met::default();
    for seed in seeds {
        let sample = sample(seed);
        let request = SpectrumRequest {
            augmentation: sample.choice,
            inner: sample.inner,
            ..SpectrumRequest::default()
        };
        let is_indefinite = sample.lowest < -1e-9;
        let report = match analyse(&sample.blocks, &request, &mut Silent) {
            Ok(report) => report,
            Err(error) => {
                // S_u of an indefinite A may have no Cholesky factorization and no positive diagonal
                assert!(is_indefinite, "seed {seed}: {error}");
                assert!(
                    error.to_string().contains("A is indefinite"),
                    "seed {seed}: {error}"
                );
                met.refused += 1;
                continue;
            }
        };
        let case = format!("seed {seed}, C = {}, inner {}", sample.choice, sample.inner);
        let a_holds = report
            .hypotheses
            .iter()
            .find(|h| h.statement == "A ⪰ 0")
            .unwrap()
            .holds;
        assert_eq!(
            a_holds,
            Some(!is_indefinite),
            "{case}: λ_min {:e}",
            sample.lowest
        );
        assert_eq!(report.outside, [], "{case}: {}", report.verdict);
        let s_u_holds = report
            .hypotheses
            .iter()
            .all(|h| h.statement != "S̃_u ≻ 0" || h.holds == Some(true));
        if is_indefinite || !s_u_holds {
            let b = report.bounds;
            assert_eq!(
                (b.theorem, report.contained),
                (Theorem::None, None),
                "{case}"
            );
            assert_eq!(
                (b.real_low, b.re_high, b.im_max),
                (None, None, None),
                "{case}"
            );
            assert_eq!(report.exact_S_u_interval, None, "{case}");
            assert!(
                report.verdict.starts_with("hypothesis fails: "),
                "{case}: {}",
                report.verdict
            );
        } else {
            assert_eq!(report.contained, Some(true), "{case}");
        }
        if is_indefinite {
            assert!(
                report.verdict.contains("A is indefinite (λ_min"),
                "{case}: {}",
                report.verdict
            );
        }
        let Some(expected) = brute_force(&sample) else {
            continue;
        };
        let size = expected
            .iter()
            .fold(1.0f64, |m, (re, im)| m.max(re.hypot(im)));
        let off = distance(&expected, &report.eigenvalues);
        assert!(off < 1e-4 * size, "{case}: off by {off:e} of {size:e}");
        let trace = |values: &Eigenvalues| values.re.iter().sum::<f64>();
        let off = (trace(&expected) - trace(&report.eigenvalues)).abs();
        assert!(off < 1e-7 * size, "{case}: the sums differ by {off:e}");
        met.compared += 1;
        met.indefinite += usize::from(is_indefinite);
        met.indefinite_with_h += usize::from(is_indefinite && sample.blocks.h.is_some());
        met.complex += usize::from(report.n_complex > 0);
    }
    met
}

#[test]
fn printed_eigenvalues_are_those_of_both_matrices_in_full_and_no_verdict_is_false() {
    let met = sweep(0..400);
    // the sample is not trivial
    assert!(met.compared > 200 && met.indefinite > 25, "{met:?}");
    assert!(
        met.indefinite_with_h > 15 && met.complex > 20 && met.refused > 20,
        "{met:?}"
    );
}

#[test]
#[ignore = "a minute: cargo test --release -p fracas-solvers --test methods -- --ignored indefinite"]
fn the_same_on_20000_systems() {
    let met = sweep(1000..21_000);
    assert!(met.compared > 14_000, "{met:?}");
}

/// A = diag(2, −½), B = (1 1)ᵀ, C = 1.
fn two_springs(h: Option<f64>) -> SaddleBlocks {
    SaddleBlocks {
        a: sparse(2, 2, |i, j| if i == j { [2.0, -0.5][i] } else { 0.0 }),
        b1: sparse(2, 1, |_, _| 1.0),
        h: h.map(|h| sparse(1, 1, |_, _| h)),
        ..random(2, 1, 0.0, 1)
    }
}

#[test]
fn two_springs_of_either_sign() {
    // S_u = [3 1; 1 ½], GᵀG = 3, λ = 1 − (1 − H)(1 − 3) = 3 − 2H
    for (h, expected) in [(Some(5.0), -7.0), (None, 3.0), (Some(1.0), 1.0)] {
        let blocks = two_springs(h);
        // γ = ‖B‖²/‖A‖ = 1
        let report = run(&blocks, AugmentationChoice::Global, "exact");
        let mut sorted = [1.0, 1.0, expected];
        sorted.sort_by(f64::total_cmp);
        for (found, expected) in report.eigenvalues.re.iter().zip(sorted) {
            assert!(
                (found - expected).abs() < 1e-9,
                "{h:?}: {:?}",
                report.eigenvalues
            );
        }
        assert_eq!((report.contained, report.exact_S_u_interval), (None, None));
        assert!(
            report.verdict.contains("A is indefinite (λ_min ≤ -5.0e-1"),
            "{}",
            report.verdict
        );
    }
}

#[test]
fn the_spectrum_can_be_complex_where_a_and_c_minus_h_are_indefinite() {
    // C = I, W = diag(−½, ½), I − H = [0 2; 2 0]: λ = 1 ± i
    let diagonal = |values: [f64; 2]| sparse(2, 2, |i, j| if i == j { values[i] } else { 0.0 });
    let blocks = SaddleBlocks {
        a: diagonal([-1.0 / 3.0, 1.0]),
        b1: diagonal([1.0, 1.0]),
        h: Some(sparse(2, 2, |i, j| if i == j { 1.0 } else { -2.0 })),
        ..random(2, 2, 0.0, 1)
    };
    let request = SpectrumRequest {
        modes: vec![ModeTarget::Largest],
        ..request(AugmentationChoice::Global, "exact")
    };
    let report = analyse(&blocks, &request, &mut Silent).unwrap();
    let expected = [(1.0, -1.0), (1.0, 0.0), (1.0, 0.0), (1.0, 1.0)];
    let expected = Eigenvalues {
        re: expected.map(|v| v.0).to_vec(),
        im: expected.map(|v| v.1).to_vec(),
    };
    assert!(distance(&expected, &report.eigenvalues) < 1e-12);
    assert_eq!((report.n_complex, report.n_at_one), (2, 2));
    assert!(report.modes[0].eigenvalue.1 != 0.0 && report.modes[0].residual < 1e-12);
}

#[test]
fn modes_of_indefinite_systems_satisfy_their_equation() {
    let mut modes = 0;
    for seed in 0..600 {
        let sample = sample(seed);
        let request = SpectrumRequest {
            augmentation: sample.choice,
            modes: vec![ModeTarget::Smallest, ModeTarget::Largest],
            ..SpectrumRequest::default()
        };
        let Ok(report) = analyse(&sample.blocks, &request, &mut Silent) else {
            continue;
        };
        for mode in &report.modes {
            let (re, im) = mode.eigenvalue;
            // u = (…)/(λ − 1)
            let amplified = 1e-9 * re.hypot(im).max(1.0) / (re - 1.0).hypot(im).min(1.0);
            assert!(
                mode.residual < amplified.max(1e-7),
                "seed {seed}: {:?} {:e}",
                mode.eigenvalue,
                mode.residual
            );
            modes += 1;
        }
    }
    assert!(modes > 400, "{modes}");
}
