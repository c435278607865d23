mod indefinite;

use super::*;
use crate::Silent;
use crate::direct::DirectChoice;
use crate::saddle::samples::{random, sparse, trusses, two_chains};
use crate::saddle::schur;
use crate::smoothers::{Jacobi, Ssor};
use crate::spectrum::bounds::Ingredients;
use crate::spectrum::similarity::Similarity;
use crate::spectrum::{Bounds, Theorem, Verdict};
use faer::Mat;
use fracas_operators::Dense;
use fracas_operators::Properties;

fn request(augmentation: AugmentationChoice, inner: &str) -> SpectrumRequest {
    SpectrumRequest {
        augmentation,
        inner: inner.parse().unwrap(),
        ..SpectrumRequest::default()
    }
}

fn run(blocks: &SaddleBlocks, augmentation: AugmentationChoice, inner: &str) -> SpectrumReport {
    analyse(blocks, &request(augmentation, inner), &mut Silent).unwrap()
}

/// Eigenvalues of M⁻¹𝒜 column by column, by the general solver.
fn oracle(blocks: &SaddleBlocks, augmentation: AugmentationChoice, inner: &str) -> Eigenvalues {
    let direct = DirectChoice::Faer.solver().unwrap();
    let c = augmentation
        .compute(blocks, direct.as_ref())
        .unwrap()
        .matrix;
    let inner: InnerChoice = inner.parse().unwrap();
    let s_u = inner.prepare(blocks, &c).unwrap().inverse;
    let scales = energy_scales(blocks, &c.diagonal_entries());
    let racp = RacpInverse::new(blocks.b1.clone(), c, s_u);
    let dense = Dense::of_operator(&Preconditioned::new(blocks, &racp));
    let n = scales.len();
    let scaled = Mat::from_fn(n, n, |i, j| scales[i] * dense.entry(i, j) / scales[j]);
    Eigenvalues::sorted(dense::general_eigenvalues(scaled.as_ref()).unwrap())
}

/// Largest distance of an eigenvalue of one list to the nearest of the other.
fn distance(a: &Eigenvalues, b: &Eigenvalues) -> f64 {
    let one_way = |a: &Eigenvalues, b: &Eigenvalues| {
        a.iter()
            .map(|p| {
                b.iter()
                    .map(|q| (p.0 - q.0).hypot(p.1 - q.1))
                    .fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
    };
    assert_eq!(a.re.len(), b.re.len());
    one_way(a, b).max(one_way(b, a))
}

#[test]
fn theorem_1_holds_with_exact_multiplicities() {
    for blocks in [
        random(30, 9, 0.0, 1),
        random(50, 20, 0.0, 2),
        two_chains(20, 6, 1.0, false),
        two_chains(20, 6, 1e6, false),
    ] {
        let report = run(&blocks, AugmentationChoice::Exact, "exact");
        assert_eq!(
            (report.n_at_one, report.n_at_half),
            (report.n_u, report.n_t)
        );
        assert_eq!((report.n_complex, report.contained), (0, Some(true)));
        // The general solver, which knows nothing of the structure, agrees.
        let check = oracle(&blocks, AugmentationChoice::Exact, "exact");
        assert!(distance(&check, &report.eigenvalues) < 1e-7);
    }
}

#[test]
fn the_reduced_spectrum_is_that_of_the_general_solver() {
    for (h, seed) in [(0.0, 5), (0.6, 6), (40.0, 7)] {
        let blocks = random(26, 8, h, seed);
        for choice in [
            AugmentationChoice::Local,
            AugmentationChoice::LocalH,
            AugmentationChoice::Global,
            AugmentationChoice::ExactH,
        ] {
            let report = run(&blocks, choice, "exact");
            let check = oracle(&blocks, choice, "exact");
            let size = report.re_max.unwrap();
            assert!(
                distance(&check, &report.eigenvalues) < 1e-7 * size.max(1.0),
                "{choice} {h}"
            );
            let (low, high) = report.exact_S_u_interval.unwrap();
            assert!(
                report.real_min.unwrap() >= low - 1e-10
                    && report.real_max.unwrap() <= high * (1.0 + 1e-10)
            );
        }
    }
    // A floating block: A is singular, the statement about exact S_u still holds.
    let blocks = two_chains(15, 5, 1e3, true);
    let report = run(&blocks, AugmentationChoice::Local, "exact");
    let check = oracle(&blocks, AugmentationChoice::Local, "exact");
    assert!(distance(&check, &report.eigenvalues) < 1e-7);
    assert_eq!((report.cond_A, report.kernel_A), (None, Some(1)));
}

#[test]
fn with_c_equal_to_h_all_eigenvalues_are_one_and_general_c_gives_the_pencil() {
    let mut blocks = random(20, 6, 0.0, 3);
    let diagonal = |i: usize| 0.3 + 0.1 * i as f64;
    blocks.h = Some(sparse(6, 6, |i, j| if i == j { diagonal(i) } else { 0.0 }));
    let c = AugmentationMatrix::from_diagonal((0..6).map(diagonal).collect()).unwrap();
    let coupling = Coupling::dense(&blocks, &c, true).unwrap();
    assert!(
        coupling
            .eigenvalues()
            .unwrap()
            .iter()
            .all(|v| (v - 1.0).norm() < 1e-12)
    );

    // eig(S+H, S+C) by Cholesky of S+C, S = BᵀA⁻¹B.
    let direct = DirectChoice::Faer.solver().unwrap();
    let c = AugmentationChoice::Local
        .compute(&blocks, direct.as_ref())
        .unwrap()
        .matrix;
    let s = AugmentationChoice::Exact
        .compute(&blocks, direct.as_ref())
        .unwrap()
        .matrix
        .to_dense();
    let l = dense::cholesky(&s + c.to_dense()).unwrap();
    let mut k = &s + dense::to_dense(blocks.h.as_ref().unwrap());
    dense::solve_lower(l.as_ref(), &mut k);
    let mut k = k.transpose().to_owned();
    dense::solve_lower(l.as_ref(), &mut k);
    dense::symmetrize(&mut k);
    let pencil = dense::symmetric_eigenvalues(k.as_ref()).unwrap();
    let inverse = schur::exact_inverse(&blocks, &c, direct.as_ref()).unwrap();
    for coupling in [
        Coupling::dense(&blocks, &c, true).unwrap(),
        Coupling::sparse(&blocks, &c, true, inverse.as_ref()).unwrap(),
    ] {
        for (a, b) in coupling.eigenvalues().unwrap().iter().zip(&pencil) {
            assert!((a - b).norm() < 1e-11);
        }
    }
}

/// S̃_u of different quality: damped Jacobi and SSOR.
fn inner_of(seed: u64) -> InnerChoice {
    let omega = 0.15 + 1.7 * (seed % 97) as f64 / 97.0;
    if seed.is_multiple_of(2) {
        InnerChoice::Jacobi(Jacobi {
            omega,
            ..Jacobi::default()
        })
    } else {
        InnerChoice::Ssor(Ssor { omega })
    }
}

#[test]
fn bounds_and_disc_hold_on_800_random_systems() {
    let (mut with_complex, mut printed_fails) = (0, 0);
    for seed in 0..800 {
        let n_u = 4 + (seed % 7) as usize;
        let n_t = 1 + (seed % 5) as usize;
        let h = if seed % 3 == 0 {
            0.0
        } else {
            0.05 * (seed % 41) as f64
        };
        let mut blocks = random(n_u, n_t, h, 31 + seed);
        if seed % 4 == 0 {
            // A singular: its last unknown floats.
            blocks.a = sparse(n_u, n_u, |i, j| {
                if i.max(j) + 1 == n_u {
                    0.0
                } else {
                    *blocks.a.get(i, j).unwrap()
                }
            });
        }
        let request = SpectrumRequest {
            augmentation: if seed % 5 == 0 {
                AugmentationChoice::Global
            } else {
                AugmentationChoice::LocalH
            },
            inner: inner_of(seed),
            ..SpectrumRequest::default()
        };
        let report = analyse(&blocks, &request, &mut Silent).unwrap();
        let theorem = if blocks.h.is_some() {
            Theorem::WithH
        } else {
            Theorem::WithoutH
        };
        assert_eq!(report.bounds.theorem, theorem);
        assert_eq!(
            report.contained,
            Some(true),
            "seed {seed}: {:?}",
            report.outside
        );
        with_complex += usize::from(report.n_complex > 0);
        printed_fails += usize::from(!report.printed.unwrap().outside.is_empty());
    }
    // The sample is not trivial.
    assert!(with_complex > 200, "{with_complex}");
    assert!(printed_fails > 50, "{printed_fails}");
}

#[test]
fn the_printed_complex_bound_fails_for_h_not_zero() {
    // A = B = C = 1, S_u = 2, S̃_u = 4, H = ½: T = [5/8 1/4; −1/4 1/2], λ = 9/16 ± i√15/16, printed Re λ = K/2 = 3/8.
    let one = || sparse(1, 1, |_, _| 1.0);
    let mut blocks = random(1, 1, 0.0, 1);
    (blocks.a, blocks.b1, blocks.h) = (one(), one(), Some(sparse(1, 1, |_, _| 0.5)));
    let request = SpectrumRequest {
        augmentation: AugmentationChoice::Global,
        inner: InnerChoice::Jacobi(Jacobi {
            omega: 0.5,
            ..Jacobi::default()
        }),
        ..SpectrumRequest::default()
    };
    let report = analyse(&blocks, &request, &mut Silent).unwrap();
    for (re, im) in report.eigenvalues.iter() {
        assert!((re - 9.0 / 16.0).abs() < 1e-14);
        assert!((im.abs() - 15f64.sqrt() / 16.0).abs() < 1e-14);
    }
    let printed = report.printed.unwrap();
    assert!(!printed.applies);
    assert_eq!(printed.outside.len(), 2);
    assert!(
        printed
            .outside
            .iter()
            .all(|o| o.verdict == Verdict::RealPart)
    );
    assert_eq!(printed.bounds.re_high, Some(0.375));
    assert_eq!(report.contained, Some(true));
}

#[test]
fn when_beta_u_is_below_twice_alpha_t_no_real_eigenvalue_lies_below_alpha_u() {
    // One spring: K = k̃, G = g; λ² − kλ + g² = 0 has no real root when k < 2g.
    let ingredients = Ingredients {
        k: (0.5, 0.9),
        g: (0.6, 0.7),
        h_hat: (0.0, 0.0),
        k_h: (0.5, 0.9),
        coupling: 0.7,
        sigma: (0.5, 0.9),
        h: (0.0, 0.0),
    };
    let bounds = Bounds::printed(&ingredients);
    assert_eq!(bounds.real_low, Some(0.5));
    let narrow = Ingredients {
        g: (0.1, 0.7),
        ..ingredients
    };
    let expected = 2.0 * 0.01 / (0.9 + (0.81f64 - 0.04).sqrt());
    assert!((Bounds::printed(&narrow).real_low.unwrap() - expected).abs() < 1e-15);
    let real = Ingredients {
        g: (0.1, 0.2),
        ..ingredients
    };
    assert_eq!(Bounds::printed(&real).im_max, Some(0.0));
}

/// `f M⁻¹`.
struct Scaled<'a>(f64, &'a dyn Preconditioner<f64>);

impl Preconditioner<f64> for Scaled<'_> {
    fn size(&self) -> usize {
        self.1.size()
    }
    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.1.solve(r, z, work);
        z.iter_mut().for_each(|z| *z *= self.0);
    }
    fn work_len(&self) -> usize {
        self.1.work_len()
    }
    fn flops(&self) -> u64 {
        self.1.flops() + self.size() as u64
    }
    fn properties(&self) -> Properties {
        self.1.properties()
    }
}

#[test]
fn when_alpha_u_is_at_least_two_the_spectrum_is_real() {
    // H = 0: a non-real λ has |λ|² ≤ Re λ = k/2 and hence k < 2.
    let direct = DirectChoice::Faer.solver().unwrap();
    let mut non_real_below = 0;
    for seed in 0..60 {
        let blocks = random(
            6 + seed as usize % 5,
            1 + seed as usize % 4,
            0.0,
            400 + seed,
        );
        let c = AugmentationChoice::Local
            .compute(&blocks, direct.as_ref())
            .unwrap()
            .matrix;
        let choice = inner_of(seed);
        let inner = choice.prepare(&blocks, &c).unwrap().inverse;
        let scaled = |factor: f64| {
            let inner = Scaled(factor, inner.as_ref());
            let similarity = Similarity::new(&blocks, &c, choice, &inner).unwrap();
            let values = dense::general_eigenvalues(similarity.matrix().as_ref()).unwrap();
            let non_real = values
                .iter()
                .any(|v| super::super::region::is_non_real(v.re, v.im));
            (
                similarity
                    .form(&|_| 1.0)
                    .unwrap()
                    .statements()
                    .unwrap()
                    .ingredients
                    .k
                    .0,
                non_real,
            )
        };
        let (alpha_u, _) = scaled(1.0);
        let (two, non_real) = scaled(2.0 / alpha_u);
        assert!((two - 2.0).abs() < 1e-9 && !non_real, "seed {seed}");
        non_real_below += usize::from(scaled(0.5 / alpha_u).1);
    }
    // Not so below: the threshold separates.
    assert!(non_real_below > 30, "{non_real_below}");
}

#[test]
fn conditions_survive_contrast() {
    // Chains of n springs held at one end: κ₂ = known eigenvalues times the contrast.
    for contrast in [1.0, 1e3, 1e6] {
        let n = 40;
        let blocks = two_chains(n, 6, contrast, false);
        let report = run(&blocks, AugmentationChoice::Local, "exact");
        let exact = |k: usize| {
            2.0 - 2.0 * ((2 * k - 1) as f64 * std::f64::consts::PI / (2 * n + 1) as f64).cos()
        };
        let expected = contrast * exact(n) / exact(1);
        assert!(
            (report.cond_A.unwrap() / expected - 1.0).abs() < 1e-8,
            "{contrast}: {:?}",
            report.cond_A
        );
        assert!(report.cond_A_error.unwrap() < 1e-8);
    }
}

#[test]
fn rank_deficient_b_gives_a_zero_and_no_failure() {
    let mut blocks = random(20, 6, 0.0, 9);
    blocks.b1 = sparse(20, 6, |i, j| *blocks.b1.get(i, j.min(4)).unwrap());
    let report = run(&blocks, AugmentationChoice::Local, "exact");
    assert!(report.real_min.unwrap().abs() < 1e-13);
    assert!(report.bounds.alpha_t.unwrap() < 1e-12);
    let error = analyse(
        &blocks,
        &request(AugmentationChoice::Exact, "exact"),
        &mut Silent,
    )
    .unwrap_err();
    assert!(matches!(
        error,
        SetupError::NotPositiveDefinite { block: "C", .. }
    ));
}

#[test]
fn a_floating_block_of_trusses_has_six_rigid_modes() {
    let blocks = trusses(4, 1e3, true);
    for choice in [
        AugmentationChoice::Local,
        AugmentationChoice::FaceBlock,
        AugmentationChoice::Global,
    ] {
        let report = run(&blocks, choice, "exact");
        assert_eq!((report.kernel_A, report.cond_A), (Some(6), None));
        assert_eq!(report.contained, Some(true));
        // G has singular value 1 for every rigid-body mode.
        assert!(report.n_at_one >= report.n_u + 6);
    }
    let error = analyse(
        &blocks,
        &request(AugmentationChoice::Exact, "exact"),
        &mut Silent,
    )
    .unwrap_err();
    assert!(matches!(error, SetupError::NotApplicable { .. }));
}

#[test]
fn a_slip_jacobian_gets_its_field_of_values() {
    let mut blocks = random(14, 6, 0.0, 4);
    let b1 = blocks.b1.clone();
    blocks.b2 = Some(sparse(6, 14, |i, j| {
        if i == 2 {
            0.3 * b1.get(j, 0).unwrap()
        } else {
            *b1.get(j, i).unwrap()
        }
    }));
    blocks.h = Some(sparse(
        6,
        6,
        |i, j| if i == 2 && j == 2 { -1.0 } else { 0.0 },
    ));
    for inner in ["exact", "jacobi"] {
        let report = run(&blocks, AugmentationChoice::LocalH, inner);
        assert_eq!(
            (report.bounds.theorem, report.contained),
            (Theorem::None, None)
        );
        let check = oracle(&blocks, AugmentationChoice::LocalH, inner);
        assert!(distance(&check, &report.eigenvalues) < 1e-8);
        let w = report.field_of_values.unwrap();
        for (re, im) in report.eigenvalues.iter() {
            for (theta, h) in w.angles.iter().zip(&w.support) {
                assert!(re * theta.cos() + im * theta.sin() <= h + 1e-9);
            }
        }
    }
    // B2 given, but equal to B1ᵀ: the theorem applies.
    blocks.b2 = Some(b1.transpose_view().to_csr());
    blocks.h = None;
    assert_eq!(
        run(&blocks, AugmentationChoice::Local, "jacobi")
            .bounds
            .theorem,
        Theorem::WithoutH
    );
}

#[test]
fn modes_satisfy_their_equation() {
    let targets = vec![
        ModeTarget::Smallest,
        ModeTarget::Largest,
        ModeTarget::Closest(0.5),
    ];
    for (h, inner) in [
        (0.0, "exact"),
        (0.8, "exact"),
        (0.8, "jacobi"),
        (0.0, "ssor"),
    ] {
        let blocks = random(18, 6, h, 11);
        let request = SpectrumRequest {
            modes: targets.clone(),
            ..request(AugmentationChoice::LocalH, inner)
        };
        let report = analyse(&blocks, &request, &mut Silent).unwrap();
        assert_eq!(report.modes.len(), 3);
        for mode in &report.modes {
            assert!(mode.residual < 1e-10, "{inner} {h}: {mode:?}");
            assert_eq!((mode.u.len(), mode.t.len()), (18, 6));
            assert!((0.0..=1.0).contains(&mode.traction_share), "{mode:?}");
        }
    }
}

#[test]
fn iterative_bounds_and_outer_eigenvalues_agree_with_dense_ones() {
    for (h, inner) in [
        (0.0, "exact"),
        (0.5, "exact"),
        (0.5, "jacobi"),
        (0.0, "ssor"),
    ] {
        let blocks = random(60, 12, h, 21);
        let full = run(&blocks, AugmentationChoice::LocalH, inner);
        let limited = SpectrumRequest {
            dense_limit: 0,
            ..request(AugmentationChoice::LocalH, inner)
        };
        let outer = analyse(&blocks, &limited, &mut Silent).unwrap();
        assert_eq!(outer.method, Method::Iterative);
        assert_eq!(outer.contained, Some(true));
        for (a, b) in [
            (full.bounds.alpha_u, outer.bounds.alpha_u),
            (full.bounds.beta_u, outer.bounds.beta_u),
            (full.bounds.alpha_t, outer.bounds.alpha_t),
            (full.bounds.beta_t, outer.bounds.beta_t),
            (full.delta, outer.delta),
            (full.Delta, outer.Delta),
            (full.eta, outer.eta),
        ] {
            let (a, b) = (a.unwrap(), b.unwrap());
            assert!(
                (a - b).abs() < 1e-6 * a.abs().max(1e-3),
                "{inner} {h}: {a} {b}"
            );
        }
        // what products alone prove is no more than what dense matrices do
        for (inside, outside) in [
            (full.bounds.im_max, outer.bounds.im_max),
            (full.bounds.real_high, outer.bounds.real_high),
            (outer.bounds.real_low, full.bounds.real_low),
        ] {
            let (inside, outside) = (inside.unwrap(), outside.unwrap());
            assert!(inside < outside + 1e-6, "{inner} {h}: {inside} {outside}");
        }
        assert!((full.re_max.unwrap() - outer.re_max.unwrap()).abs() < 1e-6);
        assert!((full.re_min.unwrap() - outer.re_min.unwrap()).abs() < 1e-6);
    }
}

#[test]
fn the_json_has_the_keys_that_other_tools_read() {
    let report = run(
        &two_chains(8, 3, 10.0, true),
        AugmentationChoice::Local,
        "exact",
    );
    let json = serde_json::to_value(&report).unwrap();
    for key in [
        "n_u",
        "n_t",
        "augmentation",
        "inner",
        "c_min",
        "c_max",
        "cond_A",
        "cond_S_u",
        "eigenvalues",
        "real_min",
        "real_max",
        "re_min",
        "re_max",
        "im_max",
        "n_complex",
        "n_at_one",
        "n_at_half",
        "bounds",
        "contained",
    ] {
        assert!(json.get(key).is_some(), "{key}");
    }
    for key in [
        "theorem",
        "alpha_u",
        "beta_u",
        "alpha_t",
        "beta_t",
        "real_low",
        "real_high",
        "re_low",
        "re_high",
        "im_max",
    ] {
        assert!(json["bounds"].get(key).is_some(), "{key}");
    }
    assert!(json["cond_A"].is_null());
    assert_eq!(json["bounds"]["theorem"], "H=0");
    assert_eq!(json["method"], "dense");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let blocks = random(150, 70, 0.4, 3);
    let bits = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let report = pool.install(|| run(&blocks, AugmentationChoice::ExactH, "jacobi"));
        let numbers: Vec<u64> = report
            .eigenvalues
            .iter()
            .flat_map(|(a, b)| [a.to_bits(), b.to_bits()])
            .collect();
        (numbers, report.cond_S_u.map(f64::to_bits))
    });
    assert!(bits.iter().all(|b| *b == bits[0]));
}

#[test]
fn more_tractions_than_displacements_and_none_at_all() {
    let wide = random(6, 9, 0.5, 3);
    for inner in ["exact", "jacobi"] {
        let report = run(&wide, AugmentationChoice::LocalH, inner);
        assert_eq!(
            (report.bounds.alpha_t, report.contained),
            (Some(0.0), Some(true))
        );
        let check = oracle(&wide, AugmentationChoice::LocalH, inner);
        assert!(distance(&check, &report.eigenvalues) < 1e-7);
    }
    let none = random(7, 0, 0.0, 3);
    for inner in ["exact", "jacobi"] {
        let report = run(&none, AugmentationChoice::Local, inner);
        assert_eq!((report.eigenvalues.re.len(), report.n_complex), (7, 0));
    }
}

#[test]
fn nothing_but_shapes_and_nan_stops_an_analysis_of_imported_blocks() {
    // An unsymmetric A: no theorem, all eigenvalues.
    let mut blocks = random(10, 3, 0.0, 3);
    *blocks.a.get_mut(0, 1).unwrap() += 0.05;
    let report = run(&blocks, AugmentationChoice::Local, "jacobi");
    assert_eq!(
        (report.bounds.theorem, report.eigenvalues.re.len()),
        (Theorem::None, 13)
    );
    let check = oracle(&blocks, AugmentationChoice::Local, "jacobi");
    assert!(distance(&check, &report.eigenvalues) < 1e-9);
    blocks.h = Some(sparse(4, 4, |_, _| 1.0));
    let error = analyse(
        &blocks,
        &request(AugmentationChoice::Local, "exact"),
        &mut Silent,
    )
    .unwrap_err();
    assert!(matches!(error, SetupError::Shape { block: "H", .. }));
}

#[test]
fn without_conditions_nothing_else_changes() {
    let blocks = random(26, 8, 0.6, 6);
    for inner in ["exact", "ssor"] {
        let full = run(&blocks, AugmentationChoice::LocalH, inner);
        assert!(full.cond_A.is_some() && full.cond_S_u.is_some());
        let request = SpectrumRequest {
            conditions: false,
            ..request(AugmentationChoice::LocalH, inner)
        };
        let report = analyse(&blocks, &request, &mut Silent).unwrap();
        assert_eq!((report.cond_A, report.cond_S_u), (None, None));
        assert_eq!(report.eigenvalues, full.eigenvalues);
        assert_eq!(report.bounds, full.bounds);
    }
}
