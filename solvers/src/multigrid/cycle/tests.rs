//! Claim: a K-cycle visits a level by two steps of conjugate gradients around its cycle, and says that it is no linear map.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::Silent;
use crate::krylov::{Cg, Criteria, KrylovMethod, Outcome, System};
use crate::multigrid::Transfer;
use fracas_operators::laws::probe;
use fracas_operators::{Dense, Identity, Preconditioner, Shape};

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

fn level(nodes: usize, fixed: Vec<u32>) -> Level<f64> {
    let diagonal = (0..nodes).map(|node| {
        let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        upper.map(|(i, j)| chain(3 * node + i, 3 * node + j))
    });
    let operator = Box::new(square(3 * nodes, chain));
    let transfer = Box::new(Pairs { coarse: nodes / 2 });
    Level::new(operator, 0, diagonal.collect(), None, fixed, transfer).unwrap()
}

/// These levels above a poor solver of 6 nodes.
fn above_six(levels: Vec<Level<f64>>, cycle: Cycle) -> Hierarchy<f64> {
    let bottom = Bottom::new(Box::new(Identity { n: 18 }), (0..18).collect(), 18);
    let smoothing = Chebyshev {
        degree: 2,
        share: 0.1,
    };
    Hierarchy::new(levels, bottom, cycle, smoothing)
}

/// Levels of 24 and 12 nodes.
fn sample(cycle: Cycle) -> Hierarchy<f64> {
    above_six(vec![level(24, Vec::new()), level(12, vec![FIXED])], cycle)
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

#[test]
fn every_way_down_counts_what_it_does() {
    let flops = |cycle| sample(cycle).flops(0);
    let [v, w, k] = [Cycle::V, Cycle::W, Cycle::K].map(flops);
    let level = &sample(Cycle::V).levels[1];
    let (below, product) = (sample(Cycle::V).flops(1), level.operator.flops());
    assert_eq!(
        flops(Cycle::VThenW),
        v,
        "two levels: nothing below the first coarse one"
    );
    assert_eq!(w - v, below + product + 36);
    assert_eq!(k - w, product + 18 * 36);
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
        assert!(sample(cycle).is_linear());
    }
    assert!(!sample(Cycle::K).is_linear());
    assert!(above_six(vec![level(12, Vec::new())], Cycle::K).is_linear());
}
