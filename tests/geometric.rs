//! Claim: geometric multigrid is a symmetric positive definite preconditioner of S_u with λ(M⁻¹S_u) in (0, 1], the same for
//! any number of threads; RACP around it needs few iterations wherever fractures run, and no more on finer meshes.
#![allow(clippy::unwrap_used)]

use fracas::contact::JumpStabilization;
use fracas::multigrid::{Geometric, GeometricError, GeometricInverse};
use fracas::scene::{Body, named};
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::vector::dot;
use fracas_operators::{LinearOperator, Preconditioner, sparse::Csr};
use fracas_solvers::Silent;
use fracas_solvers::amg::Precision;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::multigrid::Cycle;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, RacpInverse, SaddleBlocks, SaddleOperator, schur,
};

struct Sample {
    body: Body,
    blocks: SaddleBlocks,
    /// C of the blocks, and of B in m².
    c: [AugmentationMatrix; 2],
}

fn sample(scene: &str, overrides: &[&str], augmentation: AugmentationChoice) -> Sample {
    let scene = named(scene).unwrap().small_scene().unwrap();
    let body = scene.with_overrides(overrides).unwrap().build().unwrap();
    let stabilization = Some(JumpStabilization::default());
    let blocks = body.saddle_blocks(stabilization).unwrap();
    let unit = blocks.traction_unit();
    let direct = DirectChoice::default().solver().unwrap();
    let c = |blocks: &SaddleBlocks| augmentation.compute(blocks, &*direct).unwrap().matrix;
    let in_si = c(&blocks);
    let blocks = blocks.into_traction_unit(unit);
    Sample {
        c: [c(&blocks), in_si],
        body,
        blocks,
    }
}

impl Sample {
    fn build(&self, settings: Geometric) -> GeometricInverse {
        let system = self.body.stick_system(Some(JumpStabilization::default()));
        settings.build(&system, &self.c[1]).unwrap()
    }

    /// Iterations of GMRES around RACP.
    fn iterations(&self, settings: Geometric) -> usize {
        let m = RacpInverse::new(
            self.blocks.b1.clone(),
            self.c[0].clone(),
            self.build(settings),
        );
        let operator = SaddleOperator::new(&self.blocks);
        let b = self.blocks.rhs();
        let system = System {
            operator: &operator,
            preconditioner: &m,
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-8,
            max_iterations: 100,
        };
        let method = KrylovChoice::default().flexible_for(&m).method();
        let mut x = vec![0.0; b.len()];
        let report = method
            .solve(&system, &criteria, &mut x, &mut Silent)
            .unwrap();
        assert_eq!(report.outcome, Outcome::Converged);
        report.iterations
    }
}

/// Small enough a bottom that every scene has several levels.
fn exact() -> Geometric {
    Geometric {
        precision: Precision::F64,
        coarsest: 60,
        ..Geometric::default()
    }
}

#[test]
fn it_is_a_symmetric_positive_map_and_no_eigenvalue_exceeds_one() {
    for scene in ["crossing", "floating", "inclined", "layered"] {
        for augmentation in [AugmentationChoice::LocalH, AugmentationChoice::FaceBlock] {
            let sample = sample(scene, &[], augmentation);
            let s_u = schur::primal_schur(&sample.blocks.a, &sample.blocks.b1, &sample.c[0]);
            let operator = Csr::new(s_u.unwrap());
            for settings in [
                exact(),
                Geometric {
                    cycle: Cycle::W,
                    degree: 2,
                    ..exact()
                },
            ] {
                let m = sample.build(settings);
                assert!(m.summary().levels.len() >= 3, "{scene}");
                check_preconditioner(scene, &m, None, 0.0).unwrap();
                let n = m.size();
                let mut work = vec![f64::NAN; m.work_len()];
                let mut solve = |r: &[f64]| {
                    let mut z = vec![f64::NAN; n];
                    m.solve(r, &mut z, &mut work);
                    z
                };
                for seed in 0..5 {
                    let (x, y) = (probe::<f64>(n, seed), probe::<f64>(n, seed + 50));
                    let (mx, my) = (solve(&x), solve(&y));
                    let (left, right) = (dot(&x, &my), dot(&mx, &y));
                    let size = (dot(&x, &mx) * dot(&y, &my)).sqrt();
                    assert!(dot(&x, &mx) > 0.0, "{scene}: not positive");
                    assert!((left - right).abs() < 1e-9 * size, "{scene}: not symmetric");
                    // xᵀS M⁻¹ S x ≤ xᵀS x is λ(M⁻¹S) ≤ 1
                    let mut s_x = vec![0.0; n];
                    operator.apply(&x, &mut s_x, &mut []);
                    let quotient = dot(&s_x, &solve(&s_x)) / dot(&x, &s_x);
                    assert!(
                        quotient < 1.01 * settings.over_correction,
                        "{scene}: {quotient}"
                    );
                }
            }
        }
    }
}

#[test]
fn one_and_two_threads_give_the_same_bits_and_f32_the_digits_of_f32() {
    let cells = ["mesh.x.cells=16", "mesh.y.cells=12", "mesh.z.cells=16"];
    for scene in ["crossing", "inclined"] {
        let sample = sample(scene, &cells, AugmentationChoice::LocalH);
        let build = |threads: usize, settings: Geometric| -> Vec<f64> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let m = sample.build(settings);
                let r = probe::<f64>(m.size(), 3);
                let mut z = vec![0.0; m.size()];
                m.solve(&r, &mut z, &mut vec![0.0; m.work_len()]);
                z
            })
        };
        let single = Geometric {
            precision: Precision::F32,
            ..exact()
        };
        for settings in [single, exact()] {
            let [one, two] = [1, 2].map(|threads| build(threads, settings));
            assert!(
                one.iter()
                    .zip(&two)
                    .all(|(a, b)| a.to_bits() == b.to_bits())
            );
        }
        let (single, double) = (build(1, single), build(1, exact()));
        let square = |(a, b): (&f64, &f64)| (a - b).powi(2);
        let error: f64 = single.iter().zip(&double).map(square).sum();
        assert!(
            error.sqrt() < 1e-4 * dot(&double, &double).sqrt(),
            "{scene}"
        );
    }
}
