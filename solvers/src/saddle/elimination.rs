//! Contact rows that determine their own traction: eliminated exactly instead of augmented.

mod inverse;

pub use inverse::EliminatedInverse;

use super::{SaddleBlocks, T};
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};

/// Relative difference of entries that counts as rounding.
const ROUNDING: f64 = 1e-12;

/// The rows l of `[A B1; B2 −H]` that are no constraint on a jump but a law for their own traction (slip tangentially,
/// open), and what is left without them:
/// ```text
/// t_l = H_ll⁻¹ (B2_l u − H_lk t_k − g_l)
/// A'  = A + B1_l H_ll⁻¹ B2_l       B1' = B1_k − B1_l H_ll⁻¹ H_lk       f' = f + B1_l H_ll⁻¹ g_l
/// ```
/// Row l is one where B2 differs from B1ᵀ, `H_ll ≠ 0`, and no other row holds t_l in H. The sign and the unit of such a row
/// do not matter. An open face has an empty B2 row and adds nothing to A; a slipping face adds the stiffness across its
/// direction of slip.
///
/// # Shape
/// What is left keeps its numbering: columns l of B and rows and columns l of H are empty.
#[derive(Clone, Debug)]
pub struct Elimination {
    kept: SaddleBlocks,
    local: Vec<usize>,
    diagonal: Vec<f64>,
    b1_l: Csr<f64>,
    b2_l: Csr<f64>,
    h_lk: Csr<f64>,
    symmetric: bool,
}

impl Elimination {
    /// Finds the rows and eliminates them; `None` where there are none.
    ///
    /// # Cost
    /// One transpose of B1; a sparse product and a sum with A where there are such rows.
    pub fn new(blocks: &SaddleBlocks) -> Option<Self> {
        let b2 = blocks.b2.as_ref()?;
        let b1_t: SparseMatrix<f64> = blocks.b1.transpose_view().to_csr();
        let (local, kept_agree) = local_rows(&b1_t, b2, blocks.h.as_ref());
        if local.is_empty() {
            return None;
        }
        let h = blocks.h.as_ref()?;
        let diagonal: Vec<f64> = local
            .iter()
            .map(|&i| h.get(i, i).copied().unwrap_or(0.0))
            .collect();
        let is_local = marks(&local, blocks.n_t());

        let (b1_l_t, b2_l) = (rows_of(&b1_t, &local), rows_of(b2, &local));
        let mut scaled = b2_l.clone();
        for (mut row, h_ii) in scaled.outer_iterator_mut().zip(&diagonal) {
            row.iter_mut().for_each(|(_, v)| *v /= h_ii);
        }
        let b1_l: SparseMatrix<f64> = b1_l_t.transpose_view().to_csr();
        let (stiffness, stiffness_symmetric) = symmetric_part(&(&b1_l * &scaled));
        let h_kept = filtered(h, |i, j| !is_local[i] && !is_local[j]);
        let h_lk = filtered(&rows_of(h, &local), |_, j| !is_local[j]);
        let symmetric =
            kept_agree && stiffness_symmetric && h_lk.nnz() == 0 && symmetric_part(&h_kept).1;
        Some(Self {
            kept: SaddleBlocks {
                a: &blocks.a + &stiffness,
                b1: filtered(&blocks.b1, |_, j| !is_local[j]),
                b2: None,
                h: (h_kept.nnz() > 0).then_some(h_kept),
                rhs_u: blocks.rhs_u.clone(),
                rhs_t: blocks.rhs_t.clone(),
                coordinates: blocks.coordinates.clone(),
                flow: None,
            },
            b1_l: Csr::new(b1_l),
            b2_l: Csr::new(b2_l),
            h_lk: Csr::new(h_lk),
            local,
            diagonal,
            symmetric,
        })
    }

    /// The rows, in ascending order.
    pub fn rows(&self) -> &[usize] {
        &self.local
    }

    /// What a preconditioner is built from: the symmetric part of A', columns k of B1, H without the rows.
    ///
    /// B1' differs from B1_k by the coupling `H_lk` (friction); its share `B2_k A'⁻¹ B1_l H_ll⁻¹H_lk` of the Schur
    /// complement is that of a shear traction in the normal jump, which vanishes on a plane between equal halves.
    pub fn kept(&self) -> &SaddleBlocks {
        &self.kept
    }

    /// [`Self::kept`] with `H_ll = 1`: regular, and what M' makes of a zero in the rows l stays zero.
    pub(super) fn with_identity(&self) -> SaddleBlocks {
        let n_t = self.kept.n_t();
        let mut identity = Triplets::new((n_t, n_t));
        for &l in &self.local {
            identity.add_triplet(l, l, 1.0);
        }
        let identity = identity.to_csr();
        SaddleBlocks {
            h: Some(match &self.kept.h {
                Some(h) => h + &identity,
                None => identity,
            }),
            ..self.kept.clone()
        }
    }

    /// True when the system without the rows is symmetric, so that short recurrences apply from [`Self::start`] on.
    pub fn is_symmetric(&self) -> bool {
        self.symmetric
    }

    /// A start x with a residual that is zero in the rows: `t_l = −H_ll⁻¹ g_l`, all else 0.
    ///
    /// Every M⁻¹ of [`EliminatedInverse`] keeps these residuals at zero, and on that subspace 𝒜 is as symmetric as the
    /// system without the rows.
    pub fn start(&self, rhs: &[f64]) -> Vec<f64> {
        let layout = self.kept.layout();
        let mut x = vec![0.0; rhs.len()];
        let ([x_t], [g]) = (layout.split_mut([T], &mut x), layout.split([T], rhs));
        for (&i, h_ii) in self.local.iter().zip(&self.diagonal) {
            x_t[i] = -g[i] / h_ii;
        }
        x
    }
}

/// Rows that can be eliminated, and whether all the others have B2 = B1ᵀ.
fn local_rows(
    b1_t: &SparseMatrix<f64>,
    b2: &SparseMatrix<f64>,
    h: Option<&SparseMatrix<f64>>,
) -> (Vec<usize>, bool) {
    let n_t = b1_t.rows();
    let mut elsewhere = vec![false; n_t];
    for (value, (i, j)) in h.into_iter().flatten() {
        elsewhere[j as usize] |= i != j && *value != 0.0;
    }
    let differing: Vec<usize> = (0..n_t).filter(|&i| rows_differ(b1_t, b2, i)).collect();
    let own = |i: usize| {
        let h_ii = h.and_then(|h| h.get(i, i)).copied().unwrap_or(0.0);
        h_ii != 0.0 && h_ii.is_finite() && !elsewhere[i]
    };
    let local: Vec<usize> = differing.iter().copied().filter(|&i| own(i)).collect();
    let kept_agree = local.len() == differing.len();
    (local, kept_agree)
}

/// Row i of two matrices beyond rounding.
fn rows_differ(a: &SparseMatrix<f64>, b: &SparseMatrix<f64>, i: usize) -> bool {
    let entries = |m: &SparseMatrix<f64>| -> Vec<(usize, f64)> {
        let row = m.outer_view(i);
        row.iter()
            .flat_map(|row| row.iter())
            .map(|(j, v)| (j, *v))
            .collect()
    };
    let (x, y) = (entries(a), entries(b));
    let size = x.iter().chain(&y).fold(0.0f64, |m, (_, v)| m.max(v.abs()));
    let value = |row: &[(usize, f64)], j: usize| {
        row.binary_search_by_key(&j, |(k, _)| *k)
            .map_or(0.0, |k| row[k].1)
    };
    let far = |j: usize| (value(&x, j) - value(&y, j)).abs() > ROUNDING * size;
    x.iter().chain(&y).any(|(j, _)| far(*j))
}

/// `marked[i]` for i in `rows`.
fn marks(rows: &[usize], n: usize) -> Vec<bool> {
    let mut marked = vec![false; n];
    rows.iter().for_each(|&i| marked[i] = true);
    marked
}

/// The chosen rows, one below the other.
pub(super) fn rows_of(matrix: &SparseMatrix<f64>, rows: &[usize]) -> SparseMatrix<f64> {
    let mut chosen = Triplets::new((rows.len(), matrix.cols()));
    for (k, &i) in rows.iter().enumerate() {
        let row = matrix.outer_view(i);
        for (j, v) in row.iter().flat_map(|row| row.iter()) {
            chosen.add_triplet(k, j, *v);
        }
    }
    chosen.to_csr()
}

/// The entries for which `keep(row, column)`.
fn filtered(matrix: &SparseMatrix<f64>, keep: impl Fn(usize, usize) -> bool) -> SparseMatrix<f64> {
    let mut left = Triplets::new((matrix.rows(), matrix.cols()));
    for (i, row) in matrix.outer_iterator().enumerate() {
        for (j, v) in row.iter().filter(|(j, _)| keep(i, *j)) {
            left.add_triplet(i, j, *v);
        }
    }
    left.to_csr()
}

/// `(M + Mᵀ)/2`, symmetric to the last bit, and whether M was symmetric up to rounding.
fn symmetric_part(matrix: &SparseMatrix<f64>) -> (SparseMatrix<f64>, bool) {
    let transpose: SparseMatrix<f64> = matrix.transpose_view().to_csr();
    let largest = |m: &SparseMatrix<f64>| m.data().iter().fold(0.0f64, |s, v| s.max(v.abs()));
    let skew = matrix - &transpose;
    let symmetric = largest(&skew) <= ROUNDING * largest(matrix);
    ((matrix + &transpose).map(|v| 0.5 * v), symmetric)
}
