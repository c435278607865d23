//! Claim: RACP is the inverse that its formula says, and counts its operations.

use crate::samples::{random, two_chains};
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{BlockOperator, Counted, Dense, Preconditioner, Shape};
use fracas_solvers::Prepare;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, Cost, InnerChoice, Racp, RacpInverse, SaddleBlocks, T,
    U,
};

fn settings(augmentation: AugmentationChoice) -> Racp {
    Racp {
        augmentation,
        relaxation: 0.0,
        ..Racp::default()
    }
}

/// `[A B; Bᵀ −C]` dense.
fn augmented(blocks: &SaddleBlocks, c: &AugmentationMatrix) -> Dense<f64> {
    let n_u = blocks.n_u();
    let entry = |m: &SparseMatrix<f64>, i: usize, j: usize| m.get(i, j).copied().unwrap_or(0.0);
    let c = c.to_dense();
    Dense::from_fn(Shape::square(n_u + blocks.n_t()), |i, j| {
        match (i < n_u, j < n_u) {
            (true, true) => entry(&blocks.a, i, j),
            (true, false) => entry(&blocks.b1, i, j - n_u),
            (false, true) => entry(&blocks.b1, j, i - n_u),
            (false, false) => -c[(i - n_u, j - n_u)],
        }
    })
}

#[test]
fn exact_parts_invert_the_augmented_matrix_for_every_c() {
    for (blocks, choices) in [
        (random(14, 6, 0.0, 3), &AugmentationChoice::ALL[..]),
        (random(14, 6, 0.7, 4), &AugmentationChoice::ALL[..]),
        (
            two_chains(9, 3, 1e3, true),
            &[AugmentationChoice::Local, AugmentationChoice::FaceBlock][..],
        ),
    ] {
        for &choice in choices {
            let direct = DirectChoice::Faer.solver().unwrap();
            let c = choice.compute(&blocks, direct.as_ref()).unwrap().matrix;
            let m = settings(choice).prepare(&blocks).unwrap();
            let matrix = augmented(&blocks, &c);
            check_preconditioner(choice.name(), &m, Some(&matrix), 1e-9).unwrap();
        }
    }
}

#[test]
fn every_inner_solver_obeys_the_laws() {
    let blocks = random(15, 6, 0.5, 8);
    for name in ["exact", "jacobi", "ssor"] {
        let inner: InnerChoice = name.parse().unwrap();
        let m = Racp {
            inner,
            ..Racp::default()
        }
        .prepare(&blocks)
        .unwrap();
        check_preconditioner(name, &m, None, 1e-9).unwrap();
    }
    assert!("amgg".parse::<InnerChoice>().is_err());
}

#[test]
fn the_three_factors_are_the_formula() {
    // y_u = S̃⁻¹(x_u + B C⁻¹ x_t), y_t = C⁻¹(Bᵀ y_u − x_t) with dense loops and S̃ = diag(S_u).
    let blocks = random(7, 3, 0.0, 5);
    let c: Vec<f64> = vec![0.5, 2.0, 3.0];
    let matrix = AugmentationMatrix::from_diagonal(c.clone()).unwrap();
    let s_u = fracas_solvers::saddle::schur::primal_schur(&blocks.a, &blocks.b1, &matrix).unwrap();
    let inner = fracas_solvers::smoothers::JacobiInverse::new(&s_u, Default::default()).unwrap();
    let inner = Counted::new(inner);
    let m = RacpInverse::new(blocks.b1.clone(), matrix, &inner);
    let b = |i: usize, k: usize| *blocks.b1.get(i, k).unwrap();
    let x: Vec<f64> = probe(10, 2);
    let mut y = vec![f64::NAN; 10];
    m.solve(&x, &mut y, &mut vec![f64::NAN; m.work_len()]);
    let y_u: Vec<f64> = (0..7)
        .map(|i| {
            let s_ii =
                blocks.a.get(i, i).unwrap() + (0..3).map(|k| b(i, k).powi(2) / c[k]).sum::<f64>();
            (x[i] + (0..3).map(|k| b(i, k) * x[7 + k] / c[k]).sum::<f64>()) / s_ii
        })
        .collect();
    for i in 0..7 {
        assert!((y[i] - y_u[i]).abs() < 1e-13 * (1.0 + y_u[i].abs()));
    }
    for k in 0..3 {
        let y_t = ((0..7).map(|i| b(i, k) * y_u[i]).sum::<f64>() - x[7 + k]) / c[k];
        assert!((y[7 + k] - y_t).abs() < 1e-12 * (1.0 + y_t.abs()));
    }
    assert_eq!(inner.applications(), 1);
}

#[test]
fn its_cost_is_counted_in_products_with_the_saddle_point() {
    let blocks = random(12, 6, 0.0, 6);
    let c = AugmentationMatrix::from_diagonal(vec![1.0; 6]).unwrap();
    let m = RacpInverse::new(blocks.b1.clone(), c, fracas_operators::Identity { n: 12 });
    let (a, b) = (Csr::new(blocks.a.clone()), Csr::new(blocks.b1.clone()));
    let b2 = Csr::new(blocks.b1.transpose_view().to_csr());
    let saddle = BlockOperator::new(blocks.layout())
        .with([U, U], 1.0, &a)
        .with([U, T], 1.0, &b)
        .with([T, U], 1.0, &b2);
    let expected =
        (2 * 6 + 2 * 2 * (72 + 12)) as f64 / (2 * (144 + 12) + 2 * (72 + 12) + 2 * (72 + 6)) as f64;
    assert!((Cost::new(&saddle, &m).c_app() - expected).abs() < 1e-14);
}

#[test]
fn settings_are_read_by_name_or_in_full() {
    let read = |json: &str| serde_json::from_str::<Racp>(json);
    let ssor = |omega: f64| InnerChoice::Ssor(fracas_solvers::smoothers::Ssor { omega });
    assert_eq!(read("{}").unwrap(), Racp::default());
    let named = read(r#"{"augmentation": "face_block", "inner": "ssor"}"#).unwrap();
    assert_eq!(
        (named.augmentation, named.inner),
        (AugmentationChoice::FaceBlock, ssor(1.0))
    );
    assert_eq!(
        read(r#"{"inner": {"ssor": {"omega": 1.25}}}"#)
            .unwrap()
            .inner,
        ssor(1.25)
    );
    assert!(
        read(r#"{"inner": "ssorr"}"#)
            .unwrap_err()
            .to_string()
            .contains("expected exact")
    );
    for inner in ["exact", "jacobi", "ssor"] {
        let racp = Racp {
            inner: inner.parse().unwrap(),
            ..Racp::default()
        };
        assert_eq!(read(&serde_json::to_string(&racp).unwrap()).unwrap(), racp);
    }
}
