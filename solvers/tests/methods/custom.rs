//! Claim: a C of any kind serves like one in full.

use crate::samples::{random, sparse};
use fracas_operators::laws::{check_operator, check_preconditioner, probe};
use fracas_operators::random::Random;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Dense, LinearOperator, Preconditioner, Properties, Shape};
use fracas_solvers::registry::Named;
use fracas_solvers::saddle::augmentation::AugmentationRule;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, CustomAugmentation, InnerChoice, Racp, SaddleBlocks,
};
use fracas_solvers::{Prepare, SetupError, direct::DirectSolver};
use std::sync::Arc;

/// Tridiagonal, symmetric, positive definite, over six decades.
fn tridiagonal(n: usize, seed: u64) -> SparseMatrix<f64> {
    let r = &mut Random::new(seed);
    let scale: Vec<f64> = (0..n).map(|_| 10f64.powf(r.between(-3.0, 3.0))).collect();
    let off: Vec<f64> = (0..n).map(|_| r.between(-0.49, 0.49)).collect();
    sparse(n, n, |i, j| {
        let share = match i.abs_diff(j) {
            0 => 1.0,
            1 => off[i.min(j)],
            _ => 0.0,
        };
        share * (scale[i] * scale[j]).sqrt()
    })
}

fn dense(c: &AugmentationMatrix) -> Dense<f64> {
    let full = c.to_dense();
    Dense::from_fn(Shape::square(c.size()), |i, j| full[(i, j)])
}

#[test]
fn a_sparse_c_is_the_dense_one_with_the_same_entries() {
    for seed in 0..40 {
        let entries = tridiagonal(3 + (seed % 11) as usize, seed);
        let full = fracas_solvers::eigen::dense::to_dense(&entries);
        let mut c = AugmentationMatrix::from_sparse(entries).unwrap();
        let mut oracle = AugmentationMatrix::from_dense(full).unwrap();
        if seed % 2 == 1 {
            (c, oracle) = (c.scaled(7.0), oracle.scaled(7.0));
        }
        check_operator("C", &c, Some(&dense(&oracle))).unwrap();
        check_preconditioner("C", &c, Some(&dense(&oracle)), 1e-8).unwrap();
        assert_eq!(c.diagonal_entries(), oracle.diagonal_entries());
        let ends = (c.extremes().unwrap(), oracle.extremes().unwrap());
        assert!((ends.0.1 / ends.1.1 - 1.0).abs() < 1e-12, "seed {seed}");
        // C F Fᵀ x = x
        let root = c.inverse_root().unwrap();
        let x: Vec<f64> = probe(c.size(), seed);
        let image = &root.transpose_view().to_csr() * &sprs_vector(&x);
        let image = &root * &image;
        let z: Vec<f64> = image.iter().map(|(v, _)| *v).collect();
        let mut y = vec![0.0; x.len()];
        let mut work = vec![0.0; LinearOperator::work_len(&c)];
        c.apply(&z, &mut y, &mut work);
        let far = x
            .iter()
            .zip(&y)
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, f64::max);
        assert!(far < 1e-8, "seed {seed}: {far:e}");
    }
}

/// A column.
fn sprs_vector(x: &[f64]) -> SparseMatrix<f64> {
    sparse(x.len(), 1, |i, _| x[i])
}

/// Tridiagonal whatever the blocks.
#[derive(Debug)]
struct Chain;

impl Named for Chain {
    fn name(&self) -> &'static str {
        "chain_of_tests"
    }
}

impl AugmentationRule for Chain {
    fn is_local(&self) -> bool {
        false
    }

    fn compute(
        &self,
        blocks: &SaddleBlocks,
        _: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError> {
        AugmentationMatrix::from_sparse(tridiagonal(blocks.n_t(), 5))
    }
}

#[test]
fn racp_around_it_inverts_the_augmented_matrix_and_is_known_by_its_name() {
    let chain = AugmentationChoice::register(&Chain).unwrap();
    assert_eq!("chain_of_tests".parse(), Ok(chain));
    let json = serde_json::to_string(&chain).unwrap();
    assert_eq!(json, "\"chain_of_tests\"");
    assert_eq!(
        serde_json::from_str::<AugmentationChoice>(&json).unwrap(),
        chain
    );
    let unknown = "chain".parse::<AugmentationChoice>().unwrap_err();
    let said = unknown.to_string();
    // names of other claims may stand beside it
    let (_, registered) = said.rsplit_once("face_block, ").unwrap();
    assert!(
        registered.split(", ").any(|name| name == "chain_of_tests"),
        "{said}"
    );
    AugmentationChoice::register(&Chain).unwrap_err();
    chain.require_local().unwrap_err();
    for (seed, h) in [(3, 0.0), (4, 0.7), (5, 0.3)] {
        let blocks = random(14, 6, h, seed);
        let of = |relaxation, inner: &str| Racp {
            augmentation: chain,
            relaxation,
            inner: inner.parse::<InnerChoice>().unwrap(),
            ..Racp::default()
        };
        let c = tridiagonal(6, 5);
        let n_u = blocks.n_u();
        let entry = |m: &SparseMatrix<f64>, i: usize, j: usize| m.get(i, j).copied().unwrap_or(0.0);
        let whole = Dense::from_fn(Shape::square(n_u + 6), |i, j| match (i < n_u, j < n_u) {
            (true, true) => entry(&blocks.a, i, j),
            (true, false) => entry(&blocks.b1, i, j - n_u),
            (false, true) => entry(&blocks.b1, j, i - n_u),
            (false, false) => -entry(&c, i - n_u, j - n_u),
        });
        let exact = of(0.0, "exact").prepare(&blocks).unwrap();
        check_preconditioner("exact", &exact, Some(&whole), 1e-8).unwrap();
        for inner in ["exact", "ssor", "amg"] {
            let m = of(4.0 / 27.0, inner).prepare(&blocks).unwrap();
            let accuracy = if m.properties().single { 1e-5 } else { 1e-9 };
            check_preconditioner(inner, &m, None, accuracy).unwrap();
        }
    }
}

#[test]
fn what_is_no_c_is_refused_with_its_row() {
    let of = |entry: fn(usize, usize) -> f64| {
        AugmentationMatrix::from_sparse(sparse(4, 4, entry))
            .unwrap_err()
            .to_string()
    };
    let unsymmetric = of(|i, j| {
        if i == j {
            1.0
        } else {
            f64::from(u8::from((i, j) == (1, 2)))
        }
    });
    assert!(
        unsymmetric.contains("row 2 of C is not its column"),
        "{unsymmetric}"
    );
    let indefinite = of(|i, j| if i == j { 1.0 } else { 2.0 });
    assert!(indefinite.contains("C"), "{indefinite}");
    let zero = of(|i, j| f64::from(u8::from(i == j && i != 2)));
    assert!(zero.contains("row 3") || zero.contains('3'), "{zero}");
    let nan = of(|i, j| if i == j { f64::NAN } else { 0.0 });
    assert!(nan.contains('C'), "{nan}");
}

/// A C of one number, with products, solves and entries of its own.
#[derive(Debug)]
struct Told {
    entries: SparseMatrix<f64>,
    product: f64,
    inverse: f64,
    size: usize,
}

impl LinearOperator<f64> for Told {
    fn shape(&self) -> Shape {
        Shape::square(3)
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], _: &mut [f64]) {
        y.iter_mut()
            .zip(x)
            .for_each(|(y, x)| *y += alpha * self.product * x);
    }

    fn flops(&self) -> u64 {
        9
    }
}

impl Preconditioner<f64> for Told {
    fn size(&self) -> usize {
        self.size
    }

    fn solve(&self, r: &[f64], z: &mut [f64], _: &mut [f64]) {
        z.iter_mut().zip(r).for_each(|(z, r)| *z = self.inverse * r);
    }

    fn flops(&self) -> u64 {
        3
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

impl CustomAugmentation for Told {
    fn entries(&self) -> SparseMatrix<f64> {
        self.entries.clone()
    }

    fn inverse_root(&self) -> Option<SparseMatrix<f64>> {
        None
    }
}

#[test]
fn a_c_from_outside_is_one_symmetric_positive_definite_matrix() {
    let diagonal = |c: f64| sparse(3, 3, |i, j| if i == j { c } else { 0.0 });
    let told = |entries, product, inverse, size| {
        let told = Told {
            entries,
            product,
            inverse,
            size,
        };
        AugmentationMatrix::custom(Arc::new(told))
    };
    assert!(told(diagonal(2.0), 2.0, 0.5, 3).is_ok());
    let skew = |i: usize, j: usize| {
        if i == j {
            2.0
        } else {
            0.1 * (i as f64 - j as f64)
        }
    };
    for (c, said) in [
        (told(diagonal(2.0), 2.0, 0.5, 4), "its solves of 4 rows"),
        (
            told(diagonal(2.0), 3.0, 1.0 / 3.0, 3),
            "row 1 of its products",
        ),
        (told(diagonal(2.0), 2.0, 0.4, 3), "row 1"),
        (told(diagonal(-2.0), -2.0, -0.5, 3), "row 1"),
        (
            told(sparse(3, 3, skew), 2.0, 0.5, 3),
            "row 1 of C is not its column",
        ),
    ] {
        let error = c.unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}
