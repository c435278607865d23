//! A box of bricks with fractures, mapped and split.

use super::error::MAX_NODES;
use super::jacobian::corners;
use super::plane_fracture::cuts;
use super::{
    Axis, FACES, FaceSide, FractureMesh, Grid, HexMesh, MeshError, PlaneFracture, Warp,
    WarpContext, check_jacobians, split,
};

/// A region of material.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxRegion {
    /// Its name, for messages.
    pub name: String,
    /// Boxes [from, to] per axis, before any map [m]: the cells whose centre lies in one of them. None at all = every cell.
    pub boxes: Vec<[[f64; 2]; 3]>,
}

impl BoxRegion {
    /// Whether a point lies in one of its boxes, or it has none.
    pub(super) fn holds(&self, point: [f64; 3]) -> bool {
        let inside = |b: &[[f64; 2]; 3]| (0..3).all(|d| (b[d][0]..=b[d][1]).contains(&point[d]));
        self.boxes.is_empty() || self.boxes.iter().any(inside)
    }
}

/// Everything that makes a mesh.
#[derive(Debug)]
pub struct BoxGrid {
    /// The three axes.
    pub axes: [Axis; 3],
    /// Regions; where two overlap the later one wins.
    pub regions: Vec<BoxRegion>,
    /// Fractures.
    pub fractures: Vec<PlaneFracture>,
    /// Maps, applied in order.
    pub warps: Vec<Box<dyn Warp>>,
}

/// A mesh, its fractures and its sides.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltMesh {
    /// The body.
    pub mesh: HexMesh,
    /// Its fractures.
    pub fractures: FractureMesh,
    /// Faces on x−, x+, y−, y+, z−, z+ of a box, or on the surfaces that were asked for; nodes counter-clockwise seen from
    /// outside.
    pub sides: Vec<Vec<FaceSide>>,
}

impl BoxGrid {
    /// A box of one region without fractures or maps.
    pub fn new(axes: [Axis; 3]) -> Self {
        Self {
            axes,
            regions: vec![BoxRegion {
                name: "rock".into(),
                boxes: Vec::new(),
            }],
            fractures: Vec::new(),
            warps: Vec::new(),
        }
    }

    /// The unit of every test: the box `from`–`to` in `cells` equal cells.
    pub fn uniform(from: [f64; 3], to: [f64; 3], cells: [usize; 3]) -> Self {
        Self::new([0, 1, 2].map(|d: usize| Axis::uniform(from[d], to[d], cells[d])))
    }

    /// Grid, regions, maps, splitting, frames and edges.
    ///
    /// # Cost
    /// O(elements) time and memory.
    ///
    /// # Errors
    /// [`MeshError`], which names the axis, fracture, region or element.
    pub fn build(&self) -> Result<BuiltMesh, MeshError> {
        let lines = [
            self.axes[0].lines(0)?,
            self.axes[1].lines(1)?,
            self.axes[2].lines(2)?,
        ];
        let count = lines.iter().map(|l| l.len() as u128).product::<u128>();
        if count > MAX_NODES {
            return Err(MeshError::TooManyNodes { nodes: count });
        }
        let parts = self.fractures.len().max(self.regions.len());
        if parts > usize::from(u16::MAX) {
            return Err(MeshError::TooManyParts { count: parts });
        }
        let cells = [0, 1, 2].map(|d: usize| lines[d].len() - 1);
        let regions = self.regions(&lines)?;
        let cuts = cuts(&lines, &self.fractures)?;
        let mut nodes = grid_nodes(&lines);
        let mut elements = grid_elements(cells);

        let mut on_fracture = vec![[false; 3]; nodes.len()];
        for cut in &cuts {
            let axis = self.fractures[usize::from(cut.fracture)].axis;
            for a in FACES[usize::from(cut.minus.1)] {
                on_fracture[elements[cut.minus.0 as usize][a] as usize][axis] = true;
            }
        }
        let on_side: Vec<[bool; 3]> = (0..nodes.len())
            .map(|a| {
                let index = grid_index(a, cells);
                [0, 1, 2].map(|d: usize| index[d] == 0 || index[d] == cells[d])
            })
            .collect();
        let context = WarpContext {
            lines: &lines,
            on_side: &on_side,
            on_fracture: &on_fracture,
        };
        for warp in &self.warps {
            warp.apply(&mut nodes, &context)?;
        }

        let mut origin: Vec<u32> = (0..nodes.len() as u32).collect();
        let pairs = split(&mut nodes, &mut elements, &mut origin, &cuts);
        let mesh = HexMesh {
            nodes,
            elements,
            regions,
            origin,
            grid: Some(Grid {
                cells,
                lines,
                axis_aligned: self.warps.is_empty(),
            }),
        };
        let advice = self
            .warps
            .last()
            .map_or("check the grid lines", |w| w.advice());
        check_jacobians(&mesh, advice)?;

        let names = self.fractures.iter().map(|f| f.name.clone()).collect();
        let fractures = FractureMesh::between(names, &cuts, &pairs, &mesh);
        let sides = (0..6).map(|side| side_faces(&mesh, cells, side)).collect();
        Ok(BuiltMesh {
            mesh,
            fractures,
            sides,
        })
    }

    /// Region per element, from its centre before any map.
    fn regions(&self, lines: &[Vec<f64>; 3]) -> Result<Vec<u16>, MeshError> {
        let cells = [0, 1, 2].map(|d: usize| lines[d].len() - 1);
        let mut used = vec![false; self.regions.len()];
        let mut regions = Vec::with_capacity(cells.iter().product());
        for e in 0..cells.iter().product::<usize>() {
            let index = [
                e % cells[0],
                e / cells[0] % cells[1],
                e / (cells[0] * cells[1]),
            ];
            let center =
                [0, 1, 2].map(|d: usize| 0.5 * (lines[d][index[d]] + lines[d][index[d] + 1]));
            let mut found = None;
            for (r, region) in self.regions.iter().enumerate() {
                if region.holds(center) {
                    used[r] |= !region.boxes.is_empty();
                    found = Some(r as u16);
                }
            }
            regions.push(found.ok_or(MeshError::NoRegion { element: e, center })?);
        }
        for (region, used) in self.regions.iter().zip(used) {
            if !used && !region.boxes.is_empty() {
                return Err(MeshError::EmptyRegion {
                    region: region.name.clone(),
                });
            }
        }
        Ok(regions)
    }
}

/// (i, j, k) of a grid node.
fn grid_index(node: usize, cells: [usize; 3]) -> [usize; 3] {
    let [nx, ny] = [cells[0] + 1, cells[1] + 1];
    [node % nx, node / nx % ny, node / (nx * ny)]
}

/// Nodes in lexicographic order.
fn grid_nodes(lines: &[Vec<f64>; 3]) -> Vec<[f64; 3]> {
    let mut nodes = Vec::with_capacity(lines.iter().map(Vec::len).product());
    for z in &lines[2] {
        for y in &lines[1] {
            nodes.extend(lines[0].iter().map(|x| [*x, *y, *z]));
        }
    }
    nodes
}

/// Elements in lexicographic order, VTK node order.
fn grid_elements([nx, ny, nz]: [usize; 3]) -> Vec<[u32; 8]> {
    let node = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    let mut elements = Vec::with_capacity(nx * ny * nz);
    for k in 0..nz {
        for j in 0..ny {
            elements.extend((0..nx).map(|i| {
                [
                    node(i, j, k),
                    node(i + 1, j, k),
                    node(i + 1, j + 1, k),
                    node(i, j + 1, k),
                    node(i, j, k + 1),
                    node(i + 1, j, k + 1),
                    node(i + 1, j + 1, k + 1),
                    node(i, j + 1, k + 1),
                ]
            }));
        }
    }
    elements
}

/// Element faces on one side of the box (x−, x+, y−, y+, z−, z+), in order of their elements.
fn side_faces(mesh: &HexMesh, cells: [usize; 3], side: usize) -> Vec<FaceSide> {
    let axis = side / 2;
    let layer = if side.is_multiple_of(2) {
        0
    } else {
        cells[axis] - 1
    };
    mesh.elements
        .iter()
        .enumerate()
        .filter(|(e, _)| {
            [
                e % cells[0],
                e / cells[0] % cells[1],
                e / (cells[0] * cells[1]),
            ][axis]
                == layer
        })
        .map(|(e, nodes)| FaceSide {
            element: e as u32,
            nodes: FACES[side].map(|a| nodes[a]),
        })
        .collect()
}

impl BuiltMesh {
    /// Volume of element `e` [m³].
    pub fn volume(&self, e: usize) -> f64 {
        super::jacobian::volume(&corners(&self.mesh, e))
    }
}
