//! Seconds and entries of every direct backend on lattices with the pattern of 3-D elasticity (27 points × 3).
//!
//! `cargo run --release -p fracas-solvers --features suitesparse --example direct_timings -- 19 26`

#[allow(dead_code, reason = "the tests use more of it")]
#[path = "../tests/lattice/mod.rs"]
mod lattice;

use fracas_operators::LinearOperator;
use fracas_operators::laws::probe;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::vector::norm2;
use fracas_solvers::SetupError;
use fracas_solvers::direct::{DirectChoice, Kind};
use lattice::{Lattice, Support};
use std::time::Instant;

fn report(choice: DirectChoice, kind: Kind, a: &SparseMatrix<f64>) -> Result<(), SetupError> {
    let r = probe::<f64>(a.rows(), 1);
    let start = Instant::now();
    let symbolic = choice.solver()?.analyze(a, kind)?;
    let analyzed = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let factors = symbolic.factor(a)?;
    let factored = start.elapsed().as_secs_f64();
    let mut z = vec![0.0; r.len()];
    let mut work = vec![0.0; factors.work_len()];
    let start = Instant::now();
    factors.solve(&r, &mut z, &mut work);
    let solved = start.elapsed().as_secs_f64();
    let mut residual = r.clone();
    Csr::new(a.clone()).apply_add(-1.0, &z, &mut residual, &mut []);
    println!(
        "{:<14} {:<8} {:>7} {:>9.3} {:>9.3} {:>9.4} {:>8.1} {:>10.1e}",
        format!("{kind:?}"),
        format!("{choice:?}").to_lowercase(),
        a.rows(),
        analyzed,
        factored,
        solved,
        factors.factor_entries() as f64 / 1e6,
        norm2(&residual) / norm2(&r)
    );
    Ok(())
}

fn main() -> Result<(), SetupError> {
    println!(
        "{:<14} {:<8} {:>7} {:>9} {:>9} {:>9} {:>8} {:>10}",
        "kind", "backend", "n", "analyze s", "factor s", "solve s", "Mentries", "residual"
    );
    for size in std::env::args().skip(1).filter_map(|n| n.parse().ok()) {
        let lattice = Lattice::new([size; 3]);
        let matrices = [
            (Kind::Spd, lattice.stiffness(Support::Clamped)),
            (Kind::QuasiDefinite, lattice.saddle(Some(0.3), 1.0)),
            (Kind::General, lattice.saddle(None, 0.7)),
        ];
        for (kind, a) in &matrices {
            for choice in DirectChoice::BACKENDS {
                match report(choice, *kind, a) {
                    Err(SetupError::NotApplicable { .. } | SetupError::NotBuilt { .. }) => {}
                    outcome => outcome?,
                }
            }
        }
    }
    Ok(())
}
