//! Claim: block-triangular preconditioners are the formulas, and give the known spectra.

use crate::oracle::{
    DenseInverse, Full, assert_spectrum, inverse, operator, spectrum, stacked, unsymmetric,
};
use crate::samples::{random, trusses};
use faer::Mat;
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::{Counted, LinearOperator, Preconditioner};
use fracas_solvers::SetupError;
use fracas_solvers::saddle::{
    BlockTriangular, BlockTriangularInverse, SaddleOperator, SaddleSettings,
};

#[test]
fn the_settings_invert_the_dense_formula() {
    for blocks in [
        random(13, 6, 0.0, 3),
        random(13, 6, 0.6, 4),
        unsymmetric(random(13, 6, 0.6, 5)),
    ] {
        let f = Full::new(&blocks);
        let d = Mat::<f64>::from_fn(13, 13, |i, j| if i == j { 1.0 / f.a[(i, i)] } else { 0.0 });
        let s = &f.h + &f.b2 * (d * &f.b1);
        let m = BlockTriangular::default().ready(&blocks).unwrap().inverse;
        let zero = Mat::<f64>::zeros(6, 13);
        let matrix = operator(&stacked(&f.a, &f.b1, &zero, &(faer::Scale(-1.0) * s)));
        check_preconditioner("triangular", &m, Some(&matrix), 1e-9).unwrap();
    }
}

#[test]
fn exact_parts_have_only_ones_and_degree_two() {
    for blocks in [
        random(12, 5, 0.0, 3),
        random(12, 5, 0.6, 4),
        unsymmetric(random(12, 5, 0.6, 5)),
    ] {
        let f = Full::new(&blocks);
        let s = &f.h + &f.b2 * (inverse(&f.a) * &f.b1);
        let m = BlockTriangularInverse::new(
            blocks.b1.clone(),
            DenseInverse::of(&f.a),
            DenseInverse::of(&s),
        );
        // Jordan blocks of size 2: eigenvalues to the square root of rounding
        assert_spectrum(&spectrum(&m, &blocks).unwrap(), vec![1.0; 17], 1e-5);
        // (M⁻¹𝒜 − I)² x = 0
        let saddle = SaddleOperator::new(&blocks);
        let step = |x: &[f64]| {
            let (mut ax, mut z) = (vec![0.0; 17], vec![0.0; 17]);
            saddle.apply(x, &mut ax, &mut []);
            m.solve(&ax, &mut z, &mut vec![f64::NAN; m.work_len()]);
            z.iter().zip(x).map(|(z, x)| z - x).collect::<Vec<f64>>()
        };
        let x: Vec<f64> = probe(17, 9);
        let once = step(&x);
        let largest = |v: &[f64]| v.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(largest(&once) > 1e-3);
        assert!(largest(&step(&once)) < 1e-9 * largest(&once).max(1.0));
    }
}

#[test]
fn the_flops_are_those_of_the_parts_as_often_as_they_run() {
    let blocks = trusses(3, 10.0, false);
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let p = Counted::new(DenseInverse::of(&Mat::identity(n_u, n_u)));
    let s = Counted::new(DenseInverse::of(&Mat::identity(n_t, n_t)));
    let m = BlockTriangularInverse::new(blocks.b1.clone(), &p, &s);
    let n = m.size();
    m.solve(
        &vec![1.0; n],
        &mut vec![0.0; n],
        &mut vec![0.0; m.work_len()],
    );
    let parts = p.applications() * p.inner().flops() + s.applications() * s.inner().flops();
    assert_eq!(m.flops(), parts + 2 * (blocks.b1.nnz() + n_u) as u64);
}

#[test]
fn a_row_of_a_without_a_diagonal_is_named() {
    let mut blocks = random(6, 2, 0.0, 3);
    let a = crate::oracle::full(&blocks.a);
    blocks.a = crate::samples::sparse(6, 6, |i, j| if (i, j) == (3, 3) { 0.0 } else { a[(i, j)] });
    let error = BlockTriangular::default().ready(&blocks).err().unwrap();
    assert!(
        matches!(
            error,
            SetupError::BadDiagonal {
                block: "A",
                row: 4,
                ..
            }
        ),
        "{error}"
    );
}
