//! Claim: a coarse matrix that is not positive is named by a row near the defect.

use crate::elastic_sample::cube;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::SetupError;
use fracas_solvers::amg::Amg;

#[test]
fn a_coarse_matrix_that_is_not_positive_is_named_by_a_row_near_the_defect() {
    let (a, coordinates) = cube(8);
    // softer than nothing in the last corner: blocks stay positive, the energy of a motion of many nodes does not
    let soft = |i: usize| coordinates[i].position.iter().all(|x| *x >= 5.0);
    let mut triplets = Triplets::new((a.rows(), a.rows()));
    for (value, (i, j)) in a.iter() {
        let shift = if i == j && soft(i as usize) {
            0.4 * value
        } else {
            0.0
        };
        triplets.add_triplet(i as usize, j as usize, value - shift);
    }
    let a: SparseMatrix<f64> = triplets.to_csr();
    let settings = Amg {
        coarsest: 50,
        ..Amg::default()
    };
    for known in [Some(&coordinates[..]), None] {
        let error = settings.build(&a, known).unwrap_err();
        let SetupError::NotPositiveDefinite { row, .. } = error else {
            panic!("{error}");
        };
        let place = coordinates[row - 1].position;
        assert!(place.iter().all(|x| *x >= 3.0), "row {row} at {place:?}");
    }
}
