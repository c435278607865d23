//! `‖(zI − T)⁻¹‖` of a real dense matrix, several points at a time.

use super::quasi_triangle::{Inverses, QuasiTriangle};
use crate::SetupError;
use crate::eigen::{Ends, Lanczos, LanczosSettings, factors};
use faer::{Mat, c64};
use fracas_operators::simd::Level;
use std::ops::ControlFlow;

/// T as a real Schur form, an upper quasi-triangular matrix that is orthogonally similar to it.
///
/// Lanczos on `(zI − T)⁻¹(zI − T)⁻ᴴ` finds `1/σ_min²`. T is real and does not depend on z: a register holds as many points z as it has
/// lanes, and each entry of T is read once for all of them. A point takes the same steps whichever others are beside it.
///
/// # Cost
/// Some 33 n³ flops once; per point and step of Lanczos 4 n² flops, and about eight steps for three digits.
///
/// # Source
/// S. H. Lui, SIAM J. Sci. Comput. 18 (1997) 565–573; L. N. Trefethen & M. Embree, *Spectra and Pseudospectra* (2005), chapter 39, with a
/// real Schur form in place of the complex one.
pub struct Resolvent {
    n: usize,
    /// T.
    triangle: QuasiTriangle,
    /// Tᵀ with rows and columns in reverse order.
    adjoint: QuasiTriangle,
}

impl Resolvent {
    /// Of a square matrix.
    ///
    /// # Errors
    /// NaN or infinity in T.
    pub fn new(t: &Mat<f64>) -> Result<Self, SetupError> {
        let n = t.nrows();
        let s = factors::schur(t.clone())?;
        let panels = QuasiTriangle::panels_of(n, |i| s[(i + 1, i)] != 0.0);
        let mirrored = (panels.iter().rev())
            .map(|panel| n - panel.end..n - panel.start)
            .collect();
        Ok(Self {
            n,
            triangle: QuasiTriangle::new(n, panels, |i, j| s[(i, j)]),
            adjoint: QuasiTriangle::new(n, mirrored, |i, j| s[(n - 1 - j, n - 1 - i)]),
        })
    }

    /// `σ_min(zI − T) = 1/‖(zI − T)⁻¹‖` at each point z, from below by the error bar of Lanczos, to this relative accuracy; 0 at an
    /// eigenvalue.
    ///
    /// # Errors
    /// Those of [`Lanczos`].
    pub fn smallest(&self, points: &[c64], accuracy: f64) -> Result<Vec<f64>, SetupError> {
        let width = Level::best().width::<f64>();
        let groups = points.chunks(width);
        let found = groups.map(|group| self.smallest_of_group(group, width, accuracy));
        Ok(found.collect::<Result<Vec<_>, _>>()?.concat())
    }

    /// At no more points than a register has lanes.
    fn smallest_of_group(
        &self,
        points: &[c64],
        width: usize,
        accuracy: f64,
    ) -> Result<Vec<f64>, SetupError> {
        let n = self.n;
        let settings = LanczosSettings {
            tolerance: accuracy,
            max_steps: 200,
            ends: Ends::Largest,
            patience: 4,
        };
        let inverses = Inverses::new(&self.triangle, points, width);
        let adjoint = inverses.adjoint(&self.adjoint);
        let mut smallest = vec![0.0; points.len()];
        // those at work, with their lanes
        let mut at_work = Vec::new();
        for lane in 0..points.len() {
            if !inverses.is_singular(lane) {
                at_work.push((lane, Lanczos::new(2 * n, settings)?));
            }
        }
        // n rows of real and imaginary parts, a lane per point
        let mut x = vec![0.0; 2 * n * width];
        loop {
            x.fill(0.0);
            let mut left = Vec::with_capacity(at_work.len());
            for (lane, mut lanczos) in at_work {
                match lanczos.next_vector()? {
                    ControlFlow::Continue(v) => {
                        // the adjoint has its rows in reverse order
                        let (re, im) = v.split_at(n);
                        let rows = x.chunks_exact_mut(2 * width).rev();
                        for (row, (re, im)) in rows.zip(re.iter().zip(im)) {
                            (row[lane], row[width + lane]) = (*re, *im);
                        }
                        left.push((lane, lanczos));
                    }
                    ControlFlow::Break((_, high)) => {
                        smallest[lane] = (high.value + high.error).sqrt().recip();
                    }
                }
            }
            at_work = left;
            if at_work.is_empty() {
                return Ok(smallest);
            }
            self.adjoint.solve(&adjoint, &mut x);
            reverse_rows(&mut x, 2 * width);
            self.triangle.solve(&inverses, &mut x);
            for (lane, lanczos) in &mut at_work {
                let re = x.chunks_exact(2 * width).map(|row| row[*lane]);
                let im = x.chunks_exact(2 * width).map(|row| row[width + *lane]);
                lanczos.take(re.chain(im));
            }
        }
    }
}

/// Turns the order of rows of this length.
fn reverse_rows(x: &mut [f64], length: usize) {
    let rows = x.len() / length;
    let (upper, lower) = x.split_at_mut(rows / 2 * length);
    let pairs = upper
        .chunks_exact_mut(length)
        .zip(lower.rchunks_exact_mut(length));
    pairs.for_each(|(a, b)| a.swap_with_slice(b));
}
