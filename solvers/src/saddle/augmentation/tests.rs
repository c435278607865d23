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
fn empty_columns_get_their_own_h_or_one_and_are_reported() {
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
    // the unit of H is that of C
    let tiny = 1e-12;
    blocks.h = Some(sparse(6, 6, |i, j| if i == j { tiny } else { 0.0 }));
    for choice in [AugmentationChoice::Local, AugmentationChoice::Exact] {
        let c = choice.compute(&blocks, direct.as_ref()).unwrap();
        assert_eq!(c.matrix.diagonal_entries()[4], tiny, "{choice}");
    }
    assert_eq!(blocks.contact_compliance()[4], tiny);
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

/// θ of every row of a C, from C − C_local and the diagonal of H.
fn shares_of_h(blocks: &SaddleBlocks) -> Vec<f64> {
    let [local, fitted] = [AugmentationChoice::Local, AugmentationChoice::FittedH]
        .map(|choice| compute(choice, blocks).unwrap().to_dense());
    let h = blocks.h.as_ref().unwrap();
    let share = |i: usize| (fitted[(i, i)] - local[(i, i)]) / h.get(i, i).unwrap();
    (0..blocks.n_t()).map(share).collect()
}

/// `H_ii = h(i)`.
fn with_diagonal_h(mut blocks: SaddleBlocks, h: impl Fn(usize) -> f64) -> SaddleBlocks {
    let n = blocks.n_t();
    blocks.h = Some(sparse(n, n, |i, j| if i == j { h(i) } else { 0.0 }));
    blocks
}

/// `Σ b_iᵀ diag(A)⁻¹ b_i` over some columns.
fn trace(blocks: &SaddleBlocks, columns: std::ops::Range<usize>) -> f64 {
    let k = |i: usize| -> f64 {
        (0..blocks.n_u())
            .filter_map(|row| Some(blocks.b1.get(row, i)?.powi(2) / blocks.a.get(row, row)?))
            .sum()
    };
    columns.map(k).sum()
}

#[test]
fn as_much_of_h_is_taken_as_h_exceeds_what_a_does_to_jumps() {
    let close = |found: &[f64], theta: f64| found.iter().all(|f| (f / theta - 1.0).abs() < 1e-9);
    // ρ, θ: half of H up to ρ = 16, then 2/√ρ, never less than a fifteenth
    let least = 1.0 / 15.0;
    for (rho, theta) in [
        (2.0, 0.5),
        (16.0, 0.5),
        (100.0, 0.2),
        (900.0, least),
        (1e6, least),
    ] {
        let blocks = random(12, 3, 0.0, 4);
        let k = trace(&blocks, 0..3);
        let shape = [1.0, 2.0, 3.0];
        let of = |blocks| with_diagonal_h(blocks, |i| rho * k * shape[i] / 6.0);
        let found = shares_of_h(&of(blocks.clone()));
        assert!(close(&found, theta), "{rho}: {found:?}");
        // an A that ties no rows of a face to each other: the fracture lies along flat cells
        let mut loose = blocks;
        loose.a = sparse(12, 12, |i, j| match i == j {
            true => *loose.a.get(i, i).unwrap(),
            false => 0.0,
        });
        let found = shares_of_h(&of(loose));
        assert!(close(&found, 0.5), "{rho}: {found:?}");
    }
    // rows that are no faces are judged one by one
    let single = random(12, 5, 0.0, 11);
    let rho = [1.0, 25.0, 100.0, 400.0, 1e12];
    let k: Vec<f64> = (0..5).map(|i| trace(&single, i..i + 1)).collect();
    let found = shares_of_h(&with_diagonal_h(single, |i| rho[i] * k[i]));
    for (found, theta) in found.iter().zip([0.5, 0.4, 0.2, 0.1, least]) {
        assert!((found / theta - 1.0).abs() < 1e-6, "{found} {theta}");
    }
}

#[test]
fn faces_that_h_couples_share_the_verdict_on_their_fracture() {
    // face 0 and face 2 have nodes that A ties to each other, face 1 has none; H couples 0 and 1
    let n_u = 18;
    let b = sparse(n_u, 9, |i, j| {
        let (face, k) = (j / 3, j % 3);
        match i == 6 * face + 2 * k || i == 6 * face + 2 * k + 1 {
            true => 1.0,
            false => 0.0,
        }
    });
    let is_tied = |i: usize| !(6..12).contains(&i);
    let a = sparse(n_u, n_u, |i, j| match (i == j, i / 2 == j / 2) {
        (true, _) => 2.0,
        (_, true) if is_tied(i) => -1.0,
        _ => 0.0,
    });
    let h_of = |coupling: f64| {
        sparse(9, 9, |i, j| match (i == j, i % 3 == j % 3) {
            (true, _) => 100.0,
            (_, true) if i / 3 + j / 3 == 1 => -coupling,
            _ => 0.0,
        })
    };
    let of = |h| {
        let blocks = SaddleBlocks {
            a: a.clone(),
            b1: b.clone(),
            h: Some(h),
            ..random(n_u, 9, 0.0, 1)
        };
        shares_of_h(&blocks)
            .chunks(3)
            .map(|theta| theta[0])
            .collect::<Vec<f64>>()
    };
    // ρ = 100/(2/2): θ = 2/10
    for (found, expected) in [(of(h_of(0.0)), [0.2, 0.5, 0.2]), (of(h_of(50.0)), [0.2; 3])] {
        let error = found.iter().zip(expected).map(|(f, e)| (f - e).abs());
        assert!(error.fold(0.0, f64::max) < 1e-12, "{found:?} {expected:?}");
    }
}

#[test]
fn faces_without_nodes_do_not_spoil_the_share_of_h() {
    for n_t in [6, 5] {
        let mut blocks = random(12, n_t, 0.7, 3);
        let b = blocks.b1.clone();
        // the first face, or the first row
        let empty = if n_t == 6 { 3 } else { 1 };
        blocks.b1 = sparse(12, n_t, |i, j| match j < empty {
            true => 0.0,
            false => b.get(i, j).copied().unwrap_or(0.0),
        });
        let c = compute(AugmentationChoice::FittedH, &blocks).unwrap();
        assert!(
            c.diagonal_entries()
                .iter()
                .all(|c| c.is_finite() && *c > 0.0)
        );
    }
}

/// What A is said to be is what it is; where no traction is left that moves anything, nothing is asked of A.
#[test]
fn a_stiffness_that_has_no_factors_is_called_what_it_is() {
    let reason = |d: [f64; 2]| {
        let blocks = SaddleBlocks {
            a: sparse(2, 2, |i, j| if i == j { d[i] } else { 0.0 }),
            h: None,
            b2: None,
            ..random(2, 1, 0.0, 2)
        };
        compute(AugmentationChoice::Exact, &blocks)
            .unwrap_err()
            .to_string()
    };
    let (indefinite, singular) = (reason([2.0, -0.5]), reason([2.0, 0.0]));
    assert!(indefinite.contains("is indefinite"), "{indefinite}");
    assert!(singular.contains("is singular"), "{singular}");
    let idle = SaddleBlocks {
        a: sparse(2, 2, |i, j| if i == j { -1.0 } else { 0.0 }),
        b1: sparse(2, 1, |_, _| 0.0),
        h: None,
        b2: None,
        ..random(2, 1, 0.0, 2)
    };
    for choice in [AugmentationChoice::Exact, AugmentationChoice::Global] {
        let c = compute(choice, &idle).unwrap();
        assert_eq!(c.diagonal_entries(), [1.0]);
    }
}
