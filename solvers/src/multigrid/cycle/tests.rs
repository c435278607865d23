//! Claim: a K-cycle visits a level by two steps of conjugate gradients around its cycle, and says that it is no linear map.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::Silent;
use crate::krylov::{Cg, Criteria, KrylovMethod, Outcome, System};
use crate::multigrid::{BlockChebyshev, BlockJacobi, Chebyshev, Scaled, Smoother, Transfer};
use fracas_operators::laws::probe;
use fracas_operators::{
    Counted, Dense, Identity, LinearOperator, Preconditioner, Properties, Shape,
};
use std::sync::Arc;

/// Two nodes of a level make one of the next.
struct Pairs {
    coarse: usize,
}

impl Transfer<f64> for Pairs {
    fn coarse_len(&self) -> usize {
        3 * self.coarse
    }

    fn restrict(&self, r: &[f64], coarse: &mut [f64]) {
        for (i, c) in coarse.iter_mut().enumerate() {
            let (node, k) = (i / 3, i % 3);
            *c = r[6 * node + k] + r[6 * node + 3 + k];
        }
    }

    fn prolong(&self, coarse: &[f64], x: &mut [f64]) {
        for (i, x) in x.iter_mut().enumerate() {
            *x = coarse[3 * (i / 6) + i % 3];
        }
    }

    fn prolong_add(&self, coarse: &[f64], x: &mut [f64]) {
        for (i, x) in x.iter_mut().enumerate() {
            *x += coarse[3 * (i / 6) + i % 3];
        }
    }

    fn flops(&self) -> u64 {
        0
    }

    fn bytes(&self) -> usize {
        0
    }
}

/// A component of level 1 that is no unknown, and is tied to others in its matrix.
const FIXED: u32 = 4;

/// Entry of a chain of nodes whose components are tied to each other, ever stiffer along it: `Σ (u_k − u_k+1)ᵀ K_k (u_k − u_k+1)`.
fn chain(i: usize, j: usize) -> f64 {
    let (low, high) = ((i / 3).min(j / 3), (i / 3).max(j / 3));
    let component = if i % 3 == j % 3 { 2.0 } else { 0.5 };
    let link = |at: usize| component * (1.0 + 0.7 * at as f64);
    match high - low {
        0 => link(low) + link(low + 1),
        1 => -link(high),
        _ => 0.0,
    }
}

fn square(n: usize, entry: impl Fn(usize, usize) -> f64) -> Dense<f64> {
    Dense::from_fn(Shape { rows: n, cols: n }, entry)
}

/// A level of the chain by this operator.
fn level_of(operator: Box<dyn LinearOperator<f64>>, fixed: Vec<u32>) -> Level<f64> {
    let nodes = operator.shape().rows / 3;
    let diagonal = (0..nodes).map(|node| {
        let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        upper.map(|(i, j)| chain(3 * node + i, 3 * node + j))
    });
    let diagonal: Vec<_> = diagonal.collect();
    let jacobi = BlockJacobi::new(&diagonal, &fixed).unwrap();
    let polynomial = Chebyshev {
        degree: 2,
        share: 0.1,
    };
    let smoother = BlockChebyshev::new(
        Scaled::estimated(operator, 0, jacobi, polynomial.degree),
        polynomial,
    );
    let transfer = Box::new(Pairs { coarse: nodes / 2 });
    Level::new(Box::new(smoother), transfer, fixed)
}

fn level(nodes: usize, fixed: Vec<u32>) -> Level<f64> {
    level_of(Box::new(square(3 * nodes, chain)), fixed)
}

/// These levels above a poor solver of so many nodes.
fn above(levels: Vec<Level<f64>>, nodes: usize, cycle: Cycle) -> Hierarchy<f64> {
    let n = 3 * nodes;
    let below = Box::new(Identity { n });
    let bottom = Bottom::new(below, Vec::new(), (0..n as u32).collect(), n);
    let about = About {
        near_null_space: "",
        smoothing: Smoothing {
            smoother: Smoother::Chebyshev,
            chained: None,
        },
    };
    Hierarchy::new(levels, bottom, cycle, about)
}

/// Levels of 24 and 12 nodes.
fn sample(cycle: Cycle) -> Hierarchy<f64> {
    above(
        vec![level(24, Vec::new()), level(12, vec![FIXED])],
        6,
        cycle,
    )
}

/// A counter that the test can read while a level owns it.
struct Shared(Arc<Counted<Dense<f64>>>);

impl LinearOperator<f64> for Shared {
    fn shape(&self) -> Shape {
        self.0.shape()
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        self.0.apply_add(alpha, x, y, work);
    }

    fn flops(&self) -> u64 {
        self.0.flops()
    }
}

/// The cycle of level 1.
struct Below<'a>(&'a Hierarchy<f64>);

impl Preconditioner<f64> for Below<'_> {
    fn size(&self) -> usize {
        self.0.size(1)
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.0.cycle(1, &mut r.to_vec(), z, work, false);
    }

    fn work_len(&self) -> usize {
        self.0.work_len()
    }

    fn flops(&self) -> u64 {
        self.0.flops(1)
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

#[test]
fn a_k_cycle_visits_by_two_steps_of_conjugate_gradients() {
    let hierarchy = sample(Cycle::K);
    let n = hierarchy.size(1);
    let mut work = vec![f64::NAN; hierarchy.work_len()];
    // the matrix over the unknowns: the fixed component is tied to nothing
    let fixed = FIXED as usize;
    let free = square(n, |i, j| match (i == fixed, j == fixed) {
        (false, false) => chain(i, j),
        (true, true) => 1.0,
        _ => 0.0,
    });
    for seed in 0..3 {
        let mut b = probe::<f64>(n, seed);
        b[fixed] = 0.0;
        let mut x = vec![f64::NAN; n];
        hierarchy.visit(Visit::TwoSteps, 1, &mut b.clone(), &mut x, &mut work);
        let system = System {
            operator: &free,
            preconditioner: &Below(&hierarchy),
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-14,
            max_iterations: 2,
        };
        let mut expected = vec![0.0; n];
        let report = Cg {}.solve(&system, &criteria, &mut expected, &mut Silent);
        assert_eq!(report.unwrap().outcome, Outcome::IterationLimit);
        let size = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (x, y) in x.iter().zip(&expected) {
            assert!((x - y).abs() < 1e-13 * size, "{x} for {y}");
        }
        assert_eq!(x[fixed], 0.0);
    }
}

/// Products of a cycle with the matrix of every level, finest first.
fn products(cycle: Cycle) -> (Vec<u64>, Hierarchy<f64>) {
    let counters: Vec<Arc<Counted<Dense<f64>>>> = [24, 12, 6]
        .map(|nodes| Arc::new(Counted::new(square(3 * nodes, chain))))
        .into();
    let levels = counters.iter().map(|operator| {
        let operator: Box<dyn LinearOperator<f64>> = Box::new(Shared(operator.clone()));
        level_of(operator, Vec::new())
    });
    let hierarchy = above(levels.collect(), 3, cycle);
    let before: Vec<u64> = counters.iter().map(|c| c.applications()).collect();
    let n = hierarchy.size(0);
    let mut work = vec![f64::NAN; hierarchy.work_len()];
    hierarchy.solve(&mut vec![1.0; n], &mut vec![0.0; n], &mut work);
    let after = counters.iter().map(|c| c.applications());
    let made = after.zip(before).map(|(a, b)| a - b).collect();
    (made, hierarchy)
}

#[test]
fn flops_are_those_of_the_products_and_sweeps_that_are_made() {
    // a cycle of degree 2 makes four products, and one more where it leaves its residual
    for (cycle, visits, expected, vectors) in [
        (Cycle::V, [1, 1, 1], [4, 4, 4], 0),
        // 2 · 2 · 18 unknowns on the third level are more than 3/4 of the 36 on the second
        (Cycle::VThenW, [1, 1, 1], [4, 4, 4], 0),
        (Cycle::W, [1, 2, 4], [4, 9, 18], 2),
        (Cycle::K, [1, 2, 4], [4, 10, 20], 19),
    ] {
        let (made, hierarchy) = products(cycle);
        assert_eq!(made, expected, "{cycle:?}");
        let mut flops = visits[2] * hierarchy.bottom.flops();
        for (k, level) in hierarchy.levels.iter().enumerate() {
            let sweeps = level.flops() - 4 * level.operator().flops();
            flops += made[k] * level.operator().flops() + visits[k] * sweeps;
            if k > 0 {
                flops += visits[k - 1] * vectors * level.size() as u64;
            }
        }
        assert_eq!(hierarchy.flops(0), flops, "{cycle:?}");
    }
}

#[test]
fn levels_that_shrink_slowly_are_visited_twice_no_more_often_than_they_can_be_afforded() {
    let of = |sizes: &[usize]| -> String {
        let visits = visits(Cycle::VThenW, sizes);
        let letter = |visit: &Visit| if *visit == Visit::Twice { '2' } else { '1' };
        visits.iter().map(letter).collect()
    };
    // the solver at the bottom is visited once
    assert_eq!(of(&[4096, 512, 64, 8, 1]), "1221");
    assert_eq!(of(&[64, 32, 16, 8, 4, 2, 1]), "112121");
    assert_eq!(of(&[100, 90, 81, 73, 66]), "1111");
    assert_eq!(of(&[8, 1]), "1");
}

#[test]
fn steps_of_a_k_cycle_end_at_two() {
    assert_eq!(step(3.0, 2.0), Some(1.5));
    assert_eq!(step(5.0, 2.0), Some(2.0));
    for (slope, curvature) in [
        (1.0, 0.0),
        (1.0, -1.0),
        (f64::NAN, 1.0),
        (1.0, f64::NAN),
        (0.0, 0.0),
    ] {
        assert_eq!(step(slope, curvature), None);
    }
    assert_eq!(step(f64::INFINITY, 1.0), None);
}

#[test]
fn nothing_comes_of_nothing() {
    let hierarchy = sample(Cycle::K);
    let n = hierarchy.size(0);
    let mut x = vec![f64::NAN; n];
    let mut work = vec![f64::NAN; hierarchy.work_len()];
    hierarchy.solve(&mut vec![0.0; n], &mut x, &mut work);
    assert!(x.iter().all(|x| *x == 0.0));
}

#[test]
fn only_a_k_cycle_over_levels_is_no_linear_map() {
    for cycle in [Cycle::V, Cycle::VThenW, Cycle::W] {
        assert!(sample(cycle).properties().is_linear_map());
    }
    assert!(!sample(Cycle::K).properties().linear);
    let above_the_bottom = above(vec![level(12, Vec::new())], 6, Cycle::K);
    assert!(above_the_bottom.properties().is_linear_map());
}
