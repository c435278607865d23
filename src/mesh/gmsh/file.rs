//! What a Gmsh file says.

use std::io::Read;
use std::path::Path;

use super::cursor::Cursor;
use super::element_kind::{ElementKind, HEXAHEDRON, QUADRILATERAL};
use super::groups::Groups;
use super::tags::Tags;
use super::{GmshDefect, GmshError, header};

/// An element: its number in the file, places of its nodes, its set of physical groups.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<const N: usize> {
    pub(super) id: u64,
    pub(super) nodes: [u32; N],
    pub(super) set: u32,
}

/// Elements of one type and one set of groups that are neither hexahedra nor quadrilaterals.
#[derive(Clone, Debug)]
pub(super) struct Others {
    pub(super) kind: &'static ElementKind,
    pub(super) set: u32,
    pub(super) count: u64,
    /// Number of the first one.
    pub(super) first: u64,
    /// Its centre, in units of the file.
    pub(super) center: [f64; 3],
}

/// Where a file announces its nodes, at the latest: entities stand before them.
const HEAD: u64 = 1 << 24;

/// Nodes, hexahedra, quadrilaterals and physical groups of a Gmsh file.
#[derive(Clone, Debug)]
pub struct GmshFile {
    /// File name, for messages.
    pub(super) name: String,
    /// Positions, in units of the file.
    pub(super) nodes: Vec<[f64; 3]>,
    /// Their numbers.
    pub(super) tags: Vec<u64>,
    pub(super) places: Option<Tags>,
    pub(super) hexahedra: Vec<Cell<8>>,
    pub(super) quadrilaterals: Vec<Cell<4>>,
    pub(super) others: Vec<Others>,
    pub(super) groups: Groups,
}

impl GmshFile {
    /// Reads a file of format 2.2 or 4.1, ASCII or little-endian binary.
    ///
    /// # Cost
    /// O(size of the file) time and memory.
    ///
    /// # Errors
    /// [`GmshError`] with the line of a text or the byte of a binary file.
    ///
    /// # Source
    /// Gmsh reference manual, "MSH file format" and "MSH file format version 2 (Legacy)".
    pub fn read(path: &Path) -> Result<Self, GmshError> {
        let name = path.display().to_string();
        match std::fs::read(path) {
            Ok(bytes) => Self::parse(&bytes, &name),
            Err(error) => Err(GmshError::new(
                &name,
                GmshDefect::Read {
                    reason: error.kind(),
                },
            )),
        }
    }

    /// The number of nodes that a file announces; no more than its first 16 MiB are read.
    ///
    /// # Errors
    /// [`GmshError`] where a file has no nodes there.
    pub fn announced_nodes(path: &Path) -> Result<u64, GmshError> {
        let name = path.display().to_string();
        let read = || -> std::io::Result<Vec<u8>> {
            let mut bytes = Vec::new();
            std::fs::File::open(path)?
                .take(HEAD)
                .read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        let bytes = read().map_err(|error| GmshDefect::Read {
            reason: error.kind(),
        });
        bytes
            .and_then(|bytes| header::node_count(&mut Cursor::new(&bytes)))
            .map_err(|defect| GmshError::new(&name, defect))
    }

    /// [`GmshFile::read`] from bytes; `name` is for messages.
    ///
    /// # Errors
    /// As [`GmshFile::read`].
    pub fn parse(bytes: &[u8], name: &str) -> Result<Self, GmshError> {
        let mut file = Self {
            name: name.into(),
            nodes: Vec::new(),
            tags: Vec::new(),
            places: None,
            hexahedra: Vec::new(),
            quadrilaterals: Vec::new(),
            others: Vec::new(),
            groups: Groups::new(),
        };
        match header::sections(&mut Cursor::new(bytes), &mut file) {
            Ok(()) => Ok(file),
            Err(defect) => Err(GmshError::new(name, defect)),
        }
    }

    /// A node, whose coordinates must be finite.
    pub(super) fn add_node(
        &mut self,
        cursor: &Cursor<'_>,
        tag: u64,
        at: [f64; 3],
    ) -> Result<(), GmshDefect> {
        if let Some(value) = at.iter().find(|x| !x.is_finite()) {
            return Err(GmshDefect::NotFinite {
                spot: cursor.before(),
                node: tag,
                value: *value,
            });
        }
        self.tags.push(tag);
        self.nodes.push(at);
        Ok(())
    }

    /// After the last node.
    pub(super) fn close_nodes(&mut self) -> Result<(), GmshDefect> {
        if self.nodes.len() as u128 > crate::mesh::MAX_NODES {
            return Err(GmshDefect::TooManyNodes {
                nodes: self.nodes.len(),
            });
        }
        let places = Tags::new(&self.tags);
        self.places = Some(places.map_err(|node| GmshDefect::NodeTwice { node })?);
        Ok(())
    }

    /// An element with its node numbers; points and curves are passed over.
    pub(super) fn add_element(
        &mut self,
        cursor: &Cursor<'_>,
        kind: &'static ElementKind,
        id: u64,
        tags: &[u64],
        set: u32,
    ) -> Result<(), GmshDefect> {
        if kind.dimension < 2 {
            return Ok(());
        }
        let places = self.places.as_ref();
        let place = |tag: u64| {
            let place = places.and_then(|p| p.place(tag));
            place.ok_or_else(|| GmshDefect::UnknownNode {
                spot: cursor.before(),
                element: id,
                node: tag,
            })
        };
        if let (HEXAHEDRON, Ok(tags)) = (kind.number, <[u64; 8]>::try_from(tags)) {
            let mut nodes = [0; 8];
            for (node, tag) in nodes.iter_mut().zip(tags) {
                *node = place(tag)?;
            }
            self.hexahedra.push(Cell { id, nodes, set });
            return Ok(());
        }
        if let (QUADRILATERAL, Ok(tags)) = (kind.number, <[u64; 4]>::try_from(tags)) {
            let mut nodes = [0; 4];
            for (node, tag) in nodes.iter_mut().zip(tags) {
                *node = place(tag)?;
            }
            self.quadrilaterals.push(Cell { id, nodes, set });
            return Ok(());
        }
        let mut center = [0.0; 3];
        for tag in tags {
            let at = self.nodes[place(*tag)? as usize];
            for d in 0..3 {
                center[d] += at[d] / tags.len() as f64;
            }
        }
        let mut known = self.others.iter_mut().rev();
        match known.find(|o| o.kind == kind && o.set == set) {
            Some(others) => others.count += 1,
            None => self.others.push(Others {
                kind,
                set,
                count: 1,
                first: id,
                center,
            }),
        }
        Ok(())
    }

    /// `error` with the file's name.
    pub(super) fn error(&self, defect: GmshDefect) -> GmshError {
        GmshError::new(&self.name, defect)
    }
}
