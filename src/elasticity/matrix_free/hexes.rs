//! Stiffness products on any mesh of hexahedra without a matrix.

use super::gauss::{VARYING, weight};
use super::groups::{Nodes, coloured, groups};
use super::modes::LEXICOGRAPHIC;
use super::pipeline::Product;
use crate::elasticity::{Elastic, ElasticityError, check};
use crate::mesh::HexMesh;
use fracas_operators::operator::assert_product;
use fracas_operators::shared::Colours;
use fracas_operators::simd::Level;
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};

/// The stiffness `A` of a mesh of arbitrary hexahedra, in full numbering.
///
/// Gauss points are recomputed in registers from the shape of each element, 21 numbers. Elements that follow each other
/// along x on lines of consecutive nodes are read line by line: the last of a line perhaps a second time, runs shorter than a
/// register through a padded copy; the others through node numbers.
///
/// # Cost
/// Per element: 1557 flops; 23 scalars, and 32 bytes of node numbers where it is not on node lines.
#[derive(Clone, Debug)]
pub struct Hexes<R> {
    level: Level,
    nodes: usize,
    count: usize,
    pub(super) groups: Vec<Nodes>,
    /// Nodes in lexicographic order per element of the groups that are not on node lines.
    pub(super) elements: Vec<[u32; 8]>,
    /// [`NUMBERS`] registers per group: weighted modes 1–7 of the three coordinates, λ/G, G/64. Groups that are not full
    /// are filled up with copies without stiffness.
    pub(super) numbers: Vec<R>,
    tasks: Colours<std::ops::Range<usize>>,
}

/// Numbers per element.
pub(super) const NUMBERS: usize = 3 * VARYING + 2;

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
        let nodes: Vec<[u32; 8]> = mesh
            .elements
            .iter()
            .map(|nodes| LEXICOGRAPHIC.map(|a| nodes[a]))
            .collect();
        let width = level.width::<R>();
        let groups = groups(&nodes, width);
        let mut elements = Vec::new();
        let mut numbers = vec![R::zero(); NUMBERS * width * groups.len()];
        let mut places = Vec::with_capacity(groups.len());
        for (group, numbers) in groups.iter().zip(numbers.chunks_exact_mut(NUMBERS * width)) {
            places.push(match group.lines {
                Some(lines) if group.elements.len() < width => {
                    Nodes::Short(lines, group.elements.len() as u8)
                }
                Some(lines) => Nodes::Lines(lines),
                None => Nodes::Any(elements.len()),
            });
            for lane in 0..width {
                let e = group.elements[lane.min(group.elements.len() - 1)];
                if group.lines.is_none() {
                    elements.push(nodes[e]);
                }
                let material = materials[usize::from(mesh.regions[e])];
                // λ/G = 2ν/(1 − 2ν); what a field on [−1, 1]³ lacks of its weights, ⅛, is squared in the energy.
                let ratio = 2.0 * material.poisson / (1.0 - 2.0 * material.poisson);
                let shear = if (group.repeated..group.elements.len()).contains(&lane) {
                    material.shear() / 64.0
                } else {
                    0.0
                };
                let shape = weighted_shape(&check::corners(mesh, e));
                let all = shape.into_iter().flatten().chain([ratio, shear]);
                for (i, number) in all.enumerate() {
                    numbers[i * width + lane] = R::of(number);
                }
            }
        }
        Ok(Self {
            level,
            nodes: mesh.nodes.len(),
            count: mesh.elements.len(),
            tasks: coloured(&groups, &nodes, mesh.nodes.len(), width),
            groups: places,
            elements,
            numbers,
        })
    }
}

impl<R> Hexes<R> {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.numbers) + size_of_val(&*self.elements) + size_of_val(&*self.groups)
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
                let value = 0.125 * weight(m) * corners[a][i];
                shape[i][m - 1] += if odd { -value } else { value };
            }
        }
    }
    shape
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
        // On node lines, additions + multiplications + 2 fused: faces 36, modes 24, weights 12, derivatives 66, those of
        // the shape 66; per Gauss point 27 (cofactors), 6 (det, G/det), 45 (gradient), 18 (stress); forces 396 at all;
        // back 81 + 12 + 24, onto lines 72.
        1_557 * self.count as u64
    }
}

impl<R: Real> AdjointOperator<R> for Hexes<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.apply_add(alpha, x, y, work);
    }

    fn adjoint_flops(&self) -> u64 {
        LinearOperator::<R>::flops(self)
    }
}
