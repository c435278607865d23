//! Interpolation reproduces the motions of every body; coarse operators are Galerkin.
#![allow(clippy::unwrap_used)]

use super::coarse_lines::CoarseLines;
use super::coarsening::coarsen;
use super::faces;
use super::grid::Grid;
use super::hierarchy::hierarchy;
use super::interpolation::{Interpolation, Owners};
use super::*;
use crate::contact::JumpStabilization;
use crate::mesh::BoxGrid;
use crate::scene::Body;
use crate::scene::sample::{Sample, Side, plane, rock};
use faer::Mat;
use fracas_operators::LinearOperator;
use fracas_solvers::eigen::dense::{multiply, symmetric_eigenvalues};
use fracas_solvers::multigrid::{Level, Precision, Transfer};
use fracas_solvers::saddle::{AugmentationMatrix, schur};

/// Fractures on and off the coarse planes, tips inside coarse cells, T and X, odd counts, layers, thin and mapped cells.
fn samples() -> [(&'static str, Sample); 10] {
    [
        ("crossing", Sample::crossing([8, 4, 8], [0.0; 2], 4.0)),
        ("off", Sample::crossing([9, 5, 8], [1.0, -1.0], 5.0)),
        ("tee", Sample::tee([8, 5, 8])),
        ("inclined", Sample::inclined([8, 4, 8])),
        ("stretched", Sample::stretched([6; 3])),
        ("layered", Sample::layered([6, 6, 12])),
        ("checkerboard", Sample::checkerboard([6; 3])),
        ("floating", Sample::floating([9, 4, 4])),
        ("few", Sample::few([10, 8, 8])),
        ("dense", Sample::dense([6, 6, 12])),
    ]
}

/// A C of the size of S, different for every row.
fn some_c(body: &Body) -> AugmentationMatrix {
    let e = body.materials[0].young;
    let c = body
        .fractures
        .faces
        .iter()
        .enumerate()
        .flat_map(|(f, face)| {
            [0, 1, 2].map(|k| face.area.powf(1.5) / e * (1.0 + ((3 * f + k) as f64).sin().abs()))
        });
    AugmentationMatrix::from_diagonal(c.collect()).unwrap()
}

/// The body that every element belongs to: components over joined faces.
fn bodies(grid: &Grid<'_>) -> Vec<usize> {
    let mut of: Vec<usize> = (0..grid.elements.len()).collect();
    loop {
        let mut changed = false;
        for cell in 0..grid.cells.iter().product() {
            let at = grid.place(cell);
            for axis in 0..3 {
                let mut next = at;
                next[axis] += 1;
                if next[axis] == grid.cells[axis] {
                    continue;
                }
                for e in grid.elements_in(cell) {
                    for f in grid.elements_in(grid.cell(next)) {
                        if grid.joined(e, f, axis) && of[e] != of[f] {
                            let least = of[e].min(of[f]);
                            (of[e], of[f]) = (least, least);
                            changed = true;
                        }
                    }
                }
            }
        }
        if !changed {
            return of;
        }
    }
}

fn of_body(body: &Body) -> CoarseLines {
    let grid = Grid::of_mesh(&body.mesh).unwrap();
    CoarseLines::new(GridLines::default(), &grid, &body.mesh, &body.materials)
}

#[test]
fn every_body_keeps_its_own_linear_motions_on_every_level() {
    for (scene, sample) in samples() {
        let body = sample.body();
        let mut grid = Grid::of_mesh(&body.mesh).unwrap();
        let of = bodies(&grid);
        // one body per element of the level
        let mut label = of.clone();
        let mut levels = 0;
        let lines = of_body(&body);
        while let Some(starts) = lines.next(&grid) {
            let coarsening = coarsen(&grid, starts);
            let coarse = &coarsening.coarse;
            let owners = Owners::new(&grid, &coarsening);
            let p = Interpolation::<f64>::new(&owners, coarse);
            let mut coarse_label = vec![usize::MAX; coarse.elements.len()];
            for (e, parent) in coarsening.parent.iter().enumerate() {
                let of = &mut coarse_label[*parent as usize];
                assert!(
                    *of == usize::MAX || *of == label[e],
                    "{scene}: a piece of two bodies"
                );
                *of = label[e];
            }
            let values = |grid: &Grid<'_>, label: &[usize]| {
                let mut u = vec![f64::NAN; 3 * grid.nodes];
                for cell in 0..grid.cells.iter().product() {
                    let at = grid.place(cell);
                    for e in grid.elements_in(cell) {
                        for (node, up) in grid.elements[e].iter().zip(super::grid::STEPS) {
                            let x = [0, 1, 2].map(|d: usize| grid.lines[d][at[d] + up[d]]);
                            let b = label[e] as f64;
                            for i in 0..3 {
                                let slope = |d: usize| ((3 * d + i) as f64 + b).sin();
                                let v = b + slope(0) * x[0] + slope(1) * x[1] + slope(2) * x[2];
                                let to = &mut u[3 * *node as usize + i];
                                assert!(to.is_nan() || *to == v, "{scene}: a node of two bodies");
                                *to = v;
                            }
                        }
                    }
                }
                u
            };
            let (fine, given) = (values(&grid, &label), values(coarse, &coarse_label));
            let mut found = vec![f64::NAN; fine.len()];
            p.prolong(&given, &mut found);
            for (found, fine) in found.iter().zip(&fine) {
                assert!((found - fine).abs() < 1e-9 * (1.0 + fine.abs()), "{scene}");
            }
            // rᵀ(P x) = (Pᵀ r)ᵀ x
            let r: Vec<f64> = (0..fine.len()).map(|i| (i as f64).cos()).collect();
            let mut restricted = vec![f64::NAN; given.len()];
            p.restrict(&r, &mut restricted);
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let (left, right) = (dot(&r, &found), dot(&restricted, &given));
            assert!((left - right).abs() < 1e-9 * dot(&found, &found).sqrt() * dot(&r, &r).sqrt());
            (grid, label) = (coarsening.coarse, coarse_label);
            levels += 1;
        }
        assert!(levels >= 1, "{scene}");
    }
}

#[test]
fn lines_between_stiff_and_soft_rock_are_kept() {
    // layers of 2 m between z = -6 and 6 m, interfaces at -4, -2, 0, 2
    let body = Sample::layered([6, 6, 24]).body();
    let lines = of_body(&body);
    let grid = Grid::of_mesh(&body.mesh).unwrap();
    let Some(starts) = lines.next(&grid) else {
        panic!("24 lines can be halved");
    };
    assert_eq!(starts[2], (0..=24).step_by(2).collect::<Vec<_>>());
    let body = Sample::layered([6, 6, 18]).body();
    let lines = of_body(&body);
    let grid = Grid::of_mesh(&body.mesh).unwrap();
    let Some(starts) = lines.next(&grid) else {
        panic!("layers of three cells can become two");
    };
    assert_eq!(starts[2], [0, 2, 3, 5, 6, 8, 9, 11, 12, 14, 16, 18]);
}

fn dense(operator: &dyn LinearOperator<f64>, fixed: &[u32]) -> Mat<f64> {
    let n = operator.shape().rows;
    let is_fixed = |i: usize| fixed.binary_search(&(i as u32)).is_ok();
    let mut work = vec![0.0; operator.work_len()];
    let mut matrix = Mat::zeros(n, n);
    let (mut x, mut y) = (vec![0.0; n], vec![0.0; n]);
    for j in (0..n).filter(|j| !is_fixed(*j)) {
        x[j] = 1.0;
        operator.apply(&x, &mut y, &mut work);
        x[j] = 0.0;
        for i in (0..n).filter(|i| !is_fixed(*i)) {
            matrix[(i, j)] = y[i];
        }
    }
    matrix
}

/// P without the rows of `level`'s and the columns of `below`'s fixed components.
fn dense_p(level: &Level<f64>, below: &Level<f64>) -> Mat<f64> {
    let (n, m) = (level.size(), below.size());
    let mut p = Mat::zeros(n, m);
    let (mut x, mut y) = (vec![0.0; m], vec![0.0; n]);
    for j in (0..m).filter(|j| below.fixed().binary_search(&(*j as u32)).is_err()) {
        x[j] = 1.0;
        level.transfer().prolong(&x, &mut y);
        x[j] = 0.0;
        level.fixed().iter().for_each(|i| y[*i as usize] = 0.0);
        (0..n).for_each(|i| p[(i, j)] = y[i]);
    }
    p
}

/// Largest entry of `a − b`.
fn apart(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    let pairs = (0..a.ncols()).flat_map(|j| (0..a.nrows()).map(move |i| (i, j)));
    pairs.fold(0.0, |most: f64, at| most.max((a[at] - b[at]).abs()))
}

#[test]
fn every_operator_is_the_galerkin_product_of_the_assembled_one() {
    for (scene, sample) in samples() {
        let body = sample.body();
        let system = body.stick_system(Some(JumpStabilization::default()));
        let c = some_c(&body);
        let settings = Geometric {
            precision: Precision::F64,
            coarsest: 30,
            direct: 30,
            ..Geometric::default()
        };
        let blocks = faces::inverse_blocks(&c, 1.0).unwrap();
        let h = hierarchy::<f64>(&settings, &system, &body.materials, &blocks).unwrap();
        assert!(h.levels().len() >= 2, "{scene}");
        // the finest operator is A + B C⁻¹Bᵀ
        let assembled = system
            .assemble(&vec![0.0; body.constraints.full_len()])
            .unwrap();
        let s_u = schur::primal_schur(&assembled.a, &assembled.b1, &c).unwrap();
        let finest = dense(h.levels()[0].operator(), h.levels()[0].fixed());
        let free = body.constraints.free();
        assert_eq!(
            h.levels()[0].size() - h.levels()[0].fixed().len(),
            free.len()
        );
        let mut expected = Mat::<f64>::zeros(finest.nrows(), finest.ncols());
        let size = apart(&finest, &expected);
        for (v, (i, j)) in &s_u {
            expected[(free[i as usize] as usize, free[j as usize] as usize)] = *v;
        }
        assert!(apart(&finest, &expected) < 1e-11 * size, "{scene}");
        // and every coarse one PᵀA P
        let mut above = expected;
        for pair in h.levels().windows(2) {
            let p = dense_p(&pair[0], &pair[1]);
            above = multiply(multiply(p.transpose(), above.as_ref()).as_ref(), p.as_ref());
            let found = dense(pair[1].operator(), pair[1].fixed());
            let error = apart(&found, &above);
            assert!(error < 1e-10 * size, "{scene}: {error:e} of {size:e}");
        }
    }
}

/// Columns one cell thick between held sides and cuts in the middle of coarse cells: their corners beyond the cuts are the only ones
/// that are left, and none of them is a combination of others.
#[test]
fn beside_held_sides_every_coarse_function_is_independent() {
    for (x, y) in [
        (Side::Roller, Side::Roller),
        (Side::Fixed, Side::Roller),
        (Side::Fixed, Side::Fixed),
    ] {
        let mut grid = BoxGrid::uniform([0.0; 3], [8.0, 8.0, 4.0], [8, 8, 4]);
        grid.fractures = vec![
            plane(0, 1.0, [None, None, Some([1.0, 4.0])]),
            plane(1, 7.0, [None; 3]),
        ];
        let name = format!("{x:?} {y:?}");
        let body = Sample {
            grid,
            rocks: vec![rock(25e9)],
            sides: vec![(4, Side::Fixed), (0, x), (3, y)],
            angle: 30.0,
        };
        let body = body.body();
        let system = body.stick_system(Some(JumpStabilization::default()));
        let settings = Geometric {
            coarsest: 30,
            ..Geometric::default()
        };
        let blocks = faces::inverse_blocks(&some_c(&body), 1.0).unwrap();
        let h = hierarchy::<f64>(&settings, &system, &body.materials, &blocks).unwrap();
        assert!(h.levels().len() >= 3 && h.left_out().is_none());
        for pair in h.levels().windows(2) {
            let p = dense_p(&pair[0], &pair[1]);
            let mut gram = multiply(p.transpose(), p.as_ref());
            // fixed columns are zero
            pair[1]
                .fixed()
                .iter()
                .for_each(|i| gram[(*i as usize, *i as usize)] = 1.0);
            let least = symmetric_eigenvalues(gram.as_ref()).unwrap()[0];
            println!("{name}: {least:e}");
            assert!(least > 1e-4, "{name}: {least:e}");
        }
    }
}
