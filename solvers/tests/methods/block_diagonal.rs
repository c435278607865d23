//! Claim: block-diagonal preconditioners are the formulas, and give the known spectra.

use crate::iterations::{solve, until};
use crate::oracle::{
    DenseInverse, Full, assert_spectrum, inverse, operator, real_eigenvalues, spectrum, stacked,
};
use crate::samples::{random, trusses, two_chains};
use faer::Mat;
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::{Counted, Preconditioner};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Minres, Outcome};
use fracas_solvers::saddle::{
    AugmentationChoice, BlockDiagonal, BlockDiagonalInverse, SaddleMethod, SaddleOperator,
    SaddleSettings, T, U,
};
use fracas_solvers::{Prepare, SetupError};

fn on(augmentation: Option<AugmentationChoice>) -> BlockDiagonal {
    BlockDiagonal {
        augmentation,
        ..BlockDiagonal::default()
    }
}

#[test]
fn both_forms_invert_the_dense_formula() {
    for blocks in [random(13, 6, 0.0, 3), random(13, 6, 0.6, 4)] {
        let f = Full::new(&blocks);
        let zero = Mat::<f64>::zeros(13, 6);
        let zero_t = Mat::<f64>::zeros(6, 13);
        // diag(A, H + Bᵀ D⁻¹ B)
        let d = Mat::<f64>::from_fn(13, 13, |i, j| if i == j { 1.0 / f.a[(i, i)] } else { 0.0 });
        let s = &f.h + f.b1.transpose() * (d * &f.b1);
        let m = on(None).ready(&blocks).unwrap().inverse;
        let matrix = operator(&stacked(&f.a, &zero, &zero_t, &s));
        check_preconditioner("on A", &m, Some(&matrix), 1e-9).unwrap();
        // diag(A + BC⁻¹Bᵀ, C)
        let choice = AugmentationChoice::LocalH;
        let direct = DirectChoice::Faer.solver().unwrap();
        let c = choice.compute(&blocks, direct.as_ref()).unwrap();
        let c = c.matrix.to_dense();
        let s_u = &f.a + &f.b1 * (inverse(&c) * f.b1.transpose());
        let m = on(Some(choice)).ready(&blocks).unwrap().inverse;
        let matrix = operator(&stacked(&s_u, &zero, &zero_t, &c));
        check_preconditioner("on S_u", &m, Some(&matrix), 1e-9).unwrap();
    }
}

#[test]
fn exact_parts_on_a_have_three_eigenvalues() {
    let blocks = random(12, 5, 0.0, 8);
    let f = Full::new(&blocks);
    let s = f.b1.transpose() * (inverse(&f.a) * &f.b1);
    let m = BlockDiagonalInverse::new(vec![
        (U, Box::new(DenseInverse::of(&f.a))),
        (T, Box::new(DenseInverse::of(&s))),
    ]);
    let root = 5.0f64.sqrt();
    let mut expected = vec![1.0; 7];
    expected.extend([0.5 * (1.0 + root); 5]);
    expected.extend([0.5 * (1.0 - root); 5]);
    assert_spectrum(&spectrum(&m, &blocks).unwrap(), expected, 1e-8);
}

#[test]
fn exact_parts_on_s_u_have_ones_and_minus_sigma_over_one_plus_sigma() {
    let choice = AugmentationChoice::Local;
    let direct = DirectChoice::Faer.solver().unwrap();
    let blocks = random(12, 5, 0.0, 8);
    let f = Full::new(&blocks);
    let s = f.b1.transpose() * (inverse(&f.a) * &f.b1);
    let c = choice.compute(&blocks, direct.as_ref()).unwrap();
    let sigma = real_eigenvalues(&(inverse(&c.matrix.to_dense()) * s));
    let mut expected = vec![1.0; 12];
    expected.extend(sigma.iter().map(|s| -s / (1.0 + s)));
    let m = on(Some(choice)).ready(&blocks).unwrap().inverse;
    assert_spectrum(&spectrum(&m, &blocks).unwrap(), expected, 1e-8);
    // a floating chain: one rigid-body mode, one eigenvalue −1
    let floating = two_chains(8, 3, 1.0, true);
    let m = on(Some(choice)).ready(&floating).unwrap().inverse;
    let values = spectrum(&m, &floating).unwrap();
    let minus_one = values.iter().filter(|v| (v.re + 1.0).hypot(v.im) < 1e-9);
    assert_eq!(minus_one.count(), 1);
    assert!(matches!(
        on(None).ready(&floating).err().unwrap(),
        SetupError::Singular { block: "A", .. }
            | SetupError::NotPositiveDefinite { block: "A", .. }
    ));
}

#[test]
fn minres_converges_with_both_forms() {
    for (blocks, choices) in [
        (
            trusses(3, 10.0, false),
            &[None, Some(AugmentationChoice::Local)][..],
        ),
        (
            two_chains(12, 4, 10.0, true),
            &[Some(AugmentationChoice::Local)][..],
        ),
    ] {
        for choice in choices {
            let method = SaddleMethod::BlockDiagonal(on(*choice));
            let m = method.prepare(&blocks).unwrap();
            let operator = SaddleOperator::new(&blocks);
            let rhs: Vec<f64> = probe(blocks.size(), 5);
            let (_, report) = solve(&Minres {}, &operator, &m, &rhs, until(1e-8, 150));
            let report = report.unwrap();
            assert_eq!(report.outcome, Outcome::Converged, "{choice:?}");
            assert!(report.relative_residual <= 1e-8);
        }
    }
}

#[test]
fn the_flops_are_those_of_the_parts() {
    let p = Counted::new(DenseInverse::of(&Mat::identity(4, 4)));
    let s = Counted::new(DenseInverse::of(&Mat::identity(3, 3)));
    let m = BlockDiagonalInverse::new(vec![(U, Box::new(&p)), (T, Box::new(&s))]);
    m.solve(&[1.0; 7], &mut [0.0; 7], &mut []);
    assert_eq!((p.applications(), s.applications()), (1, 1));
    assert_eq!(m.flops(), 2 * 16 + 2 * 9);
}
