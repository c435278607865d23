//! Claim: a hierarchy for other values on the pattern of a first one is that of its own set-up where the values are the same,
//! as good a preconditioner where they are not, and refuses what the pattern does not hold.

use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::amg::{Amg, Coarsening};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::multigrid::{Precision, Smoother};
use fracas_solvers::saddle::{AugmentationChoice, SaddleBlocks};
use fracas_solvers::{SetupError, Silent};

fn blocks(scene: &str) -> SaddleBlocks {
    let scene = named(scene).unwrap().small_scene().unwrap();
    let body = scene.build().unwrap();
    let blocks = body
        .saddle_blocks(Some(JumpStabilization::default()))
        .unwrap();
    let unit = blocks.traction_unit();
    blocks.into_traction_unit(unit)
}

/// F of `F Fᵀ = B C⁻¹ Bᵀ` with C = local_h.
fn factor(blocks: &SaddleBlocks) -> SparseMatrix<f64> {
    let direct = DirectChoice::default().solver().unwrap();
    let c = AugmentationChoice::LocalH.compute(blocks, &*direct);
    &blocks.b1 * &c.unwrap().matrix.inverse_root().unwrap()
}

/// Columns multiplied by `by(column)`.
fn scaled(f: &SparseMatrix<f64>, by: impl Fn(usize) -> f64) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((f.rows(), f.cols()));
    for (value, (i, j)) in f.iter() {
        triplets.add_triplet(i as usize, j as usize, value * by(j as usize));
    }
    triplets.to_csr()
}

/// The three columns of every face turned into two that are kept and one of almost nothing: slip at an angle.
fn slipping(f: &SparseMatrix<f64>) -> SparseMatrix<f64> {
    let (sin, cos) = 0.6f64.sin_cos();
    let turn = [
        [1.0, 0.0, 0.0],
        [0.0, cos, 1e-4 * sin],
        [0.0, -sin, 1e-4 * cos],
    ];
    let mut triplets = Triplets::new((f.rows(), f.cols()));
    for (value, (i, j)) in f.iter() {
        let (face, row) = (j as usize / 3, turn[j as usize % 3]);
        for (k, by) in row.into_iter().enumerate() {
            triplets.add_triplet(i as usize, 3 * face + k, value * by);
        }
    }
    triplets.to_csr()
}

fn settings() -> [Amg; 4] {
    let small = Amg {
        coarsest: 60,
        ..Amg::default()
    };
    let double = Amg {
        precision: Precision::F64,
        ..small
    };
    let classical = Amg {
        coarsening: Coarsening::Classical,
        ..double
    };
    let fsai = Amg {
        smoother: Smoother::Fsai,
        ..small
    };
    [small, double, classical, fsai]
}

fn solved(m: &impl Preconditioner<f64>) -> Vec<u64> {
    let r = probe::<f64>(m.size(), 3);
    let mut z = vec![0.0; m.size()];
    m.solve(&r, &mut z, &mut vec![0.0; m.work_len()]);
    z.into_iter().map(f64::to_bits).collect()
}

#[test]
fn the_same_values_give_the_same_bits() {
    for scene in ["crossing", "floating"] {
        let blocks = blocks(scene);
        let f = factor(&blocks);
        for settings in settings() {
            for coordinates in [blocks.coordinates.as_deref(), None] {
                let (first, plan) = settings.plan(&blocks.a, Some(&f), coordinates).unwrap();
                let built = settings.build_augmented(&blocks.a, &f, coordinates);
                let again = plan.refresh(&blocks.a, Some(&f)).unwrap();
                assert!(first.summary().levels.len() >= 2, "{scene}: {settings:?}");
                assert_eq!(solved(&first), solved(&built.unwrap()), "{scene}");
                assert_eq!(solved(&first), solved(&again), "{scene}: {settings:?}");
                assert_eq!(first.summary(), again.summary(), "{scene}: {settings:?}");
                assert!(plan.bytes() > 0);
            }
        }
    }
}

/// Iterations of conjugate gradients on `A + F Fᵀ`.
fn iterations(s_u: &SparseMatrix<f64>, m: &dyn Preconditioner<f64>) -> usize {
    let operator = Csr::new(s_u.clone());
    let rhs = probe::<f64>(operator.shape().rows, 7);
    let system = System {
        operator: &operator,
        preconditioner: m,
        rhs: &rhs,
    };
    let criteria = Criteria {
        relative_tolerance: 1e-8,
        max_iterations: 300,
    };
    let mut x = vec![0.0; rhs.len()];
    let krylov = KrylovChoice::Cg(Default::default());
    let report = krylov
        .method()
        .solve(&system, &criteria, &mut x, &mut Silent)
        .unwrap();
    assert_eq!(report.outcome, Outcome::Converged);
    report.iterations
}

#[test]
fn other_values_cost_few_iterations_more_than_their_own_set_up() {
    for scene in ["crossing", "floating", "layered"] {
        let blocks = blocks(scene);
        let f = factor(&blocks);
        let faces = f.cols() / 3;
        let held = scene != "floating";
        // a third of the faces open, one component of another third without a spring
        let some = |j: usize| match (3 * (j / 3) / faces, j % 3) {
            (1, _) if held => 0.0,
            (2, 1) => 0.0,
            _ => 1.0,
        };
        let changes = [
            ("softer", scaled(&f, |_| 0.2)),
            ("stiffer", scaled(&f, |_| 5.0)),
            ("some open", scaled(&f, some)),
            ("slip", slipping(&f)),
            ("all open", scaled(&f, |_| if held { 1e-4 } else { 1.0 })),
        ];
        for settings in settings() {
            let coordinates = blocks.coordinates.as_deref();
            let (_, plan) = settings.plan(&blocks.a, Some(&f), coordinates).unwrap();
            for (name, changed) in &changes {
                let refreshed = plan.refresh(&blocks.a, Some(changed)).unwrap();
                if settings.precision == Precision::F64 {
                    check_preconditioner(scene, &refreshed, None, 0.0).unwrap();
                }
                let own = settings.build_augmented(&blocks.a, changed, coordinates);
                let s_u = &blocks.a + &(changed * &changed.transpose_view().to_csr());
                let [kept, new] = [&refreshed, &own.unwrap()].map(|m| iterations(&s_u.to_csr(), m));
                assert!(
                    kept <= new + 3,
                    "{scene}, {name}: {kept} against {new}, {settings:?}"
                );
            }
        }
    }
}

#[test]
fn what_the_pattern_does_not_hold_is_refused_with_its_row() {
    let blocks = blocks("crossing");
    let coordinates = blocks.coordinates.as_deref();
    let (_, plan) = Amg::default().plan(&blocks.a, None, coordinates).unwrap();
    let n = blocks.a.rows();
    let mut triplets = Triplets::new((n, n));
    for (value, (i, j)) in blocks.a.iter() {
        triplets.add_triplet(i as usize, j as usize, *value);
    }
    triplets.add_triplet(4, n - 1, 1.0);
    triplets.add_triplet(n - 1, 4, 1.0);
    let strange: SparseMatrix<f64> = triplets.to_csr();
    let error = plan.refresh(&strange, None).unwrap_err();
    assert!(matches!(error, SetupError::NotApplicable { .. }));
    assert!(error.to_string().contains("row 5 "), "{error}");
    let smaller = SparseMatrix::eye(n - 3);
    let error = plan.refresh(&smaller, None).unwrap_err().to_string();
    assert!(error.contains(&format!("{n} unknowns")), "{error}");
}
