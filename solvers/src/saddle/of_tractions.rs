//! How much of the tractions C_0 + H holds.

use fracas_operators::{LinearOperator, Shape};

/// `D^(−1/2) (C_0 + H) D^(−1/2)`, D the diagonal of C_0 + H: how much of what D holds, C_0 + H holds, traction by traction.
pub(super) struct OfTractions<'n> {
    /// 𝒜, which knows of other parts.
    whole: &'n dyn LinearOperator<f64>,
    c: &'n [f64],
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
            h,
            scale: scale.collect(),
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

    /// `y ← D^(−1/2) y`.
    pub(super) fn unscale(&self, y: &mut [f64]) {
        y.iter_mut().zip(&self.scale).for_each(|(y, s)| *y *= s);
    }

    /// `Σ d y²` of the tractions that `t` has less of than this share, and of all.
    pub(super) fn missed(&self, y: &[f64], t: &[f64], share: f64) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for ((y, t), s) in y.iter().zip(t).zip(&self.scale).filter(|(_, s)| **s > 0.0) {
            let energy = (y / s).powi(2);
            sums[1] += energy;
            // NaN is missed, too
            let is_there = t * y >= share * y * y;
            sums[0] += if is_there { 0.0 } else { energy };
        }
        self.sum_over_parts(&mut sums);
        sums
    }
}

impl LinearOperator<f64> for OfTractions<'_> {
    fn shape(&self) -> Shape {
        Shape::square(self.size())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let (scaled, work) = work.split_at_mut(x.len());
        let (image, work) = work.split_at_mut(x.len());
        let scales = self.scale.iter().zip(self.c);
        for (((scaled, image), x), (s, c)) in
            (scaled.iter_mut().zip(&mut *image)).zip(x).zip(scales)
        {
            *scaled = s * x;
            *image = c * *scaled;
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
        5 * self.size() as u64 + self.h.map_or(0, |h| h.flops())
    }

    fn sum_over_parts(&self, sums: &mut [f64]) {
        self.whole.sum_over_parts(sums);
    }
}
