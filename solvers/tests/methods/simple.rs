//! Claim: SIMPLE is the product of its formula, and gives the known spectra.

use crate::oracle::{
    DenseInverse, Full, assert_spectrum, inverse, operator, spectrum, stacked, unsymmetric,
};
use crate::samples::{random, trusses};
use faer::Mat;
use fracas_operators::laws::check_preconditioner;
use fracas_operators::{Counted, Dense, Preconditioner};
use fracas_solvers::saddle::{
    Correction, SaddleBlocks, SaddleOperator, SaddleSettings, Simple, SimpleInverse,
};

fn systems() -> [SaddleBlocks; 3] {
    [
        random(13, 6, 0.0, 3),
        random(13, 6, 0.6, 4),
        unsymmetric(random(13, 6, 0.6, 5)),
    ]
}

fn inverse_diagonal(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.nrows(), |i, j| {
        if i == j { 1.0 / a[(i, i)] } else { 0.0 }
    })
}

#[test]
fn both_corrections_invert_the_dense_formula() {
    for blocks in systems() {
        let f = Full::new(&blocks);
        let d = inverse_diagonal(&f.a);
        let s = &f.h + &f.b2 * (&d * &f.b1);
        for (correction, q) in [
            (Correction::Solve, inverse(&f.a)),
            (Correction::Diagonal, d.clone()),
        ] {
            let settings = Simple {
                correction,
                ..Simple::default()
            };
            let m = settings.ready(&blocks).unwrap().inverse;
            // M = [A 0; B2 −Ŝ] [I QB1; 0 I]
            let lower = stacked(&f.a, &Mat::zeros(13, 6), &f.b2, &(faer::Scale(-1.0) * &s));
            let upper = stacked(
                &Mat::identity(13, 13),
                &(q * &f.b1),
                &Mat::zeros(6, 13),
                &Mat::identity(6, 6),
            );
            let matrix = operator(&(lower * upper));
            check_preconditioner("simple", &m, Some(&matrix), 1e-9).unwrap();
        }
    }
}

#[test]
fn exact_parts_invert_the_saddle_point_itself() {
    for blocks in systems() {
        let f = Full::new(&blocks);
        let s = &f.h + &f.b2 * (inverse(&f.a) * &f.b1);
        let m = SimpleInverse::new(
            blocks.b1.clone(),
            blocks.b2_rows(),
            DenseInverse::of(&f.a),
            DenseInverse::of(&s),
        );
        let saddle = Dense::of_operator(&SaddleOperator::new(&blocks));
        check_preconditioner("full factorization", &m, Some(&saddle), 1e-9).unwrap();
        assert_spectrum(&spectrum(&m, &blocks).unwrap(), vec![1.0; 19], 1e-7);
    }
}

#[test]
fn the_flops_are_those_of_the_parts_as_often_as_they_run() {
    let blocks = trusses(3, 10.0, false);
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    for diagonal in [false, true] {
        let p = Counted::new(DenseInverse::of(&Mat::identity(n_u, n_u)));
        let s = Counted::new(DenseInverse::of(&Mat::identity(n_t, n_t)));
        let mut m = SimpleInverse::new(blocks.b1.clone(), blocks.b2_rows(), &p, &s);
        if diagonal {
            m = m.correcting_by(vec![1.0; n_u]);
        }
        let n = m.size();
        m.solve(
            &vec![1.0; n],
            &mut vec![0.0; n],
            &mut vec![0.0; m.work_len()],
        );
        assert_eq!(p.applications(), if diagonal { 1 } else { 2 });
        let parts = p.applications() * p.inner().flops() + s.applications() * s.inner().flops();
        let products = 2 * (2 * blocks.b1.nnz() + n_u + n_t) + if diagonal { 2 * n_u } else { 0 };
        assert_eq!(m.flops(), parts + products as u64);
    }
}
