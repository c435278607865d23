//! What can be wrong with a Gmsh file: where, and what to do.

use std::fmt::{self, Display};

use super::{GroupName, Spot};
use crate::mesh::error::point;

/// A Gmsh file that gives no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}: {defect}")]
pub struct GmshError {
    /// File name.
    pub file: String,
    /// What is wrong.
    pub defect: Box<GmshDefect>,
}

impl GmshError {
    pub(super) fn new(file: &str, defect: GmshDefect) -> Self {
        Self {
            file: file.into(),
            defect: Box::new(defect),
        }
    }
}

/// ` or "a", "b"`-like lists.
struct List<'a>(&'a [GroupName]);

impl Display for List<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, name) in self.0.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{name}")?;
        }
        match self.0.is_empty() {
            true => write!(f, "none at all"),
            false => Ok(()),
        }
    }
}

/// `, did you mean "x"?`
fn meant(nearest: &Option<GroupName>) -> String {
    nearest
        .as_ref()
        .map_or(String::new(), |n| format!(", did you mean {n}?"))
}

/// What is wrong with a Gmsh file; elements and nodes have the numbers of the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GmshDefect {
    /// No such file, or no right to read it.
    #[error("cannot be read: {reason}")]
    Read {
        /// Why.
        reason: std::io::ErrorKind,
    },
    /// Another kind of file.
    #[error("does not start with $MeshFormat; a mesh file is written by Gmsh as .msh")]
    NotGmsh,
    /// A format that is not read.
    #[error("format {found} is not read; save the mesh in format 4.1 or 2.2 (Mesh.MshFileVersion)")]
    Version {
        /// As it is written.
        found: String,
    },
    /// Neither text nor binary.
    #[error("file type {found} is neither 0 (ASCII) nor 1 (binary)")]
    FileType {
        /// As it is written.
        found: i64,
    },
    /// Numbers of other sizes.
    #[error("data size {found} is not 8; save the mesh on a 64-bit machine")]
    DataSize {
        /// As it is written [bytes].
        found: i64,
    },
    /// The other order of bytes.
    #[error(
        "its binary numbers are big-endian; save the mesh as ASCII (Mesh.Binary = 0) or on a little-endian machine"
    )]
    BigEndian,
    /// No order of bytes.
    #[error(
        "the number one behind its header is {found:?} in bytes; the file is damaged, as by a transfer in text mode"
    )]
    NoOne {
        /// The four bytes.
        found: [u8; 4],
    },
    /// The file stops too early.
    #[error("{spot} is its end, where {expected} was expected: the file is truncated")]
    Truncated {
        /// The end.
        spot: Spot,
        /// What comes next in a whole file.
        expected: &'static str,
    },
    /// Something else than what has to come.
    #[error("{spot}: expected {expected}, found `{found}`")]
    Malformed {
        /// Where.
        spot: Spot,
        /// What has to come.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// Blocks that do not add up.
    #[error("{spot}: the section announces {expected} {what} and lists {found}")]
    Count {
        /// Where.
        spot: Spot,
        /// Nodes or elements.
        what: &'static str,
        /// In the first line of the section.
        expected: u64,
        /// In its blocks.
        found: u64,
    },
    /// A section that has to be there.
    #[error("has no {section} section before it is needed; save the mesh again")]
    NoSection {
        /// Its name.
        section: &'static str,
    },
    /// A section that is there twice.
    #[error("has two {section} sections; save the mesh again as one")]
    SectionTwice {
        /// Its name.
        section: &'static str,
    },
    /// A mesh in partitions.
    #[error("is partitioned ($PartitionedEntities); save the mesh without partitions")]
    Partitioned,
    /// Nodes with parameters of the geometry.
    #[error(
        "has $ParametricNodes, which are not read; save the mesh without them (Mesh.SaveParametric = 0)"
    )]
    Parametric,
    /// A coordinate that is none.
    #[error("{spot}: a coordinate of node {node} is {value}")]
    NotFinite {
        /// Where.
        spot: Spot,
        /// The node.
        node: u64,
        /// Its coordinate.
        value: f64,
    },
    /// A node number that is there twice.
    #[error("node {node} is listed twice")]
    NodeTwice {
        /// The node.
        node: u64,
    },
    /// More nodes than 32-bit indices count when each of them gets eight copies.
    #[error(
        "has {nodes} nodes; {} is the most this mesh can number",
        crate::mesh::MAX_NODES
    )]
    TooManyNodes {
        /// Their number.
        nodes: usize,
    },
    /// A node that is not there.
    #[error("{spot}: element {element} has node {node}, which $Nodes does not list")]
    UnknownNode {
        /// Where.
        spot: Spot,
        /// The element.
        element: u64,
        /// The node.
        node: u64,
    },
    /// A type of element that Gmsh has and this reader does not.
    #[error("{spot}: element type {number} is not known")]
    UnknownKind {
        /// Where.
        spot: Spot,
        /// The type.
        number: i64,
    },
    /// Nothing to make a body of.
    #[error(
        "has no hexahedron (type 5), but {surfaces} surface elements; mesh in three dimensions and put the volumes into a physical group, or Gmsh does not save them"
    )]
    NoHexahedra {
        /// Elements of dimension two.
        surfaces: u64,
    },
    /// Volume elements that are no eight-node hexahedra.
    #[error(
        "has {count} {kind}, the first of them element {element} at {}; the body must be of eight-node hexahedra alone (transfinite or extruded with Recombine, Mesh.ElementOrder = 1)",
        point(center)
    )]
    OtherVolumes {
        /// Their number.
        count: u64,
        /// What they are.
        kind: &'static str,
        /// The first one.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
    },
    /// An element turned inside out, or flat.
    #[error(
        "hexahedron {element} at {} is inverted or flat: min det J = {min_jacobian:e} m^3; improve the mesh there",
        point(center)
    )]
    Inverted {
        /// The element.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
        /// Smallest Jacobian determinant on [−1, 1]³ over corners and Gauss points [m³].
        min_jacobian: f64,
    },
    /// One element twice.
    #[error(
        "hexahedra {first} and {second} at {} have the same nodes",
        point(center)
    )]
    SameHexahedra {
        /// The earlier one.
        first: u64,
        /// The later one.
        second: u64,
        /// Their centre [m].
        center: [f64; 3],
    },
    /// Two elements on one side of a face.
    #[error(
        "hexahedra {first} and {second} overlap: both lie on one side of the face at {}",
        point(center)
    )]
    Overlap {
        /// The earlier one.
        first: u64,
        /// The later one.
        second: u64,
        /// Centre of the face [m].
        center: [f64; 3],
    },
    /// Two nodes at one place.
    #[error(
        "nodes {first} and {second} both lie at {}, so the mesh is torn there; parts must share their nodes (BooleanFragments before meshing, or Coherence Mesh), and fractures are split here, not by the Crack plugin",
        point(at)
    )]
    SameNodes {
        /// The earlier one.
        first: u64,
        /// The later one.
        second: u64,
        /// Their place [m].
        at: [f64; 3],
    },
    /// A face that lies on another element without being its face.
    #[error(
        "hexahedra {element} and {other} touch at {} without sharing a face: the mesh has hanging nodes there, or a gap below a thousandth of an element; mesh both sides alike (BooleanFragments before meshing)",
        point(at)
    )]
    NotConforming {
        /// The owner of the face.
        element: u64,
        /// The element behind it.
        other: u64,
        /// A point of the face [m].
        at: [f64; 3],
    },
    /// A physical group that is not there.
    #[error(
        "has no physical {dimension} {name}{}; there are: {}",
        meant(nearest),
        List(known)
    )]
    UnknownGroup {
        /// Surface or volume.
        dimension: &'static str,
        /// As the scene calls it.
        name: GroupName,
        /// The known one most like it.
        nearest: Option<GroupName>,
        /// All of that dimension.
        known: Vec<GroupName>,
    },
    /// A physical group of points where a surface is needed, and the like.
    #[error("{name} is a physical {found}, but a physical {expected} is needed here")]
    WrongDimension {
        /// As the scene calls it.
        name: GroupName,
        /// What it is.
        found: &'static str,
        /// What it has to be.
        expected: &'static str,
    },
    /// A physical group without elements.
    #[error("physical {dimension} {name} has no {elements}; mesh its entities, or leave it out")]
    EmptyGroup {
        /// Surface or volume.
        dimension: &'static str,
        /// As the scene calls it.
        name: GroupName,
        /// What it should have.
        elements: &'static str,
    },
    /// An element without material.
    #[error(
        "hexahedron {element} at {}, in the physical volumes: {}, has no material; let the first material have no `volume`, so that it fills the rest",
        point(center),
        List(volumes)
    )]
    NoMaterial {
        /// The element.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
        /// Physical volumes that it is in.
        volumes: Vec<GroupName>,
    },
    /// Surface elements that are no four-node quadrilaterals.
    #[error(
        "physical surface {surface} has {count} {kind}, the first of them element {element} at {}; faces of hexahedra are four-node quadrilaterals (Recombine Surface)",
        point(center)
    )]
    NotQuadrilaterals {
        /// As the scene calls it.
        surface: GroupName,
        /// Their number.
        count: u64,
        /// What they are.
        kind: &'static str,
        /// The first one.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
    },
    /// A surface that has no face in common with the body.
    #[error(
        "physical surface {surface} touches nothing: none of its {count} quadrilaterals is a face of a hexahedron; the first, element {element}, lies at {}",
        point(center)
    )]
    TouchesNothing {
        /// As the scene calls it.
        surface: GroupName,
        /// Its quadrilaterals.
        count: usize,
        /// The first one.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
    },
    /// A quadrilateral that is no face of the body.
    #[error(
        "quadrilateral {element} of physical surface {surface} at {} is no face of a hexahedron; embed the surface in the volume before meshing (BooleanFragments)",
        point(center)
    )]
    NoFace {
        /// As the scene calls it.
        surface: GroupName,
        /// The quadrilateral.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
    },
    /// A fracture on the surface of the body.
    #[error(
        "quadrilateral {element} of physical surface {surface} at {} lies on the boundary of the body, where there is rock on one side only; a fracture must lie inside",
        point(center)
    )]
    FractureOutside {
        /// As the scene calls it.
        surface: GroupName,
        /// The quadrilateral.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
    },
    /// A boundary inside the body.
    #[error(
        "quadrilateral {element} of physical surface {surface} at {} lies inside the body, between hexahedra {first} and {second}; a boundary condition needs a surface of the body",
        point(center)
    )]
    BoundaryInside {
        /// As the scene calls it.
        surface: GroupName,
        /// The quadrilateral.
        element: u64,
        /// Its centre [m].
        center: [f64; 3],
        /// One neighbour.
        first: u64,
        /// The other one.
        second: u64,
    },
    /// A fracture with one side only.
    #[error(
        "fracture \"{fracture}\" has no two sides: its normal comes back reversed around a loop through the face at {}; divide it into two fractures",
        point(center)
    )]
    OneSided {
        /// Its name.
        fracture: String,
        /// Centre of a face where both orientations meet [m].
        center: [f64; 3],
    },
}
