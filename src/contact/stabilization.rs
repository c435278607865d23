//! The jump stabilization H that balances the checkerboard modes of piecewise-constant tractions.

use super::ContactState;
use crate::elasticity::Elastic;
use crate::mesh::{FaceSide, FractureEdge, FractureFace, FractureMesh, HexMesh};
use fracas_operators::sparse::{SparseMatrix, Triplets};

/// `H(μ, t) = Σ_e [[μ]]_e · Y⁽ᵉ⁾ · [[t]]_e` over the inner edges e of every fracture.
///
/// With K, L the faces of an edge, F ∈ {K, L}, side ∈ {−, +}, j = x, y, z and h the bounding box of an element:
/// ```text
/// k_{F,side,j} = s E/((1+ν)(1−2ν)) (2/9)(2−3ν) V/h_j²
/// inv_j        = Σ_side 1/(k_{K,side,j} + k_{L,side,j})
/// Y            = diag(inv) · Σ_{a ∈ the 2 edge nodes} A_{K,a} A_{L,a}        A_{K,a} = ∫_K N_a dS
/// H           += [ R_K Y R_Kᵀ  −R_K Y R_Lᵀ ; −R_L Y R_Kᵀ  R_L Y R_Lᵀ ]        rows of R_F: the frame of F
/// ```
/// On a planar fracture R_K = R_L, which is the published form; across a bend the jump is taken of the traction vector,
/// so a constant vector is never penalised.
///
/// # Shape
/// (3 · faces) × (3 · faces), symmetric positive semi-definite; kernel: constants on each fracture.
/// # Units
/// m³/Pa.
/// # Source
/// Form: deck (Franceschini et al. 2022a). Scaling: open implementations of the authors, s = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpStabilization {
    /// Dimensionless factor s on the stiffness; 1 balances the checkerboard exactly on uniform cubes.
    pub scale: f64,
}

impl Default for JumpStabilization {
    fn default() -> Self {
        Self { scale: 1.0 }
    }
}

/// Bounding box and volume of the element beside a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Extent of the element along x, y, z [m].
    pub extent: [f64; 3],
    /// Volume [m³].
    pub volume: f64,
}

/// `k_j = s E/((1+ν)(1−2ν)) (2/9)(2−3ν) V/h_j²` [Pa·m]: the stiffness that a split corner node sees from one element.
pub fn side_stiffness(scale: f64, material: Elastic, side: Side) -> [f64; 3] {
    let Elastic { young, poisson } = material;
    let modulus = young / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    side.extent
        .map(|h| scale * modulus * (2.0 / 9.0) * (2.0 - 3.0 * poisson) * side.volume / (h * h))
}

impl JumpStabilization {
    /// Assembles H for all faces in stick.
    pub fn assemble(
        &self,
        mesh: &HexMesh,
        fractures: &FractureMesh,
        materials: &[Elastic],
    ) -> SparseMatrix<f64> {
        self.assemble_for(mesh, fractures, materials, |_| ContactState::Stick)
    }

    /// Assembles H for faces in given states: an edge couples the components that both of its faces constrain (all
    /// three between sticking faces, the normal one beside a slipping face, none beside an open face).
    ///
    /// H stays symmetric positive semi-definite, and on a plane fracture it penalises no constant.
    pub fn assemble_for(
        &self,
        mesh: &HexMesh,
        fractures: &FractureMesh,
        materials: &[Elastic],
        state: impl Fn(usize) -> ContactState,
    ) -> SparseMatrix<f64> {
        let n = 3 * fractures.faces.len();
        let mut h = Triplets::new((n, n));
        for edge in &fractures.edges {
            let faces = edge.faces.map(|f| f as usize);
            let shared = faces.map(|f| state(f).constrained());
            let shared = shared[0].min(shared[1]);
            if shared == 0 {
                continue;
            }
            let y = self.edge_weight(mesh, fractures, materials, edge);
            for (row, f) in faces.iter().enumerate() {
                for (column, g) in faces.iter().enumerate() {
                    let sign = if row == column { 1.0 } else { -1.0 };
                    let (r_f, r_g) = (&fractures.faces[*f].frame, &fractures.faces[*g].frame);
                    for k in 0..shared {
                        for l in 0..shared {
                            let value: f64 = (0..3).map(|j| r_f[k][j] * y[j] * r_g[l][j]).sum();
                            if value != 0.0 {
                                h.add_triplet(3 * f + k, 3 * g + l, sign * value);
                            }
                        }
                    }
                }
            }
        }
        h.to_csr()
    }

    /// The diagonal of Y⁽ᵉ⁾ in global axes [m³/Pa].
    fn edge_weight(
        &self,
        mesh: &HexMesh,
        fractures: &FractureMesh,
        materials: &[Elastic],
        edge: &FractureEdge,
    ) -> [f64; 3] {
        let [k_face, l_face] = edge.faces.map(|f| &fractures.faces[f as usize]);
        let stiffness = |side: FaceSide| {
            let element = side.element as usize;
            let material = materials[mesh.regions[element] as usize];
            side_stiffness(self.scale, material, side_of(mesh, element))
        };
        let (k_minus, l_minus) = (stiffness(k_face.minus), stiffness(l_face.minus));
        let (k_plus, l_plus) = (stiffness(k_face.plus), stiffness(l_face.plus));
        let areas: f64 = (0..2)
            .map(|a| {
                k_face.node_areas[edge.nodes_k[a] as usize]
                    * l_face.node_areas[edge.nodes_l[a] as usize]
            })
            .sum();
        std::array::from_fn(|j| {
            (1.0 / (k_minus[j] + l_minus[j]) + 1.0 / (k_plus[j] + l_plus[j])) * areas
        })
    }
}

/// `ω = Σ_a A_a²/A_f · Σ_side 1/k_n` [m/Pa], `k_n = Σ_j n_j² k_j`: the mean jump of a face under a unit normal traction
/// when each of its corner nodes moves against one element alone.
pub fn face_compliance(mesh: &HexMesh, materials: &[Elastic], face: &FractureFace) -> f64 {
    let squares: f64 = face.node_areas.iter().map(|a| a * a).sum();
    let compliance = |side: FaceSide| {
        let element = side.element as usize;
        let material = materials[mesh.regions[element] as usize];
        let k = side_stiffness(1.0, material, side_of(mesh, element));
        let n = face.frame[0];
        1.0 / (0..3).map(|j| n[j] * n[j] * k[j]).sum::<f64>()
    };
    squares / face.area * (compliance(face.minus) + compliance(face.plus))
}

/// Bounding box and volume of an element.
fn side_of(mesh: &HexMesh, element: usize) -> Side {
    let corners = mesh.elements[element].map(|a| mesh.nodes[a as usize]);
    let extent = std::array::from_fn(|j| {
        let (low, high) = corners
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x[j]), high.max(x[j]))
            });
        high - low
    });
    Side {
        extent,
        volume: mesh.element_volume(element),
    }
}
