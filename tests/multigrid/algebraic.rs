//! Claim: multigrid is a symmetric positive definite preconditioner of S_u with λ(M⁻¹S_u) in (0, 1] before its factor, the same
//! for any number of threads and any order of the unknowns, and it allocates nothing.

use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_operators::vector::dot;
use fracas_operators::{LinearOperator, Preconditioner, sparse::Csr};
use fracas_solvers::amg::{Amg, Coarsening};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::multigrid::{Cycle, MultigridInverse, Precision, Smoother};
use fracas_solvers::saddle::{
    AugmentationChoice, DofCoordinate, InnerChoice, RacpInverse, SaddleBlocks, SaddleOperator,
    schur,
};
use fracas_solvers::{SetupError, Silent};

fn blocks(scene: &str, overrides: &[&str]) -> SaddleBlocks {
    let scene = named(scene).unwrap().small_scene().unwrap();
    let body = scene.with_overrides(overrides).unwrap().build().unwrap();
    let blocks = body
        .saddle_blocks(Some(JumpStabilization::default()))
        .unwrap();
    let unit = blocks.traction_unit();
    blocks.into_traction_unit(unit)
}

/// S_u with C = local_h.
fn s_u(blocks: &SaddleBlocks) -> SparseMatrix<f64> {
    let direct = DirectChoice::default().solver().unwrap();
    let c = AugmentationChoice::LocalH
        .compute(blocks, &*direct)
        .unwrap()
        .matrix;
    schur::primal_schur(&blocks.a, &blocks.b1, &c).unwrap()
}

/// Small enough a coarsest level that every scene has several.
fn exact() -> Amg {
    Amg {
        precision: Precision::F64,
        coarsest: 60,
        ..Amg::default()
    }
}

fn variants() -> Vec<Amg> {
    let mut variants = Vec::new();
    for cycle in [Cycle::V, Cycle::W] {
        for smoother in [Smoother::GaussSeidel, Smoother::Chebyshev, Smoother::Fsai] {
            for coarsening in [Coarsening::SmoothedAggregation, Coarsening::Classical] {
                variants.push(Amg {
                    cycle,
                    smoother,
                    coarsening,
                    sweeps: if smoother == Smoother::Chebyshev {
                        2
                    } else {
                        1
                    },
                    ..exact()
                });
            }
        }
    }
    variants
}

#[test]
fn a_matrix_of_up_to_coarsest_unknowns_is_factorized_however_large_it_is() {
    let n = 30_300;
    let mut chain = Triplets::new((n, n));
    for i in 0..n as u32 {
        chain.add_triplet(i as usize, i as usize, 2.5);
        for j in [i.wrapping_sub(3), i + 3] {
            if (j as usize) < n {
                chain.add_triplet(i as usize, j as usize, -1.0);
            }
        }
    }
    let a: SparseMatrix<f64> = chain.to_csr();
    let coarsest = Amg {
        coarsest: n,
        over_correction: 1.0,
        ..exact()
    };
    let m = coarsest.build(&a, None).unwrap();
    assert_eq!(m.summary().levels.len(), 1);
    check_preconditioner("chain", &m, Some(&Csr::new(a)), 1e-9).unwrap();
}

#[test]
fn every_variant_is_a_symmetric_positive_map_and_no_eigenvalue_exceeds_one() {
    for scene in ["crossing", "floating", "layered"] {
        let blocks = blocks(scene, &[]);
        let s_u = s_u(&blocks);
        let operator = Csr::new(s_u.clone());
        for settings in variants() {
            let m = settings.build(&s_u, blocks.coordinates.as_deref()).unwrap();
            assert!(m.summary().levels.len() >= 2, "{scene}: {settings:?}");
            check_preconditioner(scene, &m, None, 0.0).unwrap();
            let n = m.size();
            let mut work = vec![f64::NAN; m.work_len()];
            let solve = |r: &[f64], work: &mut [f64]| {
                let mut z = vec![f64::NAN; n];
                m.solve(r, &mut z, work);
                z
            };
            for seed in 0..5 {
                let (x, y) = (probe::<f64>(n, seed), probe::<f64>(n, seed + 50));
                let (mx, my) = (solve(&x, &mut work), solve(&y, &mut work));
                let (left, right) = (dot(&x, &my), dot(&mx, &y));
                let size = (dot(&x, &mx) * dot(&y, &my)).sqrt();
                assert!(dot(&x, &mx) > 0.0, "{scene}: {settings:?} is not positive");
                assert!(
                    (left - right).abs() < 1e-9 * size,
                    "{scene}: {settings:?} is not symmetric"
                );
                // xᵀS M⁻¹ S x ≤ f · xᵀS x is λ(M⁻¹S) ≤ f
                let mut s_x = vec![0.0; n];
                operator.apply(&x, &mut s_x, &mut []);
                let image = solve(&s_x, &mut work);
                let quotient = dot(&s_x, &image) / dot(&x, &s_x);
                // Chebyshev and FSAI have estimated ends: a per cent
                assert!(
                    quotient < 1.01 * settings.over_correction,
                    "{scene}: {settings:?} {quotient}"
                );
            }
        }
    }
}

#[test]
fn one_and_two_threads_give_the_same_bits_and_f32_the_digits_of_f32() {
    let blocks = blocks(
        "crossing",
        &["mesh.x.cells=16", "mesh.y.cells=12", "mesh.z.cells=16"],
    );
    let s_u = s_u(&blocks);
    let build = |threads: usize, settings: &Amg| -> Vec<f64> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let m: MultigridInverse = settings.build(&s_u, blocks.coordinates.as_deref()).unwrap();
            let r = probe::<f64>(m.size(), 3);
            let mut z = vec![0.0; m.size()];
            m.solve(&r, &mut z, &mut vec![0.0; m.work_len()]);
            z
        })
    };
    for settings in [Amg::default(), exact()] {
        let [one, two] = [1, 2].map(|threads| build(threads, &settings));
        assert!(
            one.iter()
                .zip(&two)
                .all(|(a, b)| a.to_bits() == b.to_bits()),
            "{settings:?}"
        );
    }
    let single = build(
        1,
        &Amg {
            coarsest: 60,
            ..Amg::default()
        },
    );
    let double = build(1, &exact());
    let error: f64 = single
        .iter()
        .zip(&double)
        .map(|(a, b)| (a - b).powi(2))
        .sum();
    assert!(error.sqrt() < 1e-4 * dot(&double, &double).sqrt());
}

/// Iterations of GMRES on the saddle point with C = local_h.
fn iterations(blocks: &SaddleBlocks, settings: Amg) -> usize {
    let direct = DirectChoice::default().solver().unwrap();
    let c = AugmentationChoice::LocalH
        .compute(blocks, &*direct)
        .unwrap()
        .matrix;
    let s_u = InnerChoice::Amg(settings)
        .prepare(blocks, &c)
        .unwrap()
        .inverse;
    let m = RacpInverse::new(blocks.b1.clone(), c, s_u);
    let operator = SaddleOperator::new(blocks);
    let b = blocks.rhs();
    let system = System {
        operator: &operator,
        preconditioner: &m,
        rhs: &b,
    };
    let criteria = Criteria {
        relative_tolerance: 1e-8,
        max_iterations: 200,
    };
    let method = KrylovChoice::default().flexible_for(&m);
    let mut x = vec![0.0; b.len()];
    let report = method
        .method()
        .solve(&system, &criteria, &mut x, &mut Silent)
        .unwrap();
    assert_eq!(report.outcome, Outcome::Converged);
    report.iterations
}

#[test]
fn racp_converges_where_a_is_singular_contrasted_nearly_incompressible_or_flat() {
    // a fifth above what was found; thin soft layers (contrast 1000) keep C from being good there even with exact S_u
    let (sweeps, fsai) = (Smoother::GaussSeidel, Smoother::Fsai);
    let flat = [
        "mesh.z.from=-3 m",
        "mesh.z.to=3 m",
        "material.0.poisson=0.49",
    ];
    let flat = [&flat[..], &["fracture.0.z=[\"-2 m\", \"2 m\"]"]].concat();
    for (scene, overrides, smoother, most) in [
        ("floating", &[][..], sweeps, 22),
        ("crossing", &[], sweeps, 24),
        ("tee", &[], sweeps, 24),
        ("layered", &[], sweeps, 60),
        ("inclined", &[], sweeps, 36),
        ("incompressible", &[], fsai, 60),
        ("stretched", &[], sweeps, 60),
        ("stretched", &flat, fsai, 60),
    ] {
        let blocks = blocks(scene, overrides);
        let m = Amg::default().build(&blocks.a, blocks.coordinates.as_deref());
        // A alone is singular where a block of rock floats
        if let Ok(m) = m {
            assert_eq!(m.summary().smoothing.smoother, smoother, "{scene}");
        }
        let found = iterations(&blocks, Amg::default());
        assert!(found <= most, "{scene}: {found} iterations");
    }
}

#[test]
fn iterations_stay_when_the_mesh_is_refined() {
    let counts = [10, 20].map(|cells| {
        let refined = [
            format!("mesh.x.cells={cells}"),
            format!("mesh.y.cells={}", 4 * cells / 5),
            format!("mesh.z.cells={}", 4 * cells / 5),
        ];
        let overrides: Vec<&str> = refined.iter().map(String::as_str).collect();
        iterations(&blocks("analogue_b", &overrides), Amg::default())
    });
    assert!(counts[1] <= counts[0] + 3, "{counts:?}");
}

#[test]
fn the_order_of_the_unknowns_does_not_matter_to_the_quality() {
    let given = blocks("crossing", &[]);
    let n = given.n_u();
    // all x components, then all y, then all z, each backwards
    let place = given.coordinates.as_ref().unwrap();
    let mut order: Vec<usize> = (0..n).rev().collect();
    order.sort_by_key(|i| place[*i].component);
    let mut new = vec![0; n];
    order.iter().enumerate().for_each(|(k, i)| new[*i] = k);
    let permuted = |m: &SparseMatrix<f64>, columns: bool| {
        let mut triplets = Triplets::new((m.rows(), m.cols()));
        for (value, (i, j)) in m {
            let j = if columns { new[j as usize] } else { j as usize };
            triplets.add_triplet(new[i as usize], j, *value);
        }
        triplets.to_csr()
    };
    let coordinates: Vec<DofCoordinate> = order.iter().map(|i| place[*i]).collect();
    let shuffled = SaddleBlocks {
        a: permuted(&given.a, true),
        b1: permuted(&given.b1, false),
        rhs_u: order.iter().map(|i| given.rhs_u[*i]).collect(),
        coordinates: Some(coordinates),
        ..given.clone()
    };
    let [a, b] = [&given, &shuffled].map(|blocks| iterations(blocks, Amg::default()));
    assert!(a.abs_diff(b) <= 3, "{a} and {b} iterations");
}

#[test]
fn without_coordinates_the_constants_remain_and_are_named() {
    let mut given = blocks("crossing", &[]);
    given.coordinates = None;
    let s_u = s_u(&given);
    let m = exact().build(&s_u, None).unwrap();
    assert_eq!(m.summary().near_null_space, "constants (no coordinates)");
    assert!(iterations(&given, Amg::default()) <= 150);
}

#[test]
fn what_is_no_positive_matrix_is_refused_with_its_row() {
    let given = blocks("crossing", &[]);
    let coordinates = given.coordinates.as_deref();
    let altered = |row: usize, value: f64| {
        let mut a = given.a.clone();
        *a.get_mut(row, row).unwrap() = value;
        Amg::default().build(&a, coordinates).unwrap_err()
    };
    assert!(matches!(
        altered(6, -1.0),
        SetupError::BadDiagonal { row: 7, .. }
    ));
    assert!(matches!(
        altered(6, 0.0),
        SetupError::BadDiagonal { row: 7, .. }
    ));
    assert!(matches!(
        altered(8, f64::NAN),
        SetupError::NotFinite {
            row: 9,
            column: 9,
            ..
        }
    ));
    // blocks that only fractures hold: A itself is singular
    let floating = blocks("floating", &[]);
    let error = exact()
        .build(&floating.a, floating.coordinates.as_deref())
        .unwrap_err();
    let singular = matches!(
        error,
        SetupError::Singular { .. } | SetupError::NotPositiveDefinite { .. }
    );
    assert!(singular, "{error}");
}
