//! Claim: products with a stiffness that is not assembled are those with the assembled one, on every instruction set, scalar and kind of
//! mesh.

use crate::sample::{self, Sample};
use fracas::elasticity::{
    Bricks, Constraints, Elastic, ElasticityError, Restricted, matrix_free, matrix_free_with_level,
    reduced, stiffness,
};
use fracas::mesh::HexMesh;
use fracas_operators::laws::{check_adjoint, probe};
use fracas_operators::simd::Level;
use fracas_operators::sparse::Csr;
use fracas_operators::{Dense, LinearOperator, Real};

const ROCKS: [Elastic; 2] = [
    Elastic {
        young: 3.0,
        poisson: 0.2,
    },
    Elastic {
        young: 1.0,
        poisson: 0.35,
    },
];

/// Graded, heterogeneous meshes with and without split nodes; bricks if `distortion` is zero.
fn meshes(distortion: f64) -> impl Iterator<Item = HexMesh> {
    let sizes = [
        [1, 1, 1],
        [7, 3, 2],
        [8, 17, 9],
        [65, 2, 5],
        [140, 1, 1],
        [16, 9, 1],
        // an overlapping register, and an indexed end, in either precision
        [47, 18, 5],
        [33, 17, 9],
    ];
    sizes.into_iter().flat_map(move |cells| {
        [false, true].map(|split| {
            sample::mesh(Sample {
                cells,
                grading: 0.02,
                distortion,
                regions: 2,
                split: split && cells[0] > 1,
            })
        })
    })
}

fn product<R: Real>(a: &dyn LinearOperator<R>, x: &[R]) -> Vec<R> {
    let mut y = vec![R::zero(); a.shape().rows];
    a.apply(x, &mut y, &mut vec![R::nan(); a.work_len()]);
    y
}

/// Largest difference relative to the largest entry.
fn deviation<R: Real>(a: &[R], b: &[f64]) -> f64 {
    let scale = b.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let difference = a.iter().zip(b).map(|(a, b)| (a.to_f64_exact() - b).abs());
    difference.fold(0.0, f64::max) / scale
}

/// Checks both scalars on every level against the assembled matrix.
fn agrees(mesh: &HexMesh) {
    let x = probe::<f64>(3 * mesh.nodes.len(), 9);
    let rounded: Vec<f32> = x.iter().map(|v| *v as f32).collect();
    let exact = product(&stiffness(mesh, &ROCKS).unwrap(), &x);
    for level in Level::supported() {
        let double = matrix_free_with_level::<f64>(mesh, &ROCKS, level).unwrap();
        let error = deviation(&product(&*double, &x), &exact);
        assert!(error < 1e-13, "{level:?}: {error:e}");
        let single = matrix_free_with_level::<f32>(mesh, &ROCKS, level).unwrap();
        let error = deviation(&product(&*single, &rounded), &exact);
        assert!(error < 1e-5, "{level:?}: {error:e}");
    }
}

#[test]
fn bricks_agree_with_the_assembled_matrix_on_every_instruction_set() {
    for mesh in meshes(0.0) {
        assert!(mesh.grid.as_ref().is_some_and(|grid| grid.axis_aligned));
        agrees(&mesh);
    }
}

#[test]
fn lines_of_any_length_agree_with_the_assembled_matrix() {
    // shorter than a register of any width, one to three of them, and every remainder
    for nx in 2..=50 {
        for (distortion, split) in [(0.0, false), (0.0, true), (0.15, false), (0.15, true)] {
            agrees(&sample::mesh(Sample {
                cells: [nx, 2, 2],
                grading: 0.02,
                distortion,
                regions: 2,
                split,
            }));
        }
    }
}

#[test]
fn hexes_agree_with_the_assembled_matrix_on_every_instruction_set() {
    for mut mesh in meshes(0.15).chain(meshes(0.0)) {
        // bricks without a grid are hexahedra like others
        mesh.grid = None;
        agrees(&mesh);
    }
}

/// Elements in an order of chance share nodes with any task: some take colours beyond the mask and run alone.
#[test]
fn elements_in_any_order_agree_with_the_assembled_matrix() {
    for (cells, split) in [([40, 30, 30], true), ([9, 4, 3], false)] {
        let mut mesh = sample::mesh(Sample {
            cells,
            distortion: 0.15,
            regions: 2,
            split,
            ..Sample::default()
        });
        mesh.grid = None;
        agrees(&mesh);
        let count = mesh.elements.len();
        // Fisher and Yates, with a fixed linear congruential generator
        let mut state = 1u64;
        for e in (1..count).rev() {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            let other = (state >> 33) as usize % (e + 1);
            mesh.elements.swap(e, other);
            mesh.regions.swap(e, other);
        }
        agrees(&mesh);
    }
}

#[test]
fn what_is_not_finite_stays_with_its_elements() {
    // runs of three and four elements, shorter than most registers
    let mesh = sample::mesh(Sample {
        cells: [7, 3, 2],
        distortion: 0.15,
        regions: 2,
        split: true,
        ..Sample::default()
    });
    let n = mesh.nodes.len();
    for level in Level::supported() {
        let a = matrix_free_with_level::<f64>(&mesh, &ROCKS, level).unwrap();
        for node in 0..n {
            let mut x = probe::<f64>(3 * n, 4);
            x[3 * node] = f64::NAN;
            let y = product(&*a, &x);
            let mut near = vec![false; n];
            for element in &mesh.elements {
                if element.contains(&(node as u32)) {
                    element.iter().for_each(|a| near[*a as usize] = true);
                }
            }
            let far = (0..n).filter(|a| !near[*a]);
            for other in far {
                let force = &y[3 * other..][..3];
                assert!(force.iter().all(|f| f.is_finite()), "{node}: {other}");
            }
        }
    }
}

#[test]
fn products_obey_the_laws_and_are_their_own_adjoint() {
    for mesh in meshes(0.0).chain(meshes(0.15)) {
        let assembled = stiffness(&mesh, &ROCKS).unwrap();
        let oracle = (mesh.nodes.len() < 100).then(|| Dense::of_operator(&assembled));
        let a = matrix_free::<f64>(&mesh, &ROCKS).unwrap();
        check_adjoint("f64", &*a, oracle.as_ref()).unwrap();
        check_adjoint("f32", &*matrix_free::<f32>(&mesh, &ROCKS).unwrap(), None).unwrap();
    }
}

#[test]
fn the_restriction_is_the_reduced_matrix() {
    let mesh = meshes(0.15).nth(3).unwrap();
    let n = 3 * mesh.nodes.len();
    let constraints = Constraints::new((0..n).map(|i| (i % 5 == 1).then_some(0.5)).collect());
    let assembled = stiffness(&mesh, &ROCKS).unwrap();
    let oracle = Dense::of_operator(&Csr::new(reduced(&assembled, &constraints)));
    let restricted = Restricted::new(matrix_free::<f64>(&mesh, &ROCKS).unwrap(), constraints);
    check_adjoint("restricted", &restricted, Some(&oracle)).unwrap();
}

#[test]
fn products_have_the_same_bits_for_any_number_of_threads() {
    for mesh in meshes(0.0).chain(meshes(0.15)) {
        let a = matrix_free::<f64>(&mesh, &ROCKS).unwrap();
        let x = probe::<f64>(3 * mesh.nodes.len(), 2);
        let results = [1, 2, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| product(&*a, &x))
        });
        assert!(results[0] == results[1] && results[0] == results[2]);
    }
}

#[test]
fn rigid_motions_of_a_free_body_cost_no_force() {
    for mesh in meshes(0.0).chain(meshes(0.15)) {
        let a = matrix_free::<f64>(&mesh, &ROCKS).unwrap();
        let largest = |values: &[f64]| values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let scale = largest(&product(&*a, &probe(3 * mesh.nodes.len(), 3)));
        let size = largest(mesh.nodes.as_flattened());
        let turn = mesh
            .nodes
            .iter()
            .flat_map(|x| [1.0 - x[1] + x[2], x[0] - x[2], 2.0 - x[0] + x[1]]);
        let force = product(&*a, &turn.collect::<Vec<f64>>());
        assert!(largest(&force) < 1e-14 * scale * size);
    }
}

#[test]
fn a_mesh_that_contradicts_its_grid_is_an_error() {
    let mut mesh = meshes(0.0).nth(3).unwrap();
    mesh.elements[4][0] += 1;
    let error = Bricks::<f64>::new(&mesh, &ROCKS).unwrap_err();
    assert_eq!(error, ElasticityError::NotBricks { element: 4 });
    let distorted = meshes(0.15).nth(3).unwrap();
    assert!(Bricks::<f64>::new(&distorted, &ROCKS).is_err());
    mesh.regions[0] = 7;
    assert!(matrix_free::<f32>(&mesh, &ROCKS).is_err());
}
