//! FSAI as a smoother.

use super::FsaiInverse;
use crate::SetupError;
use crate::eigen::{Ends, LanczosSettings, extreme_eigenvalues};
use fracas_operators::{AdjointOperator, LinearOperator};

/// Largest eigenvalue of `ω G A Gᵀ` that is allowed; 2 is the limit of convergence. Unit: 1.
///
/// # Source
/// The group's published multigrid.
const LARGEST: f64 = 1.9;

/// λ_max to about 1 %, which [`LARGEST`] leaves room for.
const ESTIMATE: LanczosSettings = LanczosSettings {
    tolerance: 0.01,
    max_steps: 60,
    ends: Ends::Largest,
    patience: 8,
};

impl FsaiInverse<f64> {
    /// `ω = min(1, 1.9/λ_max(G A Gᵀ))`, with which the error propagator `I − ωGᵀG A` is a contraction in the norm of A.
    ///
    /// # Cost
    /// Some ten products with A, G and Gᵀ.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] when Lanczos meets NaN.
    pub fn damping(&self, a: &dyn LinearOperator<f64>) -> Result<f64, SetupError> {
        let n = a.shape().rows;
        assert_eq!(n, self.g().shape().rows, "A and G of different sizes");
        let (mut low, mut image) = (vec![0.0; n], vec![0.0; n]);
        let mut work = vec![0.0; a.work_len()];
        let mut apply = |x: &[f64], y: &mut [f64]| {
            low.fill(0.0);
            self.g().apply_adjoint_add(1.0, x, &mut low, &mut []);
            a.apply(&low, &mut image, &mut work);
            self.g().apply(&image, y, &mut []);
        };
        let (_, largest) = extreme_eigenvalues(n, &mut apply, None, ESTIMATE)?;
        Ok((LARGEST / (largest.value + largest.error)).min(1.0))
    }

    /// `ωGᵀG` with the ω of [`damping`](Self::damping).
    ///
    /// # Errors
    /// As [`damping`](Self::damping).
    pub fn damped(&self, a: &dyn LinearOperator<f64>) -> Result<Self, SetupError> {
        let root = self.damping(a)?.sqrt();
        Ok(Self::of_factor(self.g().matrix().map(|value| root * value)))
    }
}
