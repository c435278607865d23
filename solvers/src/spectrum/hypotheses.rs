//! What the statements about the eigenvalues rest on, and whether it holds.

use crate::SetupError;
use crate::direct::{DirectSolver, Kind};
use crate::eigen::{LanczosSettings, extreme_eigenvalues};
use fracas_operators::laws::probe;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::{dot, norm2};
use fracas_operators::{LinearOperator, Preconditioner};
use serde::Serialize;

/// A condition of a statement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hypothesis {
    /// In formulas.
    pub statement: &'static str,
    /// Whether it holds; null where that is not known.
    pub holds: Option<bool>,
    /// How it was checked and what was found.
    pub reason: String,
}

impl Hypothesis {
    /// A condition that holds, or does not.
    pub(super) fn new(statement: &'static str, holds: bool, reason: impl Into<String>) -> Self {
        Self {
            statement,
            holds: Some(holds),
            reason: reason.into(),
        }
    }

    /// A condition that nobody asks for, because another one fails.
    pub(super) fn not_needed(statement: &'static str) -> Self {
        Self {
            statement,
            holds: None,
            reason: "another hypothesis fails".to_owned(),
        }
    }

    /// The sentence that takes the place of a verdict; `None` where the condition holds.
    pub(super) fn objection(&self) -> Option<String> {
        match self.holds {
            Some(true) => None,
            Some(false) => Some(format!("hypothesis fails: {}", self.reason)),
            None => Some(format!(
                "hypothesis {} is not checked: {}",
                self.statement, self.reason
            )),
        }
    }
}

/// Eigenvalues of `D^{-1/2}AD^{-1/2}`, D = diag(A), that rounding makes of a zero. Unit: 1; rounding leaves about 1e-15.
const ZERO: f64 = 1e-12;

/// Least multiple of √n ε for [`ZERO`]: four times what a factorization takes for a lost pivot.
const ROUNDING: f64 = 32.0;

/// A ⪰ 0 up to rounding, from the Cholesky factorization of `D^{-1/2}AD^{-1/2} + 1e-12 I`, which exists exactly where no
/// eigenvalue is below −1e-12. Neither units nor material contrast change the answer.
///
/// # Cost
/// One sparse factorization; Lanczos where it fails.
pub(super) fn semi_definite(a: &SparseMatrix<f64>, direct: &dyn DirectSolver) -> Hypothesis {
    const STATEMENT: &str = "A ⪰ 0";
    let fails = |reason| Hypothesis::new(STATEMENT, false, reason);
    let n = a.rows();
    let mut scale = Vec::with_capacity(n);
    for (i, row) in a.outer_iterator().enumerate() {
        let a_ii = row.get(i).copied().unwrap_or(0.0);
        let is_zero = row.iter().all(|(_, v)| *v == 0.0);
        if a_ii < 0.0 || (a_ii == 0.0 && !is_zero) {
            return fails(format!(
                "A is indefinite (λ_min ≤ {a_ii:.1e}: diagonal entry of the nonzero row {})",
                i + 1
            ));
        }
        scale.push(if a_ii > 0.0 { a_ii.sqrt().recip() } else { 1.0 });
    }
    let mut scaled = a.clone();
    for (i, mut row) in scaled.outer_iterator_mut().enumerate() {
        row.iter_mut()
            .for_each(|(j, value)| *value *= scale[i] * scale[j]);
    }
    let shift = ZERO.max(ROUNDING * (n as f64).sqrt() * f64::EPSILON);
    let mut diagonal = Triplets::new((n, n));
    (0..n).for_each(|i| diagonal.add_triplet(i, i, shift));
    let shifted = &scaled + &diagonal.to_csr();
    let factors =
        (direct.analyze(&shifted, Kind::Spd)).and_then(|symbolic| symbolic.factor(&shifted));
    match factors {
        Ok(_) => Hypothesis::new(
            STATEMENT,
            true,
            format!(
                "no eigenvalue of D^-1/2 A D^-1/2, D = diag A, is below −{shift:.0e} (Cholesky)"
            ),
        ),
        Err(SetupError::NotPositiveDefinite { .. } | SetupError::Singular { .. }) => {
            fails(match smallest(scaled) {
                Some(value) => {
                    format!("A is indefinite (λ_min = {value:.1e} of D^-1/2 A D^-1/2, D = diag A)")
                }
                None => format!(
                    "A is indefinite (D^-1/2 A D^-1/2 + {shift:.0e} I, D = diag A, has no Cholesky factorization)"
                ),
            })
        }
        Err(error) => Hypothesis {
            statement: STATEMENT,
            holds: None,
            reason: error.to_string(),
        },
    }
}

/// λ_min by Lanczos on −A; `None` where it finds nothing below zero.
fn smallest(a: SparseMatrix<f64>) -> Option<f64> {
    let n = a.rows();
    let a = Csr::new(a);
    let mut negative = |x: &[f64], y: &mut [f64]| {
        y.fill(0.0);
        a.apply_add(-1.0, x, y, &mut []);
    };
    let settings = LanczosSettings {
        tolerance: 1e-6,
        ..LanczosSettings::one_sided()
    };
    let (_, largest) = extreme_eigenvalues(n, &mut negative, None, settings).ok()?;
    (largest.value > 0.0).then_some(-largest.value)
}

/// Vectors on which an approximate inverse is tried.
const PROBES: u64 = 4;

/// `xᵀS̃_u⁻¹x > 0` and `xᵀS̃_u⁻¹y = yᵀS̃_u⁻¹x` on a few vectors: what can be said above the dense limit.
pub(super) fn probed(inner: &dyn Preconditioner<f64>) -> Hypothesis {
    const STATEMENT: &str = "S̃_u ≻ 0";
    let rounding = if inner.properties().single {
        1e-5
    } else {
        1e-9
    };
    let n = inner.size();
    let mut work = vec![0.0; inner.work_len()];
    let images: Vec<(Vec<f64>, Vec<f64>)> = (0..PROBES)
        .map(|k| {
            let x = probe(n, 201 + k);
            let mut z = vec![0.0; n];
            inner.solve(&x, &mut z, &mut work);
            (x, z)
        })
        .collect();
    if images.iter().any(|(x, z)| dot(x, z) <= 0.0) {
        return Hypothesis::new(STATEMENT, false, "S̃_u⁻¹ is not positive definite");
    }
    let is_asymmetric = images.windows(2).any(|pair| {
        let ((x, z), (y, w)) = (&pair[0], &pair[1]);
        (dot(y, z) - dot(x, w)).abs() > rounding * (norm2(y) * norm2(z)).max(norm2(x) * norm2(w))
    });
    if is_asymmetric {
        return Hypothesis::new(STATEMENT, false, "S̃_u⁻¹ is not symmetric");
    }
    Hypothesis::new(STATEMENT, true, format!("estimate: on {PROBES} vectors"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direct::DirectChoice;
    use crate::saddle::samples::{random, sparse, two_chains};

    fn holds(a: &SparseMatrix<f64>) -> bool {
        let direct = DirectChoice::Faer.solver().unwrap();
        semi_definite(a, direct.as_ref()).holds.unwrap()
    }

    #[test]
    fn floating_blocks_contrast_and_units_are_semi_definite() {
        for contrast in [1.0, 1e-8, 1e8] {
            assert!(holds(&two_chains(40, 5, contrast, true).a));
        }
        let a = random(30, 3, 0.0, 5).a;
        let scale = |i: usize| 10f64.powi(i as i32 % 25 - 12);
        assert!(holds(&sparse(30, 30, |i, j| scale(i)
            * scale(j)
            * a.get(i, j).unwrap())));
        assert!(holds(&sparse(4, 4, |_, _| 0.0)));
    }

    #[test]
    fn one_negative_eigenvalue_is_found_down_to_rounding() {
        for seed in 0..40 {
            for size in [1.0, 1e-4, 1e-8, 1e-10] {
                // Aᵤ = A − (λ + size) v vᵀ for the lowest pair (λ, v)
                let a = random(12, 3, 0.0, seed).a;
                let full = crate::eigen::dense::to_dense(&a);
                let (values, vectors) =
                    crate::eigen::dense::symmetric_eigen(full.as_ref()).unwrap();
                let shifted = |size: f64| {
                    sparse(12, 12, |i, j| {
                        let (i, j) = (i.max(j), i.min(j));
                        full[(i, j)] - (values[0] + size) * vectors[(i, 0)] * vectors[(j, 0)]
                    })
                };
                assert!(!holds(&shifted(size)), "{seed} {size}");
                assert!(holds(&shifted(-size)), "{seed} {size}");
            }
        }
    }

    #[test]
    fn the_reason_names_the_eigenvalue_or_the_row() {
        let direct = DirectChoice::Faer.solver().unwrap();
        let reason = |a: &SparseMatrix<f64>| semi_definite(a, direct.as_ref()).objection().unwrap();
        let diagonal = sparse(2, 2, |i, j| if i == j { [2.0, -0.5][i] } else { 0.0 });
        assert_eq!(
            reason(&diagonal),
            "hypothesis fails: A is indefinite (λ_min ≤ -5.0e-1: diagonal entry of the nonzero row 2)"
        );
        // eigenvalues 3 and −1
        let hidden = sparse(2, 2, |i, j| if i == j { 1.0 } else { 2.0 });
        assert!(
            reason(&hidden).contains("λ_min = -1.0e0"),
            "{}",
            reason(&hidden)
        );
    }
}
