//! The unit of the tractions: a similarity that makes both block rows of one size.

use super::SaddleBlocks;
use fracas_operators::sparse::SparseMatrix;

/// Largest |entry|.
fn largest(matrix: &SparseMatrix<f64>) -> f64 {
    matrix.data().iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// The unit of tractions for the largest |entry| of A and that of B1: the power of two nearest to their ratio, see
/// [`SaddleBlocks::traction_unit`].
pub fn unit_of_tractions(largest_a: f64, largest_b: f64) -> f64 {
    let ratio = largest_a / largest_b;
    if ratio > 0.0 && ratio.is_finite() {
        ratio.log2().round().exp2()
    } else {
        1.0
    }
}

impl SaddleBlocks {
    /// A unit s of tractions in which the contact rows count as much as those of equilibrium: the power of two nearest
    /// to `max|A| / max|B1|`; 1 where a block is empty.
    ///
    /// In SI units forces are of order 1e7 and area-weighted jumps of order 1e-4: the 2-norm of the whole residual does
    /// not see the jumps, and a solution may be wrong by per cents below a relative residual of 1e-8.
    pub fn traction_unit(&self) -> f64 {
        unit_of_tractions(largest(&self.a), largest(&self.b1))
    }

    /// The same system for tractions counted in units of `unit`: `B s`, `H s²`, `rhs_t s`; a solution gives `t = s t'`.
    ///
    /// Pressures are counted in the same unit, and the rows of their balance times the power of two that brings their largest entry
    /// nearest to that of A: volumes per time are as far from forces as jumps are.
    ///
    /// A power of two changes no bit of any mantissa. RACP commutes with it: C scales by s² for every choice, but where an empty column
    /// has no H either.
    #[must_use]
    pub fn in_traction_unit(&self, unit: f64) -> Self {
        self.clone().into_traction_unit(unit)
    }

    /// As [`in_traction_unit`](Self::in_traction_unit), without a second copy of the blocks.
    #[must_use]
    pub fn into_traction_unit(mut self, unit: f64) -> Self {
        self.b1.map_inplace(|v| v * unit);
        self.b2
            .iter_mut()
            .for_each(|b2| b2.map_inplace(|v| v * unit));
        self.h
            .iter_mut()
            .for_each(|h| h.map_inplace(|v| v * (unit * unit)));
        self.rhs_t.iter_mut().for_each(|g| *g *= unit);
        if let Some(flow) = &mut self.flow {
            let row = unit_of_tractions(
                largest(&self.a),
                largest(&flow.q2).max(unit * largest(&flow.t)),
            );
            flow.q1.map_inplace(|v| v * unit);
            flow.q2.map_inplace(|v| v * row);
            flow.t.map_inplace(|v| v * (unit * row));
            flow.rhs_p.iter_mut().for_each(|s| *s *= row);
        }
        self
    }
}
