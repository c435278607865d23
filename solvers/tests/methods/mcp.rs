//! Claim: MCP is the product of its formula, and fails where the theory says.

use crate::oracle::{
    DenseInverse, Full, assert_spectrum, inverse, operator, real_eigenvalues, spectrum, stacked,
    unsymmetric,
};
use crate::samples::{random, trusses, two_chains};
use faer::Mat;
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::{Counted, Preconditioner};
use fracas_solvers::SetupError;
use fracas_solvers::fsai::Fsai;
use fracas_solvers::saddle::{
    Cost, Mcp, McpInverse, SaddleMethod, SaddleOperator, SaddleSettings, published_gamma,
};

/// A + γBBᵀ and H + T, T = BᵀPB, dense.
fn parts(full: &Full, gamma: f64) -> (Mat<f64>, Mat<f64>, Mat<f64>) {
    let b = &full.b1;
    let bt = b.transpose().to_owned();
    let a_gamma = &full.a + faer::Scale(gamma) * (b * &bt);
    let t = &bt * (inverse(&a_gamma) * b);
    let s = &full.h + &t;
    (a_gamma, t, s)
}

#[test]
fn exact_parts_invert_the_augmented_constraint_matrix() {
    for (blocks, gamma) in [
        (random(13, 5, 0.0, 3), 0.8),
        (random(13, 5, 0.6, 4), 0.8),
        (random(13, 5, 0.6, 5), 0.0),
        (unsymmetric(random(13, 5, 0.6, 6)), 0.3),
    ] {
        let full = Full::new(&blocks);
        let (a_gamma, _, s) = parts(&full, gamma);
        let m = McpInverse::new(
            blocks.b1.clone(),
            gamma,
            DenseInverse::of(&a_gamma),
            DenseInverse::of(&s),
        );
        // M = E⁻¹ [A_γ B; Bᵀ −H], E = [I γB; 0 I]
        let (n_u, n_t) = (13, 5);
        let e = stacked(
            &Mat::identity(n_u, n_u),
            &(faer::Scale(-gamma) * &full.b1),
            &Mat::zeros(n_t, n_u),
            &Mat::identity(n_t, n_t),
        );
        let b_t = full.b1.transpose().to_owned();
        let constraint = stacked(&a_gamma, &full.b1, &b_t, &(faer::Scale(-1.0) * &full.h));
        let matrix = operator(&(e * constraint));
        check_preconditioner("mcp", &m, Some(&matrix), 1e-9).unwrap();
    }
}

#[test]
fn exact_parts_have_the_stated_spectrum() {
    for (h, gamma) in [(0.0, 0.8), (0.7, 0.0), (0.7, 0.8)] {
        let blocks = random(12, 5, h, 9);
        let full = Full::new(&blocks);
        let (a_gamma, t, s) = parts(&full, gamma);
        let m = McpInverse::new(
            blocks.b1.clone(),
            gamma,
            DenseInverse::of(&a_gamma),
            DenseInverse::of(&s),
        );
        // I − γ T(T + H)⁻¹H
        let sum = &t * (inverse(&s) * &full.h);
        let others = Mat::<f64>::identity(5, 5) - faer::Scale(gamma) * sum;
        let mut expected = vec![1.0; 12];
        expected.extend(real_eigenvalues(&others));
        let h_max = real_eigenvalues(&full.h).into_iter().fold(0.0, f64::max);
        let low = 1.0 / (1.0 + gamma * h_max);
        assert!(expected.iter().all(|v| *v > low - 1e-9 && *v < 1.0 + 1e-9));
        // ones come in Jordan blocks of size 2: the square root of rounding
        assert_spectrum(&spectrum(&m, &blocks).unwrap(), expected, 1e-5);
    }
}

#[test]
fn a_dense_factor_makes_the_approximate_schur_complement_exact() {
    // With a full G the published S is H + Bᵀ A_γ⁻¹ B and G₂₂ inverts it.
    for blocks in [random(12, 5, 0.0, 21), random(12, 5, 0.5, 22)] {
        let settings = Mcp {
            schur: Fsai::adaptive(40, 1, 0.0),
            gamma_factor: 0.5 / published_gamma(&blocks).unwrap(),
            ..Mcp::default()
        };
        let m = settings.ready(&blocks).unwrap().inverse;
        let full = Full::new(&blocks);
        let (a_gamma, _, s) = parts(&full, 0.5);
        let oracle = McpInverse::new(
            blocks.b1.clone(),
            0.5,
            DenseInverse::of(&a_gamma),
            DenseInverse::of(&s),
        );
        let r: Vec<f64> = probe(17, 4);
        let (mut z, mut y) = (vec![0.0; 17], vec![0.0; 17]);
        m.solve(&r, &mut z, &mut vec![f64::NAN; m.work_len()]);
        oracle.solve(&r, &mut y, &mut vec![f64::NAN; oracle.work_len()]);
        let largest = y.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(
            z.iter()
                .zip(&y)
                .all(|(z, y)| (z - y).abs() < 1e-8 * largest)
        );
    }
}

#[test]
fn gamma_is_the_published_ratio() {
    let blocks = random(11, 4, 0.0, 31);
    let full = Full::new(&blocks);
    let largest = real_eigenvalues(&full.a).into_iter().fold(0.0, f64::max);
    let b_b = &full.b1 * full.b1.transpose();
    let mean = (0..11).map(|i| b_b[(i, i)].ln()).sum::<f64>() / 11.0;
    let expected = largest / mean.exp();
    assert!((published_gamma(&blocks).unwrap() - expected).abs() < 1e-9 * expected);
}

#[test]
fn a_floating_block_needs_the_augmentation() {
    let blocks = two_chains(8, 3, 1.0, true);
    let plain = Mcp {
        gamma_factor: 0.0,
        ..Mcp::default()
    };
    let error = plain.ready(&blocks).err().unwrap();
    assert!(
        matches!(&error, SetupError::NotApplicable { method: "mcp with γ = 0", reason } if reason.contains("take γ > 0")),
        "{error}"
    );
    let m = Mcp::default().ready(&blocks).unwrap().inverse;
    check_preconditioner("mcp", &m, None, 0.0).unwrap();
    let negative = Mcp {
        gamma_factor: -1.0,
        ..Mcp::default()
    };
    assert!(negative.ready(&blocks).is_err());
}

#[test]
fn an_empty_column_of_b_without_h_is_named() {
    let mut blocks = trusses(2, 1.0, false);
    let b = crate::oracle::full(&blocks.b1);
    blocks.b1 = crate::samples::sparse(48, 12, |i, j| if j == 4 { 0.0 } else { b[(i, j)] });
    let error = Mcp::default().ready(&blocks).err().unwrap();
    assert!(
        matches!(
            error,
            SetupError::BadDiagonal {
                block: "S = H + (GB)ᵀ(GB)",
                row: 5,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn the_flops_are_those_of_the_parts_as_often_as_they_run() {
    let blocks = trusses(3, 10.0, false);
    let nnz = blocks.b1.nnz() as u64;
    for (gamma, products) in [(0.0, 2), (2.0, 3)] {
        let p = Counted::new(
            fracas_solvers::smoothers::JacobiInverse::new(&blocks.a, Default::default()).unwrap(),
        );
        let s = Counted::new(fracas_operators::Identity { n: blocks.n_t() });
        let m = McpInverse::new(blocks.b1.clone(), gamma, &p, &s);
        let n = m.size();
        m.solve(
            &vec![1.0; n],
            &mut vec![0.0; n],
            &mut vec![0.0; m.work_len()],
        );
        let rows = blocks.n_u() as u64;
        let counted = p.applications() * Preconditioner::<f64>::flops(p.inner())
            + s.applications() * Preconditioner::<f64>::flops(s.inner())
            + products * 2 * (nnz + rows);
        assert_eq!(m.flops(), counted);
        let cost = Cost::new(&SaddleOperator::new(&blocks), &m);
        assert_eq!(cost.application_flops, counted);
    }
    assert_eq!(SaddleMethod::Mcp(Mcp::default()).name(), "mcp");
}
