//! Claim: elimination of the rows of slip and opening is exact.

use crate::iterations::{solve, until};
use crate::samples::{random, sparse, trusses};
use faer::Mat;
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::norm2;
use fracas_operators::{Dense, LinearOperator, Preconditioner, Shape};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::eigen::dense;
use fracas_solvers::krylov::{Gmres, KrylovMethod, Outcome, Sqmr, System};
use fracas_solvers::saddle::{
    AugmentationChoice, Elimination, InnerChoice, Racp, SaddleBlocks, SaddleMethod, SaddleOperator,
};
use fracas_solvers::{Prepare, Silent};

/// What the rows of a face do: (state of the face, tan φ).
#[derive(Clone, Copy)]
enum Face {
    Stick,
    /// Direction of slip, stiffness across it, tan φ.
    Slip([f64; 2], f64, f64),
    Open,
}

/// Turns an all-stick system into one with slipping and open faces, as a contact law does it.
fn in_states(stick: &SaddleBlocks, faces: &[Face], omega: f64) -> SaddleBlocks {
    let n_t = stick.n_t();
    let b1 = |i: usize, k: usize| stick.b1.get(i, k).copied().unwrap_or(0.0);
    let factor = |k: usize, l: usize| -> f64 {
        match (faces[k / 3], k % 3, l % 3) {
            _ if k / 3 != l / 3 => 0.0,
            (Face::Open, ..) => 0.0,
            (Face::Slip(m, d, _), i @ 1.., j @ 1..) => {
                d * (f64::from(u8::from(i == j)) - m[i - 1] * m[j - 1])
            }
            (_, i, j) => f64::from(u8::from(i == j)),
        }
    };
    let constrained = |k: usize| match faces[k / 3] {
        Face::Stick => true,
        Face::Slip(..) => k.is_multiple_of(3),
        Face::Open => false,
    };
    let h = |k: usize, l: usize| -> f64 {
        let form = match &stick.h {
            Some(h) if constrained(k) && constrained(l) => h.get(k, l).copied().unwrap_or(0.0),
            _ => 0.0,
        };
        let law = match faces[k / 3] {
            _ if constrained(k) => 0.0,
            _ if k == l => omega,
            Face::Slip(m, _, slope) if l == 3 * (k / 3) => omega * slope * m[k % 3 - 1],
            _ => 0.0,
        };
        form + law
    };
    SaddleBlocks {
        b2: Some(sparse(n_t, stick.n_u(), |k, i| {
            (3 * (k / 3)..3 * (k / 3) + 3)
                .map(|l| factor(k, l) * b1(i, l))
                .sum()
        })),
        h: Some(sparse(n_t, n_t, h)),
        ..stick.clone()
    }
}

/// Four faces: stick, slip, open, slip.
fn mixed(slope: f64, seed: u64) -> SaddleBlocks {
    let faces = [
        Face::Stick,
        Face::Slip([0.6, 0.8], 0.7, slope),
        Face::Open,
        Face::Slip([-0.8, 0.6], 2.0, slope),
    ];
    in_states(&random(20, 12, 0.3, seed), &faces, 0.4)
}

const LOCAL: [usize; 7] = [4, 5, 6, 7, 8, 10, 11];

fn entry(m: &SparseMatrix<f64>, i: usize, j: usize) -> f64 {
    m.get(i, j).copied().unwrap_or(0.0)
}

/// `[A  B_k + B1_l H_ll⁻¹H_lk  B1_l; B_kᵀ  −C  0; B2_l  −H_lk  −H_ll]`, which M⁻¹ inverts when S_u is exact.
fn oracle(blocks: &SaddleBlocks, choice: AugmentationChoice) -> Dense<f64> {
    let elimination = Elimination::new(blocks).unwrap();
    let direct = DirectChoice::Faer.solver().unwrap();
    let c = choice
        .compute(elimination.kept(), direct.as_ref())
        .unwrap()
        .matrix
        .to_dense();
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let (b2, h) = (blocks.b2.as_ref().unwrap(), blocks.h.as_ref().unwrap());
    let local: Vec<bool> = (0..n_t).map(|k| elimination.rows().contains(&k)).collect();
    Dense::from_fn(Shape::square(n_u + n_t), |i, j| match (i < n_u, j < n_u) {
        (true, true) => entry(&blocks.a, i, j),
        (true, false) => {
            let k = j - n_u;
            let friction: f64 = LOCAL
                .iter()
                .filter(|_| !local[k])
                .map(|&l| entry(&blocks.b1, i, l) * entry(h, l, k) / entry(h, l, l))
                .sum();
            entry(&blocks.b1, i, k) + friction
        }
        (false, true) => entry(b2, i - n_u, j),
        (false, false) if local[i - n_u] => -entry(h, i - n_u, j - n_u),
        (false, false) if local[j - n_u] => 0.0,
        (false, false) => -c[(i - n_u, j - n_u)],
    })
}

#[test]
fn the_rows_with_a_law_are_found_and_the_others_are_not() {
    let blocks = mixed(0.5, 3);
    let elimination = Elimination::new(&blocks).unwrap();
    assert_eq!(elimination.rows(), LOCAL);
    assert!(!elimination.is_symmetric());
    assert!(Elimination::new(&mixed(0.0, 3)).unwrap().is_symmetric());
    let stick = random(20, 12, 0.3, 3);
    assert!(Elimination::new(&stick).is_none());
    let written_out = SaddleBlocks {
        b2: Some(stick.b1.transpose_view().to_csr()),
        ..stick
    };
    assert!(Elimination::new(&written_out).is_none());
}

#[test]
fn open_faces_do_not_stiffen_and_sliding_ones_only_across_the_slip() {
    let stick = random(20, 12, 0.0, 5);
    let open = in_states(&stick, &[Face::Open; 4], 2.5);
    let elimination = Elimination::new(&open).unwrap();
    assert_eq!(elimination.kept().b1.nnz(), 0);
    for i in 0..20 {
        for j in 0..20 {
            assert_eq!(entry(&elimination.kept().a, i, j), entry(&stick.a, i, j));
        }
    }
    // A' − A = d/ω b bᵀ with b = B1_T (−m₂, m₁)
    let (m, d, omega) = ([0.6, 0.8], 0.7, 2.5);
    let slip = in_states(&stick, &[Face::Slip(m, d, 0.3); 4], omega);
    let kept = Elimination::new(&slip).unwrap().kept().clone();
    for i in 0..20 {
        for j in 0..20 {
            let across = |i: usize, f: usize| {
                -m[1] * entry(&stick.b1, i, 3 * f + 1) + m[0] * entry(&stick.b1, i, 3 * f + 2)
            };
            let added: f64 = (0..4)
                .map(|f| d / omega * across(i, f) * across(j, f))
                .sum();
            let found = entry(&kept.a, i, j) - entry(&stick.a, i, j);
            assert!((found - added).abs() < 1e-13);
            assert_eq!(entry(&kept.a, i, j), entry(&kept.a, j, i));
        }
    }
}

#[test]
fn exact_parts_invert_the_matrix_that_is_claimed_for_every_c() {
    for (slope, seed) in [(0.0, 3), (0.6, 4)] {
        let blocks = mixed(slope, seed);
        for choice in AugmentationChoice::ALL {
            let racp = Racp {
                augmentation: choice,
                ..Racp::published(InnerChoice::default())
            };
            let m = racp.prepare(&blocks).unwrap();
            let matrix = oracle(&blocks, choice);
            check_preconditioner(choice.name(), &m, Some(&matrix), 1e-9).unwrap();
        }
    }
}

#[test]
fn the_eigenvalues_are_one_and_those_of_the_schur_complements() {
    let blocks = mixed(0.5, 7);
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let m = Racp::published(InnerChoice::default())
        .prepare(&blocks)
        .unwrap();
    let operator = SaddleOperator::new(&blocks);
    let n = n_u + n_t;
    let mut product = Mat::zeros(n, n);
    for j in 0..n {
        let mut e = vec![0.0; n];
        e[j] = 1.0;
        let (mut p, mut z) = (vec![0.0; n], vec![0.0; n]);
        operator.apply(&e, &mut p, &mut vec![0.0; operator.work_len()]);
        m.solve(&p, &mut z, &mut vec![0.0; m.work_len()]);
        (0..n).for_each(|i| product[(i, j)] = z[i]);
    }
    let sorted = |matrix: &Mat<f64>| {
        let mut values: Vec<(f64, f64)> = matrix
            .eigenvalues()
            .unwrap()
            .iter()
            .map(|v| (v.re, v.im))
            .collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        values
    };
    // (S' + C)⁻¹ (S_12 + H) over the rows that are left
    let elimination = Elimination::new(&blocks).unwrap();
    let kept = elimination.kept();
    let direct = DirectChoice::Faer.solver().unwrap();
    let c = AugmentationChoice::default()
        .compute(kept, direct.as_ref())
        .unwrap()
        .matrix
        .to_dense();
    let rest: Vec<usize> = (0..n_t).filter(|k| !LOCAL.contains(k)).collect();
    let (h, r) = (blocks.h.as_ref().unwrap(), rest.len());
    let b = Mat::from_fn(n_u, r, |i, k| entry(&blocks.b1, i, rest[k]));
    let b1 = Mat::from_fn(n_u, r, |i, k| {
        let friction: f64 = LOCAL
            .iter()
            .map(|&l| entry(&blocks.b1, i, l) * entry(h, l, rest[k]) / entry(h, l, l))
            .sum();
        b[(i, k)] - friction
    });
    let l = dense::cholesky(dense::to_dense(&kept.a)).unwrap();
    let (mut g, mut g1) = (b.clone(), b1);
    dense::solve_lower(l.as_ref(), &mut g);
    dense::solve_lower(l.as_ref(), &mut g1);
    let left = Mat::from_fn(r, r, |i, j| {
        c[(rest[i], rest[j])] + (0..n_u).map(|q| g[(q, i)] * g[(q, j)]).sum::<f64>()
    });
    let right = Mat::from_fn(r, r, |i, j| {
        entry(h, rest[i], rest[j]) + (0..n_u).map(|q| g[(q, i)] * g1[(q, j)]).sum::<f64>()
    });
    let factor = dense::cholesky(left).unwrap();
    let mut schur = right;
    dense::solve_lower(factor.as_ref(), &mut schur);
    dense::solve_lower_adjoint(factor.as_ref(), &mut schur);
    let mut expected = sorted(&schur);
    expected.extend(std::iter::repeat_n((1.0, 0.0), n - r));
    expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // the multiple eigenvalue 1 belongs to Jordan blocks of size 2: rounding moves it by the root of ε
    for (found, expected) in sorted(&product).iter().zip(&expected) {
        let distance = (found.0 - expected.0).hypot(found.1 - expected.1);
        assert!(distance < 1e-6, "{found:?} against {expected:?}");
    }
}

#[test]
fn the_sign_and_the_unit_of_a_row_do_not_matter() {
    let blocks = mixed(0.4, 9);
    let factor = |k: usize| match LOCAL.contains(&k) {
        true => -1e4 * (1.0 + k as f64),
        false => 1.0,
    };
    let by_rows = |m: &SparseMatrix<f64>| {
        let mut m = m.clone();
        for (k, mut row) in m.outer_iterator_mut().enumerate() {
            row.iter_mut().for_each(|(_, v)| *v *= factor(k));
        }
        m
    };
    let scaled = SaddleBlocks {
        b2: blocks.b2.as_ref().map(by_rows),
        h: blocks.h.as_ref().map(by_rows),
        ..blocks.clone()
    };
    let n_u = blocks.n_u();
    let x: Vec<f64> = probe(n_u + 12, 2);
    let mut x_scaled = x.clone();
    (0..12).for_each(|k| x_scaled[n_u + k] *= factor(k));
    let solve = |blocks: &SaddleBlocks, x: &[f64]| {
        let m = Racp::default().prepare(blocks).unwrap();
        let mut y = vec![0.0; x.len()];
        m.solve(x, &mut y, &mut vec![0.0; m.work_len()]);
        y
    };
    for (y, z) in solve(&blocks, &x).iter().zip(solve(&scaled, &x_scaled)) {
        assert!((y - z).abs() < 1e-10 * (1.0 + y.abs()));
    }
}

#[test]
fn short_recurrences_apply_to_open_faces_from_the_right_start() {
    let stick = trusses(4, 10.0, false);
    let faces: Vec<Face> = (0..16)
        .map(|f| {
            if f % 4 == 1 {
                Face::Open
            } else if f % 4 == 2 {
                Face::Slip([0.6, 0.8], 0.5, 0.0)
            } else {
                Face::Stick
            }
        })
        .collect();
    let blocks = in_states(&stick, &faces, 0.7);
    let elimination = Elimination::new(&blocks).unwrap();
    assert!(elimination.is_symmetric());
    let m = Racp {
        inner: "ssor".parse().unwrap(),
        ..Racp::default()
    }
    .prepare(&blocks)
    .unwrap();
    let operator = SaddleOperator::new(&blocks);
    let rhs: Vec<f64> = (1..=blocks.size()).map(|i| (i as f64).sin()).collect();
    let system = System {
        operator: &operator,
        preconditioner: m.as_ref(),
        rhs: &rhs,
    };
    let mut x = elimination.start(&rhs);
    let report = Sqmr {}
        .solve(&system, &until(1e-10, 200), &mut x, &mut Silent)
        .unwrap();
    assert_eq!(report.outcome, Outcome::Converged);
    let mut r = rhs.clone();
    operator.apply_add(-1.0, &x, &mut r, &mut vec![0.0; operator.work_len()]);
    assert!(norm2(&r) <= 1e-10 * norm2(&rhs));
}

#[test]
fn every_method_of_the_list_takes_slipping_and_open_faces() {
    for slope in [0.0, 0.6] {
        let blocks = mixed(slope, 5);
        let (n_u, n) = (blocks.n_u(), blocks.size());
        let saddle = SaddleOperator::new(&blocks);
        for method in SaddleMethod::all() {
            let m = method.prepare(&blocks).unwrap();
            check_preconditioner(method.name(), &m, None, 0.0).unwrap();
            // row l of 𝒜 M⁻¹ is row l of the identity
            let x: Vec<f64> = probe(n, 3);
            let (mut y, mut back) = (vec![0.0; n], vec![0.0; n]);
            m.solve(&x, &mut y, &mut vec![f64::NAN; m.work_len()]);
            saddle.apply(&y, &mut back, &mut []);
            for l in LOCAL {
                assert!(
                    (back[n_u + l] - x[n_u + l]).abs() < 1e-9,
                    "{method}, row {l}"
                );
            }
            let (_, report) = solve(&Gmres::default(), &saddle, &m, &x, until(1e-10, n));
            assert_eq!(report.unwrap().outcome, Outcome::Converged, "{method}");
        }
    }
}
