//! Claim: classical coarsening converges as published, whatever the mesh.

use crate::elastic_sample::{bodies, cube};
use crate::iterations::cg_iterations;
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::dot;
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::amg::{Amg, Coarsening};
use fracas_solvers::eigen::{LanczosSettings, extreme_eigenvalues};
use fracas_solvers::multigrid::{Cycle, Precision, Smoother};
use fracas_solvers::{DofCoordinate, SetupError};

/// The group's combination: V(1,1), smoothed by FSAI.
fn classical() -> Amg {
    Amg {
        coarsening: Coarsening::Classical,
        smoother: Smoother::Fsai,
        cycle: Cycle::V,
        precision: Precision::F64,
        ..Amg::default()
    }
}

#[test]
fn two_grids_converge_with_a_bound_that_the_mesh_does_not_change() {
    let condition = |cells: usize| {
        let (a, coordinates) = cube(cells);
        let two_grids = Amg {
            coarsest: a.rows() / 4,
            ..classical()
        };
        let m = two_grids.build(&a, Some(&coordinates)).unwrap();
        assert_eq!(m.summary().levels.len(), 2);
        let operator = Csr::new(a);
        let mut work = vec![0.0; m.work_len()];
        let mut apply = |x: &[f64], y: &mut [f64]| operator.apply(x, y, &mut []);
        let mut solve = |r: &[f64], z: &mut [f64]| m.solve(r, z, &mut work);
        let settings = LanczosSettings {
            tolerance: 1e-3,
            max_steps: 60,
            ..LanczosSettings::default()
        };
        let n = operator.shape().rows;
        let (low, high) = extreme_eigenvalues(n, &mut apply, Some(&mut solve), settings).unwrap();
        high.value / low.value
    };
    let numbers = [6, 9, 12].map(condition);
    println!("{numbers:?}");
    assert!(
        numbers.iter().all(|k| (1.0..2.5).contains(k)),
        "{numbers:?}"
    );
}

/// Conjugate gradients to 1e-6 under a constant load.
fn iterations(a: &SparseMatrix<f64>, m: &dyn Preconditioner<f64>) -> usize {
    cg_iterations(a, m, &vec![1.0; a.rows()], 1e-6)
}

#[test]
fn a_cube_needs_no_more_iterations_than_the_published_twenty() {
    for (name, a, coordinates) in bodies(14) {
        let count = |settings: Amg| {
            let m = settings.build(&a, Some(&coordinates)).unwrap();
            (iterations(&a, &m), m.summary().operator_complexity)
        };
        let (found, complexity) = count(classical());
        let aggregation = Amg {
            coarsening: Coarsening::SmoothedAggregation,
            ..classical()
        };
        let sweeps = Amg {
            smoother: Smoother::GaussSeidel,
            ..classical()
        };
        println!(
            "{name}: {found}, operator complexity {complexity:.2}; with Gauss-Seidel {:.2?}; aggregation with FSAI {:.2?}",
            count(sweeps),
            count(aggregation),
        );
        let most = match name {
            "cube" | "far from the origin" => 20,
            _ => 43,
        };
        assert!(found <= most && complexity < 2.5, "{name}: {found}");
    }
}

#[test]
fn the_hierarchy_obeys_the_laws_in_both_precisions() {
    let (a, coordinates) = cube(7);
    for precision in [Precision::F32, Precision::F64] {
        for smoother in [Smoother::Fsai, Smoother::GaussSeidel] {
            let settings = Amg {
                precision,
                smoother,
                sweeps: 2,
                coarsest: 50,
                ..classical()
            };
            let m = settings.build(&a, Some(&coordinates)).unwrap();
            assert!(m.summary().levels.len() > 2);
            if precision == Precision::F64 {
                check_preconditioner("classical", &m, None, 0.0).unwrap();
            }
            let [x, y]: [Vec<f64>; 2] = [probe(a.rows(), 1), probe(a.rows(), 2)];
            let solve = |r: &[f64]| {
                let mut z = vec![0.0; r.len()];
                m.solve(r, &mut z, &mut vec![f64::NAN; m.work_len()]);
                z
            };
            let (left, right) = (dot(&solve(&x), &y), dot(&x, &solve(&y)));
            let size = dot(&solve(&x), &x).max(dot(&solve(&y), &y));
            let rounding = if precision == Precision::F32 {
                1e-4
            } else {
                1e-11
            };
            assert!((left - right).abs() < rounding * size);
        }
    }
    // without coordinates: translations only
    let m = classical().build(&a, None).unwrap();
    assert!(iterations(&a, &m) < 60);
}

#[test]
fn blocks_joined_across_a_fracture_keep_to_themselves() {
    let cells = 6;
    let (block, coordinates) = cube(cells);
    let n = block.rows();
    let mut triplets = Triplets::new((2 * n, 2 * n));
    for (value, (i, j)) in block.iter() {
        for shift in [0, n] {
            triplets.add_triplet(i as usize + shift, j as usize + shift, *value);
        }
    }
    let beside = |mut dof: DofCoordinate| {
        dof.position[1] -= cells as f64;
        dof
    };
    // the face y = 0 of the first block touches y = cells of the second, which lies at y = 0 too
    let both: Vec<DofCoordinate> = coordinates
        .iter()
        .copied()
        .chain(coordinates.iter().copied().map(beside))
        .collect();
    let mut springs = vec![];
    for (i, dof) in both
        .iter()
        .enumerate()
        .take(n)
        .filter(|(_, dof)| dof.position[1] == 0.0)
    {
        let partner = (n..2 * n).find(|j| both[*j] == *dof).unwrap();
        springs.push((i, partner));
    }
    assert_eq!(springs.len(), 3 * cells * (cells + 1));
    for stiffness in [1e-3f64, 1.0, 1e3] {
        let mut f = Triplets::new((2 * n, springs.len()));
        for (k, (i, j)) in springs.iter().enumerate() {
            // normal springs only: tangential motion is free
            if both[*i].component == 1 {
                f.add_triplet(*i, k, stiffness.sqrt());
                f.add_triplet(*j, k, -stiffness.sqrt());
            }
        }
        let (a, f): (SparseMatrix<f64>, SparseMatrix<f64>) = (triplets.to_csr(), f.to_csr());
        let m = classical().build_augmented(&a, &f, Some(&both)).unwrap();
        let sum = &a + &(&f * &f.transpose_view().to_csr());
        let count = iterations(&sum, &m);
        println!("springs {stiffness:e}: {count}");
        assert!(count < 40, "{stiffness:e}: {count}");
    }
}

#[test]
fn an_indefinite_matrix_is_refused_with_a_row() {
    let (a, coordinates) = cube(7);
    let mut triplets = Triplets::new((a.rows(), a.rows()));
    for (value, (i, j)) in a.iter() {
        let shift = if i == j { 0.4 * value } else { 0.0 };
        triplets.add_triplet(i as usize, j as usize, value - shift);
    }
    let shifted: SparseMatrix<f64> = triplets.to_csr();
    for smoother in [Smoother::GaussSeidel, Smoother::Fsai] {
        let settings = Amg {
            smoother,
            coarsest: 50,
            ..classical()
        };
        let error = settings.build(&shifted, Some(&coordinates)).unwrap_err();
        let named = matches!(error, SetupError::NotPositiveDefinite { row, .. } if (1..=a.rows()).contains(&row));
        assert!(named, "{error}");
    }
}
