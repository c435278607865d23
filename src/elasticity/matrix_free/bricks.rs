//! Stiffness products on rectilinear grids without a matrix: line by line through the grid, in modes of bricks.

use super::colours::{Colours, Shared};
use super::line::{Line, TILE};
use super::modes::{Brick, D_X, D_Y, D_Z, LEXICOGRAPHIC, Modes, forces, to_corners, to_modes};
use crate::elasticity::{Elastic, ElasticityError, check};
use crate::mesh::HexMesh;
use fracas_operators::operator::assert_product;
use fracas_operators::simd::{Kernel, Lanes, Level, MAX_WIDTH};
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};

/// Element lines of one task along y and z. Two neighbouring tasks share node lines, so they have different colours;
/// long enough that the lines computed twice are few, short enough that a small mesh has a task for every thread.
const TASK: [usize; 2] = [32, 4];

/// The stiffness `A` of a body of axis-aligned bricks, in full numbering.
///
/// Every element is worth its modes (sums and differences of corner values, see [`forces`]); along a line of elements
/// the registers hold consecutive elements, so no index is read. Elements at split nodes take an indexed path.
///
/// # Cost
/// Per element and f64: 262 flops; 24 bytes of vectors per unknown and 16 bytes of material.
#[derive(Clone, Debug)]
pub struct Bricks<R> {
    level: Level,
    cells: [usize; 3],
    nodes: usize,
    /// 1/h per axis; along x padded with zeros to `stride`.
    inverse: [Vec<R>; 3],
    /// λV/16 and GV/16 per element, lines padded to `stride`; zero where the element takes the indexed path.
    lambda: Vec<R>,
    shear: Vec<R>,
    stride: usize,
    tasks: Colours<Task<R>>,
}

/// A block of element lines and the elements in it that touch split nodes.
#[derive(Clone, Debug)]
struct Task<R> {
    lines: [std::ops::Range<usize>; 2],
    split: Vec<SplitElement<R>>,
}

/// An element that touches split nodes.
#[derive(Clone, Copy, Debug)]
struct SplitElement<R> {
    /// Nodes in lexicographic order.
    nodes: [u32; 8],
    brick: Brick<R>,
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
        let [nx, ny, nz] = grid.cells;
        let stride = nx.next_multiple_of(MAX_WIDTH);
        let mut inverse = [0, 1, 2].map(|axis| {
            grid.lines[axis]
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
        let blocks_y = ny.div_ceil(TASK[0]);
        for (e, nodes) in mesh.elements.iter().enumerate() {
            let at = [e % nx, e / nx % ny, e / nx / ny];
            let size = [0, 1, 2].map(|i| grid.lines[i][at[i] + 1] - grid.lines[i][at[i]]);
            let scale = size[0] * size[1] * size[2] / 16.0;
            let material = materials[usize::from(mesh.regions[e])];
            let moduli = (
                R::of(material.lambda() * scale),
                R::of(material.shear() * scale),
            );
            let expected = grid_nodes(grid.cells, at);
            if nodes
                .iter()
                .zip(expected)
                .any(|(node, expected)| root(mesh, *node) != expected)
            {
                return Err(ElasticityError::NotBricks { element: e });
            }
            if *nodes == expected {
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
        // belongs only to elements around its original (checked above by `root`), so they share no copy either.
        let tasks = unsafe { Colours::new(tasks.into()) };
        Ok(Self {
            level,
            cells: grid.cells,
            nodes: mesh.nodes.len(),
            inverse,
            lambda,
            shear,
            stride,
            tasks,
        })
    }

    /// Elements that take the indexed path because they touch split nodes.
    pub fn indexed_elements(&self) -> usize {
        self.tasks.iter().map(|task| task.split.len()).sum()
    }
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
        // Per element: sums and differences along z 6, x 24, y 24; forces 16 + 18 + 23 + 49 + 18; back along y 24 and
        // x 24, neighbours along x and y 18, along z with α 18.
        262 * self.cells.iter().product::<usize>() as u64
    }
}

impl<R: Real> AdjointOperator<R> for Bricks<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.apply_add(alpha, x, y, work);
    }
}

/// One task of one product.
struct Product<'a, R> {
    bricks: &'a Bricks<R>,
    alpha: R,
    x: &'a [R],
    y: &'a Shared<'a, R>,
    task: &'a Task<R>,
}

impl<R: Real> Kernel<R> for Product<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let [nx, ny, _] = self.bricks.cells;
        let [lines_y, lines_z] = self.task.lines.clone();
        let mut u = [Line::new(), Line::new()];
        let mut f = [Line::new(), Line::new()];
        for k in lines_z {
            for first in (0..nx).step_by(TILE) {
                let elements = TILE.min(nx - first);
                let start = |j: usize, k: usize| 3 * (first + (nx + 1) * (j + (ny + 1) * k));
                let nodes = elements + 1;
                let mut now = 0;
                u[now].read::<L>(
                    nodes,
                    &self.x[start(lines_y.start, k)..],
                    &self.x[start(lines_y.start, k + 1)..],
                );
                f[now].clear();
                for j in lines_y.clone() {
                    let next = 1 - now;
                    u[next].read::<L>(
                        nodes,
                        &self.x[start(j + 1, k)..],
                        &self.x[start(j + 1, k + 1)..],
                    );
                    self.line::<L>(j, k, first, elements, [&u[now], &u[next]], &mut f, now);
                    self.add::<L>(nodes, &f[now], start(j, k), start(j, k + 1));
                    now = next;
                }
                self.add::<L>(
                    nodes,
                    &f[now],
                    start(lines_y.end, k),
                    start(lines_y.end, k + 1),
                );
            }
        }
        for chunk in self.task.split.chunks(L::WIDTH) {
            self.split::<L>(chunk);
        }
    }
}

impl<R: Real> Product<'_, R> {
    /// `y += α F` on the two node lines that `forces` belongs to.
    #[inline(always)]
    fn add<L: Lanes<R>>(&self, nodes: usize, forces: &Line<R>, low: usize, high: usize) {
        // SAFETY: both lines belong to this task and are different.
        let (low, high) = unsafe { (self.y.part(low, 3 * nodes), self.y.part(high, 3 * nodes)) };
        forces.add_to::<L>(nodes, self.alpha, low, high);
    }

    /// Elements `first..first + elements` of the line (j, k): forces on node line j add to `f[now]`, those on line j + 1
    /// replace the other.
    #[inline(always)]
    fn line<L: Lanes<R>>(
        &self,
        j: usize,
        k: usize,
        first: usize,
        elements: usize,
        u: [&Line<R>; 2],
        f: &mut [Line<R>; 2],
        now: usize,
    ) {
        let bricks = self.bricks;
        let zero = L::splat(R::zero());
        let (s, t) = (
            L::splat(bricks.inverse[1][j]),
            L::splat(bricks.inverse[2][k]),
        );
        let materials = first + bricks.stride * (j + bricks.cells[1] * k);
        let (near, far) = {
            let (a, b) = f.split_at_mut(1);
            if now == 0 {
                (&mut a[0], &mut b[0])
            } else {
                (&mut b[0], &mut a[0])
            }
        };
        // Forces that elements to the left put on their right nodes, not yet added: [component][z mode][line].
        let mut carried = [[[zero; 2]; 2]; 3];
        let mut i = 0;
        while i < elements {
            let mut modes: Modes<L> = [[zero; 8]; 3];
            for c in 0..3 {
                for z in 0..2 {
                    let (left0, right0) = (u[0].load::<L>(z, c, i), u[0].load::<L>(z, c, i + 1));
                    let (left1, right1) = (u[1].load::<L>(z, c, i), u[1].load::<L>(z, c, i + 1));
                    let (p0, d0) = (left0 + right0, right0 - left0);
                    let (p1, d1) = (left1 + right1, right1 - left1);
                    let m = D_Z * z;
                    modes[c][m] = p0 + p1;
                    modes[c][m | D_X] = d0 + d1;
                    modes[c][m | D_Y] = p1 - p0;
                    modes[c][m | D_X | D_Y] = d1 - d0;
                }
            }
            let brick = Brick {
                inverse: [L::load(&bricks.inverse[0][first + i..]), s, t],
                lambda: L::load(&bricks.lambda[materials + i..]),
                shear: L::load(&bricks.shear[materials + i..]),
            };
            let force = forces(&modes, brick);
            for c in 0..3 {
                for z in 0..2 {
                    let m = D_Z * z;
                    let (p, d) = (force[c][m], force[c][m | D_X]);
                    let (py, dy) = (force[c][m | D_Y], force[c][m | D_X | D_Y]);
                    let (sums, differences) = ([p - py, p + py], [d - dy, d + dy]);
                    for line in 0..2 {
                        let right = sums[line] + differences[line];
                        let left = sums[line] - differences[line];
                        let here = left + right.shifted(carried[c][z][line]);
                        carried[c][z][line] = right;
                        if line == 0 {
                            (near.load::<L>(z, c, i) + here).store(near.lanes(z, c, i));
                        } else {
                            here.store(far.lanes(z, c, i));
                        }
                    }
                }
            }
            i += L::WIDTH;
        }
        for c in 0..3 {
            for z in 0..2 {
                let [to_near, to_far] = carried[c][z];
                let (to_near, to_far) = (zero.shifted(to_near), zero.shifted(to_far));
                (near.load::<L>(z, c, i) + to_near).store(near.lanes(z, c, i));
                to_far.store(far.lanes(z, c, i));
            }
        }
    }

    /// Up to `WIDTH` elements anywhere, by their node numbers.
    #[inline(always)]
    fn split<L: Lanes<R>>(&self, elements: &[SplitElement<R>]) {
        let mut lanes = [[[R::zero(); MAX_WIDTH]; 8]; 3];
        let mut brick = [[R::zero(); MAX_WIDTH]; 5];
        for (l, element) in elements.iter().enumerate() {
            for (m, node) in element.nodes.iter().enumerate() {
                for c in 0..3 {
                    lanes[c][m][l] = self.x[3 * *node as usize + c];
                }
            }
            let Brick {
                inverse,
                lambda,
                shear,
            } = element.brick;
            for (value, lanes) in inverse.into_iter().chain([lambda, shear]).zip(&mut brick) {
                lanes[l] = value;
            }
        }
        let [r, s, t, lambda, shear] = &brick;
        let brick = Brick {
            inverse: [L::load(r), L::load(s), L::load(t)],
            lambda: L::load(lambda),
            shear: L::load(shear),
        };
        let mut corners: Modes<L> = [[L::splat(R::zero()); 8]; 3];
        for c in 0..3 {
            for m in 0..8 {
                corners[c][m] = L::load(&lanes[c][m]);
            }
        }
        let force = to_corners(forces(&to_modes(corners), brick));
        for c in 0..3 {
            for m in 0..8 {
                force[c][m].store(&mut lanes[c][m]);
            }
        }
        for (l, element) in elements.iter().enumerate() {
            for (m, node) in element.nodes.iter().enumerate() {
                // SAFETY: the node belongs to this task.
                let y = unsafe { self.y.part(3 * *node as usize, 3) };
                for c in 0..3 {
                    y[c] += self.alpha * lanes[c][m][l];
                }
            }
        }
    }
}
