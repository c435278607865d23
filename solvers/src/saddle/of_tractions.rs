//! How much of the tractions C_0 + H, or `B1ᵀ diag(A)⁻¹ B1 + H`, holds.

use super::Stiffness;
use fracas_operators::random::signed;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::dot;
use fracas_operators::{LinearOperator, Shape};

/// Products that a polynomial takes which leaves little but the lowest modes: 2,000 times as much of a mode at 0 as of one at the limit,
/// where the largest eigenvalue is 100 times that limit. Unit: 1.
const DEGREE: usize = 60;

/// Products of the power iteration that bounds the spectrum. Unit: 1.
const POWERS: usize = 8;

/// Times that the largest eigenvalue may be what they give. Unit: 1.
const MARGIN: f64 = 1.5;

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
    /// 69 products.
    ///
    /// # Formula
    /// `y = T_k((b + a − 2N)/(b − a)) w`, a = `limit`, b above the largest eigenvalue of N, w random.
    pub(super) fn lowest(&self, limit: f64) -> (Vec<f64>, f64) {
        let mut work = vec![0.0; self.work_len()];
        let mut y: Vec<f64> = (0..self.size() as u64).map(signed).collect();
        let mut image = vec![0.0; y.len()];
        let mut largest = 0.0;
        for _ in 0..POWERS {
            self.apply(&y, &mut image, &mut work);
            let [before, after] = self.squares([&y, &image]);
            largest = (after / before).sqrt();
            let scale = after.sqrt().recip();
            y.iter_mut().zip(&image).for_each(|(y, i)| *y = scale * i);
        }
        let (low, high) = (limit, (MARGIN * largest).max(2.0 * limit));
        let (centre, radius) = (0.5 * (high + low), 0.5 * (high - low));
        let mut before: Vec<f64> = (0..self.size() as u64).map(signed).collect();
        y.iter_mut()
            .zip(&before)
            .for_each(|(y, w)| *y = centre / radius * w);
        self.apply_add(-1.0 / radius, &before, &mut y, &mut work);
        for _ in 1..DEGREE {
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

    /// `√(Σ d t²)`.
    pub(super) fn norm(&self, t: &[f64]) -> f64 {
        let held = t.iter().zip(&self.scale).filter(|(_, s)| **s > 0.0);
        let mut square = [held.map(|(t, s)| (t / s).powi(2)).sum()];
        self.sum_over_parts(&mut square);
        square[0].sqrt()
    }

    /// ‖·‖² of both.
    fn squares(&self, of: [&[f64]; 2]) -> [f64; 2] {
        let mut squares = of.map(|v| dot(v, v));
        self.sum_over_parts(&mut squares);
        squares
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
