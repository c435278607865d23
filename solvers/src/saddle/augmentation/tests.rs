use super::*;
use crate::direct::DirectChoice;
use crate::eigen::dense;
use crate::saddle::samples::{random, sparse, two_chains};
use faer::Mat;
use fracas_operators::{LinearOperator, Preconditioner};

fn compute(
    choice: AugmentationChoice,
    blocks: &SaddleBlocks,
) -> Result<AugmentationMatrix, SetupError> {
    let direct = DirectChoice::Faer.solver().unwrap();
    choice.compute(blocks, direct.as_ref()).map(|a| a.matrix)
}

#[test]
fn local_is_its_formula_on_a_chain() {
    // Column k of B has −1 and +1 on two uncoupled nodes with stiffness 2 (1 at the free end) and contrast times it.
    let c = compute(AugmentationChoice::Local, &two_chains(6, 3, 10.0, false)).unwrap();
    let expected = [2.0 / 20.0, 2.0 / 20.0, 2.0 / 10.0];
    for (c, e) in c.diagonal_entries().iter().zip(expected) {
        assert!((c - e).abs() < 1e-15);
    }
}

#[test]
fn large_supports_agree_with_small_ones() {
    // The same dense column through Lanczos (n = 300) and through the dense solver.
    let blocks = random(300, 2, 0.0, 9);
    let c = compute(AugmentationChoice::Local, &blocks)
        .unwrap()
        .diagonal_entries();
    let norm = dense::symmetric_eigenvalues(dense::to_dense(&blocks.a).as_ref()).unwrap()[299];
    for k in 0..2 {
        let b: f64 = (0..300).map(|i| blocks.b1.get(i, k).unwrap().powi(2)).sum();
        assert!((c[k] * norm / b - 1.0).abs() < 1e-11);
    }
}

#[test]
fn global_is_the_ratio_of_norms() {
    let blocks = random(30, 8, 0.0, 2);
    let c = compute(AugmentationChoice::Global, &blocks)
        .unwrap()
        .diagonal_entries();
    let a = dense::to_dense(&blocks.a);
    let b = dense::singular_values(dense::to_dense(&blocks.b1).as_ref()).unwrap()[0];
    let gamma = b * b / dense::symmetric_eigenvalues(a.as_ref()).unwrap()[29];
    assert!(c.iter().all(|c| (c / gamma - 1.0).abs() < 1e-11));
    let twice = compute("global_times=2".parse().unwrap(), &blocks)
        .unwrap()
        .diagonal_entries();
    assert!((twice[0] / c[0] - 2.0).abs() < 1e-14);
}

#[test]
fn exact_is_the_schur_complement() {
    for blocks in [random(40, 7, 0.4, 3), two_chains(30, 9, 1e6, false)] {
        let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
        let c = compute(AugmentationChoice::Exact, &blocks)
            .unwrap()
            .to_dense();
        let l = dense::cholesky(dense::to_dense(&blocks.a)).unwrap();
        let mut g = dense::to_dense(&blocks.b1);
        dense::solve_lower(l.as_ref(), &mut g);
        let s = g.transpose() * &g;
        assert!((&c - &s).norm_max() < 1e-11 * s.norm_max(), "{n_u} {n_t}");
        let exact_h = compute(AugmentationChoice::ExactH, &blocks)
            .unwrap()
            .to_dense();
        let h = blocks
            .h
            .as_ref()
            .map_or(Mat::zeros(n_t, n_t), dense::to_dense);
        assert!((exact_h - s - h).norm_max() < 1e-11 * c.norm_max());
    }
}

#[test]
fn a_singular_a_has_no_exact_c_and_says_what_to_take() {
    let blocks = two_chains(20, 5, 1e3, true);
    for choice in [AugmentationChoice::Exact, AugmentationChoice::ExactH] {
        let error = compute(choice, &blocks).unwrap_err();
        assert!(matches!(error, SetupError::NotApplicable { .. }), "{error}");
        assert!(error.to_string().contains("local"));
    }
    for choice in [
        AugmentationChoice::Local,
        AugmentationChoice::Global,
        AugmentationChoice::LocalH,
    ] {
        compute(choice, &blocks).unwrap();
    }
}

#[test]
fn face_blocks_are_schur_complements_of_their_support_and_lie_below_the_exact_ones() {
    let mut blocks = two_chains(12, 6, 50.0, false);
    let h = sparse(6, 6, |i, j| if i == j { 0.3 } else { 0.0 });
    blocks.h = Some(h);
    let c = compute(AugmentationChoice::FaceBlock, &blocks)
        .unwrap()
        .to_dense();
    let exact = compute(AugmentationChoice::ExactH, &blocks)
        .unwrap()
        .to_dense();
    let gap = Mat::from_fn(3, 3, |i, j| exact[(i, j)] - c[(i, j)]);
    assert!(dense::symmetric_eigenvalues(gap.as_ref()).unwrap()[0] > -1e-12);
    assert!(c[(0, 1)] != 0.0 && c[(0, 3)] == 0.0);
    let two = random(10, 4, 0.0, 1);
    assert!(matches!(
        compute(AugmentationChoice::FaceBlock, &two),
        Err(SetupError::NotApplicable { .. })
    ));
}

#[test]
fn local_lies_below_the_diagonal_of_the_schur_complement() {
    for blocks in [random(40, 7, 0.0, 3), two_chains(12, 6, 50.0, false)] {
        let c = compute(AugmentationChoice::Local, &blocks)
            .unwrap()
            .diagonal_entries();
        let s = compute(AugmentationChoice::Exact, &blocks)
            .unwrap()
            .to_dense();
        for (i, c) in c.iter().enumerate() {
            assert!(*c > 0.0 && *c <= s[(i, i)] * (1.0 + 1e-12), "row {i}");
        }
    }
}

#[test]
fn every_c_scales_like_b_squared_over_a() {
    let (alpha, beta) = (3.7e9, 2.3e-2);
    let blocks = random(24, 6, 0.0, 12);
    let mut scaled = blocks.clone();
    scaled.a.data_mut().iter_mut().for_each(|v| *v *= alpha);
    scaled.b1.data_mut().iter_mut().for_each(|v| *v *= beta);
    for choice in AugmentationChoice::ALL {
        let (c, d) = (
            compute(choice, &blocks).unwrap(),
            compute(choice, &scaled).unwrap(),
        );
        let factor = beta * beta / alpha;
        let difference = d.to_dense() - c.to_dense() * faer::Scale(factor);
        assert!(
            difference.norm_max() < 1e-11 * factor * c.to_dense().norm_max(),
            "{choice}"
        );
    }
}

#[test]
fn empty_columns_get_one_and_are_reported() {
    let mut blocks = random(12, 6, 0.0, 4);
    blocks.b1 = sparse(12, 6, |i, j| {
        if j == 4 {
            0.0
        } else {
            *blocks.b1.get(i, j).unwrap()
        }
    });
    let direct = DirectChoice::Faer.solver().unwrap();
    for choice in AugmentationChoice::ALL {
        let c = choice.compute(&blocks, direct.as_ref()).unwrap();
        assert_eq!(c.empty_columns, [4]);
        // C = γI has no exception
        if !matches!(choice, AugmentationChoice::Global) {
            assert_eq!(c.matrix.diagonal_entries()[4], 1.0, "{choice}");
        }
    }
}

#[test]
fn an_indefinite_h_leaves_c_positive_definite() {
    // Slip and open rows: H_ii = −area, and the slip block is unsymmetric.
    let mut blocks = random(12, 6, 0.0, 4);
    blocks.h = Some(sparse(6, 6, |i, j| {
        if i == j {
            -2.0
        } else if i == j + 1 {
            0.5
        } else {
            0.0
        }
    }));
    let local = compute(AugmentationChoice::Local, &blocks)
        .unwrap()
        .diagonal_entries();
    let local_h = compute(AugmentationChoice::LocalH, &blocks)
        .unwrap()
        .diagonal_entries();
    assert!(local.iter().zip(&local_h).all(|(l, h)| *h == l + 2.0));
    compute(AugmentationChoice::FaceBlock, &blocks).unwrap();
}

#[test]
fn dependent_columns_are_named_by_row() {
    let mut blocks = random(12, 3, 0.0, 4);
    blocks.b1 = sparse(12, 3, |i, j| *blocks.b1.get(i, j.min(1)).unwrap());
    let error = compute(AugmentationChoice::Exact, &blocks).unwrap_err();
    assert!(
        matches!(
            error,
            SetupError::NotPositiveDefinite {
                block: "C",
                row: 3,
                ..
            }
        ),
        "{error}"
    );
    compute(AugmentationChoice::FaceBlock, &blocks).unwrap();
}

#[test]
fn nan_is_found_with_its_place() {
    let mut blocks = random(5, 2, 0.0, 4);
    blocks.b1.data_mut()[3] = f64::NAN;
    let error = compute(AugmentationChoice::Local, &blocks).unwrap_err();
    assert!(matches!(
        error,
        SetupError::NotFinite {
            block: "B1",
            row: 2,
            column: 2,
            ..
        }
    ));
}

#[test]
fn names_round_trip() {
    for choice in AugmentationChoice::ALL {
        assert_eq!(choice.to_string().parse(), Ok(choice));
        let json = serde_json::to_string(&choice).unwrap();
        assert_eq!(json, format!("\"{choice}\""));
    }
    assert!("locale".parse::<AugmentationChoice>().is_err());
}

#[test]
fn another_unit_of_tractions_scales_c_and_its_inverse() {
    let blocks = random(12, 6, 0.4, 5);
    for choice in AugmentationChoice::ALL {
        let (c, four) = (
            compute(choice, &blocks).unwrap(),
            compute(choice, &blocks).unwrap().scaled(4.0),
        );
        let r: Vec<f64> = fracas_operators::laws::probe(6, 3);
        let (mut x, mut y, mut z) = (vec![0.0; 6], vec![0.0; 6], vec![0.0; 6]);
        c.solve(&r, &mut x, &mut []);
        four.solve(&r, &mut y, &mut []);
        four.apply(&y, &mut z, &mut []);
        for i in 0..6 {
            assert_eq!(x[i], 4.0 * y[i], "{choice}");
            assert!((z[i] - r[i]).abs() < 1e-9, "{choice}");
        }
    }
}

#[test]
fn a_last_digit_between_the_triangles_of_h_does_not_cost_its_coupling() {
    let mut blocks = random(12, 6, 0.4, 5);
    let h = |skew: f64| {
        let rows = [
            [2.0, 0.5 + skew, 0.25],
            [0.5, 3.0, -0.75],
            [0.25, -0.75, 4.0],
        ];
        let mut h = fracas_operators::sparse::Triplets::new((6, 6));
        for (i, row) in rows.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                h.add_triplet(i, j, *v);
                h.add_triplet(3 + i, 3 + j, *v);
            }
        }
        Some(h.to_csr())
    };
    let mut of = |skew: f64| {
        blocks.h = h(skew);
        compute(AugmentationChoice::FaceBlock, &blocks)
            .unwrap()
            .to_dense()
    };
    let (plain, rounded, slip) = (of(0.0), of(1e-15), of(0.1));
    assert!((&rounded - &plain).norm_max() < 1e-14);
    assert!(
        (slip[(0, 1)] - plain[(0, 1)]).abs() > 0.4,
        "an unsymmetric H gives its diagonal"
    );
}

#[test]
fn as_much_of_h_is_taken_as_h_exceeds_what_a_does_to_jumps() {
    // b_iᵀ diag(A)⁻¹ b_i of the inner columns: 2·(1/2)·(1 + 1/10) = 1.1 with contrast 10
    let mut blocks = two_chains(8, 3, 10.0, false);
    let local = compute(AugmentationChoice::Local, &blocks).unwrap();
    let stiff = |i: usize| -> f64 {
        (0..blocks.n_u())
            .filter_map(|row| Some(blocks.b1.get(row, i)?.powi(2) / blocks.a.get(row, row)?))
            .sum()
    };
    let trace: f64 = (0..3).map(stiff).sum();
    // ρ, θ: half of H up to ρ = 16, then 2/√ρ, never less than a fifteenth
    for (rho, theta) in [
        (2.0, 0.5),
        (16.0, 0.5),
        (100.0, 0.2),
        (900.0, 1.0 / 15.0),
        (1e6, 1.0 / 15.0),
    ] {
        let shape = [1.0, 2.0, 3.0];
        let h_ii = |i: usize| rho * trace * shape[i] / 6.0;
        let h = sparse(3, 3, |i, j| if i == j { h_ii(i) } else { 0.0 });
        blocks.h = Some(h);
        let c = compute(AugmentationChoice::FittedH, &blocks).unwrap();
        for (i, c) in c.diagonal_entries().into_iter().enumerate() {
            let expected = local.diagonal_entries()[i] + theta * h_ii(i);
            assert!(
                (c / expected - 1.0).abs() < 1e-12,
                "{rho} {i}: {c} {expected}"
            );
        }
    }
    // rows that are no faces are judged one by one
    let mut single = random(12, 5, 0.7, 11);
    let h = sparse(5, 5, |i, j| {
        if i == j {
            [0.0, 1e-3, 1.0, 1e6, 1e12][i]
        } else {
            0.0
        }
    });
    single.h = Some(h);
    let [none, fitted] = [AugmentationChoice::Local, AugmentationChoice::FittedH]
        .map(|choice| compute(choice, &single).unwrap().diagonal_entries());
    assert_eq!(fitted[0], none[0]);
    assert!(((fitted[4] - none[4]) / (1e12 / 15.0) - 1.0).abs() < 1e-9);
    assert!((fitted[1] - none[1] - 5e-4).abs() < 1e-12);
}
