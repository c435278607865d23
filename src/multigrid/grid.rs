//! The cells of one level and the elements in them.

use crate::mesh::HexMesh;
use std::borrow::Cow;
use std::ops::Range;

/// Steps along x, y, z from the lowest corner of a cell to each corner, VTK order.
pub(super) const STEPS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
];

/// Per axis, the corners on the upper face of a cell and those of the next cell that lie on them.
pub(super) const ACROSS: [[[usize; 2]; 4]; 3] = [
    [[1, 0], [2, 3], [5, 4], [6, 7]],
    [[3, 0], [2, 1], [7, 4], [6, 5]],
    [[4, 0], [5, 1], [6, 2], [7, 3]],
];

/// A box of cells; a cell that fractures cut holds one element per side, each with its own corner nodes.
///
/// Nodes are numbered as vertices, x fastest; further copies of a vertex come behind all of those.
#[derive(Clone, Debug)]
pub(super) struct Grid<'a> {
    pub(super) cells: [usize; 3],
    /// Positions per axis, before any map [m].
    pub(super) lines: [Cow<'a, [f64]>; 3],
    /// Which line of the finest grid each line is.
    pub(super) origin: [Vec<u32>; 3],
    pub(super) nodes: usize,
    pub(super) elements: Cow<'a, [[u32; 8]]>,
    /// First element of every cell, and one more; `None` where element = cell.
    pub(super) first: Option<Vec<u32>>,
    /// Vertices of the copies (of the coarse levels only).
    pub(super) copies: Vec<u32>,
}

impl<'a> Grid<'a> {
    /// The finest grid, or `None` if the mesh follows none: its elements are the cells, its nodes vertices or copies of them.
    pub(super) fn of_mesh(mesh: &'a HexMesh) -> Option<Self> {
        let grid = mesh.grid.as_ref()?;
        let count = grid.cells.iter().product::<usize>();
        if count != mesh.elements.len() || grid.node_count() > mesh.nodes.len() {
            return None;
        }
        let finest = Self {
            cells: grid.cells,
            lines: [0, 1, 2].map(|d: usize| Cow::Borrowed(&*grid.lines[d])),
            origin: grid.cells.map(|n| (0..=n as u32).collect()),
            nodes: mesh.nodes.len(),
            elements: Cow::Borrowed(&mesh.elements),
            first: None,
            copies: Vec::new(),
        };
        // every corner is a vertex of its cell or was split from it: threads rely on that
        let follows = (0..count).all(|cell| {
            let at = finest.place(cell);
            mesh.elements[cell].iter().zip(STEPS).all(|(node, up)| {
                let mut node = *node as usize;
                while mesh.origin[node] as usize != node {
                    node = mesh.origin[node] as usize;
                }
                node == finest.vertex([0, 1, 2].map(|d: usize| at[d] + up[d]))
            })
        });
        follows.then_some(finest)
    }

    /// Number of the cell (i, j, k).
    pub(super) fn cell(&self, at: [usize; 3]) -> usize {
        at[0] + self.cells[0] * (at[1] + self.cells[1] * at[2])
    }

    /// (i, j, k) of a cell.
    pub(super) fn place(&self, cell: usize) -> [usize; 3] {
        let [nx, ny, _] = self.cells;
        [cell % nx, cell / nx % ny, cell / (nx * ny)]
    }

    /// The cells whose place along `axis` is `at`.
    pub(super) fn layer(&self, axis: usize, at: usize) -> impl Iterator<Item = usize> {
        let [n, m] = [(axis + 1) % 3, (axis + 2) % 3].map(|d| self.cells[d]);
        (0..n * m).map(move |k| {
            let mut place = [at; 3];
            place[(axis + 1) % 3] = k % n;
            place[(axis + 2) % 3] = k / n;
            self.cell(place)
        })
    }

    /// Number of the vertex (i, j, k).
    pub(super) fn vertex(&self, at: [usize; 3]) -> usize {
        at[0] + (self.cells[0] + 1) * (at[1] + (self.cells[1] + 1) * at[2])
    }

    /// Vertices.
    pub(super) fn vertices(&self) -> usize {
        self.cells.iter().map(|n| n + 1).product()
    }

    /// Elements of a cell.
    pub(super) fn elements_in(&self, cell: usize) -> Range<usize> {
        match &self.first {
            Some(first) => first[cell] as usize..first[cell + 1] as usize,
            None => cell..cell + 1,
        }
    }

    /// True where two elements of neighbouring cells share the four nodes of the face between them.
    pub(super) fn joined(&self, low: usize, high: usize, axis: usize) -> bool {
        let (low, high) = (&self.elements[low], &self.elements[high]);
        ACROSS[axis].iter().all(|[a, b]| low[*a] == high[*b])
    }

    /// Edge lengths of a cell, before any map.
    pub(super) fn size(&self, at: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|d: usize| self.spacing(d, at[d]))
    }

    /// Length of cell i of an axis, before any map.
    pub(super) fn spacing(&self, axis: usize, i: usize) -> f64 {
        self.lines[axis][i + 1] - self.lines[axis][i]
    }

    /// Every line of every axis.
    pub(super) fn all_lines(&self) -> [Vec<usize>; 3] {
        self.cells.map(|n| (0..=n).collect())
    }

    /// Vertex (i, j, k) of the finest grid at which a node lies.
    pub(super) fn finest_place(&self, node: usize) -> [usize; 3] {
        let vertex = match node.checked_sub(self.vertices()) {
            Some(copy) => self.copies[copy] as usize,
            None => node,
        };
        let [nx, ny] = [self.cells[0] + 1, self.cells[1] + 1];
        let at = [vertex % nx, vertex / nx % ny, vertex / (nx * ny)];
        [0, 1, 2].map(|d: usize| self.origin[d][at[d]] as usize)
    }
}
