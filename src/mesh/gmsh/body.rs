//! A body of hexahedra that meet face to face, and how it is split along its fractures.

use std::collections::HashMap;

use super::conforming::require_conforming;
use super::distinct::require_distinct;
use super::faces::{Face, Faces, corners, mean};
use super::file::Cell;
use super::orientation::turned;
use super::{GmshDefect, GmshError, GmshFile, GroupName, Surface};
use crate::mesh::jacobian::{center, volume};
use crate::mesh::{
    BoxRegion, BuiltMesh, Cut, FACES, FaceSide, FractureMesh, HexMesh, MeshError, min_jacobian,
    split,
};
use rayon::prelude::*;

/// The hexahedra of a file: positively oriented, meeting face to face.
#[derive(Clone, Debug)]
pub struct GmshMesh {
    /// Positions in metres.
    pub(super) file: GmshFile,
    pub(super) faces: Faces,
}

/// A fracture on physical surfaces.
#[derive(Clone, Debug)]
pub struct SurfaceFracture {
    /// Its name.
    pub name: String,
    /// Its faces.
    pub surface: Surface,
    /// The normal points the other way.
    pub flip: bool,
}

/// The same element with its reference axis ζ reversed.
const MIRRORED: [usize; 8] = [4, 5, 6, 7, 0, 1, 2, 3];

impl GmshMesh {
    /// Checks the body; `unit` is the length of one unit of the file [m].
    ///
    /// Left-handed hexahedra are mirrored, a hexahedron that the file repeats for each of its physical volumes (as format
    /// 2.2 does) becomes one that is in all of them, and nodes without hexahedron are dropped when it is built.
    ///
    /// # Cost
    /// O(n log n) for n elements, 144 bytes each for their faces.
    ///
    /// # Errors
    /// [`GmshError`]: no hexahedra or other volume elements, inverted, equal or overlapping hexahedra, nodes at one place,
    /// faces that touch without being shared.
    pub fn new(mut file: GmshFile, unit: f64) -> Result<Self, GmshError> {
        for x in file.nodes.iter_mut().flatten() {
            *x *= unit;
        }
        for x in file.others.iter_mut().flat_map(|o| &mut o.center) {
            *x *= unit;
        }
        match checked(&mut file) {
            Ok(faces) => Ok(Self { file, faces }),
            Err(defect) => Err(file.error(defect)),
        }
    }

    /// Marks of the hexahedra in physical volumes.
    ///
    /// # Errors
    /// [`GmshError`] for a name that no volume has, or one without hexahedra.
    pub fn in_volumes(&self, names: &[GroupName]) -> Result<Vec<bool>, GmshError> {
        let cells = &self.file.hexahedra;
        let mut marks = vec![false; cells.len()];
        for name in names {
            let numbers = self.file.groups.find(3, name);
            let numbers = numbers.map_err(|defect| self.file.error(defect))?;
            let mut found = false;
            for (mark, cell) in marks.iter_mut().zip(cells) {
                let is_here = self.file.groups.touches(cell.set, &numbers);
                *mark |= is_here;
                found |= is_here;
            }
            if !found {
                return Err(self.file.error(GmshDefect::EmptyGroup {
                    dimension: "volume",
                    name: name.clone(),
                    elements: "hexahedron",
                }));
            }
        }
        Ok(marks)
    }

    /// Region of every element: the last one whose box its centre lies in and whose marks, if any, have it.
    ///
    /// # Errors
    /// [`MeshError`] for a region without elements, or an element without region.
    pub fn regions(
        &self,
        regions: &[BoxRegion],
        marks: &[Option<Vec<bool>>],
    ) -> Result<Vec<u16>, MeshError> {
        if regions.len() > usize::from(u16::MAX) {
            let count = regions.len();
            return Err(MeshError::TooManyParts { count });
        }
        let mut used = vec![false; regions.len()];
        let mut found = Vec::with_capacity(self.file.hexahedra.len());
        for (e, cell) in self.file.hexahedra.iter().enumerate() {
            let at = center(&corners_of(&self.file, cell));
            let mut region = None;
            for (r, candidate) in regions.iter().enumerate() {
                let is_marked = marks[r].as_ref().is_none_or(|marks| marks[e]);
                if is_marked && candidate.holds(at) {
                    used[r] = true;
                    region = Some(r as u16);
                }
            }
            found.push(region.ok_or_else(|| {
                let volumes = self.file.groups.of(cell.set).iter();
                self.file.error(GmshDefect::NoMaterial {
                    element: cell.id,
                    center: at,
                    volumes: volumes.map(|v| self.file.groups.name(3, *v)).collect(),
                })
            })?);
        }
        let mut unused = regions.iter().zip(used).filter(|(_, used)| !used);
        match unused.next() {
            Some((region, _)) => Err(MeshError::EmptyRegion {
                region: region.name.clone(),
            }),
            None => Ok(found),
        }
    }

    /// Splits the body along its fractures; `boundaries` become the sides.
    ///
    /// The normal of a fracture is the same across all its inner edges. N = Σ area vectors of a connected part is positive
    /// along the first of x, y, z along which it has at least half of its largest component; closed parts point outwards;
    /// `flip` reverses. Faces of a fracture come in order of their elements.
    ///
    /// # Cost
    /// O(n log n) for n elements.
    ///
    /// # Errors
    /// [`MeshError`]: a face in two fractures, a fracture with one side.
    pub fn build(
        self,
        regions: Vec<u16>,
        fractures: &[SurfaceFracture],
        boundaries: &[Surface],
    ) -> Result<BuiltMesh, MeshError> {
        if fractures.len() > usize::from(u16::MAX) {
            let count = fractures.len();
            return Err(MeshError::TooManyParts { count });
        }
        let cuts = self.cuts(fractures)?;
        drop(self.faces);
        let (mut nodes, mut elements) = compacted(self.file);
        let mut origin: Vec<u32> = (0..nodes.len() as u32).collect();
        let pairs = split(&mut nodes, &mut elements, &mut origin, &cuts);
        let mesh = HexMesh {
            nodes,
            elements,
            regions,
            origin,
            grid: None,
        };
        let names = fractures.iter().map(|f| f.name.clone()).collect();
        let side = |(_, element, face): &Face| FaceSide {
            element: *element,
            nodes: FACES[usize::from(*face)].map(|a| mesh.elements[*element as usize][a]),
        };
        let sides = boundaries
            .iter()
            .map(|b| b.faces.iter().map(side).collect());
        Ok(BuiltMesh {
            sides: sides.collect(),
            fractures: FractureMesh::between(names, &cuts, &pairs, &mesh),
            mesh,
        })
    }

    /// Faces to cut, fracture by fracture.
    fn cuts(&self, fractures: &[SurfaceFracture]) -> Result<Vec<Cut>, MeshError> {
        let cells = &self.file.hexahedra;
        let mut owner: HashMap<[u32; 4], usize> = HashMap::new();
        let mut cuts = Vec::new();
        for (index, fracture) in fractures.iter().enumerate() {
            let (pairs, _) = fracture.surface.faces.as_chunks::<2>();
            for [(key, ..), _] in pairs {
                if let Some(first) = owner.insert(*key, index) {
                    return Err(MeshError::Overlap {
                        first: fractures[first].name.clone(),
                        second: fracture.name.clone(),
                        center: mean(&key.map(|n| self.file.nodes[n as usize])),
                    });
                }
            }
            let quads: Vec<[u32; 4]> = pairs.iter().map(|[a, _]| corners(cells, a)).collect();
            let turned = turned(&fracture.name, &quads, &self.file.nodes);
            let turned = turned.map_err(|defect| self.file.error(defect))?;
            for ([first, second], turned) in pairs.iter().zip(turned) {
                // the nodes run around the normal that leaves the first element
                let [minus, plus] = match turned ^ fracture.flip {
                    false => [first, second],
                    true => [second, first],
                };
                cuts.push(Cut {
                    fracture: index as u16,
                    minus: (minus.1, minus.2),
                    plus: (plus.1, plus.2),
                });
            }
        }
        Ok(cuts)
    }
}

fn corners_of(file: &GmshFile, cell: &Cell<8>) -> [[f64; 3]; 8] {
    cell.nodes.map(|n| file.nodes[n as usize])
}

/// Merges, mirrors and checks the hexahedra, and finds their faces.
fn checked(file: &mut GmshFile) -> Result<Faces, GmshDefect> {
    if let Some(other) = file.others.iter().find(|o| o.kind.dimension == 3) {
        let alike = file.others.iter().filter(|o| o.kind == other.kind);
        return Err(GmshDefect::OtherVolumes {
            count: alike.map(|o| o.count).sum(),
            kind: other.kind.name,
            element: other.first,
            center: other.center,
        });
    }
    if file.hexahedra.is_empty() {
        let others: u64 = file.others.iter().map(|o| o.count).sum();
        return Err(GmshDefect::NoHexahedra {
            surfaces: file.quadrilaterals.len() as u64 + others,
        });
    }
    merge(file)?;
    let GmshFile {
        hexahedra: cells,
        nodes,
        tags,
        ..
    } = file;
    let place = |n: u32| nodes[n as usize];
    cells.par_iter_mut().for_each(|cell| {
        if volume(&cell.nodes.map(place)) < 0.0 {
            cell.nodes = MIRRORED.map(|a| cell.nodes[a]);
        }
    });
    let inverted = cells.par_iter().find_map_first(|cell| {
        let x = cell.nodes.map(place);
        let min_jacobian = min_jacobian(&x);
        match min_jacobian > 0.0 {
            true => None,
            false => Some(GmshDefect::Inverted {
                element: cell.id,
                center: center(&x),
                min_jacobian,
            }),
        }
    });
    if let Some(defect) = inverted {
        return Err(defect);
    }
    require_distinct(cells, nodes, tags)?;
    let faces = Faces::new(cells, nodes)?;
    require_conforming(cells, nodes, &faces)?;
    Ok(faces)
}

/// Makes one of hexahedra with the same nodes in different physical volumes.
fn merge(file: &mut GmshFile) -> Result<(), GmshDefect> {
    let sorted = |cell: &Cell<8>| {
        let mut nodes = cell.nodes;
        nodes.sort_unstable();
        nodes
    };
    let mut keys: Vec<([u32; 8], u32)> = file
        .hexahedra
        .par_iter()
        .enumerate()
        .map(|(e, cell)| (sorted(cell), e as u32))
        .collect();
    keys.par_sort_unstable();
    let mut is_copy = vec![false; keys.len()];
    for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let [first, second] = [pair[0].1, pair[1].1].map(|e| file.hexahedra[e as usize]);
        let groups = file.groups.of(second.set).to_vec();
        if groups.is_empty() || file.groups.touches(first.set, &groups) {
            return Err(GmshDefect::SameHexahedra {
                first: first.id,
                second: second.id,
                center: center(&corners_of(file, &first)),
            });
        }
        // handed on to the last one of them
        file.hexahedra[pair[1].1 as usize].set = file.groups.union(3, first.set, second.set);
        is_copy[pair[0].1 as usize] = true;
    }
    let mut copies = is_copy.into_iter();
    file.hexahedra.retain(|_| copies.next() != Some(true));
    Ok(())
}

/// Nodes that hexahedra have, in order of the file, and the elements in their numbering.
fn compacted(file: GmshFile) -> (Vec<[f64; 3]>, Vec<[u32; 8]>) {
    let mut places = vec![0u32; file.nodes.len()];
    for node in file.hexahedra.iter().flat_map(|cell| cell.nodes) {
        places[node as usize] = 1;
    }
    let mut nodes = Vec::new();
    for (place, x) in places.iter_mut().zip(&file.nodes) {
        if *place == 1 {
            *place = nodes.len() as u32;
            nodes.push(*x);
        }
    }
    let elements = file.hexahedra.iter();
    let elements = elements.map(|cell| cell.nodes.map(|n| places[n as usize]));
    (nodes, elements.collect())
}
