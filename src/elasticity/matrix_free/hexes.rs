//! Stiffness products on any mesh of hexahedra without a matrix.

use super::colours::{Colours, Shared};
use super::gauss::{VARYING, forces, weight};
use super::modes::{LEXICOGRAPHIC, Modes, to_corners, to_modes};
use crate::elasticity::{Elastic, ElasticityError, check};
use crate::mesh::HexMesh;
use fracas_operators::operator::assert_product;
use fracas_operators::simd::{Kernel, Lanes, Level, MAX_WIDTH, prefetch};
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};

/// Elements of one task: a multiple of [`MAX_WIDTH`].
const TASK: usize = 512;

/// The stiffness `A` of a mesh of arbitrary hexahedra, in full numbering.
///
/// Gauss points are recomputed in registers from the shape of each element, 21 numbers; see [`forces`].
///
/// # Cost
/// Per element: 1655 flops; 23 scalars and 32 bytes of node numbers.
#[derive(Clone, Debug)]
pub struct Hexes<R> {
    level: Level,
    nodes: usize,
    /// Nodes per element in lexicographic order.
    elements: Vec<[u32; 8]>,
    /// [`NUMBERS`] registers per group of as many elements as a register holds lanes: weighted modes 1–7 of the three
    /// coordinates, λ, G. The last group is filled up with copies without stiffness.
    groups: Vec<R>,
    tasks: Colours<std::ops::Range<usize>>,
}

/// Numbers per element: weighted modes of the three coordinates, λ, G.
const NUMBERS: usize = 3 * VARYING + 2;

impl<R: Real> Hexes<R> {
    /// The stiffness of `mesh`, one material per region.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without a material.
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
        check::elements(mesh, materials.len())?;
        let n = mesh.elements.len();
        let width = level.width::<R>();
        let mut groups = vec![R::zero(); NUMBERS * n.next_multiple_of(width)];
        for (g, group) in groups.chunks_exact_mut(NUMBERS * width).enumerate() {
            for lane in 0..width {
                let e = (g * width + lane).min(n - 1);
                let material = materials[usize::from(mesh.regions[e])];
                let stiff = if g * width + lane < n { 1.0 } else { 0.0 };
                let moduli = [stiff * material.lambda(), stiff * material.shear()];
                let shape = weighted_shape(&check::corners(mesh, e));
                for (i, number) in shape.into_iter().flatten().chain(moduli).enumerate() {
                    group[i * width + lane] = R::of(number);
                }
            }
        }
        Ok(Self {
            level,
            nodes: mesh.nodes.len(),
            elements: mesh
                .elements
                .iter()
                .map(|nodes| LEXICOGRAPHIC.map(|a| nodes[a]))
                .collect(),
            groups,
            tasks: coloured(mesh),
        })
    }
}

impl<R> Hexes<R> {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.elements) + size_of_val(&*self.groups)
    }
}

/// Weighted modes 1–7 of the three coordinates of an element.
fn weighted_shape(corners: &[[f64; 3]; 8]) -> [[f64; VARYING]; 3] {
    let mut shape = [[0.0; VARYING]; 3];
    for i in 0..3 {
        for m in 1..8 {
            for (place, a) in LEXICOGRAPHIC.into_iter().enumerate() {
                // A corner counts negatively for every difference at whose low end it is.
                let odd = (m & !place).count_ones() % 2 == 1;
                let value = weight(m) * corners[a][i];
                shape[i][m - 1] += if odd { -value } else { value };
            }
        }
    }
    shape
}

/// Consecutive elements in tasks of [`TASK`], coloured first come first served; the colours depend on the mesh alone.
fn coloured(mesh: &HexMesh) -> Colours<std::ops::Range<usize>> {
    /// Colours that fit a mask of 64 bits; tasks beyond them, on meshes numbered at random, run alone.
    const MASKED: usize = 64;
    let mut used = vec![0u64; mesh.nodes.len()];
    let mut colours: Vec<Vec<std::ops::Range<usize>>> = Vec::new();
    let mut alone = Vec::new();
    let n = mesh.elements.len();
    for first in (0..n).step_by(TASK) {
        let task = first..n.min(first + TASK);
        let nodes = || mesh.elements[task.clone()].iter().flatten();
        let taken = nodes().fold(0, |mask, node| mask | used[*node as usize]);
        let colour = taken.trailing_ones() as usize;
        if colour == MASKED {
            alone.push(vec![task]);
            continue;
        }
        nodes().for_each(|node| used[*node as usize] |= 1 << colour);
        if colour == colours.len() {
            colours.push(Vec::new());
        }
        colours[colour].push(task);
    }
    colours.append(&mut alone);
    // SAFETY: a task takes a colour that no task before it at any of its nodes has.
    unsafe { Colours::new(colours) }
}

impl<R: Real> LinearOperator<R> for Hexes<R> {
    fn shape(&self) -> Shape {
        Shape::square(3 * self.nodes)
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape(), x, y);
        self.tasks.run(y, &|task, y| {
            self.level.run(Product {
                hexes: self,
                alpha,
                x,
                y,
                task: task.clone(),
            });
        });
    }

    fn flops(&self) -> u64 {
        // Modes 72, weights 21, derivatives 72, those of the shape 72; per Gauss point 33 (cofactors, det, inverse),
        // 45 (gradient), 18 (stress), 54 (force); back 99 + 21 + 72; α and accumulation 26.
        1_655 * self.elements.len() as u64
    }
}

impl<R: Real> AdjointOperator<R> for Hexes<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.apply_add(alpha, x, y, work);
    }
}

/// One task of one product.
struct Product<'a, R> {
    hexes: &'a Hexes<R>,
    alpha: R,
    x: &'a [R],
    y: &'a Shared<'a, R>,
    task: std::ops::Range<usize>,
}

impl<R: Real> Kernel<R> for Product<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        // Scalars are written here a group ahead of the registers that read them: by then they have left the store queue.
        let zero = || Corners([[[R::zero(); MAX_WIDTH]; 8]; 3]);
        let mut corners = [zero(), zero()];
        self.gather(self.group::<L>(self.task.start), &mut corners[0]);
        for (g, first) in self.task.clone().step_by(L::WIDTH).enumerate() {
            let [even, odd] = &mut corners;
            let (now, next) = if g % 2 == 0 { (even, odd) } else { (odd, even) };
            self.gather(self.group::<L>(first + L::WIDTH), next);
            for number in (0..NUMBERS * L::WIDTH).step_by(64 / std::mem::size_of::<R>()) {
                prefetch(&self.hexes.groups, NUMBERS * (first + L::WIDTH) + number);
            }
            self.registers::<L>(first, now);
            self.scatter(self.group::<L>(first), now);
        }
    }
}

/// Values at the corners of a group: `[component][lexicographic corner][element]`; aligned so that no register
/// straddles two cache lines.
#[repr(align(64))]
struct Corners<R>([[[R; MAX_WIDTH]; 8]; 3]);

impl<R: Real> Product<'_, R> {
    /// Nodes of up to `WIDTH` elements of this task from `first`; none behind its end.
    #[inline(always)]
    fn group<L: Lanes<R>>(&self, first: usize) -> &[[u32; 8]] {
        let end = self.task.end;
        &self.hexes.elements[first.min(end)..end.min(first + L::WIDTH)]
    }

    #[inline(always)]
    fn gather(&self, elements: &[[u32; 8]], corners: &mut Corners<R>) {
        for (lane, nodes) in elements.iter().enumerate().take(MAX_WIDTH) {
            for (m, node) in nodes.iter().enumerate() {
                let x = &self.x[3 * *node as usize..][..3];
                for c in 0..3 {
                    corners.0[c][m][lane] = x[c];
                }
            }
        }
    }

    #[inline(always)]
    fn scatter(&self, elements: &[[u32; 8]], corners: &Corners<R>) {
        for (lane, nodes) in elements.iter().enumerate().take(MAX_WIDTH) {
            for (m, node) in nodes.iter().enumerate() {
                // SAFETY: the node belongs to this task.
                let y = unsafe { self.y.part(3 * *node as usize, 3) };
                for c in 0..3 {
                    y[c] += corners.0[c][m][lane];
                }
            }
        }
    }

    /// Replaces corner displacements of `WIDTH` elements by α times their corner forces.
    #[inline(always)]
    fn registers<L: Lanes<R>>(&self, first: usize, corners: &mut Corners<R>) {
        let zero = L::splat(R::zero());
        let (mut u, mut shape) = ([[zero; 8]; 3], [[zero; 8]; 3]);
        let group = &self.hexes.groups[NUMBERS * first..][..NUMBERS * L::WIDTH];
        for c in 0..3 {
            for m in 0..8 {
                u[c][m] = L::load(&corners.0[c][m]);
            }
            for m in 1..8 {
                shape[c][m] = L::load(&group[(VARYING * c + m - 1) * L::WIDTH..]);
            }
        }
        let alpha = L::splat(self.alpha);
        let lambda = alpha * L::load(&group[(NUMBERS - 2) * L::WIDTH..]);
        let shear = alpha * L::load(&group[(NUMBERS - 1) * L::WIDTH..]);
        let u: Modes<L> = to_modes(u);
        let f = to_corners(forces(&u, &shape, lambda, shear));
        for c in 0..3 {
            for m in 0..8 {
                f[c][m].store(&mut corners.0[c][m]);
            }
        }
    }
}
