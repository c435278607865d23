//! Claim: Krylov methods and smoothers allocate nothing once their memory exists, and give the same bits for any
//! number of threads.
#![allow(clippy::unwrap_used)]

#[path = "../../tests/counting/mod.rs"]
mod counting;

use counting::{allocations, threads};
use fracas_operators::laws::probe;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::krylov::{Criteria, KrylovChoice, System, Watch};
use fracas_solvers::smoothers::{Jacobi, JacobiBlock, Ssor};
use fracas_solvers::{Prepare, Silent};
use rayon::ThreadPool;

/// Long enough that every vector operation is split between threads.
const N: usize = 30_000;

/// SPD, so that every method applies: `tridiag(−1, 3, −1)`, far from diagonal scaling.
fn matrix() -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((N, N));
    for i in 0..N {
        triplets.add_triplet(i, i, 2.2 + (i % 5) as f64);
        if i > 0 {
            triplets.add_triplet(i, i - 1, -1.0);
            triplets.add_triplet(i - 1, i, -1.0);
        }
    }
    triplets.to_csr()
}

fn preconditioners(a: &SparseMatrix<f64>) -> Vec<Box<dyn Preconditioner<f64>>> {
    let node = Jacobi {
        omega: 0.9,
        block: JacobiBlock::Node,
    };
    vec![
        Jacobi::default().prepare(a).unwrap(),
        node.prepare(a).unwrap(),
        Ssor::default().prepare(a).unwrap(),
    ]
}

/// Solves twice in the same memory: (bits of x, allocations of the second solve).
fn solve_again(
    choice: KrylovChoice,
    operator: &dyn LinearOperator<f64>,
    preconditioner: &dyn Preconditioner<f64>,
    pool: &ThreadPool,
) -> (Vec<u64>, u64) {
    let rhs = probe(N, 1);
    let system = System {
        operator,
        preconditioner,
        rhs: &rhs,
    };
    let criteria = Criteria {
        relative_tolerance: 1e-9,
        max_iterations: 60,
    };
    let method = choice.method();
    let mut work = vec![0.0; method.work_len(&system, &criteria)];
    let mut x = vec![0.0; N];
    pool.install(|| {
        let mut run = |x: &mut [f64]| {
            x.fill(0.0);
            method.solve_in(&system, &criteria, x, Watch::of(&mut Silent), &mut work)
        };
        run(&mut x).unwrap();
        let mut report = None;
        let made = allocations(|| report = Some(run(&mut x)));
        let iterations = report.unwrap().unwrap().iterations;
        assert!(iterations > 3, "{choice} did too little");
        (x.iter().map(|v| v.to_bits()).collect(), made)
    })
}

// one test, because the counter belongs to the whole process
#[test]
fn nothing_is_allocated_and_bits_do_not_depend_on_threads() {
    let (one_thread, two_threads) = (threads(1), threads(2));
    let a = matrix();
    let prepared = preconditioners(&a);
    let operator = Csr::new(a);
    let mut choices = KrylovChoice::all().to_vec();
    choices.push("gmres:4".parse().unwrap());
    for choice in choices {
        for m in &prepared {
            let (one, quiet) = solve_again(choice, &operator, m, &one_thread);
            assert_eq!(quiet, 0, "{choice} allocates on one thread");
            let (two, quiet) = solve_again(choice, &operator, m, &two_threads);
            assert_eq!(quiet, 0, "{choice} allocates on two threads");
            assert!(one == two, "{choice}: bits depend on threads");
        }
    }
}
