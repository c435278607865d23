//! Every direct backend solves what it says it solves, and says so when it cannot.

mod lattice;

use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::norm2;
use fracas_operators::{Dense, LinearOperator, Preconditioner};
use fracas_solvers::SetupError;
use fracas_solvers::direct::{DirectChoice, Factorization, Kind, reciprocal_condition};
use lattice::{Lattice, Support};

const KINDS: [Kind; 3] = [Kind::Spd, Kind::QuasiDefinite, Kind::General];

/// Backends of this build that factorize this kind.
fn backends(kind: Kind) -> Vec<DirectChoice> {
    let of_kind = DirectChoice::BACKENDS.into_iter().filter(|b| match b {
        DirectChoice::Cholmod => kind == Kind::Spd,
        DirectChoice::Umfpack => kind == Kind::General,
        _ => true,
    });
    of_kind.filter(|b| b.solver().is_ok()).collect()
}

fn factor(
    choice: DirectChoice,
    a: &SparseMatrix<f64>,
    kind: Kind,
) -> Result<Box<dyn Factorization>, SetupError> {
    choice.solver()?.analyze(a, kind)?.factor(a)
}

/// A matrix of each kind, small enough for a dense oracle and large enough for supernodes.
fn example(kind: Kind, n: usize) -> SparseMatrix<f64> {
    let lattice = Lattice::new([n, n, n]);
    match kind {
        Kind::Spd => lattice.stiffness(Support::Clamped),
        Kind::QuasiDefinite => lattice.saddle(Some(0.3), 1.0),
        Kind::General => lattice.saddle(None, 0.7),
    }
}

fn solved(factors: &dyn Factorization, r: &[f64]) -> Vec<f64> {
    let mut z = vec![f64::NAN; r.len()];
    factors.solve(r, &mut z, &mut vec![f64::NAN; factors.work_len()]);
    z
}

fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let d: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    norm2(&d) / norm2(b)
}

#[test]
fn every_backend_obeys_the_laws_of_a_preconditioner() {
    for kind in KINDS {
        for n in [1, 2, 3, 6] {
            let a = example(kind, n);
            let product = Csr::new(a.clone());
            for choice in backends(kind) {
                let factors = factor(choice, &a, kind).unwrap();
                let subject = format!("{choice:?} {kind:?} {n}");
                check_preconditioner(&subject, &*factors, Some(&product), 1e-11).unwrap();
            }
        }
    }
}

#[test]
fn the_adjoint_solves_with_the_transposed_matrix() {
    for kind in KINDS {
        let a = example(kind, 5);
        let r = probe::<f64>(a.rows(), 1);
        for choice in backends(kind) {
            let factors = factor(choice, &a, kind).unwrap();
            let mut z = vec![f64::NAN; r.len()];
            factors.solve_adjoint(&r, &mut z, &mut vec![f64::NAN; factors.work_len()]);
            let mut back = vec![0.0; r.len()];
            Csr::new(a.transpose_view().to_csr()).apply(&z, &mut back, &mut []);
            assert!(
                relative_difference(&back, &r) < 1e-11,
                "{choice:?} {kind:?}"
            );
        }
    }
}

#[test]
fn all_backends_give_the_same_solution() {
    for kind in KINDS {
        let a = example(kind, 9);
        let r = probe::<f64>(a.rows(), 2);
        let reference = solved(&*factor(DirectChoice::Faer, &a, Kind::General).unwrap(), &r);
        for choice in backends(kind) {
            let z = solved(&*factor(choice, &a, kind).unwrap(), &r);
            let difference = relative_difference(&z, &reference);
            assert!(difference < 1e-10, "{choice:?} {kind:?}: {difference:e}");
        }
    }
}

#[test]
fn a_symbolic_factorization_outlives_the_values() {
    for kind in KINDS {
        let a = example(kind, 4);
        let softer = a.map(|v| 0.5 * v);
        let other = example(kind, 3);
        for choice in backends(kind) {
            let symbolic = choice.solver().unwrap().analyze(&a, kind).unwrap();
            let r = probe::<f64>(a.rows(), 3);
            let z = solved(&*symbolic.factor(&a).unwrap(), &r);
            let twice = solved(&*symbolic.factor(&softer).unwrap(), &r);
            let half: Vec<f64> = twice.iter().map(|v| 0.5 * v).collect();
            assert!(
                relative_difference(&half, &z) < 1e-12,
                "{choice:?} {kind:?}"
            );
            assert!(matches!(
                symbolic.factor(&other),
                Err(SetupError::NotApplicable { .. })
            ));
        }
    }
}

#[test]
fn rows_and_columns_as_storage_are_the_same_matrix() {
    for kind in KINDS {
        let a = example(kind, 4);
        let r = probe::<f64>(a.rows(), 3);
        for choice in backends(kind) {
            let by_rows = solved(&*factor(choice, &a, kind).unwrap(), &r);
            let by_columns = solved(&*factor(choice, &a.to_csc(), kind).unwrap(), &r);
            assert!(relative_difference(&by_columns, &by_rows) < 1e-12);
        }
    }
}

#[test]
fn the_order_of_threads_changes_no_bit() {
    for kind in KINDS {
        // the last separator is wide enough for dense kernels on several threads
        let a = example(kind, 13);
        let columns = 10;
        let b = probe::<f64>(a.rows() * columns, 5);
        for choice in backends(kind) {
            let run = |threads: usize| -> Vec<u64> {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                pool.build().unwrap().install(|| {
                    let factors = factor(choice, &a, kind).unwrap();
                    let mut x = b.clone();
                    factors.solve_many(columns, &mut x);
                    x.extend(solved(&*factors, &b[..a.rows()]));
                    x.iter().map(|v| v.to_bits()).collect()
                })
            };
            let one = run(1);
            assert!(one == run(1), "{choice:?} {kind:?} does not repeat itself");
            assert!(one == run(2), "{choice:?} {kind:?} depends on the threads");
            let factors = factor(choice, &a, kind).unwrap();
            let last = solved(&*factors, &b[(columns - 1) * a.rows()..]);
            let many: Vec<f64> = one[(columns - 1) * a.rows()..columns * a.rows()]
                .iter()
                .map(|v| f64::from_bits(*v))
                .collect();
            assert!(relative_difference(&many, &last) < 1e-12);
        }
    }
}

#[test]
fn the_first_indefinite_row_is_named() {
    for n in [2, 7] {
        let a = Lattice::new([n, n, n]).stiffness(Support::Clamped);
        for row in [0, a.rows() / 2, a.rows() - 1] {
            let mut a = a.clone();
            let diagonal = a.get_mut(row, row).unwrap();
            *diagonal = -*diagonal;
            for choice in backends(Kind::Spd) {
                match factor(choice, &a, Kind::Spd).err() {
                    Some(SetupError::NotPositiveDefinite { row: found, .. }) => {
                        assert_eq!(found, row + 1, "{choice:?}")
                    }
                    other => panic!("{choice:?}: {other:?}"),
                }
            }
        }
    }
}

#[test]
fn floating_bodies_are_reported() {
    for size in [[2, 2, 2], [3, 4, 5], [9, 9, 9], [40, 3, 3]] {
        for stiffness in [1.0, 1e10, 1e-9] {
            let a = Lattice::new(size)
                .stiffness(Support::Floating)
                .map(|v| stiffness * v);
            for kind in KINDS {
                for choice in backends(kind) {
                    let error = factor(choice, &a, kind).err();
                    assert!(
                        matches!(
                            error,
                            Some(
                                SetupError::Singular { .. }
                                    | SetupError::NotPositiveDefinite { .. }
                            )
                        ),
                        "{choice:?} {kind:?} {size:?} {stiffness:e}: {error:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn hard_but_regular_matrices_are_accepted() {
    // a stiff body on springs eight orders softer, and a long slender one
    let soft = Lattice::new([6, 6, 6]).stiffness(Support::Springs(1e-8));
    let slender = Lattice::new([120, 2, 2]).stiffness(Support::Clamped);
    for a in [soft, slender] {
        for kind in KINDS {
            for choice in backends(kind) {
                factor(choice, &a, kind).unwrap();
            }
        }
    }
    // rows of a saddle point in units 1e10 apart
    let saddle = example(Kind::General, 5);
    let n_u = 3 * 125;
    let unit = |i: usize| if i < n_u { 1e5 } else { 1e-8 };
    let mut scaled = Triplets::new((saddle.rows(), saddle.cols()));
    for (i, row) in saddle.outer_iterator().enumerate() {
        for (j, v) in row.iter() {
            scaled.add_triplet(i, j, v * unit(i) * unit(j));
        }
    }
    let scaled: SparseMatrix<f64> = scaled.to_csr();
    for choice in backends(Kind::General) {
        factor(choice, &scaled, Kind::General).unwrap();
    }
}

#[test]
fn empty_tiny_and_diagonal_matrices_work() {
    for kind in KINDS {
        for choice in backends(kind) {
            for n in [0, 1, 2, 5] {
                let mut t = Triplets::<f64>::new((n, n));
                (0..n).for_each(|i| t.add_triplet(i, i, (i + 1) as f64));
                let a: SparseMatrix<f64> = t.to_csr();
                let factors = factor(choice, &a, kind).unwrap();
                let ones = vec![1.0; n];
                let exact: Vec<f64> = (0..n).map(|i| 1.0 / (i + 1) as f64).collect();
                let z = solved(&*factors, &ones);
                assert!(z.iter().zip(&exact).all(|(z, e)| (z - e).abs() < 1e-15));
                let mut b = ones.repeat(2);
                factors.solve_many(2, &mut b);
            }
        }
    }
}

#[test]
fn not_a_number_is_located() {
    for kind in KINDS {
        let mut a = example(kind, 2);
        *a.get_mut(4, 1).unwrap() = f64::NAN;
        for choice in backends(kind) {
            for a in [a.clone(), a.to_csc()] {
                let error = factor(choice, &a, kind).err();
                assert!(
                    matches!(
                        error,
                        Some(SetupError::NotFinite {
                            row: 5,
                            column: 2,
                            ..
                        })
                    ),
                    "{choice:?} {kind:?}: {error:?}"
                );
            }
        }
    }
}

#[test]
fn rectangles_and_zero_rows_are_refused() {
    let mut t = Triplets::<f64>::new((3, 3));
    t.add_triplet(0, 0, 1.0);
    t.add_triplet(1, 1, 0.0);
    t.add_triplet(2, 2, 1.0);
    let zero_row: SparseMatrix<f64> = t.to_csr();
    let rectangle: SparseMatrix<f64> = Triplets::<f64>::new((3, 4)).to_csr();
    for kind in KINDS {
        for choice in backends(kind) {
            assert!(matches!(
                factor(choice, &rectangle, kind),
                Err(SetupError::Shape { .. })
            ));
            match factor(choice, &zero_row, kind).err() {
                Some(SetupError::Singular { row, .. }) => assert_eq!(row, Some(2)),
                Some(SetupError::NotPositiveDefinite { row, .. }) => assert_eq!(row, 2),
                other => panic!("{choice:?} {kind:?}: {other:?}"),
            }
        }
    }
}

#[test]
fn the_condition_estimate_is_within_a_factor_three_of_the_truth() {
    for kind in KINDS {
        let a = example(kind, 4);
        for choice in backends(kind) {
            let factors = factor(choice, &a, kind).unwrap();
            let norm = |m: &Dense<f64>| {
                (0..a.cols())
                    .map(|j| m.column(j).iter().map(|v| v.abs()).sum::<f64>())
                    .fold(0.0, f64::max)
            };
            let inverse = Dense::of_preconditioner(&*factors as &dyn Preconditioner<f64>);
            let matrix = Dense::of_operator(&Csr::new(a.clone()) as &dyn LinearOperator<f64>);
            let exact = 1.0 / (norm(&matrix) * norm(&inverse));
            let estimate = reciprocal_condition(&a, &*factors);
            assert!(
                estimate >= 0.999 * exact && estimate <= 3.0 * exact,
                "{choice:?} {kind:?}: {estimate:e} for {exact:e}"
            );
        }
    }
}

#[test]
fn determinants_agree_with_products_of_known_factors() {
    // det of a lower times an upper bidiagonal matrix is the product of the diagonals
    let n = 40;
    let mut t = Triplets::<f64>::new((n, n));
    let mut exact = 0.0;
    for i in 0..n {
        let d = 1.0 + 0.1 * (i % 7) as f64;
        exact += d.log2();
        // A = L D Lᵀ with unit lower bidiagonal L, l = 0.5
        let before = if i > 0 {
            0.25 * (1.0 + 0.1 * ((i - 1) % 7) as f64)
        } else {
            0.0
        };
        t.add_triplet(i, i, d + before);
        if i + 1 < n {
            t.add_triplet(i, i + 1, 0.5 * d);
            t.add_triplet(i + 1, i, 0.5 * d);
        }
    }
    let a: SparseMatrix<f64> = t.to_csr();
    for kind in KINDS {
        for choice in backends(kind) {
            let factors = factor(choice, &a, kind).unwrap();
            if let Some(found) = factors.log2_abs_determinant() {
                assert!((found - exact).abs() < 1e-10, "{choice:?} {kind:?}");
            }
            assert!(factors.factor_entries() >= 2 * n - 1);
        }
    }
}

#[test]
fn names_are_lower_case_and_missing_backends_say_so() {
    for (choice, name) in [
        (DirectChoice::Auto, "\"auto\""),
        (DirectChoice::Faer, "\"faer\""),
        (DirectChoice::Cholmod, "\"cholmod\""),
        (DirectChoice::Umfpack, "\"umfpack\""),
        (DirectChoice::Mumps, "\"mumps\""),
    ] {
        assert_eq!(serde_json::to_string(&choice).unwrap(), name);
        assert_eq!(serde_json::from_str::<DirectChoice>(name).unwrap(), choice);
        let built = match choice {
            DirectChoice::Cholmod | DirectChoice::Umfpack => cfg!(feature = "suitesparse"),
            DirectChoice::Mumps => cfg!(feature = "petsc"),
            _ => true,
        };
        match choice.solver() {
            Ok(solver) => {
                assert!(built);
                assert_eq!(format!("\"{}\"", solver.name()), name);
            }
            Err(e) => assert!(!built && matches!(e, SetupError::NotBuilt { .. })),
        }
    }
    for kind in KINDS {
        let a = example(kind, 2);
        factor(DirectChoice::Auto, &a, kind).unwrap();
    }
}
