//! Large systems: bounds by Lanczos on pencils, outer eigenvalues by Arnoldi. Nothing is formed.

use super::arnoldi::Ritz;
use super::bounds::Ingredients;
use super::product::Preconditioned;
use crate::SetupError;
use crate::eigen::{Ends, Extreme, LanczosSettings, extreme_eigenvalues};
use crate::saddle::{AugmentationMatrix, SaddleBlocks};
use faer::c64;
use fracas_operators::laws::probe;
use fracas_operators::sparse::Csr;
use fracas_operators::{AdjointOperator, LinearOperator, Preconditioner};

/// Extreme values for the bounds and the largest relative error bar among them.
///
/// Pencils: K from `(A + 2BC⁻¹Bᵀ, S̃_u)`, K_H from the same minus `BC⁻¹HC⁻¹Bᵀ`, GᵀG from `(BᵀS̃_u⁻¹B, C)`, Ĥ from
/// `(H, C)`, ‖G(I−Ĥ)‖² from `((C−H)C⁻¹BᵀS̃_u⁻¹BC⁻¹(C−H), C)`.
pub(super) fn ingredients(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    inner: &dyn Preconditioner<f64>,
) -> Result<(Ingredients, f64), SetupError> {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let a = Csr::new(blocks.a.clone());
    let b = Csr::with_transpose(blocks.b1.clone());
    let h = blocks.h.clone().map(Csr::new);
    let settings = LanczosSettings {
        tolerance: 1e-10,
        max_steps: 600,
        ends: Ends::Both,
    };
    let mut worst = 0.0f64;
    let mut record = |(low, high): (Extreme, Extreme)| {
        let scale = high.value.abs().max(low.value.abs());
        worst = worst.max(low.error / scale).max(high.error / scale);
        (low.value, high.value)
    };

    let mut inner_work = vec![0.0; inner.work_len()];
    let (mut p, mut q) = (vec![0.0; n_t], vec![0.0; n_t]);
    let mut c_work = vec![0.0; Preconditioner::work_len(c)];
    let mut stiffness = |with_h: bool, x: &[f64], y: &mut [f64]| {
        a.apply(x, y, &mut []);
        p.fill(0.0);
        b.apply_adjoint_add(1.0, x, &mut p, &mut []);
        c.solve(&p, &mut q, &mut c_work);
        b.apply_add(2.0, &q, y, &mut []);
        if let (true, Some(h)) = (with_h, &h) {
            h.apply(&q, &mut p, &mut []);
            c.solve(&p, &mut q, &mut c_work);
            b.apply_add(-1.0, &q, y, &mut []);
        }
    };
    let mut solve = |x: &[f64], y: &mut [f64]| inner.solve(x, y, &mut inner_work);
    let k = record(extreme_eigenvalues(
        n_u,
        &mut |x, y| stiffness(false, x, y),
        Some(&mut solve),
        settings,
    )?);
    let k_h = match &h {
        Some(_) => record(extreme_eigenvalues(
            n_u,
            &mut |x, y| stiffness(true, x, y),
            Some(&mut solve),
            settings,
        )?),
        None => k,
    };

    let (mut v, mut w) = (vec![0.0; n_u], vec![0.0; n_u]);
    let mut gram = |x: &[f64], y: &mut [f64]| {
        b.apply(x, &mut v, &mut []);
        solve(&v, &mut w);
        y.fill(0.0);
        b.apply_adjoint_add(1.0, &w, y, &mut []);
    };
    let mut work = vec![0.0; Preconditioner::work_len(c)];
    let mut solve_c = |x: &[f64], y: &mut [f64]| c.solve(x, y, &mut work);
    let squared = record(extreme_eigenvalues(
        n_t,
        &mut gram,
        Some(&mut solve_c),
        settings,
    )?);
    let g = (squared.0.max(0.0).sqrt(), squared.1.max(0.0).sqrt());
    let Some(h) = &h else {
        return Ok((
            Ingredients {
                k,
                g,
                h_hat: (0.0, 0.0),
                k_h: k,
                coupling: g.1,
            },
            worst,
        ));
    };
    let mut apply_h = |x: &[f64], y: &mut [f64]| h.apply(x, y, &mut []);
    let h_hat = record(extreme_eigenvalues(
        n_t,
        &mut apply_h,
        Some(&mut solve_c),
        settings,
    )?);
    let (mut r, mut s) = (vec![0.0; n_t], vec![0.0; n_t]);
    let mut c_work = vec![0.0; Preconditioner::work_len(c)];
    let mut both = |x: &[f64], y: &mut [f64]| {
        // r = C⁻¹(C−H) x = x − C⁻¹Hx
        h.apply(x, &mut s, &mut []);
        c.solve(&s, &mut r, &mut c_work);
        r.iter_mut().zip(x).for_each(|(r, x)| *r = x - *r);
        gram(&r, &mut s);
        // y = (C−H)C⁻¹ s = s − H C⁻¹ s
        c.solve(&s, &mut r, &mut c_work);
        y.copy_from_slice(&s);
        h.apply_add(-1.0, &r, y, &mut []);
    };
    let one_sided = LanczosSettings {
        ends: Ends::Largest,
        ..settings
    };
    let (_, norm) = extreme_eigenvalues(n_t, &mut both, Some(&mut solve_c), one_sided)?;
    Ok((
        Ingredients {
            k,
            g,
            h_hat,
            k_h,
            coupling: norm.value.max(0.0).sqrt(),
        },
        worst.max(norm.error / norm.value.abs().max(f64::MIN_POSITIVE)),
    ))
}

/// Steps of Arnoldi.
const ARNOLDI_STEPS: usize = 160;

/// Residual relative to the largest Ritz value below which a Ritz value counts as an eigenvalue.
const CONVERGED: f64 = 1e-7;

/// The outer eigenvalues of M⁻¹𝒜 that Arnoldi finds, with the largest of their residuals.
///
/// Works on `D M⁻¹𝒜 D⁻¹` with the energy scales D, so that units do not decide what is found. Multiplicities are not
/// seen.
pub(super) fn outer_eigenvalues(
    operator: &Preconditioned<'_>,
    scales: &[f64],
) -> Result<(Vec<c64>, f64), SetupError> {
    let ritz = Ritz::new(operator, scales, probe(scales.len(), 31), ARNOLDI_STEPS)?;
    let size = ritz.values.iter().fold(0.0f64, |s, v| s.max(v.norm()));
    let converged: Vec<usize> = (0..ritz.values.len())
        .filter(|&j| ritz.residual(j) <= CONVERGED * size)
        .collect();
    let worst = converged
        .iter()
        .map(|&j| ritz.residual(j))
        .fold(0.0, f64::max);
    Ok((converged.iter().map(|&j| ritz.values[j]).collect(), worst))
}
