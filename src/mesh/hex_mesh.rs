//! The body: nodes after splitting, hexahedra, regions.

/// A structured numbering that the mesh still follows, for kernels that need no index arrays.
///
/// Element `e = i + n_x (j + n_y k)`; node `a = i + (n_x + 1)(j + (n_y + 1) k)` for the nodes that existed before
/// splitting. Copies made by splitting are appended behind all of those.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Cells per axis.
    pub cells: [usize; 3],
    /// Grid-line positions per axis [m] before any map (cells + 1 values, increasing).
    pub lines: [Vec<f64>; 3],
    /// True when no map moved the nodes: every element is an axis-aligned brick.
    pub axis_aligned: bool,
}

impl Grid {
    /// Nodes before splitting.
    pub fn node_count(&self) -> usize {
        self.cells.iter().map(|n| n + 1).product()
    }
}

/// A mesh of eight-node hexahedra.
#[derive(Clone, Debug, PartialEq)]
pub struct HexMesh {
    /// Node positions [m]; nodes on a fracture appear once per side.
    pub nodes: Vec<[f64; 3]>,
    /// Eight node indices per element in VTK order: bottom face counter-clockwise seen from above
    /// (−−−, +−−, ++−, −+−), then the top face (−−+, +−+, +++, −++).
    pub elements: Vec<[u32; 8]>,
    /// Region index per element, into the scene's list of materials.
    pub regions: Vec<u16>,
    /// For every node the node it was split from (itself if it was not), so copies can be recognised.
    pub origin: Vec<u32>,
    /// The structured numbering, where the mesh has one.
    pub grid: Option<Grid>,
}

impl HexMesh {
    /// Volume of an element [m³]: `Σ_q det J(ξ_q)` over the 2×2×2 Gauss points, exact for trilinear hexahedra.
    pub fn element_volume(&self, element: usize) -> f64 {
        let corners = self.elements[element].map(|a| self.nodes[a as usize]);
        let g = 1.0 / 3.0_f64.sqrt();
        let mut volume = 0.0;
        for q in 0..8 {
            let xi = [q & 1, (q >> 1) & 1, q >> 2].map(|b| if b == 0 { -g } else { g });
            volume += jacobian_determinant(&corners, xi);
        }
        volume
    }
}

/// Reference corners of the hexahedron in VTK order.
pub const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// `det ∂x/∂ξ` of the trilinear map at `xi ∈ [−1, 1]³`.
pub fn jacobian_determinant(corners: &[[f64; 3]; 8], xi: [f64; 3]) -> f64 {
    let mut j = [[0.0; 3]; 3];
    for (x, c) in corners.iter().zip(&CORNERS) {
        let factor: [f64; 3] = std::array::from_fn(|d| 1.0 + c[d] * xi[d]);
        let gradient = [
            0.125 * c[0] * factor[1] * factor[2],
            0.125 * c[1] * factor[0] * factor[2],
            0.125 * c[2] * factor[0] * factor[1],
        ];
        for i in 0..3 {
            for d in 0..3 {
                j[i][d] += x[i] * gradient[d];
            }
        }
    }
    j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1])
        - j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0])
        + j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0])
}
