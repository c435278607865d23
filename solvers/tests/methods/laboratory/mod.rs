//! Claim: spectra, their bounds and what they say of a system are those of the general solver.

mod bounds;
mod indefinite;

use crate::samples::{random, sparse, trusses, two_chains};
use faer::Mat;
use fracas_operators::{LinearOperator, Preconditioner, Properties};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::eigen::dense;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, InnerChoice, RacpInverse, SaddleBlocks, SaddleOperator,
    schur,
};
use fracas_solvers::smoothers::{Jacobi, Ssor};
use fracas_solvers::spectrum::bounds::Ingredients;
use fracas_solvers::spectrum::report::{Eigenvalues, Method};
use fracas_solvers::spectrum::{
    Bounds, ModeTarget, SpectrumReport, SpectrumRequest, Theorem, Verdict, analyse, analyse_around,
};
use fracas_solvers::{SetupError, Silent};

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
    // scales in which u and t have the same unit
    let s = schur::primal_schur(&blocks.a, &blocks.b1, &c).unwrap();
    let of_u = (0..s.rows()).map(|i| s.get(i, i).copied().unwrap_or(0.0));
    let scales: Vec<f64> = of_u.chain(c.diagonal_entries()).map(f64::sqrt).collect();
    let racp = RacpInverse::new(blocks.b1.clone(), c, s_u);
    let (saddle, n) = (SaddleOperator::new(blocks), scales.len());
    let (mut work, mut inner_work) = (vec![0.0; saddle.work_len()], vec![0.0; racp.work_len()]);
    let columns = (0..n).flat_map(|j| {
        let (mut x, mut y, mut z) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        x[j] = 1.0;
        saddle.apply(&x, &mut y, &mut work);
        racp.solve(&y, &mut z, &mut inner_work);
        z
    });
    let dense: Vec<f64> = columns.collect();
    let scaled = Mat::from_fn(n, n, |i, j| scales[i] * dense[n * j + i] / scales[j]);
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
