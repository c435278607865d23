//! Claim: chains of flat cells are found, and decide about the smoother.

use crate::elastic_sample::clamped_box;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::DofCoordinate;
use fracas_solvers::amg::Amg;
use fracas_solvers::multigrid::{Smoother, Smoothing};

fn chosen(a: &SparseMatrix<f64>, at: &[DofCoordinate]) -> Smoothing {
    let m = Amg::default().build(a, Some(at));
    m.unwrap().summary().smoothing
}

#[test]
fn flat_cells_are_chains_and_cubes_are_not_in_any_unit() {
    for (h, smoother) in [
        ([1.0, 1.0, 1.0], Smoother::GaussSeidel),
        ([1.0, 0.6, 0.8], Smoother::GaussSeidel),
        ([1.0, 1.0, 0.1], Smoother::Fsai),
        ([0.01, 1.0, 1.0], Smoother::Fsai),
    ] {
        let (a, at) = clamped_box([8, 7, 7], h, |_| 1.0);
        // aggregates along the chains take their place where the nodes are known
        assert_eq!(chosen(&a, &at).smoother, Smoother::GaussSeidel, "{h:?}");
        let found = Amg::default().build(&a, None).unwrap().summary().smoothing;
        assert_eq!(found.smoother, smoother, "{h:?}: {found}");
        let chained = found.chained.unwrap();
        assert!(chained == 0.0 || chained > 0.8, "{h:?}: {found}");
        // D A D with one factor per node
        let factor = |i: usize| 10f64.powf(3.0 * (1.7 * (i / 3) as f64).sin());
        let mut scaled = a.clone();
        for (i, mut row) in scaled.outer_iterator_mut().enumerate() {
            row.iter_mut()
                .for_each(|(j, v)| *v *= factor(i) * factor(j));
        }
        let again = Amg::default()
            .build(&scaled, None)
            .unwrap()
            .summary()
            .smoothing;
        assert!((again.chained.unwrap() - chained).abs() < 0.01);
    }
}

#[test]
fn a_stiff_layer_in_a_body_of_cubes_does_not_decide() {
    // a stiff layer couples its nodes; the others are as in cubes
    let (a, at) = clamped_box([8, 7, 12], [1.0; 3], |c| if c[2] == 6 { 1e3 } else { 1.0 });
    let found = chosen(&a, &at);
    assert_eq!(found.smoother, Smoother::GaussSeidel, "{found}");
}

#[test]
fn a_named_smoother_is_taken_as_it_is() {
    let (a, at) = clamped_box([6, 6, 6], [1.0, 1.0, 0.01], |_| 1.0);
    for smoother in [Smoother::GaussSeidel, Smoother::Chebyshev, Smoother::Fsai] {
        let m = Amg::with(smoother).build(&a, Some(&at)).unwrap();
        let found = m.summary().smoothing;
        assert_eq!((found.smoother, found.chained), (smoother, None));
    }
}
