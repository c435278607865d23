//! The Arnoldi process behind GMRES: `A M⁻¹ V_k = V_{k+1} H_k`, with the QR factors of H_k by Givens rotations.

use super::ritz::nearest_to_zero;
use super::run::{End, carve};
use fracas_operators::Real;
use fracas_operators::vector::{CHUNK, axpy, dot, scale};
use rayon::prelude::*;

/// Rows of V that one block of a projection covers: 8 KiB of `f64`, so that w stays in the first cache.
const ROWS: usize = 1024;

/// An orthonormal basis V that grows by a column at a time, and the triangular least-squares problem that goes with it.
///
/// # Cost
/// Column k: three sweeps over `k` vectors of length n (classical Gram–Schmidt twice, the second projection fused with
/// the first subtraction), `8 k n` flops.
///
/// # Source
/// Giraud, Langou, Rozložník & van den Eshof (2005): twice is enough.
pub(super) struct Arnoldi<'w, R> {
    n: usize,
    k: usize,
    basis: &'w mut [R],
    /// Columns of R, each with `capacity + 1` entries.
    triangle: &'w mut [R],
    cosines: &'w mut [R],
    sines: &'w mut [R],
    /// Rotated right-hand side: its entry k is the residual.
    rhs: &'w mut [R],
    /// Corrections of a projection, or y.
    correction: &'w mut [R],
    /// The y that x has already.
    taken: &'w mut [R],
    partial: &'w mut [R],
}

/// What one more column brought.
pub(super) struct Grown<R> {
    /// Norm of the least-squares residual.
    pub residual: R,
    /// The Krylov space is invariant: no further column exists.
    pub exhausted: bool,
}

impl<'w, R: Real> Arnoldi<'w, R> {
    /// Entries that a basis of `m` steps needs.
    pub(super) fn work_len(n: usize, m: usize) -> usize {
        (m + 1) * n + (m + 1) * m + 3 * m + 2 * (m + 1) + n.div_ceil(CHUNK) * (m + 2)
    }

    /// `v_0 = r / ‖r‖` with room for `m` steps.
    pub(super) fn new(r: &[R], rho: R, m: usize, mut work: &'w mut [R]) -> Self {
        let n = r.len();
        let arnoldi = Self {
            n,
            k: 0,
            basis: carve(&mut work, (m + 1) * n),
            triangle: carve(&mut work, (m + 1) * m),
            cosines: carve(&mut work, m),
            sines: carve(&mut work, m),
            rhs: carve(&mut work, m + 1),
            correction: carve(&mut work, m + 1),
            taken: carve(&mut work, m),
            partial: carve(&mut work, n.div_ceil(CHUNK) * (m + 2)),
        };
        arnoldi.basis[..n].copy_from_slice(r);
        scale(rho.recip(), &mut arnoldi.basis[..n]);
        arnoldi.rhs[0] = rho;
        arnoldi.taken.fill(R::zero());
        arnoldi
    }

    /// Columns so far.
    pub(super) fn size(&self) -> usize {
        self.k
    }

    /// `(v_k, place for A M⁻¹ v_k)`.
    pub(super) fn next(&mut self) -> (&[R], &mut [R]) {
        let (old, new) = self.basis.split_at_mut((self.k + 1) * self.n);
        (&old[self.k * self.n..], &mut new[..self.n])
    }

    /// Orthogonalises the vector in [`next`](Self::next)'s place and updates the least-squares problem; `sum` makes sums of every part
    /// those of all.
    pub(super) fn grow(&mut self, sum: &dyn Fn(&mut [R])) -> Grown<R> {
        let (n, k) = (self.n, self.k);
        let height = self.rhs.len();
        let (old, new) = self.basis.split_at_mut((k + 1) * n);
        let w = &mut new[..n];
        let h = &mut self.triangle[k * height..(k + 1) * height];
        let d = &mut self.correction[..k + 1];

        // h = Vᵀw,  w ← w − V h,  d = Vᵀw,  w ← w − V d,  h ← h + d
        sweep(old, w, None, Some(&mut h[..=k]), self.partial);
        sum(&mut h[..=k]);
        sweep(old, w, Some(&h[..=k]), Some(d), self.partial);
        sum(d);
        let mut square = [sweep(old, w, Some(d), None, self.partial)];
        sum(&mut square);
        let norm = square[0].sqrt();
        h.iter_mut().zip(d).for_each(|(h, d)| *h += *d);

        // below rounding of ‖A M⁻¹ v‖ nothing is left of w
        let length = dot(&h[..=k], &h[..=k]).sqrt().hypot(norm);
        let exhausted = norm <= R::of(10.0) * R::epsilon() * length;
        let below = if exhausted { R::zero() } else { norm };
        if !exhausted {
            scale(norm.recip(), w);
        }
        for i in 0..k {
            let (c, s) = (self.cosines[i], self.sines[i]);
            (h[i], h[i + 1]) = (c * h[i] + s * h[i + 1], c * h[i + 1] - s * h[i]);
        }
        let diagonal = h[k].hypot(below);
        if diagonal <= R::epsilon() * length {
            // A M⁻¹ is singular on the space: the column adds nothing
            return Grown {
                residual: self.rhs[k].abs(),
                exhausted: true,
            };
        }
        let (c, s) = (h[k] / diagonal, below / diagonal);
        (self.cosines[k], self.sines[k], h[k]) = (c, s, diagonal);
        (self.rhs[k], self.rhs[k + 1]) = (c * self.rhs[k], -s * self.rhs[k]);
        self.k += 1;
        Grown {
            residual: self.rhs[k + 1].abs(),
            exhausted,
        }
    }

    /// Why the process has no further column, if so.
    pub(super) fn last(&self, grown: &Grown<R>) -> Option<End> {
        let is_full = self.k == self.taken.len();
        let full = is_full.then_some(End::Restart);
        grown.exhausted.then_some(End::Believed).or(full)
    }

    /// `y = R⁻¹ g` less what was taken before; from here on all of y is taken.
    fn take(&mut self) {
        let (height, y) = (self.rhs.len(), &mut self.correction[..self.k]);
        y.copy_from_slice(&self.rhs[..self.k]);
        for j in (0..self.k).rev() {
            let column = &self.triangle[j * height..=j * height + j];
            y[j] /= column[j];
            let y_j = y[j];
            for (y, r) in y[..j].iter_mut().zip(column) {
                *y -= *r * y_j;
            }
        }
        for (y, taken) in y.iter_mut().zip(&mut *self.taken) {
            let all = *y;
            *y -= *taken;
            *taken = all;
        }
    }

    /// `V y` less what was combined before, in the place after that of the next vector; where the basis is full, in that one.
    pub(super) fn combine(&mut self) -> &[R] {
        self.take();
        let (old, new) = self.basis.split_at_mut(self.k * self.n);
        let first = if new.len() > self.n { self.n } else { 0 };
        let u = &mut new[first..][..self.n];
        u.fill(R::zero());
        add_combination(old, &self.correction[..self.k], u);
        u
    }

    /// Modulus of the Ritz value of `A M⁻¹` nearest to zero, by inverse iteration with the square part of H_k; `None` where that
    /// is singular or empty.
    ///
    /// `H_k = Qᵀ R̃`: the first k − 1 rotations, and R with its last diagonal entry as it was before the k-th rotation.
    pub(super) fn ritz_nearest_to_zero(&mut self) -> Option<R> {
        let (k, height) = (self.k, self.rhs.len());
        let last = k.checked_sub(1)?;
        let (triangle, cosines, sines) = (&*self.triangle, &*self.cosines, &*self.sines);
        nearest_to_zero(&mut self.correction[..k], |y| {
            for i in 0..last {
                let (c, s) = (cosines[i], sines[i]);
                (y[i], y[i + 1]) = (c * y[i] + s * y[i + 1], c * y[i + 1] - s * y[i]);
            }
            for j in (0..k).rev() {
                let column = &triangle[j * height..=j * height + j];
                let diagonal = if j == last { cosines[j] } else { R::one() } * column[j];
                y[j] /= diagonal;
                let y_j = y[j];
                for (y, r) in y[..j].iter_mut().zip(column) {
                    *y -= *r * y_j;
                }
            }
        })
    }

    /// `x ← x + Z y` for other vectors Z, less what was combined before.
    pub(super) fn combine_onto(&mut self, z: &[R], x: &mut [R]) {
        self.take();
        add_combination(z, &self.correction[..self.k], x);
    }
}

/// `x ← x + Z y`, block of rows after block of rows.
fn add_combination<R: Real>(z: &[R], y: &[R], x: &mut [R]) {
    let n = x.len();
    x.par_chunks_mut(CHUNK)
        .enumerate()
        .for_each(|(leaf, part)| {
            for (block, x) in part.chunks_mut(ROWS).enumerate() {
                let first = leaf * CHUNK + block * ROWS;
                for (j, y_j) in y.iter().enumerate() {
                    let start = j * n + first;
                    axpy(*y_j, &z[start..start + x.len()], x);
                }
            }
        });
}

/// One sweep over V: `w ← w − V h` where h is given, then `d ← Vᵀ w` where d is wanted; returns ‖w‖².
///
/// Sums run over chunks of fixed length in fixed order, so they have the same bits for any number of threads.
fn sweep<R: Real>(
    basis: &[R],
    w: &mut [R],
    subtract: Option<&[R]>,
    project: Option<&mut [R]>,
    partial: &mut [R],
) -> R {
    let n = w.len();
    let wanted = project.as_ref().map_or(0, |d| d.len());
    let partial = &mut partial[..n.div_ceil(CHUNK) * (wanted + 1)];
    w.par_chunks_mut(CHUNK)
        .zip(partial.par_chunks_mut(wanted + 1))
        .enumerate()
        .for_each(|(leaf, (part, sums))| {
            sums.fill(R::zero());
            for (block, w) in part.chunks_mut(ROWS).enumerate() {
                let first = leaf * CHUNK + block * ROWS;
                let rows = w.len();
                let column = |j: usize| &basis[j * n + first..j * n + first + rows];
                for (j, h_j) in subtract.unwrap_or(&[]).iter().enumerate() {
                    axpy(-*h_j, column(j), w);
                }
                for (j, sum) in sums[..wanted].iter_mut().enumerate() {
                    *sum += dot(column(j), w);
                }
                sums[wanted] += dot(w, w);
            }
        });
    let total = |j: usize| partial.iter().skip(j).step_by(wanted + 1).copied().sum();
    if let Some(d) = project {
        d.iter_mut().enumerate().for_each(|(j, d)| *d = total(j));
    }
    total(wanted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::laws::probe;

    #[test]
    fn the_basis_stays_orthonormal_where_columns_are_nearly_dependent() {
        let (n, m) = (9000, 12);
        let r: Vec<f64> = probe(n, 1);
        let rho = dot(&r, &r).sqrt();
        let mut work = vec![f64::NAN; Arnoldi::<f64>::work_len(n, m)];
        let mut arnoldi = Arnoldi::new(&r, rho, m, &mut work);
        for step in 0..m {
            let (v, w) = arnoldi.next();
            // A = I + 1e-9 diag: A v is v to nine digits
            for (i, (w, v)) in w.iter_mut().zip(v).enumerate() {
                *w = v * (1.0 + 1e-9 * ((i * i) as f64).sin());
            }
            arnoldi.grow(&|_| ());
            assert_eq!(arnoldi.size(), step + 1);
        }
        for i in 0..=m {
            for j in 0..=i {
                let (a, b) = (&arnoldi.basis[i * n..][..n], &arnoldi.basis[j * n..][..n]);
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((dot(a, b) - expected).abs() < 1e-14, "{i} {j}");
            }
        }
    }
}
