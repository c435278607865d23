//! Claim: a probe of the slowest modes finds what an iteration misses.

use crate::samples::sparse;
use fracas_operators::Preconditioner;
use fracas_solvers::krylov::{Criteria, Gmres, KrylovMethod, System};
use fracas_solvers::saddle::{
    EnergyNorms, InnerChoice, Left, SaddleBlocks, SaddleMethod, SaddleOperator, probe,
};
use fracas_solvers::smoothers::Jacobi;
use fracas_solvers::{Prepare, Silent};
use std::borrow::Cow;

const SHORT: usize = 4;
const LONG: usize = 30;

/// Chains without a contact: a load on the one shows nothing of the slow modes of the other, which is longer.
#[test]
fn it_finds_what_an_iteration_misses() {
    let of_chain = |i: usize| if i < SHORT { 0 } else { 1 };
    let n = SHORT + LONG;
    let a = sparse(n, n, |i, j| {
        match (of_chain(i) == of_chain(j), i.abs_diff(j)) {
            (true, 0) => 2.0,
            (true, 1) => -1.0,
            _ => 0.0,
        }
    });
    let b1 = sparse(n, 1, |i, _| f64::from(u8::from(i == 0)));
    let mut rhs_u = vec![0.0; n];
    rhs_u[1] = 1.0;
    let blocks = SaddleBlocks {
        a,
        b1,
        b2: None,
        h: None,
        rhs_u,
        rhs_t: vec![0.0],
        coordinates: None,
        flow: None,
    };
    let jacobi = InnerChoice::Jacobi(Jacobi::default());
    let method = SaddleMethod::default().with_parts(None, Some(jacobi));
    let m = method.unwrap().prepare(&blocks).unwrap();
    assert!(m.properties().local);
    let operator = SaddleOperator::new(&blocks);
    let norms = EnergyNorms::new(
        &operator,
        None,
        blocks.contact_compliance(),
        Cow::Owned(blocks.stiffness()),
    );
    let system = System {
        operator: &operator,
        preconditioner: &m,
        rhs: &blocks.rhs(),
    };
    let criteria = Criteria {
        relative_tolerance: 1e-6,
        max_iterations: 200,
    };
    let gmres = Gmres::default();
    let mut x = vec![0.0; system.size()];
    let report = gmres.solve(&system, &criteria, &mut x, &mut Silent);
    let seen = report.unwrap().smallest_ritz.unwrap();
    let probed = probe(&gmres, &system, &norms, (None, Left::Little), &mut Silent);
    // 1 − cos(π/(n + 1)) of Jacobi, times its damping
    let found = probed.ritz.unwrap();
    let least = 1.0 - (std::f64::consts::PI / (LONG + 1) as f64).cos();
    assert!(
        found < 1.5 * least && seen > 0.05,
        "{found:e} beside {seen:e}"
    );
    assert!(probed.products <= 124 && probed.solves <= 124, "{probed:?}");
}
