//! A stress field in equilibrium, and a fractured block that it loads.

use fracas::contact::{JumpStabilization, Rocks};
use fracas::elasticity::{Constraints, Elastic, loads};
use fracas::mesh::{BoxGrid, BuiltMesh, Distort, PlaneFracture, face_geometry};
use fracas::system::StickSystem;
use fracas_operators::vector::axpy;
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::saddle::{InnerChoice, Iterated, Racp, SaddleBlocks, SaddleOperator, T, U};
use fracas_solvers::{Prepare, Silent};

/// The rock.
const ROCK: Elastic = Elastic {
    young: 25e9,
    poisson: 0.25,
};

/// Uniform compression across the fracture [Pa].
pub(super) const COMPRESSION: f64 = 20e6;

/// Amplitude of the normal traction that varies on it [Pa].
pub(super) const AMPLITUDE: f64 = 5e6;

/// Phases of the waves along x and y [rad]: no side is a plane of symmetry.
const PHASES: [f64; 2] = [0.7, 0.3];

/// Largest shift of a node over its cell.
const DISTORTION: f64 = 0.2;

/// Residual of the saddle point.
const TOLERANCE: f64 = 1e-10;

/// u = ∇φ/(2G) and σ = ∇∇φ with φ harmonic, so that div σ = 0:
/// ```text
/// φ = (P/k²) cos(π x + α) cos(π y + β) e^{kz}      k = √2 π
/// ```
/// plus a uniform compression along z without lateral strain. On z = 0: t_N = −σ0 + P cos cos.
fn potential(x: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let pi = std::f64::consts::PI;
    let k = std::f64::consts::SQRT_2 * pi;
    let (sx, cx) = (pi * x[0] + PHASES[0]).sin_cos();
    let (sy, cy) = (pi * x[1] + PHASES[1]).sin_cos();
    let p = AMPLITUDE / (k * k) * (k * x[2]).exp();
    let gradient = [-pi * p * sx * cy, -pi * p * cx * sy, k * p * cx * cy];
    let hessian = [
        [
            -pi * pi * p * cx * cy,
            pi * pi * p * sx * sy,
            -pi * k * p * sx * cy,
        ],
        [
            pi * pi * p * sx * sy,
            -pi * pi * p * cx * cy,
            -pi * k * p * cx * sy,
        ],
        [
            -pi * k * p * sx * cy,
            -pi * k * p * cx * sy,
            k * k * p * cx * cy,
        ],
    ];
    (gradient, hessian)
}

/// Displacement [m].
pub(super) fn displacement(x: [f64; 3]) -> [f64; 3] {
    let (gradient, _) = potential(x);
    let shear = ROCK.young / (2.0 * (1.0 + ROCK.poisson));
    let confined =
        ROCK.young * (1.0 - ROCK.poisson) / ((1.0 + ROCK.poisson) * (1.0 - 2.0 * ROCK.poisson));
    let mut u = gradient.map(|g| g / (2.0 * shear));
    u[2] -= COMPRESSION / confined * x[2];
    u
}

/// Stress [Pa].
pub(super) fn stress(x: [f64; 3]) -> [[f64; 3]; 3] {
    let (_, mut sigma) = potential(x);
    let lateral = ROCK.poisson / (1.0 - ROCK.poisson) * COMPRESSION;
    for (i, pressed) in [lateral, lateral, COMPRESSION].into_iter().enumerate() {
        sigma[i][i] -= pressed;
    }
    sigma
}

/// What one mesh says.
pub(super) struct Solved {
    pub(super) built: BuiltMesh,
    pub(super) n_u: usize,
    /// (t_N, t_1, t_2) per face [Pa].
    pub(super) tractions: Vec<f64>,
    /// Root mean square of the nodal errors of u over that of u.
    pub(super) u_error: f64,
    pub(super) iterations: usize,
    /// The same around each of the other inner solvers asked for.
    pub(super) around: Vec<usize>,
}

impl Solved {
    /// Traction less the closed form per face [Pa].
    pub(super) fn errors(&self) -> impl Iterator<Item = [f64; 3]> {
        let faces = self.built.fractures.faces.iter();
        faces
            .zip(self.tractions.as_chunks::<3>().0)
            .map(|(face, t)| {
                let sigma = stress(face.center);
                let [n, ..] = face.frame;
                let exact = sigma.map(|row| (0..3).map(|j| row[j] * n[j]).sum::<f64>());
                std::array::from_fn(|k| {
                    let along: f64 = (0..3).map(|j| face.frame[k][j] * exact[j]).sum();
                    t[k] - along
                })
            })
    }
}

/// The block [0, 1]² × [−½, ½] of n³ cells with these fractures, its nodes shifted at random (those on a cut within its
/// plane); displacements given below and above, tractions on the sides, every face in stick. Solved with exact S_u; around `others` iterations
/// are counted.
pub(super) fn solve(
    n: usize,
    fractures: Vec<PlaneFracture>,
    stabilization: Option<JumpStabilization>,
    others: &[InnerChoice],
) -> anyhow::Result<Solved> {
    let mut grid = BoxGrid::uniform([0.0, 0.0, -0.5], [1.0, 1.0, 0.5], [n, n, n]);
    grid.fractures = fractures;
    grid.warps.push(Box::new(Distort {
        amplitude: DISTORTION,
        seed: 1,
        smooth: false,
        planar: true,
    }));
    let built = grid.build()?;
    let nodes = &built.mesh.nodes;
    let mut prescribed = vec![None; 3 * nodes.len()];
    for node in built.sides[4..]
        .iter()
        .flatten()
        .flat_map(|face| face.nodes)
    {
        let u = displacement(nodes[node as usize]);
        (0..3).for_each(|i| prescribed[3 * node as usize + i] = Some(u[i]));
    }
    let mut force = vec![0.0; 3 * nodes.len()];
    for face in built.sides[..4].iter().flatten() {
        let shape = face_geometry(&face.nodes.map(|a| nodes[a as usize]));
        let sigma = stress(shape.center);
        let pull = sigma.map(|row| (0..3).map(|j| row[j] * shape.frame[0][j]).sum());
        axpy(
            1.0,
            &loads::surface_traction(nodes, &[face.nodes], pull),
            &mut force,
        );
    }
    let constraints = Constraints::new(prescribed);
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
    let blocks = system.assemble(&force)?;
    let (n_u, unit) = (blocks.n_u(), blocks.traction_unit());
    let blocks = blocks.into_traction_unit(unit);
    let (x, iterations) = iterate(&blocks, InnerChoice::default())?;
    let around = others.iter().map(|inner| Ok(iterate(&blocks, *inner)?.1));
    let around = around.collect::<anyhow::Result<_>>()?;
    let [u, t] = blocks.layout().split([U, T], &x);
    let (mut error, mut norm) = (0.0, 0.0);
    for (dof, u) in constraints.free().iter().zip(u) {
        let exact = displacement(nodes[*dof as usize / 3])[*dof as usize % 3];
        error += (u - exact).powi(2);
        norm += exact * exact;
    }
    Ok(Solved {
        n_u,
        tractions: t.iter().map(|t| unit * t).collect(),
        u_error: f64::sqrt(error / norm),
        iterations,
        around,
        built,
    })
}

/// The solution by RACP around this inner solver, and its iterations.
fn iterate(blocks: &SaddleBlocks, inner: InnerChoice) -> anyhow::Result<(Vec<f64>, usize)> {
    let method = Racp {
        inner,
        ..Racp::default()
    };
    let inverse = method.prepare(blocks)?;
    let operator = SaddleOperator::new(blocks);
    let rhs = blocks.rhs();
    let linear = System {
        operator: &operator,
        preconditioner: &*inverse,
        rhs: &rhs,
    };
    let criteria = Criteria {
        relative_tolerance: TOLERANCE,
        max_iterations: 1000,
    };
    let mut x = vec![0.0; rhs.len()];
    let krylov = KrylovChoice::default();
    let iterations = Iterated::new(&linear, krylov, &criteria, &mut x, &mut Silent).reached()?;
    Ok((x, iterations))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central difference of u along j.
    fn slope(x: [f64; 3], i: usize, j: usize) -> f64 {
        let h = 1e-5;
        let at = |s: f64| {
            let mut y = x;
            y[j] += s * h;
            displacement(y)[i]
        };
        (at(1.0) - at(-1.0)) / (2.0 * h)
    }

    #[test]
    fn stress_is_that_of_the_displacement_and_in_equilibrium() {
        let shear = ROCK.young / (2.0 * (1.0 + ROCK.poisson));
        let lambda = 2.0 * shear * ROCK.poisson / (1.0 - 2.0 * ROCK.poisson);
        for x in [[0.1, 0.8, 0.3], [0.6, 0.2, -0.4], [0.9, 0.5, 0.0]] {
            let divergence: f64 = (0..3).map(|i| slope(x, i, i)).sum();
            let sigma = stress(x);
            for i in 0..3 {
                for j in 0..3 {
                    let hooke = shear * (slope(x, i, j) + slope(x, j, i))
                        + if i == j { lambda * divergence } else { 0.0 };
                    assert!((sigma[i][j] - hooke).abs() < 1e-5 * AMPLITUDE);
                }
                let h = 1e-5;
                let force: f64 = (0..3)
                    .map(|j| {
                        let at = |s: f64| {
                            let mut y = x;
                            y[j] += s * h;
                            stress(y)[i][j]
                        };
                        (at(1.0) - at(-1.0)) / (2.0 * h)
                    })
                    .sum();
                assert!(force.abs() < 1e-4 * AMPLITUDE, "{force:e} N/m³");
            }
        }
    }
}
