//! How much of the tractions C_0 + H, or `B1ᵀ diag(A)⁻¹ B1 + H`, holds.

use super::Stiffness;
use crate::eigen::lanczos::largest_of_tridiagonal;
use crate::eigen::{Ends, LanczosSettings};
use fracas_operators::random::signed;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::{axpy, dot};
use fracas_operators::{LinearOperator, Shape};

/// Share of the largest eigenvalue that Lanczos steps may miss: their number keeps the chance of more at 10⁻⁹, however far that eigenvalue is
/// from all others. Eight steps of the power method saw nothing of one at 2 among two thousand at 1, and the polynomial grew there. Unit: 1.
const MISSED: f64 = 1.0 / 3.0;

/// How far a polynomial raises one mode at 0 above all others together, beyond what the limit of a Rayleigh quotient asks for: a random start has less
/// than a thousandth of its share of that mode once in a thousand times. With a twentieth one of 40 such systems was missed. Unit: 1.
const RAISED: f64 = 1000.0;

/// Most products of the polynomial, which suffice where the largest eigenvalue is 1,000 times the limit: it may be beyond all numbers. Unit: 1.
const MOST_DEGREE: usize = 250;

/// `D^(−1/2) (C + H) D^(−1/2)`, D the diagonal of C_0 + H, and C = C_0 or all of `B1ᵀ diag(A)⁻¹ B1`: how much of what D holds, C + H holds,
/// traction by traction.
pub(super) struct OfTractions<'n> {
    /// 𝒜, which knows of other parts.
    whole: &'n dyn LinearOperator<f64>,
    c: &'n [f64],
    /// In place of C_0.
    moved: Option<Moved<'n>>,
    h: Option<&'n dyn LinearOperator<f64>>,
    /// Diagonal of D^(−1/2).
    scale: Vec<f64>,
}

impl<'n> OfTractions<'n> {
    /// Of 𝒜, C_0 and H, and the diagonal of C_0 + H.
    pub(super) fn new(
        whole: &'n dyn LinearOperator<f64>,
        (c, h): (&'n [f64], Option<&'n dyn LinearOperator<f64>>),
        diagonal: &[f64],
    ) -> Self {
        let scale = diagonal.iter().map(|d| match *d > 0.0 {
            true => d.sqrt().recip(),
            false => 0.0,
        });
        Self {
            whole,
            c,
            moved: None,
            h,
            scale: scale.collect(),
        }
    }

    /// The same with `B1ᵀ diag(A)⁻¹ B1` in place of its diagonal: what tractions on all faces together move.
    pub(super) fn moving(self, b1: &'n SparseMatrix<f64>, stiffness: &Stiffness) -> Self {
        let rows = stiffness.entries().zip(b1.outer_iterator()).enumerate();
        let reached = rows.filter(|(_, (a, row))| *a > 0.0 && row.nnz() > 0);
        let moved = Moved {
            b1,
            rows: reached.map(|(i, (a, _))| (i, a.recip())).collect(),
        };
        Self {
            moved: Some(moved),
            ..self
        }
    }

    /// n_t of this part.
    pub(super) fn size(&self) -> usize {
        self.scale.len()
    }

    /// False where every eigenvalue is above `limit` because every `c_0 / (c_0 + h)` is, if H is not negative.
    pub(super) fn may_fall_below(&self, limit: f64) -> bool {
        let mut shares = self.c.iter().zip(&self.scale);
        let here = shares.any(|(c, s)| c * s * s < limit);
        let mut anywhere = [f64::from(u8::from(here))];
        self.sum_over_parts(&mut anywhere);
        anywhere[0] > 0.0
    }

    /// Tractions made of the modes with eigenvalues below `limit`, all with weights of the same size, and their Rayleigh quotient: above
    /// `limit` where there are none.
    ///
    /// # Cost
    /// Some 90 to 140 products, as log n_t.
    ///
    /// # Formula
    /// `y = T_k((b + a − 2N)/(b − a)) w`, a = `limit`, b above the largest eigenvalue of N, w random, `T_k((b + a)/(b − a)) ≥ 1000 √(n_t/a)`.
    pub(super) fn lowest(&self, limit: f64) -> (Vec<f64>, f64) {
        let mut work = vec![0.0; self.work_len()];
        let mut y: Vec<f64> = (0..self.size() as u64).map(signed).collect();
        let mut image = vec![0.0; y.len()];
        let mut tractions = [self.size() as f64];
        self.sum_over_parts(&mut tractions);
        let largest = self.largest(tractions[0], &mut work) / (1.0 - MISSED);
        let (low, high) = (limit, largest.max(2.0 * limit));
        let (centre, radius) = (0.5 * (high + low), 0.5 * (high - low));
        let raised = RAISED * (tractions[0] / limit).sqrt();
        let degree = (raised.acosh() / (centre / radius).acosh()).ceil() as usize;
        let degree = degree.min(MOST_DEGREE);
        let mut before = y.clone();
        y.iter_mut()
            .zip(&before)
            .for_each(|(y, w)| *y = centre / radius * w);
        self.apply_add(-1.0 / radius, &before, &mut y, &mut work);
        for _ in 1..degree {
            let twice = before.iter_mut().zip(&y);
            twice.for_each(|(next, y)| *next = 2.0 * centre / radius * y - *next);
            self.apply_add(-2.0 / radius, &y, &mut before, &mut work);
            std::mem::swap(&mut before, &mut y);
        }
        self.apply(&y, &mut image, &mut work);
        let mut sums = [dot(&y, &image), dot(&y, &y)];
        self.sum_over_parts(&mut sums);
        y.iter_mut().zip(&self.scale).for_each(|(y, s)| *y *= s);
        (y, sums[0] / sums[1])
    }

    /// The largest Ritz value of so many Lanczos steps that it misses more than [`MISSED`] of the largest eigenvalue once in 10⁹ times, for n
    /// tractions over all parts.
    fn largest(&self, n: f64, work: &mut [f64]) -> f64 {
        let steps = LanczosSettings::within(n as usize, MISSED, Ends::Largest).max_steps;
        let mut v: Vec<f64> = (0..self.size() as u64).map(signed).collect();
        let [mut before, mut image] = [0; 2].map(|_| vec![0.0; v.len()]);
        let [mut diagonal, mut off] = [const { Vec::<f64>::new() }; 2];
        let mut size = self.square(&v).sqrt();
        while diagonal.len() < steps && size > 0.0 {
            v.iter_mut().for_each(|v| *v /= size);
            self.apply(&v, &mut image, work);
            if let Some(&beta) = off.last() {
                axpy(-beta, &before, &mut image);
            }
            let mut alpha = [dot(&v, &image)];
            self.sum_over_parts(&mut alpha);
            axpy(-alpha[0], &v, &mut image);
            size = self.square(&image).sqrt();
            diagonal.push(alpha[0]);
            off.push(size);
            std::mem::swap(&mut before, &mut v);
            std::mem::swap(&mut v, &mut image);
        }
        largest_of_tridiagonal(&diagonal, &off)
    }

    /// `√(Σ d t²)`.
    pub(super) fn norm(&self, t: &[f64]) -> f64 {
        let held = t.iter().zip(&self.scale).filter(|(_, s)| **s > 0.0);
        let mut square = [held.map(|(t, s)| (t / s).powi(2)).sum()];
        self.sum_over_parts(&mut square);
        square[0].sqrt()
    }

    /// ‖v‖².
    fn square(&self, v: &[f64]) -> f64 {
        let mut square = [dot(v, v)];
        self.sum_over_parts(&mut square);
        square[0]
    }
}

impl LinearOperator<f64> for OfTractions<'_> {
    fn shape(&self) -> Shape {
        Shape::square(self.size())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let (scaled, work) = work.split_at_mut(x.len());
        let (image, work) = work.split_at_mut(x.len());
        let scales = self.scale.iter().zip(x);
        (scaled.iter_mut().zip(scales)).for_each(|(scaled, (s, x))| *scaled = s * x);
        match &self.moved {
            Some(moved) => moved.apply(scaled, image),
            None => {
                let held = self.c.iter().zip(&*scaled);
                (image.iter_mut().zip(held)).for_each(|(image, (c, scaled))| *image = c * scaled);
            }
        }
        if let Some(h) = self.h {
            h.apply_add(1.0, scaled, image, work);
        }
        for ((y, image), s) in y.iter_mut().zip(image).zip(&self.scale) {
            *y += alpha * s * *image;
        }
    }

    fn work_len(&self) -> usize {
        2 * self.size() + self.h.map_or(0, |h| h.work_len())
    }

    fn flops(&self) -> u64 {
        let moved = (self.moved.as_ref()).map_or(0, |moved| 4 * moved.b1.nnz() as u64);
        5 * self.size() as u64 + moved + self.h.map_or(0, |h| h.flops())
    }

    fn sum_over_parts(&self, sums: &mut [f64]) {
        self.whole.sum_over_parts(sums);
    }
}

/// `B1ᵀ diag(A)⁻¹ B1`, not assembled.
struct Moved<'n> {
    b1: &'n SparseMatrix<f64>,
    /// Rows of B1 that are not empty, and the entries of `diag(A)⁻¹` there.
    rows: Vec<(usize, f64)>,
}

impl Moved<'_> {
    /// Row by row of B1.
    fn apply(&self, t: &[f64], image: &mut [f64]) {
        image.fill(0.0);
        for (i, inverse) in &self.rows {
            let Some(row) = self.b1.outer_view(*i) else {
                continue;
            };
            let force: f64 = row.iter().map(|(j, b)| b * t[j]).sum();
            (row.iter()).for_each(|(j, b)| image[j] += b * inverse * force);
        }
    }
}
