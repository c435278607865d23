//! Ends of the real eigenvalues.
//!
//! `T = [K, G N; −N Gᵀ, Ã]` of [`Form`](super::form::Form), all of K, N, Ã symmetric.

use crate::SetupError;
use crate::eigen::dense;
use faer::Mat;

/// The largest real eigenvalue is not above `max{1, max a, r}`, r the larger root of `λ² − (Δ+b)λ + b = 0`, where
/// `S_u ⪯ Δ S̃_u`, `b = ‖G‖² ≤ Δ`, H ⪰ 0 and q ≤ 1. Only for Δ > 1 is r above 1; with b = Δ it is Δ + √(Δ²−Δ).
///
/// Proof: for λ > max(1, max a), t is eliminated: `λ = u*Âu + Σ g_j|w_j|²`, `g = ((2q−a)λ − q²)/(λ−a)`, ‖u‖ = 1. g decreases in a
/// and, at a = 0, increases in q: g ≤ 2 − 1/λ. So `λ ≤ u*Âu + ‖w‖² + (1−1/λ)‖w‖² ≤ Δ + (1−1/λ) b`.
pub(super) fn upper(capital_delta: f64, b: f64, largest_a: f64) -> f64 {
    let sum = capital_delta + b;
    let root = 0.5 * (sum + (sum * sum - 4.0 * b).max(0.0).sqrt());
    let root = if capital_delta > 1.0 { root } else { 1.0 };
    root.max(largest_a).max(1.0)
}

/// The smallest real eigenvalue for exact S_u and H ⪯ C is the smallest of the pencil, `μ = λ_min((S+C)⁻¹(S+H))`; for
/// `δ S̃_u ⪯ S_u ⪯ Δ S̃_u` it is not below the smaller of δ and `2μ / (1 + μ + √((1+μ)² − 4μ/max(Δ,1)))`: μ itself for Δ ≤ 1.
///
/// Proof: λ < δ ≤ λ_min(K). With N = I − Ĥ ⪰ 0, V = GᵀΣ⁻¹G and `K − λ ⪯ (1−λ/Δ)Σ + GNGᵀ`, u eliminated gives
/// `1/(1−λ) ≥ y*N⁻¹y + y*Vy/(1−λ/Δ)` for some ‖y‖ = 1. There `N⁻¹ ⪰ I` and `N⁻¹ ⪰ (I−V)/(1−μ)`; of both bounds the larger one is
/// least where y*Vy = μ, and leaves `λ²/Δ − (1+μ)λ + μ ≤ 0`. Of A nothing is asked beyond S_u ≻ 0.
pub fn lower(delta: f64, capital_delta: f64, mu: f64) -> f64 {
    let sum = 1.0 + mu;
    let root = (sum * sum - 4.0 * mu / capital_delta.max(1.0))
        .max(0.0)
        .sqrt();
    delta.min(2.0 * mu / (sum + root))
}

/// Steps from each end.
const STEPS: usize = 24;

/// A step that moves an end by less than this fraction is the last one. Unit: 1.
const GAIN: f64 = 1e-6;

/// K by its eigenvalues, the coupling in its eigenvectors, and Ã.
pub(super) struct Ends<'a> {
    /// Eigenvalues of K, ascending.
    pub(super) k: &'a [f64],
    /// `Vᵀ G N`, V the eigenvectors of K.
    pub(super) w: &'a Mat<f64>,
    /// Eigenvalues of Ã.
    pub(super) a: &'a [f64],
}

impl Ends<'_> {
    /// A lower end, from one that is known.
    ///
    /// A real λ below λ_min(K) is one of `S(λ) = Ã + N Gᵀ(K−λ)⁻¹G N`, and S grows with its argument: from `s ≤ λ` follows
    /// `λ ≥ λ_min(S(s))`. The first step, from s = 0, holds for every S̃_u at once: S(0) knows A, B, C and H alone.
    pub(super) fn lower(&self, known: f64) -> Result<f64, SetupError> {
        let (Some(&least), n_t) = (self.k.first(), self.a.len()) else {
            return Ok(known);
        };
        let mut low = known;
        for _ in 0..STEPS {
            if low >= least || n_t == 0 {
                break;
            }
            let scaled = Mat::from_fn(self.w.nrows(), n_t, |i, j| {
                self.w[(i, j)] / (self.k[i] - low).sqrt()
            });
            let mut s = dense::multiply(scaled.transpose(), scaled.as_ref());
            (0..n_t).for_each(|j| s[(j, j)] += self.a[j]);
            dense::symmetrize(&mut s);
            let next = dense::symmetric_eigenvalues(s.as_ref())?[0].min(least);
            let gain = next - low;
            low = low.max(next);
            if gain <= GAIN * low.abs() {
                break;
            }
        }
        Ok(low)
    }

    /// An upper end, from one that is known: `λ ≤ λ_max(K − G N(s−Ã)⁻¹N Gᵀ)` for max a < λ ≤ s, and
    /// `λ ≤ λ_max(Ã − N Gᵀ(s−K)⁻¹G N)` for λ_max(K) < λ ≤ s.
    pub(super) fn upper(&self, known: f64) -> Result<f64, SetupError> {
        let largest = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (k_high, a_high) = (largest(self.k), largest(self.a));
        let mut high = known;
        for _ in 0..STEPS {
            let mut next = high;
            if next > a_high {
                next = next.min(self.without_t(next)?.max(a_high));
            }
            if next > k_high {
                next = next.min(self.without_u(next)?.max(k_high));
            }
            let gain = high - next;
            high = next;
            if gain <= GAIN * high.abs() {
                break;
            }
        }
        Ok(high)
    }

    fn without_t(&self, s: f64) -> Result<f64, SetupError> {
        let scaled = Mat::from_fn(self.w.nrows(), self.a.len(), |i, j| {
            self.w[(i, j)] / (s - self.a[j]).sqrt()
        });
        self.largest(self.k, &scaled)
    }

    fn without_u(&self, s: f64) -> Result<f64, SetupError> {
        let scaled = Mat::from_fn(self.a.len(), self.w.nrows(), |j, i| {
            self.w[(i, j)] / (s - self.k[i]).sqrt()
        });
        self.largest(self.a, &scaled)
    }

    /// λ_max(diag d − X Xᵀ), dense: Lanczos, which may miss the largest of a cluster, gave an end 5e-6 too low (`analogue_b`, SSOR).
    fn largest(&self, d: &[f64], x: &Mat<f64>) -> Result<f64, SetupError> {
        let mut matrix = dense::multiply(x.as_ref(), x.transpose());
        matrix *= -1.0;
        for (i, d) in d.iter().enumerate() {
            matrix[(i, i)] += d;
        }
        dense::symmetrize(&mut matrix);
        let values = dense::symmetric_eigenvalues(matrix.as_ref())?;
        Ok(values.last().copied().unwrap_or(f64::NEG_INFINITY))
    }
}
