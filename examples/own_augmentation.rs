//! A C of one's own that couples faces, tridiagonal along fractures: in the spectrum laboratory and in a contact run.
//!
//! `cargo run --release --example own_augmentation`

use fracas::nonlinear::Simulation;
use fracas::scene::named;
use fracas_operators::sparse::Triplets;
use fracas_solvers::direct::DirectSolver;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, AugmentationRule, SaddleBlocks,
};
use fracas_solvers::spectrum::{SpectrumRequest, analyse};
use fracas_solvers::{Named, SetupError, Silent};

/// `C = C_local + ½ tri(H)`: what H couples in a face, and in the face after it.
#[derive(Debug)]
struct Tridiagonal;

impl Named for Tridiagonal {
    fn name(&self) -> &'static str {
        "tridiagonal"
    }
}

impl AugmentationRule for Tridiagonal {
    fn is_local(&self) -> bool {
        false
    }

    fn compute(
        &self,
        blocks: &SaddleBlocks,
        direct: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError> {
        let local = AugmentationChoice::Local.compute(blocks, direct)?.matrix;
        let mut near = Triplets::new((blocks.n_t(), blocks.n_t()));
        for (value, (i, j)) in blocks.h.iter().flatten() {
            if i == j || i.abs_diff(j) == 3 {
                near.add_triplet(i as usize, j as usize, 0.5 * value);
            }
        }
        AugmentationMatrix::from_sparse(&local.entries() + &near.to_csr())
    }
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mine = AugmentationChoice::register(&Tridiagonal)?;
    let scene = named("cycle")
        .ok_or("a scene of the gallery")?
        .small_scene()?;
    // the laboratory
    let blocks = scene.build()?.saddle_blocks(Some(Default::default()))?;
    for augmentation in [mine, AugmentationChoice::LocalH] {
        let request = SpectrumRequest {
            augmentation,
            ..SpectrumRequest::default()
        };
        let report = analyse(&blocks, &request, &mut Silent)?;
        let (low, high) = (report.real_min, report.real_max);
        println!(
            "{augmentation}: λ from {low:?} to {high:?}, {}",
            report.verdict
        );
        assert_eq!(report.contained, Some(true));
    }
    // a run, by its name
    let body = scene
        .with_overrides(&["solver.racp.augmentation=tridiagonal"])?
        .build()?;
    let mut simulation = Simulation::new(&body)?;
    simulation.run(&mut Silent, |_, _, done| {
        let (step, krylov) = (done.record.step, done.record.lin_it);
        println!("step {step}: {krylov} Krylov iterations");
    })?;
    Ok(())
}
