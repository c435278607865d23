//! The eight-node hexahedron: trilinear shape functions, 2×2×2 Gauss points, isotropic stiffness.

use super::Elastic;
use crate::mesh::brick_size;
use crate::mesh::jacobian::{CORNERS, GAUSS};
use fracas_operators::simd::{Kernel, Lanes, Level};
use fracas_operators::small::Matrix3;

/// A 24×24 element matrix; unknown `3·a + component` of local node a.
pub type ElementMatrix = [[f64; 24]; 24];

/// The map from the reference cube folds over: det J ≤ 0 at a Gauss point.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("det J = {jacobian:.3e} at Gauss point {point}")]
pub struct Inverted {
    /// The offending det J [m³].
    pub jacobian: f64,
    /// Gauss point, 0–7.
    pub point: usize,
}

/// Shape functions and their physical gradients at the eight Gauss points.
#[derive(Clone, Debug)]
pub struct GaussPoints {
    /// `gradients[a][i][q]` = ∂N_a/∂x_i at point q [1/m].
    pub gradients: [[[f64; 8]; 3]; 8],
    /// det J times the weight [m³].
    pub weights: [f64; 8],
}

/// `N_a(ξ) = (1 + ξ_a ξ)(1 + η_a η)(1 + ζ_a ζ)/8`.
pub fn shape_functions(at: [f64; 3]) -> [f64; 8] {
    CORNERS.map(|c| (0..3).map(|i| 1.0 + c[i] * at[i]).product::<f64>() / 8.0)
}

/// Reference coordinates of Gauss point q: the corners drawn in by 1/√3.
pub fn gauss_point(q: usize) -> [f64; 3] {
    CORNERS[q].map(|c| c * GAUSS)
}

/// `∂N_a/∂ξ_i` at all eight Gauss points: `[a][i][q]`.
const REFERENCE_GRADIENTS: [[[f64; 8]; 3]; 8] = reference_gradients();

const fn reference_gradients() -> [[[f64; 8]; 3]; 8] {
    let mut table = [[[0.0; 8]; 3]; 8];
    let mut n = 0;
    while n < 192 {
        let (a, i, q) = (n / 24, n / 8 % 3, n % 8);
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (c, p) = (CORNERS[a], CORNERS[q]);
        table[a][i][q] = c[i] * (1.0 + c[j] * p[j] * GAUSS) * (1.0 + c[k] * p[k] * GAUSS) / 8.0;
        n += 1;
    }
    table
}

/// Gradients and weights at the eight points, one lane each: the same bits on all registers.
struct Mapped<'a> {
    nodes: &'a [[f64; 3]; 8],
    /// Zeros.
    points: &'a mut GaussPoints,
}

impl Kernel<f64> for Mapped<'_> {
    #[inline(always)]
    fn run<L: Lanes<f64>>(self) {
        let GaussPoints { gradients, weights } = self.points;
        let mut jacobian = [[[0.0; 8]; 3]; 3];
        for a in 0..8 {
            for i in 0..3 {
                for j in 0..3 {
                    for q in 0..8 {
                        jacobian[i][j][q] += self.nodes[a][i] * REFERENCE_GRADIENTS[a][j][q];
                    }
                }
            }
        }
        let mut cofactor = [[[0.0; 8]; 3]; 3];
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                for q in 0..8 {
                    cofactor[i][j][q] = jacobian[i1][j1][q] * jacobian[i2][j2][q]
                        - jacobian[i1][j2][q] * jacobian[i2][j1][q];
                }
            }
        }
        for i in 0..3 {
            for q in 0..8 {
                weights[q] += jacobian[0][i][q] * cofactor[0][i][q];
            }
        }
        // ∂N/∂x_i = Σ_j cof_ij ∂N/∂ξ_j / det J
        for a in 0..8 {
            for i in 0..3 {
                for j in 0..3 {
                    for q in 0..8 {
                        gradients[a][i][q] += cofactor[i][j][q] * REFERENCE_GRADIENTS[a][j][q];
                    }
                }
                for q in 0..8 {
                    gradients[a][i][q] /= weights[q];
                }
            }
        }
    }
}

impl GaussPoints {
    /// Gradients of the element with corners `nodes`.
    ///
    /// # Errors
    /// [`Inverted`] where det J ≤ 0 (or is not a number).
    pub fn new(nodes: &[[f64; 3]; 8]) -> Result<Self, Inverted> {
        let mut points = Self {
            gradients: [[[0.0; 8]; 3]; 8],
            weights: [0.0; 8],
        };
        Level::best().run(Mapped {
            nodes,
            points: &mut points,
        });
        let weights = &points.weights;
        match weights.iter().position(|w| *w <= 0.0 || w.is_nan()) {
            Some(point) => Err(Inverted {
                jacobian: weights[point],
                point,
            }),
            None => Ok(points),
        }
    }

    /// `M_ij = ∫ ∂_i N_a ∂_j N_b`; the bits of (a, b) are those of (b, a) transposed.
    fn products(&self, a: usize, b: usize) -> [[f64; 3]; 3] {
        let mut m = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                for q in 0..8 {
                    m[i][j] +=
                        self.weights[q] * (self.gradients[a][i][q] * self.gradients[b][j][q]);
                }
            }
        }
        m
    }
}

/// `M_ij = ∫ ∂_i N_a ∂_j N_b` on a brick of edge lengths `size`, in closed form: one factor per axis from the 1-D mass
/// h/6 [2 1; 1 2], stiffness 1/h [1 −1; −1 1] and mixed ½ [∓1] matrices.
fn brick_products(size: [f64; 3], a: usize, b: usize) -> [[f64; 3]; 3] {
    let (p, q) = (CORNERS[a], CORNERS[b]);
    let mut m = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            let factor = |axis: usize| match (axis == i, axis == j) {
                (true, true) => p[axis] * q[axis] / size[axis],
                (true, false) => p[axis] / 2.0,
                (false, true) => q[axis] / 2.0,
                (false, false) => size[axis] * (3.0 + p[axis] * q[axis]) / 12.0,
            };
            m[i][j] = factor(0) * factor(1) * factor(2);
        }
    }
    m
}

/// What the stiffness of one element needs of its geometry.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one at a time, on the stack of an assembly task"
)]
pub enum Geometry {
    /// An axis-aligned brick with these edge lengths [m].
    Brick([f64; 3]),
    /// Any other hexahedron.
    General(GaussPoints),
}

impl Geometry {
    /// Recognises bricks and integrates the others.
    ///
    /// # Errors
    /// [`Inverted`] where det J ≤ 0.
    pub fn new(nodes: &[[f64; 3]; 8]) -> Result<Self, Inverted> {
        match brick_size(nodes) {
            Some(size) => Ok(Self::Brick(size)),
            None => GaussPoints::new(nodes).map(Self::General),
        }
    }

    /// 3×3 block (a, b) of the stiffness [N/m]:
    /// `K_ij = λ M_ij + G (M_ji + δ_ij Σ_k M_kk)` with `M_ij = ∫ ∂_i N_a ∂_j N_b`.
    pub fn stiffness_block(&self, a: usize, b: usize, material: Elastic) -> Matrix3<f64> {
        let m = match self {
            Self::Brick(size) => brick_products(*size, a, b),
            Self::General(points) => points.products(a, b),
        };
        let (lambda, shear) = (material.lambda(), material.shear());
        let trace = m[0][0] + m[1][1] + m[2][2];
        let entry = |i: usize, j: usize| {
            let delta = if i == j { trace } else { 0.0 };
            lambda * m[i][j] + shear * (m[j][i] + delta)
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }

    /// Diagonal of the block (a, a), with its bits: only the `M_ii` are integrated [N/m].
    pub fn stiffness_diagonal(&self, a: usize, material: Elastic) -> [f64; 3] {
        let m: [f64; 3] = match self {
            Self::Brick(size) => {
                let m = brick_products(*size, a, a);
                [m[0][0], m[1][1], m[2][2]]
            }
            Self::General(points) => std::array::from_fn(|i| {
                let gradient = &points.gradients[a][i];
                let squares = points.weights.iter().zip(gradient);
                squares.fold(0.0, |sum, (weight, g)| sum + weight * (g * g))
            }),
        };
        let (lambda, shear) = (material.lambda(), material.shear());
        let trace = m[0] + m[1] + m[2];
        m.map(|m| lambda * m + shear * (m + trace))
    }

    /// The 24×24 stiffness.
    pub fn stiffness(&self, material: Elastic) -> ElementMatrix {
        let mut k = [[0.0; 24]; 24];
        for a in 0..8 {
            for b in 0..8 {
                let block = self.stiffness_block(a, b, material);
                for i in 0..3 {
                    k[3 * a + i][3 * b..3 * b + 3].copy_from_slice(&block[i]);
                }
            }
        }
        k
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::{Dense, Shape};
    use fracas_solvers::eigen::dense::symmetric_eigenvalues;

    const ROCK: Elastic = Elastic {
        young: 3.0,
        poisson: 0.2,
    };

    fn distorted() -> [[f64; 3]; 8] {
        let mut nodes = CORNERS;
        for (a, x) in nodes.iter_mut().enumerate() {
            for i in 0..3 {
                x[i] += 0.25 * ((7 * a + 3 * i) as f64).sin();
            }
        }
        nodes
    }

    fn largest(k: &ElementMatrix) -> f64 {
        k.iter().flatten().fold(0.0, |m, v| v.abs().max(m))
    }

    #[test]
    fn the_stiffness_is_symmetric_to_the_last_bit() {
        for nodes in [distorted(), CORNERS] {
            let k = Geometry::new(&nodes).unwrap().stiffness(ROCK);
            for i in 0..24 {
                for j in 0..24 {
                    assert_eq!(k[i][j].to_bits(), k[j][i].to_bits(), "({i}, {j})");
                }
            }
        }
    }

    #[test]
    fn exactly_six_eigenvalues_vanish_and_the_others_are_positive() {
        for nodes in [distorted(), CORNERS] {
            let k = Geometry::new(&nodes).unwrap().stiffness(ROCK);
            let dense = Dense::from_fn(Shape::square(24), |i, j| k[i][j]);
            let matrix = faer::Mat::from_fn(24, 24, |i, j| dense.entry(i, j));
            let mut values = symmetric_eigenvalues(matrix.as_ref()).unwrap();
            values.sort_by(f64::total_cmp);
            let top = values[23];
            assert!(
                values[..6].iter().all(|v| v.abs() < 1e-13 * top),
                "{values:?}"
            );
            assert!(values[6] > 1e-3 * top, "{values:?}");
        }
    }

    #[test]
    fn rigid_modes_cost_no_force() {
        let nodes = distorted();
        let k = Geometry::new(&nodes).unwrap().stiffness(ROCK);
        for mode in 0..6 {
            let u: Vec<f64> = nodes
                .iter()
                .flat_map(|x| match mode {
                    0..3 => std::array::from_fn(|i| if i == mode { 1.0 } else { 0.0 }),
                    3 => [0.0, -x[2], x[1]],
                    4 => [x[2], 0.0, -x[0]],
                    _ => [-x[1], x[0], 0.0],
                })
                .collect();
            for row in &k {
                let force: f64 = row.iter().zip(&u).map(|(k, u)| k * u).sum();
                assert!(force.abs() < 1e-12 * largest(&k));
            }
        }
    }

    #[test]
    fn a_constant_strain_costs_its_energy_on_a_distorted_element() {
        let nodes = distorted();
        let geometry = GaussPoints::new(&nodes).unwrap();
        let k = Geometry::new(&nodes).unwrap().stiffness(ROCK);
        let h = [[0.3, -0.1, 0.2], [0.5, 0.7, -0.4], [0.6, 0.1, -0.2]];
        let u: Vec<f64> = nodes
            .iter()
            .flat_map(|x| h.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]))
            .collect();
        let strain = |i: usize, j: usize| 0.5 * (h[i][j] + h[j][i]);
        let trace = h[0][0] + h[1][1] + h[2][2];
        let stress = |i: usize, j: usize| {
            2.0 * ROCK.shear() * strain(i, j) + if i == j { ROCK.lambda() * trace } else { 0.0 }
        };
        let volume: f64 = geometry.weights.iter().sum();
        let energy: f64 = (0..9)
            .map(|n| stress(n / 3, n % 3) * strain(n / 3, n % 3))
            .sum();
        let product: f64 = (0..24)
            .map(|i| u[i] * (0..24).map(|j| k[i][j] * u[j]).sum::<f64>())
            .sum();
        assert!((product - energy * volume).abs() < 1e-12 * product);
    }

    #[test]
    fn the_closed_form_of_a_brick_is_its_quadrature() {
        let size = [0.7, 2.0, 1.3];
        let nodes = CORNERS.map(|c| std::array::from_fn(|i| 5.0 + size[i] * 0.5 * (1.0 + c[i])));
        let closed = Geometry::Brick(size).stiffness(ROCK);
        let points = Geometry::General(GaussPoints::new(&nodes).unwrap());
        let general = points.stiffness(ROCK);
        for (a, b) in closed.iter().flatten().zip(general.iter().flatten()) {
            assert!((a - b).abs() < 1e-13 * largest(&general));
        }
    }

    #[test]
    fn a_folded_element_is_an_error() {
        let mut nodes = CORNERS;
        nodes.swap(0, 6);
        assert!(Geometry::new(&nodes).is_err());
        nodes[3][1] = f64::NAN;
        assert!(Geometry::new(&nodes).is_err());
    }
}
