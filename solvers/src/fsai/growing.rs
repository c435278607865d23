//! The small dense system of one row, growing column by column.

/// Part of a pivot's diagonal entry below which rounding decides its sign. Unit: 1.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Why a column cannot be taken in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NotPositive {
    /// The pivot of the column itself.
    Column,
    /// The pivot of the row: `ψ ≤ 0`.
    Row,
}

/// `A[P, P] y = −A[P, i]` by the Cholesky factor of A[P, P], which gains a row per column of P.
///
/// `ψ = a_ii + yᵀA[P, i] = a_ii − zᵀz` with `L z = −A[P, i]` is the pivot of row i: `G_ii = 1/√ψ`.
#[derive(Clone, Debug, Default)]
pub(super) struct Growing {
    a_ii: f64,
    psi: f64,
    /// Rows of L one after the other, with 1/l_kk in place of l_kk.
    factor: Vec<f64>,
    z: Vec<f64>,
    w: Vec<f64>,
}

impl Growing {
    /// Starts row i with an empty P.
    pub(super) fn start(&mut self, a_ii: f64) {
        self.factor.clear();
        self.z.clear();
        self.a_ii = a_ii;
        self.psi = a_ii;
    }

    /// Columns in P.
    pub(super) fn len(&self) -> usize {
        self.z.len()
    }

    /// ψ.
    pub(super) fn psi(&self) -> f64 {
        self.psi
    }

    /// Takes a column j into P; `a_pj` writes the entries A[P, j] into a vector of zeros.
    pub(super) fn append(
        &mut self,
        a_ij: f64,
        a_jj: f64,
        a_pj: impl FnOnce(&mut [f64]),
    ) -> Result<(), NotPositive> {
        let m = self.len();
        self.w.clear();
        self.w.resize(m, 0.0);
        a_pj(&mut self.w);
        // L w = A[P, j]
        let mut row = 0;
        for k in 0..m {
            let known = short_dot(&self.factor[row..row + k], &self.w[..k]);
            self.w[k] = (self.w[k] - known) * self.factor[row + k];
            row += k + 1;
        }
        // l_jj² = a_jj − wᵀw,  z_j = (−a_ij − wᵀz) / l_jj
        let pivot = a_jj - short_dot(&self.w, &self.w);
        if pivot.is_nan() || pivot <= ROUNDING * a_jj {
            return Err(NotPositive::Column);
        }
        let inverse = pivot.sqrt().recip();
        let z = (-a_ij - short_dot(&self.w, &self.z)) * inverse;
        self.factor.extend_from_slice(&self.w);
        self.factor.push(inverse);
        self.z.push(z);
        self.psi -= z * z;
        if self.psi.is_nan() || self.psi <= ROUNDING * self.a_ii {
            return Err(NotPositive::Row);
        }
        Ok(())
    }

    /// `y ← L⁻ᵀ z`.
    pub(super) fn solve(&self, y: &mut Vec<f64>) {
        y.clear();
        y.extend_from_slice(&self.z);
        let mut end = self.factor.len();
        for k in (0..self.len()).rev() {
            let row = &self.factor[end - (k + 1)..end];
            end -= k + 1;
            let (before, y_k) = y[..=k].split_at_mut(k);
            y_k[0] *= row[k];
            for (y, l) in before.iter_mut().zip(row) {
                *y -= l * y_k[0];
            }
        }
    }
}

/// `xᵀy` of short vectors, in four sums.
#[inline(always)]
fn short_dot(x: &[f64], y: &[f64]) -> f64 {
    let (x4, x) = x.as_chunks::<4>();
    let (y4, y) = y.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (x, y) in x4.iter().zip(y4) {
        for lane in 0..4 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
