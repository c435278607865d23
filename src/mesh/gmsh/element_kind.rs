//! The element types of Gmsh: what is not a hexahedron or a quadrilateral is passed over or named.

/// A type of element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ElementKind {
    /// Its number in the file.
    pub(super) number: i64,
    /// Dimension: 0 points, 1 curves, 2 surfaces, 3 volumes.
    pub(super) dimension: u8,
    /// Nodes of an element.
    pub(super) nodes: usize,
    /// What several of them are called.
    pub(super) name: &'static str,
}

/// Four-node quadrilaterals.
pub(super) const QUADRILATERAL: i64 = 3;

/// Eight-node hexahedra.
pub(super) const HEXAHEDRON: i64 = 5;

const fn kind(number: i64, dimension: u8, nodes: usize, name: &'static str) -> ElementKind {
    ElementKind {
        number,
        dimension,
        nodes,
        name,
    }
}

/// # Source
/// Gmsh reference manual, "MSH file format", list of element types.
const KINDS: [ElementKind; 34] = [
    kind(1, 1, 2, "lines"),
    kind(2, 2, 3, "triangles"),
    kind(QUADRILATERAL, 2, 4, "quadrilaterals"),
    kind(4, 3, 4, "tetrahedra"),
    kind(HEXAHEDRON, 3, 8, "hexahedra"),
    kind(6, 3, 6, "prisms"),
    kind(7, 3, 5, "pyramids"),
    kind(8, 1, 3, "3-node lines"),
    kind(9, 2, 6, "6-node triangles"),
    kind(10, 2, 9, "9-node quadrilaterals"),
    kind(11, 3, 10, "10-node tetrahedra"),
    kind(12, 3, 27, "27-node hexahedra"),
    kind(13, 3, 18, "18-node prisms"),
    kind(14, 3, 14, "14-node pyramids"),
    kind(15, 0, 1, "points"),
    kind(16, 2, 8, "8-node quadrilaterals"),
    kind(17, 3, 20, "20-node hexahedra"),
    kind(18, 3, 15, "15-node prisms"),
    kind(19, 3, 13, "13-node pyramids"),
    kind(20, 2, 9, "9-node triangles"),
    kind(21, 2, 10, "10-node triangles"),
    kind(22, 2, 12, "12-node triangles"),
    kind(23, 2, 15, "15-node triangles"),
    kind(24, 2, 15, "15-node triangles"),
    kind(25, 2, 21, "21-node triangles"),
    kind(26, 1, 4, "4-node lines"),
    kind(27, 1, 5, "5-node lines"),
    kind(28, 1, 6, "6-node lines"),
    kind(29, 3, 20, "20-node tetrahedra"),
    kind(30, 3, 35, "35-node tetrahedra"),
    kind(31, 3, 56, "56-node tetrahedra"),
    kind(36, 2, 16, "16-node quadrilaterals"),
    kind(92, 3, 64, "64-node hexahedra"),
    kind(93, 3, 125, "125-node hexahedra"),
];

/// The type with this number.
pub(super) fn element_kind(number: i64) -> Option<&'static ElementKind> {
    KINDS.iter().find(|kind| kind.number == number)
}
