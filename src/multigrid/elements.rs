//! Element matrices of a level.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::grid::Grid;
use crate::elasticity::element::Geometry;
use crate::elasticity::{Elastic, ElasticityError};
use crate::mesh::HexMesh;
use fracas_operators::shared::Colours;
use fracas_operators::small::{Matrix3, Symmetric, add, transposed, upper};
use std::borrow::Cow;

/// Node blocks `[a][b]` of an element matrix.
pub(super) type ElementBlocks = [[Matrix3<f64>; 8]; 8];

/// Relative difference up to which two edge lengths count as equal: what rounding makes of equal spacings. Unit: 1.
const SAME_SIZE: f64 = 1e-9;

/// Which elements of a level have a matrix of their own, and which.
#[derive(Clone, Debug)]
pub(super) enum Elements<'a> {
    /// Bricks with their materials; [`Elements::NONE`] where the level's remainder holds what there is.
    Bricks {
        kinds: Cow<'a, [u16]>,
        materials: &'a [Elastic],
    },
    /// Hexahedra of any shape (of the finest level only).
    Hexes {
        mesh: &'a HexMesh,
        materials: &'a [Elastic],
    },
}

impl<'a> Elements<'a> {
    /// Not a brick.
    pub(super) const NONE: u16 = u16::MAX;

    /// The elements of the finest level.
    pub(super) fn of_mesh(mesh: &'a HexMesh, materials: &'a [Elastic]) -> Self {
        match &mesh.grid {
            Some(grid) if grid.axis_aligned => Self::Bricks {
                kinds: Cow::Borrowed(&mesh.regions),
                materials,
            },
            _ => Self::Hexes { mesh, materials },
        }
    }

    /// Material of a brick.
    pub(super) fn brick_kind(&self, element: usize) -> u16 {
        match self {
            Self::Bricks { kinds, .. } => kinds[element],
            Self::Hexes { .. } => Self::NONE,
        }
    }

    /// True where an element has a matrix of its own.
    pub(super) fn has(&self, element: usize) -> bool {
        matches!(self, Self::Hexes { .. }) || self.brick_kind(element) != Self::NONE
    }
}

/// Matrices of bricks of one size for unit moduli.
#[derive(Debug, Default)]
pub(super) struct BrickCache {
    size: [f64; 3],
    lambda: Vec<ElementBlocks>,
    shear: Vec<ElementBlocks>,
}

impl BrickCache {
    fn set(&mut self, size: [f64; 3]) {
        let same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_SIZE * b;
        if !self.lambda.is_empty() && self.size.iter().zip(&size).all(same) {
            return;
        }
        let brick = Geometry::Brick(size);
        // G = 1, λ = 0;  G = λ = 1
        let only_shear = Elastic {
            young: 2.0,
            poisson: 0.0,
        };
        let both = Elastic {
            young: 2.5,
            poisson: 0.25,
        };
        let blocks = |material: Elastic| -> ElementBlocks {
            std::array::from_fn(|a| std::array::from_fn(|b| brick.stiffness_block(a, b, material)))
        };
        let shear = blocks(only_shear);
        let mut lambda = blocks(both);
        for (l, s) in lambda
            .as_flattened_mut()
            .iter_mut()
            .zip(shear.as_flattened())
        {
            add(l, -1.0, s);
        }
        (self.size, self.lambda, self.shear) = (size, vec![lambda], vec![shear]);
    }

    /// Block (a, b) of a brick.
    fn block(&self, a: usize, b: usize, material: Elastic) -> Matrix3<f64> {
        let (lambda, shear) = (material.lambda(), material.shear());
        let (l, s) = (&self.lambda[0][a][b], &self.shear[0][a][b]);
        std::array::from_fn(|i| std::array::from_fn(|j| lambda * l[i][j] + shear * s[i][j]))
    }
}

impl Elements<'_> {
    /// Calls `visit(a, b, block)` for the blocks `wanted` of an element's matrix, in the cell at `place`.
    fn for_blocks(
        &self,
        grid: &Grid<'_>,
        element: usize,
        place: [usize; 3],
        cache: &mut BrickCache,
        wanted: impl Iterator<Item = (usize, usize)>,
        mut visit: impl FnMut(usize, usize, Matrix3<f64>),
    ) -> Result<(), ElasticityError> {
        match self {
            Self::Bricks { kinds, materials } => {
                let material = materials[usize::from(kinds[element])];
                cache.set(grid.size(place));
                wanted.for_each(|(a, b)| visit(a, b, cache.block(a, b, material)));
            }
            Self::Hexes { mesh, materials } => {
                let nodes = mesh.elements[element].map(|n| mesh.nodes[n as usize]);
                let geometry = Geometry::new(&nodes).map_err(|source| {
                    let sum = |i: usize| nodes.iter().map(|x| x[i]).sum::<f64>();
                    ElasticityError::Inverted {
                        element,
                        center: [sum(0) / 8.0, sum(1) / 8.0, sum(2) / 8.0],
                        source,
                    }
                })?;
                let material = materials[usize::from(mesh.regions[element])];
                wanted.for_each(|(a, b)| visit(a, b, geometry.stiffness_block(a, b, material)));
            }
        }
        Ok(())
    }

    /// The matrix of an element that has one.
    ///
    /// # Errors
    /// [`ElasticityError::Inverted`].
    pub(super) fn matrix(
        &self,
        grid: &Grid<'_>,
        element: usize,
        place: [usize; 3],
        cache: &mut BrickCache,
    ) -> Result<ElementBlocks, ElasticityError> {
        let mut blocks = [[[[0.0; 3]; 3]; 8]; 8];
        let upper = (0..8).flat_map(|a| (a..8).map(move |b| (a, b)));
        self.for_blocks(grid, element, place, cache, upper, |a, b, block| {
            blocks[a][b] = block;
            if a != b {
                blocks[b][a] = transposed(&block);
            }
        })?;
        Ok(blocks)
    }

    /// Adds the diagonal blocks of all element matrices.
    ///
    /// # Errors
    /// [`ElasticityError::Inverted`].
    pub(super) fn add_diagonals(
        &self,
        grid: &Grid<'_>,
        diagonal: &mut [Symmetric<f64>],
    ) -> Result<(), ElasticityError> {
        let layers = |from: usize| (from..grid.cells[2]).step_by(2).collect::<Vec<_>>();
        // SAFETY: every second layer of cells has nodes of its own.
        let colours = unsafe { Colours::new(vec![layers(0), layers(1)]) };
        let failed = std::sync::OnceLock::new();
        colours.run(diagonal, &|k, diagonal| {
            let mut cache = BrickCache::default();
            let plane = grid.cells[0] * grid.cells[1];
            for cell in k * plane..(k + 1) * plane {
                for e in grid.elements_in(cell).filter(|e| self.has(*e)) {
                    let own = (0..8).map(|a| (a, a));
                    let place = grid.place(cell);
                    let done = self.for_blocks(grid, e, place, &mut cache, own, |a, _, block| {
                        // SAFETY: a node of this layer.
                        let to = unsafe { diagonal.part(grid.elements[e][a] as usize, 1) };
                        to[0]
                            .iter_mut()
                            .zip(upper(&block))
                            .for_each(|(to, v)| *to += v);
                    });
                    if let Err(error) = done {
                        // the lowest layer's error may not come first; any names an inverted element
                        let _ = failed.set(error);
                        return;
                    }
                }
            }
        });
        failed.into_inner().map_or(Ok(()), Err)
    }
}
