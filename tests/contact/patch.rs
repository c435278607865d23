//! Claim: a uniform stress passes a closed fracture exactly, t = σ·n on every face and no jump, whatever the mesh.

use fracas::contact::{Coupling, JumpStabilization, Rocks};
use fracas::elasticity::{Constraints, Elastic, loads};
use fracas::mesh::{BoxGrid, BuiltMesh, Distort, Incline, PlaneFracture};
use fracas::system::StickSystem;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_operators::{Dense, Preconditioner, laws};
use fracas_solvers::direct::{DirectSolver, Faer, Kind};
use fracas_solvers::saddle::SaddleBlocks;

const ROCK: Elastic = Elastic {
    young: 25e9,
    poisson: 0.25,
};
const PRESSURE: f64 = 10e6;

/// A column cut by a horizontal and a vertical fracture (X crossing), pressed from above.
fn column(cells: [usize; 3]) -> BoxGrid {
    let mut grid = BoxGrid::uniform([0.0; 3], [3.0, 2.0, 4.0], cells);
    grid.fractures.push(PlaneFracture::through("flat", 2, 2.0));
    grid
}

/// Rollers on x−, y−, z−; the pressure on z+ as nodal forces.
fn supports(built: &BuiltMesh) -> (Constraints, Vec<f64>) {
    let mut fixed = vec![None; 3 * built.mesh.nodes.len()];
    for (axis, side) in [(0, 0), (1, 2), (2, 4)] {
        for node in built.sides[side].iter().flat_map(|f| f.nodes) {
            fixed[3 * node as usize + axis] = Some(0.0);
        }
    }
    let top: Vec<[u32; 4]> = built.sides[5].iter().map(|f| f.nodes).collect();
    let force = loads::surface_traction(&built.mesh.nodes, &top, [0.0, 0.0, -PRESSURE]);
    (Constraints::new(fixed), force)
}

/// `[A B; Bᵀ −H]` as one matrix.
fn joined(blocks: &SaddleBlocks) -> SparseMatrix<f64> {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let mut all = Triplets::new((n_u + n_t, n_u + n_t));
    for (i, row) in blocks.a.outer_iterator().enumerate() {
        row.iter().for_each(|(j, v)| all.add_triplet(i, j, *v));
    }
    for (i, row) in blocks.b1.outer_iterator().enumerate() {
        for (j, v) in row.iter() {
            all.add_triplet(i, n_u + j, *v);
            all.add_triplet(n_u + j, i, *v);
        }
    }
    for (i, row) in blocks.h.iter().flat_map(|h| h.outer_iterator().enumerate()) {
        row.iter()
            .for_each(|(j, v)| all.add_triplet(n_u + i, n_u + j, -*v));
    }
    all.to_csr()
}

fn solve(built: &BuiltMesh) -> (SaddleBlocks, Vec<f64>) {
    let (constraints, force) = supports(built);
    solve_under(
        built,
        &constraints,
        &force,
        Some(JumpStabilization::default()),
    )
}

fn solve_under(
    built: &BuiltMesh,
    constraints: &Constraints,
    force: &[f64],
    stabilization: Option<JumpStabilization>,
) -> (SaddleBlocks, Vec<f64>) {
    let system = StickSystem {
        mesh: &built.mesh,
        fractures: &built.fractures,
        materials: &[ROCK],
        jump_rocks: Rocks {
            elastic: &[ROCK],
            first_alike: &[0],
        },
        constraints,
        stabilization,
    };
    let blocks = system.assemble(force).unwrap();
    let matrix = joined(&blocks);
    let factor = Faer
        .analyze(&matrix, Kind::General)
        .unwrap()
        .factor(&matrix)
        .unwrap();
    let rhs: Vec<f64> = blocks.rhs_u.iter().chain(&blocks.rhs_t).copied().collect();
    let mut x = vec![0.0; rhs.len()];
    factor.solve(&rhs, &mut x, &mut vec![0.0; factor.work_len()]);
    (blocks, x)
}

/// Checks `t = σ·n` with σ = −p e_z ⊗ e_z, and `Bᵀu = 0`.
fn check(built: &BuiltMesh, name: &str) {
    let (blocks, x) = solve(built);
    let (u, t) = x.split_at(blocks.n_u());
    for (f, face) in built.fractures.faces.iter().enumerate() {
        let sigma_n = [0.0, 0.0, -PRESSURE * face.frame[0][2]];
        for (k, axis) in face.frame.iter().enumerate() {
            let expected: f64 = axis.iter().zip(sigma_n).map(|(a, b)| a * b).sum();
            let error = (t[3 * f + k] - expected).abs() / PRESSURE;
            assert!(error < 1e-11, "{name}: face {f}, component {k}: {error:e}");
        }
    }
    let mut jump = vec![0.0; blocks.n_t()];
    for (row, u_i) in blocks.b1.outer_iterator().zip(u) {
        row.iter().for_each(|(j, v)| jump[j] += v * u_i);
    }
    let size = u.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    for g in jump {
        assert!(
            g.abs() < 1e-11 * size,
            "{name}: jump {g:e} beside displacements of {size:e}"
        );
    }
}

#[test]
fn uniform_pressure_passes_a_flat_fracture() {
    check(&column([3, 2, 4]).build().unwrap(), "flat");
}

#[test]
fn uniform_pressure_passes_an_x_crossing() {
    let mut grid = column([4, 2, 4]);
    grid.axes[0] = fracas::mesh::Axis::Lines(vec![0.0, 0.5, 1.5, 2.0, 3.0]);
    grid.fractures
        .push(PlaneFracture::through("upright", 0, 1.5));
    // the lower right block is held by rollers below only: its motion along x is held by the fracture
    check(&grid.build().unwrap(), "crossing");
}

#[test]
fn uniform_pressure_passes_an_inclined_and_distorted_fracture() {
    let mut grid = column([3, 2, 6]);
    // distorted within the plane first, then tilted: the fracture stays plane
    grid.warps.push(Box::new(Distort {
        amplitude: 0.1,
        seed: 7,
        smooth: false,
        planar: true,
    }));
    grid.warps.push(Box::new(Incline {
        plane: 2,
        along: 0,
        tilt: 20f64.to_radians(),
        pivot: [1.5, 1.0, 2.0],
        fade: true,
    }));
    check(&grid.build().unwrap(), "inclined and distorted");
}

/// Largest normal and shear traction beside −p under a pressure all round, over p.
fn beside_pressure(built: &BuiltMesh, stabilization: Option<JumpStabilization>) -> [f64; 2] {
    let (constraints, _) = supports(built);
    let pressed: Vec<[u32; 4]> = [1, 3, 5]
        .iter()
        .flat_map(|side| built.sides[*side].iter().map(|f| f.nodes))
        .collect();
    let force = loads::surface_pressure(&built.mesh.nodes, &pressed, PRESSURE);
    let (blocks, x) = solve_under(built, &constraints, &force, stabilization);
    let mut worst = [0.0f64; 2];
    for t in x[blocks.n_u()..].chunks_exact(3) {
        worst[0] = worst[0].max((t[0] + PRESSURE).abs() / PRESSURE);
        worst[1] = worst[1].max(t[1].hypot(t[2]) / PRESSURE);
    }
    worst
}

#[test]
fn pressure_all_round_passes_faces_that_are_not_plane() {
    for seed in 0..6 {
        let mut grid = column([6, 5, 6]);
        grid.warps.push(Box::new(Distort {
            amplitude: 0.1 + 0.02 * seed as f64,
            seed,
            smooth: seed % 2 == 1,
            planar: false,
        }));
        let built = grid.build().unwrap();
        assert!(built.fractures.faces.iter().any(|f| f.tilts.is_some()));
        let bare = beside_pressure(&built, None);
        let held = beside_pressure(&built, Some(JumpStabilization::default()));
        let worst = bare.into_iter().chain(held).fold(0.0, f64::max);
        assert!(worst < 1e-10, "seed {seed}: {bare:?} {held:?}");
    }
}

#[test]
fn coupling_obeys_the_laws_and_equals_its_assembled_form() {
    let mut grid = column([4, 3, 4]);
    grid.axes[0] = fracas::mesh::Axis::Lines(vec![0.0, 0.5, 1.5, 2.0, 3.0]);
    grid.fractures
        .push(PlaneFracture::through("upright", 0, 1.5));
    grid.warps.push(Box::new(Distort {
        amplitude: 0.15,
        seed: 3,
        smooth: false,
        planar: false,
    }));
    let built = grid.build().unwrap();
    let (constraints, _) = supports(&built);
    let coupling = Coupling::<f64>::new(&built.fractures, &constraints);
    let assembled = coupling.assemble();
    let shape = fracas_operators::Shape::new(assembled.rows(), assembled.cols());
    let mut oracle = Dense::zeros(shape);
    for (i, row) in assembled.outer_iterator().enumerate() {
        row.iter().for_each(|(j, v)| *oracle.entry_mut(i, j) = *v);
    }
    laws::check_adjoint("B", &coupling, Some(&oracle)).unwrap();
    laws::check_adjoint(
        "B in f32",
        &Coupling::<f32>::new(&built.fractures, &constraints),
        None,
    )
    .unwrap();
}
