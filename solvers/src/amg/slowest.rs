//! What a hierarchy leaves: the vectors that its cycle damps least.

use super::cycle::Shape;
use super::hierarchy::Hierarchy;
use super::sweeps::SweepMatrix;
use super::{Amg, Cycle};
use crate::SetupError;
use crate::eigen::dense;
use faer::Mat;
use fracas_operators::Real;
use fracas_operators::vector::{axpy, dot, norm_inf, xpby};

/// Vectors that are looked for: blocks between fractures can turn against their neighbours, like gears, about each of three
/// axes, and the mean jump over a face, which is all that a constant traction sees, does not feel it.
pub(super) const SLOWEST: usize = 3;

/// Lanczos steps; each is a cycle of the trial hierarchy.
const STEPS: usize = 16;

/// Ritz vectors of the smallest eigenvalues of `M⁻¹A`, M one V-cycle of the hierarchy of A, three rows per block row, each
/// with largest entry 1 (zero where there are none).
///
/// # Cost
/// 16 cycles and as many vectors of the scalars of the hierarchy.
///
/// # Source
/// Brezina, Falgout, MacLachlan, Manteuffel, McCormick, Ruge, SIAM Rev. 47 (2005), for near-null vectors found by the solver
/// itself.
pub(super) fn slowest<R: Real>(
    trial: &Hierarchy<R>,
    settings: &Amg,
    a: &SweepMatrix<f64>,
) -> Result<Vec<[[f64; SLOWEST]; 3]>, SetupError> {
    let shape = Shape::from(&Amg {
        cycle: Cycle::V,
        ..*settings
    });
    let n = 3 * a.rows();
    let [mut b, mut x] = [0; 2].map(|_| vec![R::zero(); n]);
    let mut work = vec![R::zero(); trial.work_len(shape)];
    let mut cycle = |r: &[f64], z: &mut [f64]| {
        let size = norm_inf(r).max(f64::MIN_POSITIVE);
        b.iter_mut().zip(r).for_each(|(b, r)| *b = R::of(r / size));
        trial.cycle(shape, 0, &mut b, &mut x, &mut work);
        z.iter_mut()
            .zip(&x)
            .for_each(|(z, x)| *z = size * x.to_f64_exact());
    };
    // conjugate gradients for A x = r₀: their coefficients are the Lanczos matrix of M⁻¹A, their preconditioned residuals its basis
    let mut r: Vec<f64> = (0..n)
        .map(|i| 0.1 + (1.0 + i as f64 * 1.618).sin())
        .collect();
    let [mut z, mut p, mut q] = [0; 3].map(|_| vec![0.0; n]);
    let mut basis: Vec<Vec<R>> = Vec::new();
    let (mut diagonal, mut off) = (Vec::new(), Vec::new());
    let (mut beta, mut alpha_before) = (0.0, 1.0);
    cycle(&r, &mut z);
    p.copy_from_slice(&z);
    let mut rho = dot(&r, &z);
    let steps = std::env::var("STEPS").map_or(STEPS, |v| v.parse().unwrap());
    while basis.len() < steps {
        a.product(&p, &mut q);
        let curvature = dot(&p, &q);
        if !(curvature > 0.0 && rho > 0.0) {
            break;
        }
        let root = rho.sqrt();
        basis.push(z.iter().map(|z| R::of(z / root)).collect());
        let alpha = rho / curvature;
        diagonal.push(1.0 / alpha + beta / alpha_before);
        axpy(-alpha, &q, &mut r);
        cycle(&r, &mut z);
        let next = dot(&r, &z);
        beta = (next / rho).max(0.0);
        off.push(beta.sqrt() / alpha);
        xpby(&z, beta, &mut p);
        (rho, alpha_before) = (next, alpha);
    }
    let m = basis.len();
    let mut t = Mat::<f64>::zeros(m, m);
    for i in 0..m {
        t[(i, i)] = diagonal[i];
        if i + 1 < m {
            // residuals of conjugate gradients alternate in sign against Lanczos vectors
            t[(i, i + 1)] = -off[i];
            t[(i + 1, i)] = -off[i];
        }
    }
    let mut vectors = vec![[[0.0; SLOWEST]; 3]; a.rows()];
    if m == 0 {
        return Ok(vectors);
    }
    let (w, y) = dense::symmetric_eigen(t.as_ref())?;
    if std::env::var("DBG").is_ok() { eprintln!("ritz {w:?}"); }
    for k in 0..SLOWEST.min(m) {
        let mut v = vec![0.0; n];
        for (j, z) in basis.iter().enumerate() {
            let weight = y[(j, k)];
            v.iter_mut()
                .zip(z)
                .for_each(|(v, z)| *v += weight * z.to_f64_exact());
        }
        let size = norm_inf(&v);
        if size > 0.0 {
            for (row, v) in vectors.iter_mut().zip(v.as_chunks::<3>().0) {
                (0..3).for_each(|c| row[c][k] = v[c] / size);
            }
        }
    }
    Ok(vectors)
}
