//! Claim: fields by name go through every preconditioner.

use crate::oracle::{DenseInverse, Full, inverse, stacked};
use crate::samples::{random, sparse};
use fracas_operators::laws::{check_operator, probe};
use fracas_operators::sparse::Csr;
use fracas_operators::{BlockOperator, Dense, Layout, LinearOperator, Preconditioner, Properties};
use fracas_solvers::Silent;
use fracas_solvers::krylov::{Criteria, Gmres, Outcome, System};
use fracas_solvers::saddle::{
    Assembled, BlockDiagonalInverse, EnergyNorms, FlowBlocks, Measure, P, SaddleBlocks,
    SaddleOperator, SaddleSystem, T, U, solve_accurately,
};
use std::borrow::Cow;

/// Blocks of u and t beside flow in four pressures, Q2 = −Q1ᵀ.
fn blocks() -> SaddleBlocks {
    let q: Vec<f64> = probe(14 * 4, 11);
    let q1 = sparse(14, 4, |i, j| q[4 * i + j]);
    let q2 = sparse(4, 14, |i, j| -q[4 * j + i]);
    let t = sparse(4, 4, |i, j| match i.abs_diff(j) {
        0 => 3.0,
        1 => -1.0,
        _ => 0.0,
    });
    SaddleBlocks {
        flow: Some(FlowBlocks {
            q1,
            q2,
            t,
            rhs_p: vec![0.0; 4],
        }),
        ..random(14, 6, 0.5, 3)
    }
}

#[test]
fn a_third_field_goes_by_its_name_through_products_iteration_judge_and_preconditioner() {
    let blocks = blocks();
    let (flow, h) = (blocks.flow.clone().unwrap(), blocks.h.clone().unwrap());
    let own = |m: &fracas_operators::sparse::SparseMatrix<f64>| Csr::new(m.clone());
    // [A B1 Q1; B2 −H 0; Q2 0 T]
    let layout = Layout::new([(U, 14), (T, 6), (P, 4)]);
    let operator = BlockOperator::new(layout)
        .with([U, U], 1.0, own(&blocks.a))
        .with([U, T], 1.0, own(&blocks.b1))
        .with([U, P], 1.0, own(&flow.q1))
        .with([T, U], 1.0, own(&blocks.b2_rows()))
        .with([T, T], -1.0, own(&h))
        .with([P, U], 1.0, own(&flow.q2))
        .with([P, P], 1.0, own(&flow.t));
    let assembled = Dense::of_operator(&SaddleOperator::new(&blocks));
    check_operator("three fields", &operator, Some(&assembled)).unwrap();
    assert_eq!((blocks.layout(), operator.layout()), (layout, layout));

    // diag(A, H + BᵀA⁻¹B, T + Q1ᵀA⁻¹Q1)
    let full = Full::new(&blocks);
    let a = inverse(&full.a);
    let dense = fracas_solvers::eigen::dense::to_dense;
    let (q1, q2) = (dense(&flow.q1), dense(&flow.q2));
    let m = BlockDiagonalInverse::new(vec![
        (U, Box::new(DenseInverse::of(&full.a))),
        (
            T,
            Box::new(DenseInverse::of(
                &(&full.h + full.b1.transpose() * (&a * &full.b1)),
            )),
        ),
        (
            P,
            Box::new(DenseInverse::of(&(dense(&flow.t) - q2 * (&a * q1)))),
        ),
    ]);
    let system = Assembled::new(&blocks, None);
    let by_name = EnergyNorms::new(
        &operator,
        Some(&h),
        blocks.contact_compliance(),
        Cow::Owned(blocks.stiffness()),
    )
    .and(P, blocks.pressure_compliance(), &flow.t);
    for norms in [by_name, system.norms(true)] {
        let exact: Vec<f64> = probe(24, 5);
        let mut b = vec![0.0; 24];
        operator.apply(&exact, &mut b, &mut vec![0.0; operator.work_len()]);
        let mut x = vec![0.0; 24];
        let equations = System {
            operator: &operator,
            preconditioner: &m,
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-9,
            max_iterations: 100,
        };
        let how = (Measure::Error, &norms);
        let gmres = Gmres::default();
        let solved = solve_accurately(&gmres, &equations, &criteria, how, &mut x, &mut Silent);
        assert_eq!(solved.result.unwrap().outcome, Outcome::Converged);
        let e: Vec<f64> = x.iter().zip(&exact).map(|(x, y)| x - y).collect();
        let truth = EnergyNorms::relative(norms.error(&e), norms.solution(&exact), 1e-9);
        for field in [U, T, P] {
            assert!(
                solved.error[field] < 1e-9 && truth[field] < 1e-8,
                "{truth:?}"
            );
        }
        // an error of p alone is one of p, and moves neither of the others
        let mut e = vec![0.0; 24];
        let [e_p] = layout.split_mut([P], &mut e);
        e_p[1] = 1.0;
        let of_p = norms.error(&e);
        let expected = blocks.pressure_compliance()[1].sqrt();
        assert_eq!([of_p[U], of_p[T], of_p[P]], [0.0, 0.0, expected]);
        assert_eq!(norms.random_residual().len(), 24);
        let residual = system.residual(&x, &b, Some(&blocks));
        assert!(residual.contact.unwrap() < 1e-8 && residual.backward.unwrap() < 1e-8);
    }
}

/// M⁻¹ that takes some rows for 0.
struct Sees(DenseInverse, fn(usize) -> bool);

impl Preconditioner<f64> for Sees {
    fn size(&self) -> usize {
        self.0.size()
    }
    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.0.solve(r, z, work);
        let unseen = z.iter_mut().enumerate().filter(|(i, _)| !self.1(*i));
        unseen.for_each(|(_, z)| *z = 0.0);
    }
    fn work_len(&self) -> usize {
        self.0.work_len()
    }
    fn flops(&self) -> u64 {
        self.0.flops()
    }
    fn properties(&self) -> Properties {
        Properties::BLIND
    }
}

#[test]
fn a_preconditioner_that_sees_nothing_proves_nothing() {
    let blocks = random(14, 6, 0.5, 3);
    let system = Assembled::new(&blocks, None);
    let operator = SaddleOperator::new(&blocks);
    let full = Full::new(&blocks);
    let whole = stacked(&full.a, &full.b1, &full.b2, &(&full.h * faer::Scale(-1.0)));
    let b = probe(20, 5);
    let sees: [fn(usize) -> bool; 4] = [|_| false, |i| i < 14, |i| i >= 14, |i| i != 3];
    for (k, sees) in sees.into_iter().enumerate() {
        let m = Sees(DenseInverse::of(&whole), sees);
        let equations = System {
            operator: &operator,
            preconditioner: &m,
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-8,
            max_iterations: 100,
        };
        let mut x = vec![0.0; 20];
        let norms = system.norms(true);
        let how = (Measure::Error, &norms);
        let gmres = Gmres::default();
        let solved = solve_accurately(&gmres, &equations, &criteria, how, &mut x, &mut Silent);
        let converged =
            matches!(&solved.result, Ok(report) if report.outcome == Outcome::Converged);
        assert!(!converged, "{k}: {:?}", solved.result);
    }
}
