//! Claim: an explanation names what costs iterations, and advises it away.

use crate::samples::two_chains;
use fracas_operators::laws::probe;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, Racp, SaddleBlocks, SaddleMethod};
use fracas_solvers::spectrum::{Explanation, Solved};

fn explained(blocks: &SaddleBlocks, racp: Racp) -> Explanation {
    let method = SaddleMethod::Racp(racp);
    let ready = method.ready(blocks).unwrap();
    let solved = Solved {
        blocks,
        method: &method,
        preconditioner: &*ready.inverse,
        hierarchy: ready.hierarchy.as_ref(),
        parts: ready.parts,
        rhs: &probe(blocks.size(), 5),
        setup_s: 0.0,
        solve_s: 0.0,
    };
    Explanation::new(&solved).unwrap()
}

#[test]
fn exact_parts_leave_one_half_and_one_and_nothing_to_gain() {
    let blocks = two_chains(6, 3, 1.0, false);
    let racp = Racp {
        augmentation: AugmentationChoice::Exact,
        ..Racp::default()
    };
    let facts = explained(&blocks, racp);
    let seen = facts.seen.unwrap();
    assert!((seen.kappa.unwrap() - 2.0).abs() < 1e-9, "{seen:?}");
    assert_eq!((seen.n_outliers, facts.c_over_h), (0, None));
    assert!(facts.inner_share.unwrap() > 0.0 && facts.inner_share.unwrap() < 1.0);
    assert_eq!(facts.advice, "nothing to gain but the tolerance");
}

#[test]
fn a_c_below_h_is_advised_away_and_local_h_is_not() {
    let mut blocks = two_chains(6, 3, 1.0, false);
    let h: fracas_operators::sparse::SparseMatrix<f64> =
        fracas_operators::sparse::SparseMatrix::eye(blocks.n_t());
    blocks.h = Some(h.map(|v| 1e4 * v));
    let of = |augmentation| {
        explained(
            &blocks,
            Racp {
                augmentation,
                ..Racp::published(InnerChoice::default())
            },
        )
    };
    let ours = explained(&blocks, Racp::default());
    assert!(!ours.advice.contains("_h"), "{}", ours.advice);
    let (local, local_h) = (
        of(AugmentationChoice::Local),
        of(AugmentationChoice::LocalH),
    );
    let (low, high) = (local.c_over_h.unwrap(), local_h.c_over_h.unwrap());
    // C_local + H = C
    assert!((high.min - low.min - 1.0).abs() < 1e-12 && low.max < 1.0);
    assert_eq!((low.share_below, high.share_below), (1.0, 0.0));
    assert!(
        local.advice.contains("augmentation = \"local_h\""),
        "{}",
        local.advice
    );
    assert!(!local_h.advice.contains("local_h"), "{}", local_h.advice);
    // H-blind C leaves eigenvalues of size H/C, and they are the outliers
    let (blind, seeing) = (local.seen.unwrap(), local_h.seen.unwrap());
    assert!(blind.modulus_max.unwrap() > 10.0 * seeing.modulus_max.unwrap());
    assert!(blind.outliers[0].eigenvalue.0 > 3.0 && seeing.n_outliers == 0);
}
