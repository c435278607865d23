use super::*;
use crate::elastic_sample::{clamped_box, cube};
use crate::krylov::oracle::cg_iterations;
use crate::smoothers::Jacobi;
use crate::{Prepare, SetupError};
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::dot;
use fracas_operators::{Dense, LinearOperator, Preconditioner, Shape};

/// Sparse SPD without structure: strong and weak couplings, scales from 1 to 100.
fn irregular(n: usize) -> SparseMatrix<f64> {
    let noise: Vec<f64> = probe(4 * n, 5);
    let mut triplets = Triplets::new((n, n));
    let mut sums = vec![0.1; n];
    for (k, value) in noise.iter().enumerate() {
        let (i, j) = (k % n, (k * k + 7 * k + k / n) % n);
        if i != j {
            triplets.add_triplet(i, j, *value);
            triplets.add_triplet(j, i, *value);
            sums[i] += value.abs();
            sums[j] += value.abs();
        }
    }
    for (i, sum) in sums.iter().enumerate() {
        triplets.add_triplet(i, i, *sum);
    }
    let a: SparseMatrix<f64> = triplets.to_csr();
    let scale = |i: usize| 10f64.powf((i % 5) as f64 / 4.0);
    scaled(&a, &scale)
}

/// `D A D`.
fn scaled(a: &SparseMatrix<f64>, scale: &dyn Fn(usize) -> f64) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((a.rows(), a.cols()));
    for (value, (i, j)) in a.iter() {
        triplets.add_triplet(
            i as usize,
            j as usize,
            scale(i as usize) * value * scale(j as usize),
        );
    }
    triplets.to_csr()
}

fn samples() -> Vec<SparseMatrix<f64>> {
    let layered = |cell: [usize; 3]| if cell[2].is_multiple_of(2) { 1.0 } else { 50.0 };
    vec![
        irregular(60),
        cube(2).0,
        clamped_box([3, 2, 2], [1.0, 0.3, 2.0], layered).0,
    ]
}

fn choices() -> Vec<Fsai> {
    let filtered = Static {
        power: 2,
        filter: 0.05,
    };
    vec![
        Fsai::default(),
        Fsai::adaptive(6, 1, 0.0),
        Fsai::adaptive(4, 3, 1e-2),
        Fsai::of_power(0),
        Fsai::of_power(1),
        Fsai::of_power(2),
        Fsai {
            kind: FsaiKind::Static(filtered),
        },
    ]
}

fn dense(a: &SparseMatrix<f64>) -> Dense<f64> {
    Dense::of_operator(&Csr::new(a.clone()))
}

/// `G A Gᵀ`, entry by entry.
fn preconditioned(g: &Dense<f64>, a: &Dense<f64>) -> Dense<f64> {
    let n = a.shape().rows;
    let ga = Dense::from_fn(a.shape(), |i, j| {
        (0..n).map(|k| g.entry(i, k) * a.entry(k, j)).sum::<f64>()
    });
    Dense::from_fn(a.shape(), |i, j| {
        (0..n).map(|k| ga.entry(i, k) * g.entry(j, k)).sum::<f64>()
    })
}

fn pattern(g: &SparseMatrix<f64>, i: usize) -> Vec<usize> {
    g.outer_view(i).map_or(vec![], |row| {
        row.indices().iter().map(|j| *j as usize).collect()
    })
}

fn faer_inverse(n: usize, entry: impl Fn(usize, usize) -> f64) -> faer::Mat<f64> {
    use faer::linalg::solvers::DenseSolveCore;
    faer::Mat::from_fn(n, n, entry).partial_piv_lu().inverse()
}

/// Row i of G by its definition: `A[P,P]⁻¹ e_i / √(e_iᵀA[P,P]⁻¹e_i)`.
fn definition(a: &Dense<f64>, p: &[usize]) -> Vec<f64> {
    let inverse = faer_inverse(p.len(), |i, j| a.entry(p[i], p[j]));
    let last = p.len() - 1;
    (0..p.len())
        .map(|k| inverse[(k, last)] / inverse[(last, last)].sqrt())
        .collect()
}

#[test]
fn obeys_the_laws_of_a_preconditioner() {
    for a in samples() {
        for settings in choices() {
            let m = settings.prepare(&a).unwrap();
            check_preconditioner("fsai", &m, None, 0.0).unwrap();
        }
    }
}

#[test]
fn g_is_lower_triangular_and_the_diagonal_of_g_a_gt_is_one() {
    for a in samples() {
        for settings in choices() {
            let g = settings.build(&a).unwrap().g().matrix().clone();
            let product = preconditioned(&dense(&g), &dense(&a));
            for i in 0..a.rows() {
                assert_eq!(pattern(&g, i).last(), Some(&i));
                assert!((product.entry(i, i) - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn every_row_is_the_solution_on_its_pattern() {
    for a in samples() {
        let oracle = dense(&a);
        for settings in choices() {
            let g = settings.build(&a).unwrap().g().matrix().clone();
            for i in 0..a.rows() {
                let p = pattern(&g, i);
                for (j, exact) in p.iter().zip(definition(&oracle, &p)) {
                    let found = g.get(i, *j).copied().unwrap_or(0.0);
                    assert!((found - exact).abs() < 1e-11 * exact.abs().max(1e-2));
                }
            }
        }
    }
}

/// On the pattern of A, `D G` with `D = diag(L)⁻¹…` makes `‖I − G L‖_F` least, `A = LLᵀ`, up to the scaling of rows.
#[test]
fn a_static_row_minimises_the_frobenius_norm_of_i_minus_g_l() {
    let a = irregular(40);
    let oracle = dense(&a);
    let llt = faer::Mat::from_fn(40, 40, |i, j| oracle.entry(i, j));
    let l = llt.llt(faer::Side::Lower).unwrap().L().to_owned();
    let g = Fsai::of_power(1).build(&a).unwrap().g().matrix().clone();
    for i in 0..40 {
        let p = pattern(&g, i);
        // min ‖e_iᵀ − xᵀ L[P, :]‖: the normal equations L[P,:]L[P,:]ᵀ x = L[P, i]
        let gram = faer_inverse(p.len(), |r, s| {
            (0..40).map(|k| l[(p[r], k)] * l[(p[s], k)]).sum()
        });
        let best: Vec<f64> = (0..p.len())
            .map(|r| (0..p.len()).map(|s| gram[(r, s)] * l[(p[s], i)]).sum())
            .collect();
        // G's rows are scaled to diag(GAGᵀ) = 1
        let scale = g.get(i, i).copied().unwrap() / best[p.len() - 1];
        for (j, x) in p.iter().zip(&best) {
            assert!((g.get(i, *j).copied().unwrap() - scale * x).abs() < 1e-11);
        }
    }
}

#[test]
fn the_full_pattern_gives_the_inverse() {
    let a = irregular(40);
    let complete = Fsai::adaptive(40, 1, 0.0);
    for settings in [Fsai::of_power(40), complete] {
        let m = settings.build(&a).unwrap();
        check_preconditioner(
            "fsai",
            &m,
            Some(&dense(&a) as &dyn LinearOperator<f64>),
            1e-11,
        )
        .unwrap();
    }
}

/// `tr(GAGᵀ)/n / det(GAGᵀ)^{1/n}`.
fn kaporin(g: &SparseMatrix<f64>, a: &SparseMatrix<f64>) -> f64 {
    let n = a.rows();
    let product = preconditioned(&dense(g), &dense(a));
    let matrix = faer::Mat::from_fn(n, n, |i, j| product.entry(i, j));
    let factor = matrix.llt(faer::Side::Lower).unwrap().L().to_owned();
    let log_det: f64 = (0..n).map(|i| 2.0 * factor[(i, i)].ln()).sum();
    let trace: f64 = (0..n).map(|i| product.entry(i, i)).sum();
    trace / n as f64 / (log_det / n as f64).exp()
}

#[test]
fn the_kaporin_number_falls_with_every_step_and_ends_at_one() {
    for a in samples() {
        let number = |steps| {
            kaporin(
                Fsai::adaptive(steps, 1, 0.0)
                    .build(&a)
                    .unwrap()
                    .g()
                    .matrix(),
                &a,
            )
        };
        let numbers: Vec<f64> = (0..8).map(number).collect();
        assert!(
            numbers.windows(2).all(|k| k[1] < k[0] && k[1] > 1.0),
            "{numbers:?}"
        );
        assert!((number(a.rows()) - 1.0).abs() < 1e-10);
    }
}

#[test]
fn growth_takes_the_steepest_columns_of_the_scaled_matrix() {
    for a in samples() {
        let oracle = dense(&a);
        let g = [2, 3].map(|k| {
            Fsai::adaptive(k, 1, 0.0)
                .build(&a)
                .unwrap()
                .g()
                .matrix()
                .clone()
        });
        for i in 3..a.rows() {
            let [before, after] = [pattern(&g[0], i), pattern(&g[1], i)];
            let row = definition(&oracle, &before);
            let last = row[row.len() - 1];
            let slope = |j: usize| {
                let product: f64 = before
                    .iter()
                    .zip(&row)
                    .map(|(l, y)| y * oracle.entry(*l, j))
                    .sum();
                (product / last).powi(2) / oracle.entry(j, j)
            };
            let steepest = (0..i)
                .filter(|j| !before.contains(j))
                .map(slope)
                .fold(0.0, f64::max);
            let taken: Vec<usize> = after.into_iter().filter(|j| !before.contains(j)).collect();
            if steepest > 1e-12 * oracle.entry(i, i) {
                assert_eq!(taken.len(), 1);
                assert!(slope(taken[0]) > (1.0 - 1e-8) * steepest);
            }
        }
    }
}

#[test]
fn the_pattern_does_not_depend_on_the_units_of_the_unknowns() {
    let a = irregular(60);
    // powers of two: no rounding
    let units = scaled(&a, &|i| 2f64.powi(i as i32 % 7 - 3));
    for settings in choices() {
        let patterns =
            [&a, &units].map(|a| settings.build(a).unwrap().g().matrix().indices().to_vec());
        assert_eq!(patterns[0], patterns[1]);
    }
}

#[test]
fn epsilon_stops_a_row_that_gains_little() {
    let a = cube(3).0;
    let entries = |epsilon| Fsai::adaptive(30, 1, epsilon).build(&a).unwrap().g().nnz();
    assert!(entries(1e-1) < entries(1e-2) && entries(1e-2) < entries(0.0));
    assert_eq!(entries(2.0), 2 * a.rows() - 1);
}

#[test]
fn a_filter_takes_weak_entries_out_of_the_pattern() {
    let a = irregular(60);
    let nnz = |filter| {
        let kind = FsaiKind::Static(Static { power: 1, filter });
        Fsai { kind }.build(&a).unwrap().g().nnz()
    };
    let strong = |limit: f64| {
        let entry = |i: u32, j: u32| a.get(i as usize, j as usize).copied().unwrap_or(0.0);
        let kept =
            |value: f64, i: u32, j: u32| value.abs() >= limit * (entry(i, i) * entry(j, j)).sqrt();
        a.iter()
            .filter(|(value, (i, j))| j <= i && kept(**value, *i, *j))
            .count()
    };
    assert_eq!(nnz(0.1), strong(0.1));
    assert!(nnz(0.1) < nnz(0.0));
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    let a = cube(7).0;
    for settings in [Fsai::adaptive(8, 2, 1e-3), Fsai::of_power(1)] {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let m = settings.build(&a).unwrap();
                let r: Vec<f64> = probe(a.rows(), 3);
                let (mut z, mut work) = (vec![0.0; r.len()], vec![0.0; m.work_len()]);
                m.solve(&r, &mut z, &mut work);
                let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let g = m.g().matrix();
                (g.indices().to_vec(), bits(g.data()), bits(&z))
            })
        };
        assert!(run(1) == run(2));
    }
}

#[test]
fn conjugate_gradients_need_fewer_iterations_than_with_jacobi() {
    let a = cube(8).0;
    let count = |settings: &dyn Prepare<SparseMatrix<f64>, f64>| {
        let rhs: Vec<f64> = probe(a.rows(), 9);
        cg_iterations(&a, &settings.prepare(&a).unwrap(), &rhs, 1e-8)
    };
    let jacobi = count(&Jacobi::default());
    let counts = [
        count(&Fsai::adaptive(5, 1, 0.0)),
        count(&Fsai::default()),
        count(&Fsai::of_power(1)),
        count(&Fsai::of_power(2)),
    ];
    println!("jacobi {jacobi}, adaptive 5 and 30, static 1 and 2: {counts:?}");
    assert!(counts.iter().all(|count| 5 * count < 4 * jacobi));
    assert!(counts[1] < counts[0] && counts[3] < counts[2] && 2 * counts[1] < jacobi);
}

#[test]
fn symmetric_and_positive_definite() {
    for settings in choices() {
        let a = cube(2).0;
        let m = Dense::of_preconditioner(&settings.build(&a).unwrap());
        let n = a.rows();
        let symmetric = |i, j| (m.entry(i, j) - m.entry(j, i)).abs() < 1e-14 * m.max_abs();
        assert!((0..n).all(|i| (0..n).all(|j| symmetric(i, j))));
        for seed in 1..10 {
            let r: Vec<f64> = probe(n, seed);
            let mut z = vec![0.0; n];
            m.apply(&r, &mut z, &mut []);
            assert!(dot(&r, &z) > 0.0);
        }
    }
}

#[test]
fn names_the_row_that_is_wrong() {
    let sparse = |n: usize, entries: &[(usize, usize, f64)]| -> SparseMatrix<f64> {
        let mut triplets = Triplets::new((n, n));
        entries
            .iter()
            .for_each(|(i, j, v)| triplets.add_triplet(*i, *j, *v));
        triplets.to_csr()
    };
    let both = [Fsai::default(), Fsai::of_power(1)];
    let error = |a: &SparseMatrix<f64>, settings: Fsai| settings.build(a).unwrap_err();
    for settings in both {
        let missing = sparse(3, &[(0, 0, 1.0), (2, 2, 1.0)]);
        assert!(matches!(
            error(&missing, settings),
            SetupError::BadDiagonal { row: 2, .. }
        ));
        let negative = sparse(2, &[(0, 0, 1.0), (1, 1, -2.0)]);
        assert!(matches!(
            error(&negative, settings),
            SetupError::BadDiagonal { row: 2, .. }
        ));
        let nan = sparse(2, &[(0, 0, 1.0), (0, 1, f64::NAN), (1, 1, 1.0)]);
        assert!(matches!(
            error(&nan, settings),
            SetupError::NotFinite {
                row: 1,
                column: 2,
                ..
            }
        ));
        // the second row of [1 2; 2 1] and of the singular [1 1; 1 1]
        for off in [2.0, 1.0] {
            let block = sparse(
                3,
                &[
                    (0, 0, 1.0),
                    (1, 1, 1.0),
                    (2, 2, 1.0),
                    (0, 1, off),
                    (1, 0, off),
                ],
            );
            assert!(matches!(
                error(&block, settings),
                SetupError::NotPositiveDefinite { row: 2, .. }
            ));
        }
        let rectangle = SparseMatrix::zero((2, 3));
        assert!(matches!(
            error(&rectangle, settings),
            SetupError::Shape {
                found: Shape { rows: 2, cols: 3 },
                ..
            }
        ));
    }
}

#[test]
fn settings_round_trip_and_default() {
    let json = r#"{"kind":{"adaptive":{"steps":10}}}"#;
    let read: Fsai = serde_json::from_str(json).unwrap();
    assert_eq!(read, Fsai::adaptive(10, 1, 1e-3));
    let written = serde_json::to_string(&Fsai::of_power(2)).unwrap();
    assert_eq!(
        serde_json::from_str::<Fsai>(&written).unwrap(),
        Fsai::of_power(2)
    );
    assert!(serde_json::from_str::<Fsai>(r#"{"kind":{"static":{"powr":2}}}"#).is_err());
}

#[test]
fn damping_makes_the_smoother_a_contraction() {
    for a in samples() {
        let oracle = dense(&a);
        for settings in choices() {
            let m = settings.build(&a).unwrap();
            let operator = Csr::new(a.clone());
            let (omega, damped) = (m.damping(&operator).unwrap(), m.damped(&operator).unwrap());
            let product = preconditioned(&dense(damped.g().matrix()), &oracle);
            let n = a.rows();
            let product = faer::Mat::from_fn(n, n, |i, j| product.entry(i, j));
            let largest = product.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[n - 1];
            assert!(largest < 1.95, "{largest}");
            assert!(omega == 1.0 || largest > 1.85, "{largest} {omega}");
        }
    }
}

#[test]
fn in_single_precision_it_is_the_same_map_up_to_rounding() {
    let a = cube(3).0;
    let m = Fsai::default().build(&a).unwrap();
    let single = m.cast::<f32>();
    check_preconditioner("fsai f32", &single, None, 0.0).unwrap();
    let (exact, rounded) = (
        Dense::of_preconditioner(&m),
        Dense::of_preconditioner(&single),
    );
    for (x, y) in exact.values().iter().zip(rounded.values()) {
        assert!((x - f64::from(*y)).abs() < 1e-6 * exact.max_abs());
    }
}
