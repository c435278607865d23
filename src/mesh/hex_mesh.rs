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

    /// [`is_thin`](super::is_thin) by its lines.
    pub fn is_thin(&self) -> bool {
        super::is_thin(&self.lines)
    }
}

/// Ends of the twelve edges of an element.
pub const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

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
    /// Volume of an element [m³].
    pub fn element_volume(&self, element: usize) -> f64 {
        super::jacobian::volume(&self.elements[element].map(|a| self.nodes[a as usize]))
    }
}
