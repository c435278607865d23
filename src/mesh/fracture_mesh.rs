//! Fractures as pairs of element faces.

use super::{Cut, HexMesh, face_geometry, fracture_edges};

/// One side of a fracture face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceSide {
    /// Element on this side.
    pub element: u32,
    /// Its four nodes, counter-clockwise seen from the + side (so that the right-hand rule gives n).
    pub nodes: [u32; 4],
}

/// A quadrilateral of a fracture: two coinciding element faces.
#[derive(Clone, Debug, PartialEq)]
pub struct FractureFace {
    /// Index of the fracture that it belongs to.
    pub fracture: u16,
    /// The side that the normal leaves.
    pub minus: FaceSide,
    /// The side that the normal points to; `plus.nodes[a]` coincides with `minus.nodes[a]`.
    pub plus: FaceSide,
    /// Area [m²].
    pub area: f64,
    /// Centroid [m].
    pub center: [f64; 3],
    /// Local frame (n, t1, t2) as rows, right-handed: t2 = n × t1. n points from − to +.
    pub frame: [[f64; 3]; 3],
    /// ∫_f N_a dS for the four nodes [m²].
    pub node_areas: [f64; 4],
    /// ∫_f N_a (n(x) − n) dS for the four nodes of a face that is not plane [m²].
    pub tilts: Option<Box<[[f64; 3]; 4]>>,
}

/// An edge shared by exactly two faces of one fracture and by no other fracture face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FractureEdge {
    /// The two faces K and L.
    pub faces: [u32; 2],
    /// Local indices (0–3) in K of the two edge nodes.
    pub nodes_k: [u8; 2],
    /// Local indices (0–3) in L of the same two nodes, in the same order.
    pub nodes_l: [u8; 2],
}

/// An edge at which a fracture goes through others, or past the end of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Its two faces there.
    pub edge: FractureEdge,
    /// Those of the other fractures.
    pub others: Box<[u32]>,
}

/// All fractures of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FractureMesh {
    /// Names, one per fracture.
    pub names: Vec<String>,
    /// Faces, grouped by fracture.
    pub faces: Vec<FractureFace>,
    /// Inner edges, without those where more than two faces meet.
    pub edges: Vec<FractureEdge>,
    /// What goes on where they meet (junctions), per fracture that has two faces there.
    pub crossings: Vec<Crossing>,
}

impl FractureMesh {
    /// Faces with their shapes, and their inner edges, from what [`super::split`] made of `cuts`.
    pub(super) fn between(
        names: Vec<String>,
        cuts: &[Cut],
        sides: &[(FaceSide, FaceSide)],
        mesh: &HexMesh,
    ) -> Self {
        let face = |(cut, (minus, plus)): (&Cut, &(FaceSide, FaceSide))| {
            let corners = minus.nodes.map(|n| mesh.nodes[n as usize]);
            let shape = face_geometry(&corners);
            FractureFace {
                fracture: cut.fracture,
                minus: *minus,
                plus: *plus,
                area: shape.area,
                center: shape.center,
                frame: shape.frame,
                tilts: shape.tilts(&corners).map(Box::new),
                node_areas: shape.node_areas,
            }
        };
        let faces: Vec<FractureFace> = cuts.iter().zip(sides).map(face).collect();
        let (edges, crossings) = fracture_edges(&faces, &mesh.origin);
        Self {
            names,
            faces,
            edges,
            crossings,
        }
    }
}
