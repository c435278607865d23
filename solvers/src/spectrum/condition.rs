//! Condition numbers in the 2-norm from both ends of the spectrum.

use crate::SetupError;
use crate::direct::DirectSolver;
use crate::eigen::{Extreme, LanczosSettings, Map, extreme_eigenvalues, kernel_of};
use crate::saddle::scaling::ScaledInverse;
use crate::saddle::{AugmentationMatrix, SaddleBlocks, schur};
use fracas_operators::sparse::Csr;
use fracas_operators::{AdjointOperator, LinearOperator, Preconditioner, Properties};

/// Both ends of the spectrum of an SPD matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// λ_min; of a singular matrix the smallest non-zero eigenvalue.
    pub low: Extreme,
    /// λ_max.
    pub high: Extreme,
}

impl Ends {
    /// κ₂ = λ_max / λ_min.
    pub fn condition(&self) -> f64 {
        self.high.value / self.low.value
    }

    /// Relative error bar of κ₂.
    pub fn error(&self) -> f64 {
        self.high.error / self.high.value + self.low.error / self.low.value
    }
}

/// λ_max by Lanczos on the matrix, λ_min by Lanczos on its inverse: as accurate as the factorization, which material
/// contrast does not disturb, where an eigenvalue solver on the matrix would lose ε·κ₂.
fn ends(apply: &mut Map<'_>, inverse: &dyn Preconditioner<f64>) -> Result<Ends, SetupError> {
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

/// λ_max(A).
fn largest(a: &Csr<f64>) -> Result<Extreme, SetupError> {
    let n = a.matrix().rows();
    let mut product = |x: &[f64], y: &mut [f64]| a.apply(x, y, &mut []);
    Ok(extreme_eigenvalues(n, &mut product, None, LanczosSettings::one_sided())?.1)
}

/// The spectrum of A from end to end, and its kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessEnds {
    /// dim ker A: six for every block that only fractures hold.
    pub kernel: usize,
    /// Ends of the spectrum on the complement of the kernel; `None` where A is singular to working precision without a
    /// clear kernel.
    pub ends: Option<Ends>,
}

/// Both ends of the spectrum of A.
///
/// # Cost
/// One sparse factorization (two where A is singular) and Lanczos.
///
/// # Errors
/// [`SetupError`] where A is not positive semi-definite.
pub fn stiffness_ends(
    blocks: &SaddleBlocks,
    direct: &dyn DirectSolver,
) -> Result<StiffnessEnds, SetupError> {
    let a = Csr::new(blocks.a.clone());
    if let Ok(inverse) = ScaledInverse::new(&blocks.a, direct, "A") {
        let ends = ends(&mut |x, y| a.apply(x, y, &mut []), &inverse)?;
        return Ok(StiffnessEnds {
            kernel: 0,
            ends: Some(ends),
        });
    }
    let kernel = kernel_of(&blocks.a, direct)?;
    let dimension = kernel.dimension();
    let low = kernel.smallest_nonzero.filter(|_| dimension > 0);
    let ends = match low {
        Some(low) => Some(Ends {
            low,
            high: largest(&a)?,
        }),
        None => None,
    };
    Ok(StiffnessEnds {
        kernel: dimension,
        ends,
    })
}

/// Both ends of the spectrum of `S_u = A + B C⁻¹Bᵀ`, given its exact inverse or factorizing it.
///
/// # Errors
/// [`SetupError`] where S_u is singular.
pub fn schur_ends(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    inverse: Option<&dyn Preconditioner<f64>>,
    direct: &dyn DirectSolver,
) -> Result<Ends, SetupError> {
    let unit = vec![1.0; blocks.n_u()];
    weighted_ends(blocks, c, inverse, direct, unit)
}

/// Both ends of the spectrum of `D^{-1/2} S_u D^{-1/2}`, D = diag(S_u): what an approximation that starts by scaling sees.
///
/// # Errors
/// [`SetupError`] where S_u is singular.
pub fn scaled_schur_ends(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    inverse: Option<&dyn Preconditioner<f64>>,
    direct: &dyn DirectSolver,
) -> Result<Ends, SetupError> {
    // (B C⁻¹ Bᵀ)_ii = ‖row i of B F‖², C⁻¹ = F Fᵀ
    let scaled = &blocks.b1 * &c.inverse_root()?;
    let weights = scaled
        .outer_iterator()
        .enumerate()
        .map(|(i, row)| {
            let added: f64 = row.data().iter().map(|v| v * v).sum();
            (blocks.a.get(i, i).copied().unwrap_or(0.0) + added).sqrt()
        })
        .collect();
    weighted_ends(blocks, c, inverse, direct, weights)
}

/// Both ends of the spectrum of `W⁻¹ S_u W⁻¹`, W = diag(weights).
fn weighted_ends(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    inverse: Option<&dyn Preconditioner<f64>>,
    direct: &dyn DirectSolver,
    weights: Vec<f64>,
) -> Result<Ends, SetupError> {
    let factorized;
    let inverse = match inverse {
        Some(inverse) => inverse,
        None => {
            factorized = schur::exact_inverse(blocks, c, direct)?;
            factorized.as_ref()
        }
    };
    let a = Csr::new(blocks.a.clone());
    let b = Csr::with_transpose(blocks.b1.clone());
    let (mut p, mut q) = (vec![0.0; blocks.n_t()], vec![0.0; blocks.n_t()]);
    let mut w = vec![0.0; blocks.n_u()];
    let mut work = vec![0.0; Preconditioner::work_len(c)];
    let mut s_u = |x: &[f64], y: &mut [f64]| {
        // y = W⁻¹ (A + B C⁻¹ Bᵀ) W⁻¹ x
        w.iter_mut()
            .zip(x)
            .zip(&weights)
            .for_each(|((w, x), d)| *w = x / d);
        a.apply(&w, y, &mut []);
        p.fill(0.0);
        b.apply_adjoint_add(1.0, &w, &mut p, &mut []);
        c.solve(&p, &mut q, &mut work);
        b.apply_add(1.0, &q, y, &mut []);
        y.iter_mut().zip(&weights).for_each(|(y, d)| *y /= d);
    };
    let weighted = Weighted {
        inverse,
        weights: &weights,
    };
    ends(&mut s_u, &weighted)
}

/// `W S⁻¹ W`.
struct Weighted<'a> {
    inverse: &'a dyn Preconditioner<f64>,
    weights: &'a [f64],
}

impl Preconditioner<f64> for Weighted<'_> {
    fn size(&self) -> usize {
        self.inverse.size()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let (w, work) = work.split_at_mut(r.len());
        w.iter_mut()
            .zip(r)
            .zip(self.weights)
            .for_each(|((w, r), d)| *w = r * d);
        self.inverse.solve(w, z, work);
        z.iter_mut().zip(self.weights).for_each(|(z, d)| *z *= d);
    }

    fn work_len(&self) -> usize {
        self.size() + self.inverse.work_len()
    }

    fn flops(&self) -> u64 {
        self.inverse.flops() + 2 * self.size() as u64
    }

    fn properties(&self) -> Properties {
        self.inverse.properties()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direct::DirectChoice;
    use crate::eigen::dense;
    use crate::saddle::AugmentationChoice;
    use crate::saddle::samples::{random, two_chains};
    use faer::Mat;

    #[test]
    fn both_conditions_of_s_u_are_the_dense_ones() {
        let direct = DirectChoice::Faer.solver().unwrap();
        for blocks in [random(24, 6, 0.3, 5), two_chains(12, 6, 1e3, false)] {
            for choice in AugmentationChoice::ALL {
                let c = choice.compute(&blocks, direct.as_ref()).unwrap().matrix;
                let s_u = schur::primal_schur(&blocks.a, &blocks.b1, &c).unwrap();
                let s_u = dense::to_dense(&s_u);
                let scaled = Mat::from_fn(24, 24, |i, j| {
                    s_u[(i, j)] / (s_u[(i, i)] * s_u[(j, j)]).sqrt()
                });
                let condition = |m: &Mat<f64>| {
                    let values = dense::symmetric_eigenvalues(m.as_ref()).unwrap();
                    values[23] / values[0]
                };
                let plain = schur_ends(&blocks, &c, None, direct.as_ref()).unwrap();
                let unit = scaled_schur_ends(&blocks, &c, None, direct.as_ref()).unwrap();
                for (found, expected) in [(plain, condition(&s_u)), (unit, condition(&scaled))] {
                    let error = (found.condition() / expected - 1.0).abs();
                    assert!(error < 1e-8, "{choice}: {error:e}");
                }
            }
        }
    }
}
