//! A x on axis-aligned grids, never assembled: about 200 flops and 100 bytes per cell.

mod irregular;
mod layer;
mod parity;

use super::Elastic;
use crate::mesh::HexMesh;
use fracas_operators::operator::assert_product;
use fracas_operators::simd::{InstructionSet, Scalar, Simd, instruction_set};
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};
use irregular::Irregular;
use layer::Layers;

/// Layers of cells that one thread treats in a row. Slabs of this height are the unit of parallelism; their number
/// depends on the grid alone.
const LAYERS: usize = 4;

/// The stiffness of a structured grid of axis-aligned bricks, whatever their grading and materials, over all
/// displacements (`3·node + component`, prescribed ones included).
///
/// Cells whose nodes follow the structured numbering are swept row by row in the parity basis, where a brick costs about
/// 50 multiplications; the few beside a fracture, whose nodes were split, go through an index list.
///
/// # Cost
/// About 200 flops per cell; memory traffic 48 bytes per node for x and y and 16 per cell for λ and G in f64.
/// # Source
/// Derived from the reflections of a brick (see `parity`); equal to 2×2×2 Gauss integration, which is exact here.
#[derive(Clone, Debug)]
pub struct Bricks<R> {
    cells: [usize; 3],
    spacing: [Vec<R>; 3],
    /// λ and G per cell [Pa], zero where the cell is irregular.
    lambda: Vec<R>,
    shear: Vec<R>,
    irregular: Irregular<R>,
    nodes: usize,
    instructions: InstructionSet,
}

impl<R: Real> Bricks<R> {
    /// The operator of `mesh`, or `None` when the mesh is not an axis-aligned structured grid.
    pub fn new(mesh: &HexMesh, materials: &[Elastic]) -> Option<Self> {
        let grid = mesh.grid.as_ref().filter(|g| g.axis_aligned)?;
        let spacing = std::array::from_fn(|d| {
            let lines = &grid.lines[d];
            lines.windows(2).map(|w| R::of(w[1] - w[0])).collect()
        });
        let mut lambda = Vec::with_capacity(mesh.elements.len());
        let mut shear = Vec::with_capacity(mesh.elements.len());
        for region in &mesh.regions {
            let material = materials[*region as usize];
            lambda.push(R::of(material.lambda()));
            shear.push(R::of(material.shear()));
        }
        let mut bricks = Self {
            cells: grid.cells,
            spacing,
            lambda,
            shear,
            irregular: Irregular::default(),
            nodes: mesh.nodes.len(),
            instructions: instruction_set(),
        };
        let split: Vec<usize> = (0..mesh.elements.len())
            .filter(|e| {
                mesh.elements[*e]
                    .iter()
                    .any(|a| *a as usize >= grid.node_count())
            })
            .collect();
        bricks.irregular = Irregular::new(mesh, &split, |e| bricks.brick(e));
        for e in split {
            bricks.lambda[e] = R::zero();
            bricks.shear[e] = R::zero();
        }
        Some(bricks)
    }

    /// The same operator compiled for other instructions, to compare them; the processor must have them.
    pub fn with_instructions(mut self, instructions: InstructionSet) -> Self {
        assert!(
            instructions.is_available(),
            "this processor lacks {instructions:?}"
        );
        self.instructions = instructions;
        self
    }

    /// λ, G and the edge lengths of cell `e`.
    fn brick(&self, e: usize) -> (R, R, [R; 3]) {
        let [nx, ny, _] = self.cells;
        let index = [e % nx, e / nx % ny, e / (nx * ny)];
        let h = std::array::from_fn(|d| self.spacing[d][index[d]]);
        (self.lambda[e], self.shear[e], h)
    }

    /// Entries of a plane of nodes.
    fn plane(&self) -> usize {
        3 * (self.cells[0] + 1) * (self.cells[1] + 1)
    }

    /// Sweeps `count` slabs `first, first + 2, …`, which touch disjoint planes; `y` starts at plane `LAYERS · first`.
    fn sweep_slabs(&self, first: usize, count: usize, factor: R, x: &[R], y: &mut [R]) {
        if count > 1 {
            let half = count / 2;
            let (y0, y1) = y.split_at_mut(2 * half * LAYERS * self.plane());
            rayon::join(
                || self.sweep_slabs(first, half, factor, x, y0),
                || self.sweep_slabs(first + 2 * half, count - half, factor, x, y1),
            );
        } else if count == 1 {
            match self.instructions {
                // SAFETY: `instructions` names a set that this processor was found to have.
                #[cfg(target_arch = "x86_64")]
                InstructionSet::Avx512 => unsafe { sweep_avx512(self, first, factor, x, y) },
                // SAFETY: as above.
                #[cfg(target_arch = "x86_64")]
                InstructionSet::Avx2 => unsafe { sweep_avx2(self, first, factor, x, y) },
                _ => self.sweep_slab::<Scalar<R>>(first, factor, x, y),
            }
        }
    }

    /// The layers of one slab, from below.
    #[inline(always)]
    fn sweep_slab<V: Simd<R>>(&self, slab: usize, factor: R, x: &[R], y: &mut [R]) {
        let layers = Layers {
            cells: self.cells,
            spacing: [&self.spacing[0], &self.spacing[1], &self.spacing[2]],
            lambda: &self.lambda,
            shear: &self.shear,
        };
        let bottom = slab * LAYERS;
        for k in bottom..(bottom + LAYERS).min(self.cells[2]) {
            let first = (k - bottom) * self.plane();
            layers.sweep::<V>(k, factor, x, &mut y[first..first + 2 * self.plane()]);
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
fn sweep_avx512<R: Real>(bricks: &Bricks<R>, slab: usize, factor: R, x: &[R], y: &mut [R]) {
    bricks.sweep_slab::<R::Wide512>(slab, factor, x, y);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn sweep_avx2<R: Real>(bricks: &Bricks<R>, slab: usize, factor: R, x: &[R], y: &mut [R]) {
    bricks.sweep_slab::<R::Wide256>(slab, factor, x, y);
}

impl<R: Real> LinearOperator<R> for Bricks<R> {
    fn shape(&self) -> Shape {
        Shape::square(3 * self.nodes)
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(self.shape(), x, y);
        let slabs = self.cells[2].div_ceil(LAYERS);
        // even slabs share no plane with each other, nor do odd ones
        self.sweep_slabs(0, slabs.div_ceil(2), alpha, x, y);
        let odd = LAYERS.min(self.cells[2]) * self.plane();
        self.sweep_slabs(1, slabs / 2, alpha, x, &mut y[odd..]);
        self.irregular
            .apply_add(self.instructions, alpha, x, y, work);
    }

    fn work_len(&self) -> usize {
        self.irregular.work_len()
    }

    fn flops(&self) -> u64 {
        // per cell: 42 additions to the parity basis, 12 constants and 97 flops for the forces, 3·24 back, 12 to store
        235 * (self.cells.iter().product::<usize>() + self.irregular.len()) as u64
    }
}

impl<R: Real> AdjointOperator<R> for Bricks<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.apply_add(alpha, x, y, work);
    }
}
