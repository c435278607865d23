//! An inner solver of one's own in a contact run: eight damped Jacobi steps.
//!
//! `cargo run --release --example own_inner`

use fracas::nonlinear::Simulation;
use fracas::scene::named;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::vector::axpy;
use fracas_operators::{LinearOperator, Preconditioner, Properties};
use fracas_solvers::saddle::{InnerChoice, InnerSolver};
use fracas_solvers::{DofCoordinate, Named, SetupError, Silent};

/// Steps of `z ← z + ω D⁻¹(r − S z)`, ω = 1/‖D⁻¹S‖_∞: linear, symmetric, positive definite.
#[derive(Debug)]
struct Richardson {
    steps: usize,
}

struct Inverse {
    s: Csr<f64>,
    weights: Vec<f64>,
    steps: usize,
}

impl Named for Richardson {
    fn name(&self) -> &'static str {
        "richardson"
    }
}

impl InnerSolver for Richardson {
    fn of_matrix(
        &self,
        s: &SparseMatrix<f64>,
        _: Option<&[DofCoordinate]>,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let diagonal = |i| s.get(i, i).copied().unwrap_or(0.0);
        let rows = s.outer_iterator().enumerate();
        let sums =
            rows.map(|(i, row)| row.data().iter().map(|v| v.abs()).sum::<f64>() / diagonal(i));
        let largest = sums.fold(0.0, f64::max);
        Ok(Box::new(Inverse {
            weights: (0..s.rows())
                .map(|i| 1.0 / (largest * diagonal(i)))
                .collect(),
            s: Csr::new(s.clone()),
            steps: self.steps,
        }))
    }
}

impl Preconditioner<f64> for Inverse {
    fn size(&self) -> usize {
        self.weights.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let work = &mut work[..r.len()];
        z.fill(0.0);
        for _ in 0..self.steps {
            work.copy_from_slice(r);
            self.s.apply_add(-1.0, z, work, &mut []);
            work.iter_mut()
                .zip(&self.weights)
                .for_each(|(w, d)| *w *= d);
            axpy(1.0, work, z);
        }
    }

    fn work_len(&self) -> usize {
        self.weights.len()
    }

    fn flops(&self) -> u64 {
        self.steps as u64 * (self.s.flops() + 3 * self.weights.len() as u64)
    }

    fn properties(&self) -> Properties {
        Properties::LOCAL
    }
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    static MINE: Richardson = Richardson { steps: 8 };
    InnerChoice::register(&MINE)?;
    let scene = named("cycle")
        .ok_or("a scene of the gallery")?
        .small_scene()?;
    let mut slips = Vec::new();
    for inner in ["richardson", "exact"] {
        let own = format!("solver.racp.inner={inner}");
        let body = scene.with_overrides(&[own])?.build()?;
        let mut simulation = Simulation::new(&body)?;
        let mut krylov = 0;
        let state = simulation.run(&mut Silent, |_, _, done| krylov += done.record.lin_it)?;
        let slip = simulation.face_fields(&state).slip;
        let largest = slip.into_iter().fold(0.0, f64::max);
        println!("{inner}: {krylov} Krylov iterations, largest slip {largest:.9} m");
        slips.push(largest);
    }
    assert!((slips[0] - slips[1]).abs() < 1e-6 * slips[1]);
    Ok(())
}
