//! Claim: without stabilization a closed N×N fracture has 2N−1 spurious modes per traction component; with it, none.

use fracas::contact::{JumpStabilization, Rocks};
use fracas::elasticity::{Constraints, Elastic};
use fracas::mesh::{BoxGrid, BuiltMesh, PlaneFracture};
use fracas::system::StickSystem;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::saddle::SaddleBlocks;

const ROCK: Elastic = Elastic {
    young: 25e9,
    poisson: 0.25,
};

/// An N×N fracture whose border lies inside a cube, so that the nodes of the border are not split.
fn embedded(n: usize) -> BuiltMesh {
    let width = (n + 2) as f64;
    let mut grid = BoxGrid::uniform([0.0; 3], [width, width, 4.0], [n + 2, n + 2, 4]);
    let inside = Some([1.0, width - 1.0]);
    let mut fracture = PlaneFracture::through("square", 2, 2.0);
    fracture.spans = [inside, inside, None];
    grid.fractures.push(fracture);
    grid.build().unwrap()
}

fn blocks(built: &BuiltMesh, stabilization: Option<JumpStabilization>) -> SaddleBlocks {
    let mut fixed = vec![None; 3 * built.mesh.nodes.len()];
    for side in &built.sides[4] {
        for node in side.nodes {
            for i in 0..3 {
                fixed[3 * node as usize + i] = Some(0.0);
            }
        }
    }
    let constraints = Constraints::new(fixed);
    let system = StickSystem {
        mesh: &built.mesh,
        fractures: &built.fractures,
        materials: &[ROCK],
        jump_rocks: Rocks {
            elastic: &[ROCK],
            first_alike: &[0],
        },
        constraints: &constraints,
        stabilization,
    };
    system.assemble(&vec![0.0; constraints.full_len()]).unwrap()
}

/// Eigenvalues of `BᵀB·scale + H`, increasing.
fn eigenvalues(b: &SparseMatrix<f64>, h: Option<&SparseMatrix<f64>>, scale: f64) -> Vec<f64> {
    let n = b.cols();
    let mut gram = faer::Mat::<f64>::zeros(n, n);
    for row in b.outer_iterator() {
        for (i, b_i) in row.iter() {
            for (j, b_j) in row.iter() {
                gram[(i, j)] += scale * b_i * b_j;
            }
        }
    }
    if let Some(h) = h {
        for (row, entries) in h.outer_iterator().enumerate() {
            for (column, value) in entries.iter() {
                gram[(row, column)] += value;
            }
        }
    }
    gram.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()
}

#[test]
fn the_kernel_has_two_n_minus_one_modes_per_component() {
    for n in [4, 5, 8] {
        let b = blocks(&embedded(n), None).b1;
        let spectrum = eigenvalues(&b, None, 1.0);
        let largest = spectrum.last().unwrap();
        let kernel = spectrum.iter().filter(|v| **v < 1e-12 * largest).count();
        assert_eq!(kernel, 3 * (2 * n - 1), "N = {n}");
        // a clear gap: nothing lies between the kernel and the rest
        assert!(
            spectrum[kernel] > 1e-4 * largest,
            "N = {n}: {:e}",
            spectrum[kernel] / largest
        );
    }
}

#[test]
fn a_cut_fracture_has_the_smallest_singular_value_of_the_chain() {
    // B of one component is √2 h²/4 · F ⊗ F, FᵀF = tridiag(1, 2, 1): σ_min/σ_max = tan²(π/(2N + 2))
    for n in [3, 6, 9] {
        let width = n as f64;
        let mut grid = BoxGrid::uniform([0.0; 3], [width, width, 4.0], [n, n, 4]);
        grid.fractures
            .push(PlaneFracture::through("square", 2, 2.0));
        let b = blocks(&grid.build().unwrap(), None).b1;
        let squares = eigenvalues(&b, None, 1.0);
        let found = (squares[0] / squares.last().unwrap()).sqrt();
        let expected = (std::f64::consts::PI / (2.0 * width + 2.0)).tan().powi(2);
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "N = {n}: {found:e}, expected {expected:e}"
        );
    }
}

#[test]
fn stabilization_removes_the_kernel() {
    for n in [4, 5, 8] {
        let blocks = blocks(&embedded(n), Some(JumpStabilization::default()));
        let h = blocks.h.as_ref().unwrap();
        // B diag(A)⁻¹Bᵀ and H have the same scale: with h = 1 m, 1/diag(A) is about 1/(λ + 4μ)
        let scale = 1.0 / (ROCK.lambda() + 4.0 * ROCK.shear());
        let spectrum = eigenvalues(&blocks.b1, Some(h), scale);
        let ratio = spectrum[0] / spectrum.last().unwrap();
        assert!(ratio > 1e-3, "N = {n}: {ratio:e}");
    }
}

#[test]
fn stabilization_on_uniform_cubes_is_the_closed_form() {
    // Y = 9 h³ / (16 (λ + 4μ)) · I, h = 1
    let blocks = blocks(&embedded(4), Some(JumpStabilization::default()));
    let h = blocks.h.unwrap();
    let expected = 9.0 / (16.0 * (ROCK.lambda() + 4.0 * ROCK.shear()));
    for (row, entries) in h.outer_iterator().enumerate() {
        let mut sum = 0.0;
        for (column, value) in entries.iter() {
            sum += value;
            if column != row {
                assert!(
                    (value + expected).abs() < 1e-13 * expected,
                    "({row}, {column}): {value:e}"
                );
            }
        }
        // constants are not penalised
        assert!(sum.abs() < 1e-13 * expected);
    }
    // 2 N (N−1) inner edges, three components, two off-diagonal entries each
    let off_diagonal = h.nnz() - h.rows();
    assert_eq!(off_diagonal, 2 * 4 * 3 * 3 * 2);
}
