//! From a matrix to a preconditioner.

use super::finest::Sum;
use super::node_map::NodeMap;
use super::plan::first;
use super::{Amg, AmgPlan, HalvedMatrix};
use crate::multigrid::MultigridInverse;
use crate::{DofCoordinate, SetupError};
use fracas_operators::sparse::{Pattern, SparseMatrix};
use std::sync::Arc;

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
    ) -> Result<MultigridInverse, SetupError> {
        Ok(first(self, Sum::new(a, None)?, coordinates, |_, _| ())?.0)
    }

    /// The hierarchy of an `a` that holds more than elements: row i of `joined` has the unknowns that an element joins with unknown i,
    /// which are gathered before those that fractures couple.
    ///
    /// # Errors
    /// As [`Amg::build`].
    pub fn build_joined(
        &self,
        a: &SparseMatrix<f64>,
        joined: &Pattern,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<MultigridInverse, SetupError> {
        let sum = Sum::new(a, None)?.joined_by(joined);
        Ok(first(self, sum, coordinates, |_, _| ())?.0)
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
    ) -> Result<MultigridInverse, SetupError> {
        Ok(first(self, Sum::new(a, Some(f))?, coordinates, |_, _| ())?.0)
    }

    /// The same for half an A, which knows its nodes.
    ///
    /// # Errors
    /// As [`Amg::build`].
    pub fn build_halved(
        &self,
        a: &HalvedMatrix,
        f: &SparseMatrix<f64>,
    ) -> Result<MultigridInverse, SetupError> {
        Ok(first(self, Sum::of_half(a, Some(f)), None, |_, _| ())?.0)
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
    ) -> Result<(MultigridInverse, AmgPlan), SetupError> {
        let sum = Sum::new(a, f)?;
        let kept = |map: &Arc<NodeMap>, pattern: &Pattern| (map.clone(), pattern.clone());
        let (inverse, steps, (map, pattern)) = first(self, sum, coordinates, kept)?;
        let plan = AmgPlan {
            settings: *self,
            map,
            pattern,
            steps,
        };
        Ok((inverse, plan))
    }
}
