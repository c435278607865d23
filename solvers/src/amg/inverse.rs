//! The ready preconditioner.

use super::cycle::Shape;
use super::finest::Sum;
use super::hierarchy::Hierarchy;
use super::node_map::{NONE, NodeMap};
use super::plan::first;
use super::rows::Pattern;
use super::scratch::{cast, doubles};
use super::{Amg, AmgPlan, Cycle, Smoothing, Summary};
use crate::{DofCoordinate, SetupError};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::{for_row_ranges, norm_inf};
use fracas_operators::{Preconditioner, Properties, Real};
use std::sync::Arc;

/// One multigrid cycle per solve.
#[derive(Debug)]
pub struct AmgInverse {
    map: Arc<NodeMap>,
    /// What the finest matrix was divided by.
    scale: f64,
    shape: Shape,
    over_correction: f64,
    hierarchy: Either,
}

/// A hierarchy in one of the two precisions.
#[derive(Debug)]
pub(super) enum Either {
    Single(Hierarchy<f32>),
    Double(Hierarchy<f64>),
}

impl Either {
    fn smoothing(&self) -> Smoothing {
        match self {
            Self::Single(hierarchy) => hierarchy.smoothing,
            Self::Double(hierarchy) => hierarchy.smoothing,
        }
    }
}

/// Entries that one task copies.
const GRAIN: usize = 1 << 14;

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
        Ok(first(self, &Sum::new(a, None)?, coordinates, |_| ())?.0)
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
        Ok(first(self, &Sum::new(a, Some(f))?, coordinates, |_| ())?.0)
    }

    /// The hierarchy of `A + F Fᵀ`, and what of it serves other values.
    ///
    /// # Errors
    /// As [`Amg::build`].
    pub fn plan(
        &self,
        a: &SparseMatrix<f64>,
        f: Option<&SparseMatrix<f64>>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<(AmgInverse, AmgPlan), SetupError> {
        let sum = Sum::new(a, f)?;
        let (inverse, steps, pattern) = first(self, &sum, coordinates, Pattern::clone)?;
        let plan = AmgPlan {
            settings: *self,
            map: inverse.map.clone(),
            pattern,
            steps,
        };
        Ok((inverse, plan))
    }
}

impl AmgInverse {
    pub(super) fn new(settings: &Amg, map: Arc<NodeMap>, scale: f64, hierarchy: Either) -> Self {
        let shape = Shape::from(&hierarchy.smoothing().in_settings(settings));
        Self {
            map,
            scale,
            shape,
            over_correction: settings.over_correction,
            hierarchy,
        }
    }

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

    fn properties(&self) -> Properties {
        Properties {
            linear: !matches!(self.shape.cycle, Cycle::K),
            single: matches!(self.hierarchy, Either::Single(_)),
            local: false,
        }
    }
}
