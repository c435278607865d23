//! Stiffness products on rectilinear grids without a matrix: line by line through the grid, in modes of bricks.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::brick::Brick;
use super::modes::LEXICOGRAPHIC;
use super::sweep::{Product, Rest, TASK};
use crate::elasticity::{Elastic, ElasticityError, check};
use crate::mesh::HexMesh;
use fracas_operators::operator::assert_product;
use fracas_operators::shared::Colours;
use fracas_operators::simd::{Level, MAX_WIDTH};
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};

/// The stiffness `A` of a body of axis-aligned bricks, in full numbering.
///
/// Every element is worth its modes (sums and differences of corner values); along a line of elements
/// the registers hold consecutive elements, so no index is read; the last register of a line may overlap the one before.
/// Elements at split nodes, and the last few of a line, take an indexed path.
///
/// # Cost
/// Per element and f64: 230 flops; 24 bytes of vectors per unknown and 16 bytes of material.
#[derive(Clone, Debug)]
pub struct Bricks<R> {
    level: Level,
    pub(super) cells: [usize; 3],
    nodes: usize,
    /// 1/h per axis; along x padded with zeros to `stride`.
    pub(super) inverse: [Vec<R>; 3],
    /// λV/16 and GV/16 per element, lines padded to `stride`; zero where the element takes the indexed path.
    pub(super) lambda: Vec<R>,
    pub(super) shear: Vec<R>,
    pub(super) stride: usize,
    tasks: Colours<Task<R>>,
}

/// A block of element lines and the elements in it that take the indexed path.
#[derive(Clone, Debug)]
pub(super) struct Task<R> {
    pub(super) lines: [std::ops::Range<usize>; 2],
    pub(super) split: Vec<SplitElement<R>>,
}

/// An element that touches split nodes, or one of a few at the end of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct SplitElement<R> {
    /// Nodes in lexicographic order.
    pub(super) nodes: [u32; 8],
    pub(super) brick: Brick<R>,
}

impl<R: std::fmt::Debug> std::fmt::Debug for Brick<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Brick({:?}, λV/16 {:?}, GV/16 {:?})",
            self.inverse, self.lambda, self.shear
        )
    }
}

impl<R: Real> Bricks<R> {
    /// The stiffness of `mesh`, one material per region.
    ///
    /// # Errors
    /// [`ElasticityError::NotBricks`] if the mesh is no axis-aligned grid, [`ElasticityError::NoMaterial`].
    pub fn new(mesh: &HexMesh, materials: &[Elastic]) -> Result<Self, ElasticityError> {
        Self::with_level(mesh, materials, Level::best())
    }

    /// The same with a chosen instruction set.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_level(
        mesh: &HexMesh,
        materials: &[Elastic],
        level: Level,
    ) -> Result<Self, ElasticityError> {
        check::regions(mesh, materials.len())?;
        let grid = match &mesh.grid {
            Some(grid) if grid.axis_aligned => grid,
            _ => return Err(ElasticityError::NotBricks { element: 0 }),
        };
        let moved = |e: usize, nodes: &[u32; 8]| {
            let expected = grid_nodes(grid.cells, place(grid.cells, e));
            let differs = |(node, expected): (&u32, u32)| root(mesh, *node) != expected;
            nodes.iter().zip(expected).any(differs)
        };
        if let Some(e) = (0..mesh.elements.len()).find(|e| moved(*e, &mesh.elements[*e])) {
            return Err(ElasticityError::NotBricks { element: e });
        }
        let lines = [0, 1, 2].map(|axis: usize| &*grid.lines[axis]);
        let elements = mesh.elements.iter().enumerate().map(|(e, nodes)| {
            let material = materials[usize::from(mesh.regions[e])];
            (e, *nodes, material)
        });
        // SAFETY: copies of a node have it for their root (checked above), so they lie where it does.
        Ok(unsafe { Self::of_elements(grid.cells, lines, mesh.nodes.len(), elements, level) })
    }

    /// The stiffness of some bricks in a grid: `(cell, nodes, material)` each, at most one per cell of those whose nodes
    /// are its vertices.
    ///
    /// # Safety
    /// Node numbers are below `nodes`; those from the number of vertices on are copies that lie at a vertex of every
    /// cell that uses them.
    pub(crate) unsafe fn of_elements(
        cells: [usize; 3],
        lines: [&[f64]; 3],
        nodes: usize,
        elements: impl Iterator<Item = (usize, [u32; 8], Elastic)>,
        level: Level,
    ) -> Self {
        let [nx, ny, nz] = cells;
        // Products count on it where they read whole lines.
        assert!(
            nodes >= (nx + 1) * (ny + 1) * (nz + 1),
            "fewer nodes than vertices"
        );
        let stride = nx.next_multiple_of(MAX_WIDTH);
        let mut inverse = lines.map(|lines| {
            lines
                .windows(2)
                .map(|x| R::of(1.0 / (x[1] - x[0])))
                .collect::<Vec<R>>()
        });
        inverse[0].resize(stride, R::zero());
        let mut lambda = vec![R::zero(); stride * ny * nz];
        let mut shear = lambda.clone();
        let mut tasks: [Vec<Task<R>>; 4] = Default::default();
        for k in (0..nz).step_by(TASK[1]) {
            for j in (0..ny).step_by(TASK[0]) {
                let lines = [j..ny.min(j + TASK[0]), k..nz.min(k + TASK[1])];
                let colour = j / TASK[0] % 2 + 2 * (k / TASK[1] % 2);
                tasks[colour].push(Task {
                    lines,
                    split: Vec::new(),
                });
            }
        }
        // elements of a line that registers along it take
        let width = level.width::<R>();
        let lined = match Rest::of(nx, width) {
            Rest::Indexed => nx - nx % width,
            _ => nx,
        };
        let blocks_y = ny.div_ceil(TASK[0]);
        for (cell, nodes, material) in elements {
            let at = place(cells, cell);
            let size = [0, 1, 2].map(|i: usize| lines[i][at[i] + 1] - lines[i][at[i]]);
            let scale = size[0] * size[1] * size[2] / 16.0;
            let moduli = (
                R::of(material.lambda() * scale),
                R::of(material.shear() * scale),
            );
            if at[0] < lined && nodes == grid_nodes(cells, at) {
                let place = at[0] + stride * (at[1] + ny * at[2]);
                (lambda[place], shear[place]) = moduli;
            } else {
                let (bj, bk) = (at[1] / TASK[0], at[2] / TASK[1]);
                let colour = bj % 2 + 2 * (bk % 2);
                // Tasks of a colour are in order; every second block of a line has it.
                let place = bj / 2 + (blocks_y - bj % 2).div_ceil(2) * (bk / 2);
                tasks[colour][place].split.push(SplitElement {
                    nodes: LEXICOGRAPHIC.map(|a| nodes[a]),
                    brick: Brick {
                        inverse: size.map(|h| R::of(1.0 / h)),
                        lambda: moduli.0,
                        shear: moduli.1,
                    },
                });
            }
        }
        // SAFETY: tasks of one colour are two blocks apart along y or z, so they share no grid node; a copy of a node
        // belongs only to elements around its original (by contract), so they share no copy either.
        let tasks = unsafe { Colours::new(tasks.into()) };
        Self {
            level,
            cells,
            nodes,
            inverse,
            lambda,
            shear,
            stride,
            tasks,
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let split = self.indexed_elements() * size_of::<SplitElement<R>>();
        2 * size_of_val(&*self.lambda) + split
    }

    /// Elements that take the indexed path: those at split nodes, and at the ends of lines what fills a quarter of a register
    /// at most.
    pub fn indexed_elements(&self) -> usize {
        self.tasks.iter().map(|task| task.split.len()).sum()
    }
}

/// (i, j, k) of a cell.
fn place([nx, ny, _]: [usize; 3], cell: usize) -> [usize; 3] {
    [cell % nx, cell / nx % ny, cell / nx / ny]
}

/// Nodes of the cell at (i, j, k) before splitting, in VTK order.
fn grid_nodes(cells: [usize; 3], at: [usize; 3]) -> [u32; 8] {
    std::array::from_fn(|a| {
        let (dx, dy, dz) = ((a % 4 == 1 || a % 4 == 2) as usize, a % 4 / 2, a / 4);
        (at[0] + dx + (cells[0] + 1) * (at[1] + dy + (cells[1] + 1) * (at[2] + dz))) as u32
    })
}

/// The node that `node` was split from, through any number of splits.
fn root(mesh: &HexMesh, node: u32) -> u32 {
    let mut node = node;
    while mesh.origin[node as usize] != node {
        node = mesh.origin[node as usize];
    }
    node
}

impl<R: Real> LinearOperator<R> for Bricks<R> {
    fn shape(&self) -> Shape {
        Shape::square(3 * self.nodes)
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape(), x, y);
        self.tasks.run(y, &|task, y| {
            self.level.run(Product {
                bricks: self,
                alpha,
                x,
                y,
                task,
            });
        });
    }

    fn flops(&self) -> u64 {
        // Per element, additions + multiplications + 2 fused: along z and x 18, along y 21; the four groups of forces with
        // their sums on both faces 6 + 11 + 22, twice 4 + 9 + 20, 3 + 11 + 28; what they share 3 + 5; back along x 12,
        // neighbours 6, along z 6, with α 12.
        230 * self.cells.iter().product::<usize>() as u64
    }
}

impl<R: Real> AdjointOperator<R> for Bricks<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.apply_add(alpha, x, y, work);
    }

    fn adjoint_flops(&self) -> u64 {
        LinearOperator::<R>::flops(self)
    }
}
