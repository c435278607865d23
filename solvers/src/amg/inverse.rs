//! The ready preconditioner.

use super::cycle::Shape;
use super::finest::Sum;
use super::hierarchy::Hierarchy;
use super::node_map::{NONE, NodeMap};
use super::rigid_body::{constants, rigid_body_modes};
use super::scratch::{cast, doubles};
use super::{Amg, Cycle, Precision, Summary};
use crate::{DofCoordinate, SetupError};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::{for_row_ranges, norm_inf};
use fracas_operators::{Preconditioner, Real};

/// One multigrid cycle per solve.
#[derive(Debug)]
pub struct AmgInverse {
    map: NodeMap,
    /// What the finest matrix was divided by.
    scale: f64,
    shape: Shape,
    over_correction: f64,
    hierarchy: Either,
}

/// A hierarchy in one of the two precisions.
#[derive(Debug)]
enum Either {
    Single(Hierarchy<f32>),
    Double(Hierarchy<f64>),
}

/// Entries that one task copies.
const GRAIN: usize = 1 << 14;

/// Without coordinates nothing but translations is known of the rigid-body modes.
const CONSTANTS: &str = "constants (no coordinates)";

impl Amg {
    /// The hierarchy of a symmetric positive definite `a` whose unknowns live at `coordinates`.
    ///
    /// # Errors
    /// [`SetupError`] with the block "A" and a row: no square matrix, NaN, a diagonal that is not positive, an indefinite or
    /// singular (coarse) matrix.
    pub fn build(
        &self,
        a: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<AmgInverse, SetupError> {
        self.build_sum(&Sum::new(a, None)?, coordinates)
    }

    /// The hierarchy of `A + F Fᵀ`, which is assembled in node blocks only.
    ///
    /// # Errors
    /// As [`Amg::build`].
    pub fn build_augmented(
        &self,
        a: &SparseMatrix<f64>,
        f: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<AmgInverse, SetupError> {
        self.build_sum(&Sum::new(a, Some(f))?, coordinates)
    }

    fn build_sum(
        &self,
        sum: &Sum<'_>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<AmgInverse, SetupError> {
        let map = NodeMap::new(sum.a, coordinates);
        let (hierarchy, scale) = match self.precision {
            Precision::F32 => {
                let (hierarchy, scale) = self.levels(sum, &map)?;
                (Either::Single(hierarchy), scale)
            }
            Precision::F64 => {
                let (hierarchy, scale) = self.levels(sum, &map)?;
                (Either::Double(hierarchy), scale)
            }
        };
        let smoothing = match &hierarchy {
            Either::Single(hierarchy) => hierarchy.smoothing,
            Either::Double(hierarchy) => hierarchy.smoothing,
        };
        Ok(AmgInverse {
            map,
            scale,
            shape: Shape::from(&smoothing.in_settings(self)),
            over_correction: self.over_correction,
            hierarchy,
        })
    }

    fn levels<R: Real>(
        &self,
        sum: &Sum<'_>,
        map: &NodeMap,
    ) -> Result<(Hierarchy<R>, f64), SetupError> {
        let finest = sum.blocks::<R>(map)?;
        let scale = finest.scale;
        let unknown = |row: usize| {
            let of_node = map.of_node(row / 3);
            let own = of_node[row % 3] as usize;
            // an empty slot is named by a neighbour in its node
            let any = of_node.iter().map(|i| *i as usize).min().unwrap_or(0);
            if own < map.unknowns_len() { own } else { any }
        };
        let hierarchy = match map.positions() {
            Some(positions) => {
                let modes = rigid_body_modes(map, positions);
                Hierarchy::new(self, finest, modes, "rigid-body modes", &unknown)?
            }
            None => Hierarchy::new(self, finest, constants(map), CONSTANTS, &unknown)?,
        };
        Ok((hierarchy, scale))
    }
}

impl AmgInverse {
    /// Levels, complexities, bytes.
    pub fn summary(&self) -> Summary {
        match &self.hierarchy {
            Either::Single(hierarchy) => hierarchy.summary(),
            Either::Double(hierarchy) => hierarchy.summary(),
        }
    }

    /// Entries of type R that a solve needs.
    fn entries<R: Real>(&self, hierarchy: &Hierarchy<R>) -> usize {
        6 * self.map.nodes() + hierarchy.work_len(self.shape)
    }

    fn solve_with<R: Real>(
        &self,
        hierarchy: &Hierarchy<R>,
        r: &[f64],
        z: &mut [f64],
        work: &mut [f64],
    ) {
        let largest = norm_inf(r);
        if largest == 0.0 || !largest.is_finite() {
            return z.copy_from_slice(r);
        }
        // a power of two brings r into the range of R and changes no digit
        let size = largest.log2().round().exp2();
        let n = 3 * self.map.nodes();
        let (b, work) = cast::<R>(work).split_at_mut(n);
        let (x, work) = work.split_at_mut(n);
        for_row_ranges(0, GRAIN, b, &|start, part| {
            for (b, i) in part.iter_mut().zip(&self.map.unknowns()[start..]) {
                *b = match *i {
                    NONE => R::zero(),
                    i => R::of(r[i as usize] / size),
                };
            }
        });
        hierarchy.cycle(self.shape, 0, b, x, work);
        let back = self.over_correction * size / self.scale;
        for_row_ranges(0, GRAIN, z, &|start, part| {
            for (z, slot) in part.iter_mut().zip(&self.map.slots()[start..]) {
                *z = back * x[*slot as usize].to_f64_exact();
            }
        });
    }
}

impl Preconditioner<f64> for AmgInverse {
    fn size(&self) -> usize {
        self.map.unknowns_len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        assert!(r.len() == self.size() && z.len() == self.size());
        match &self.hierarchy {
            Either::Single(hierarchy) => self.solve_with(hierarchy, r, z, work),
            Either::Double(hierarchy) => self.solve_with(hierarchy, r, z, work),
        }
    }

    fn work_len(&self) -> usize {
        match &self.hierarchy {
            Either::Single(hierarchy) => doubles::<f32>(self.entries(hierarchy)),
            Either::Double(hierarchy) => self.entries(hierarchy),
        }
    }

    fn flops(&self) -> u64 {
        match &self.hierarchy {
            Either::Single(hierarchy) => hierarchy.flops(self.shape, 0),
            Either::Double(hierarchy) => hierarchy.flops(self.shape, 0),
        }
    }

    fn is_single(&self) -> bool {
        matches!(self.hierarchy, Either::Single(_))
    }

    fn is_linear(&self) -> bool {
        !matches!(self.shape.cycle, Cycle::K)
    }
}
