//! The kernel of a symmetric positive semi-definite sparse matrix: rigid-body modes of floating blocks.

use super::lanczos::{LanczosSettings, extreme_eigenvalues};
use super::{Extreme, dense};
use crate::SetupError;
use crate::direct::{DirectSolver, Factorization, Kind};
use faer::Mat;
use fracas_operators::LinearOperator;
use fracas_operators::laws::probe;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::{axpy, dot};

/// Shift of `D^{-1/2} A D^{-1/2}` (diagonal 1) that makes a singular matrix factorizable. Unit: 1.
const SHIFT: f64 = 1e-9;

/// Eigenvalues of `D^{-1/2} A D^{-1/2}` below this belong to the kernel. Unit: 1; rounding leaves about 1e-15.
const ZERO: f64 = 1e-12;

/// Steps of block inverse iteration; each gains `SHIFT / μ` for the smallest eigenvalue μ outside the kernel.
const STEPS: usize = 4;

/// What [`kernel_of`] finds.
#[derive(Debug)]
pub struct Kernel {
    /// Euclidean-orthonormal basis of ker A.
    pub basis: Vec<Vec<f64>>,
    /// Smallest non-zero eigenvalue of A.
    pub smallest_nonzero: Option<Extreme>,
}

impl Kernel {
    /// dim ker A.
    pub fn dimension(&self) -> usize {
        self.basis.len()
    }
}

/// Kernel and smallest non-zero eigenvalue of an SPSD matrix; an error where A is indefinite beyond rounding.
///
/// Block inverse iteration with `A + σD`, D = diag(A), σ = 1e-9, and Rayleigh quotients of A itself; then Lanczos on
/// the pseudo-inverse `A⁺ b = Σ_k ((A+σD)⁻¹σD)^k (A+σD)⁻¹ b` projected off the kernel.
///
/// # Cost
/// One sparse Cholesky factorization and 4 p solves with a block of p ≥ 12 vectors, p > dim ker A.
pub fn kernel_of(a: &SparseMatrix<f64>, solver: &dyn DirectSolver) -> Result<Kernel, SetupError> {
    let n = a.rows();
    let d = scale_of(a)?;
    let shifted = shifted(a, &d, SHIFT);
    let factors = solver.analyze(&shifted, Kind::Spd)?.factor(&shifted)?;
    let a = Csr::new(a.clone());
    let mut block = 12.min(n);
    let basis = loop {
        let (values, vectors) = inverse_iteration(&a, &d, factors.as_ref(), block)?;
        if let Some(mu) = values.first().filter(|mu| **mu < -ZERO) {
            return Err(SetupError::NotApplicable {
                method: "the search for rigid-body modes",
                reason: format!(
                    "A is indefinite (λ_min = {mu:.1e} of D^-1/2 A D^-1/2, D = diag A)"
                ),
            });
        }
        let dimension = values.iter().filter(|mu| **mu < ZERO).count();
        if dimension < block || block == n {
            break orthonormal(vectors.into_iter().take(dimension).collect());
        }
        block = (2 * block).min(n);
    };
    let smallest_nonzero = if basis.len() == n {
        None
    } else {
        Some(smallest_outside(&a, &basis, factors.as_ref())?)
    };
    Ok(Kernel {
        basis,
        smallest_nonzero,
    })
}

/// diag(A), with the largest entry in place of zeros: an unknown without stiffness belongs to the kernel.
fn scale_of(a: &SparseMatrix<f64>) -> Result<Vec<f64>, SetupError> {
    let mut d: Vec<f64> = (0..a.rows())
        .map(|i| a.get(i, i).copied().unwrap_or(0.0))
        .collect();
    let largest = d.iter().copied().fold(0.0, f64::max);
    for (i, value) in d.iter_mut().enumerate() {
        if *value == 0.0 && largest > 0.0 {
            *value = largest;
        } else if value.is_nan() || *value <= 0.0 {
            return Err(SetupError::BadDiagonal {
                block: "A",
                row: i + 1,
                value: *value,
                method: "the search for rigid-body modes",
            });
        }
    }
    Ok(d)
}

/// `A + σD`.
fn shifted(a: &SparseMatrix<f64>, d: &[f64], sigma: f64) -> SparseMatrix<f64> {
    let mut diagonal = Triplets::new((d.len(), d.len()));
    d.iter()
        .enumerate()
        .for_each(|(i, d_i)| diagonal.add_triplet(i, i, sigma * d_i));
    a + &diagonal.to_csr()
}

/// Ritz values (ascending) and vectors of the pencil (A, D) after a few steps of `(A + σD)⁻¹ D`.
fn inverse_iteration(
    a: &Csr<f64>,
    d: &[f64],
    factors: &dyn Factorization,
    block: usize,
) -> Result<(Vec<f64>, Vec<Vec<f64>>), SetupError> {
    let n = d.len();
    let mut x: Vec<Vec<f64>> = (0..block).map(|k| probe(n, 101 + k as u64)).collect();
    let mut values = Vec::new();
    for _ in 0..STEPS {
        let mut flat: Vec<f64> = x
            .iter()
            .flat_map(|v| v.iter().zip(d).map(|(v, d)| v * d))
            .collect();
        // vectors that the solves have made parallel are gone
        factors.solve_many(x.len(), &mut flat);
        x = flat.chunks(n).map(<[f64]>::to_vec).collect();
        // D-orthonormal basis, then Rayleigh–Ritz: Q = XᵀAX
        let scaled =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(d).map(|(v, d)| v * d.sqrt()).collect() };
        let unscaled =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(d).map(|(v, d)| v / d.sqrt()).collect() };
        x = orthonormal(x.iter().map(|v| scaled(v)).collect())
            .iter()
            .map(|v| unscaled(v))
            .collect();
        let image: Vec<Vec<f64>> = x
            .iter()
            .map(|v| {
                let mut y = vec![0.0; n];
                a.apply(v, &mut y, &mut []);
                y
            })
            .collect();
        let m = x.len();
        let mut q = Mat::from_fn(m, m, |i, j| dot(&x[i], &image[j]));
        dense::symmetrize(&mut q);
        let (mu, rotation) = dense::symmetric_eigen(q.as_ref())?;
        x = (0..m)
            .map(|j| {
                let mut v = vec![0.0; n];
                (0..m).for_each(|i| axpy(rotation[(i, j)], &x[i], &mut v));
                v
            })
            .collect();
        values = mu;
    }
    Ok((values, x))
}

/// Gram–Schmidt, twice; vectors that vanish are dropped.
fn orthonormal(vectors: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(vectors.len());
    for mut v in vectors {
        let start = dot(&v, &v).sqrt();
        for _ in 0..2 {
            project(&basis, &mut v);
        }
        let norm = dot(&v, &v).sqrt();
        if norm > 1e-12 * start {
            v.iter_mut().for_each(|entry| *entry /= norm);
            basis.push(v);
        }
    }
    basis
}

/// `v ← (I − Z Zᵀ) v`.
fn project(basis: &[Vec<f64>], v: &mut [f64]) {
    for z in basis {
        axpy(-dot(z, v), z, v);
    }
}

/// 1 / λ_max(A⁺).
fn smallest_outside(
    a: &Csr<f64>,
    kernel: &[Vec<f64>],
    factors: &dyn Factorization,
) -> Result<Extreme, SetupError> {
    let n = a.shape().rows;
    let (mut r, mut dx) = (vec![0.0; n], vec![0.0; n]);
    let mut work = vec![0.0; factors.work_len()];
    let mut pseudo_inverse = |b: &[f64], y: &mut [f64]| {
        // x ← x + (A + σD)⁻¹ (P b − A x), then P
        y.fill(0.0);
        for _ in 0..3 {
            r.copy_from_slice(b);
            project(kernel, &mut r);
            a.apply_add(-1.0, y, &mut r, &mut []);
            project(kernel, &mut r);
            factors.solve(&r, &mut dx, &mut work);
            axpy(1.0, &dx, y);
        }
        project(kernel, y);
    };
    let settings = LanczosSettings::one_sided();
    let (_, high) = extreme_eigenvalues(n, &mut pseudo_inverse, None, settings)?;
    Ok(Extreme {
        value: 1.0 / high.value,
        error: high.error / (high.value * high.value),
        steps: high.steps,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direct::DirectChoice;
    use crate::saddle::samples::{sparse, two_chains};

    #[test]
    fn floating_chains_are_counted_and_the_next_eigenvalue_is_found() {
        let n = 30;
        for contrast in [1.0, 1e-6, 1e6] {
            let blocks = two_chains(n, 3, contrast, true);
            let kernel =
                kernel_of(&blocks.a, DirectChoice::Faer.solver().unwrap().as_ref()).unwrap();
            assert_eq!(kernel.dimension(), 1);
            let mode = &kernel.basis[0];
            assert!(mode[..n].iter().all(|v| v.abs() < 1e-6));
            assert!(
                mode[n..]
                    .iter()
                    .all(|v| (v.abs() - (n as f64).powf(-0.5)).abs() < 1e-9)
            );
            // Held: 2 − 2cos(π/(2n+1)); floating: contrast·(2 − 2cos(π/n)).
            let pi = std::f64::consts::PI;
            let held = 2.0 - 2.0 * (pi / (2 * n + 1) as f64).cos();
            let floating = contrast * (2.0 - 2.0 * (pi / n as f64).cos());
            let found = kernel.smallest_nonzero.unwrap().value;
            assert!(
                (found / held.min(floating) - 1.0).abs() < 1e-8,
                "{contrast}: {found}"
            );
        }
    }

    #[test]
    fn an_eigenvalue_just_below_zero_is_no_kernel() {
        // eigenvalues δ and 2 − δ; A + σD comes as close to singular as it can
        let direct = DirectChoice::Faer.solver().unwrap();
        for k in 0..15 {
            let delta = -SHIFT * (1.0 - 0.1f64.powi(k));
            let a = sparse(2, 2, |i, j| if i == j { 1.0 } else { delta - 1.0 });
            let found = kernel_of(&a, direct.as_ref());
            assert_eq!(found.is_ok(), k == 0, "{delta:e}: {found:?}");
        }
    }

    #[test]
    fn many_floating_pieces_need_a_larger_block() {
        // Twenty pairs of nodes, each joined by a spring: twenty kernel vectors, then the eigenvalue 2.
        let a = sparse(40, 40, |i, j| {
            if i == j {
                1.0
            } else if i / 2 == j / 2 {
                -1.0
            } else {
                0.0
            }
        });
        let kernel = kernel_of(&a, DirectChoice::Faer.solver().unwrap().as_ref()).unwrap();
        assert_eq!(kernel.dimension(), 20);
        assert!((kernel.smallest_nonzero.unwrap().value - 2.0).abs() < 1e-10);
    }
}
