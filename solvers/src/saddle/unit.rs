//! The unit of the tractions: a similarity that makes both block rows of one size.

use super::SaddleBlocks;
use fracas_operators::sparse::SparseMatrix;

/// Largest |entry|.
fn largest(matrix: &SparseMatrix<f64>) -> f64 {
    matrix.data().iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

impl SaddleBlocks {
    /// A unit s of tractions in which the contact rows count as much as those of equilibrium: the power of two nearest
    /// to `max|A| / max|B1|`; 1 where a block is empty.
    ///
    /// In SI units forces are of order 1e7 and area-weighted jumps of order 1e-4: the 2-norm of the whole residual does
    /// not see the jumps, and a solution may be wrong by per cents below a relative residual of 1e-8.
    pub fn traction_unit(&self) -> f64 {
        let ratio = largest(&self.a) / largest(&self.b1);
        if ratio > 0.0 && ratio.is_finite() {
            ratio.log2().round().exp2()
        } else {
            1.0
        }
    }

    /// The same system for tractions counted in units of `unit`: `B s`, `H s²`, `rhs_t s`; a solution gives `t = s t'`.
    ///
    /// A power of two changes no bit of any mantissa. RACP commutes with it: C scales by s² for every choice but the
    /// 1 of an empty column.
    #[must_use]
    pub fn in_traction_unit(&self, unit: f64) -> Self {
        let scaled = |matrix: &SparseMatrix<f64>, factor: f64| matrix.map(|v| v * factor);
        Self {
            b1: scaled(&self.b1, unit),
            b2: self.b2.as_ref().map(|b2| scaled(b2, unit)),
            h: self.h.as_ref().map(|h| scaled(h, unit * unit)),
            rhs_t: self.rhs_t.iter().map(|g| g * unit).collect(),
            ..self.clone()
        }
    }
}
