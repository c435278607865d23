//! Condition numbers in the 2-norm from both ends of the spectrum.

use crate::SetupError;
use crate::eigen::{Extreme, LanczosSettings, Map, extreme_eigenvalues};
use fracas_operators::Preconditioner;

/// Both ends of the spectrum of an SPD matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ends {
    pub(super) low: Extreme,
    pub(super) high: Extreme,
}

impl Ends {
    /// κ₂ = λ_max / λ_min.
    pub(super) fn condition(&self) -> f64 {
        self.high.value / self.low.value
    }

    /// Relative error bar of κ₂.
    pub(super) fn error(&self) -> f64 {
        self.high.error / self.high.value + self.low.error / self.low.value
    }
}

/// λ_max by Lanczos on the matrix, λ_min by Lanczos on its inverse: as accurate as the factorization, which material
/// contrast does not disturb, where an eigenvalue solver on the matrix would lose ε·κ₂.
pub(super) fn ends(
    apply: &mut Map<'_>,
    inverse: &dyn Preconditioner<f64>,
) -> Result<Ends, SetupError> {
    let n = inverse.size();
    let settings = LanczosSettings::one_sided();
    let (_, high) = extreme_eigenvalues(n, apply, None, settings)?;
    let mut work = vec![0.0; inverse.work_len()];
    let mut solve = |x: &[f64], y: &mut [f64]| inverse.solve(x, y, &mut work);
    let (_, reciprocal) = extreme_eigenvalues(n, &mut solve, None, settings)?;
    let low = Extreme {
        value: 1.0 / reciprocal.value,
        error: reciprocal.error / (reciprocal.value * reciprocal.value),
        steps: reciprocal.steps,
    };
    Ok(Ends { low, high })
}
