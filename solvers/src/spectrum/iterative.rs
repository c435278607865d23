//! Large systems: bounds by Lanczos on pencils, outer eigenvalues by Arnoldi. Nothing is formed.

use super::arnoldi::Ritz;
use super::bounds::Ingredients;
use super::discs;
use super::form::Statements;
use super::product::Preconditioned;
use super::real_ends;
use super::region::Circle;
use crate::SetupError;
use crate::eigen::{Ends, Extreme, LanczosSettings, Map, extreme_eigenvalues};
use crate::saddle::{AugmentationMatrix, RacpInverse, SaddleBlocks};
use faer::c64;
use fracas_operators::laws::probe;
use fracas_operators::sparse::Csr;
use fracas_operators::{AdjointOperator, LinearOperator, Preconditioner};

/// What can be said of T by products alone, and the largest relative error bar among the extreme values, each of which is taken with its
/// error bar outwards.
///
/// Pencils: Σ from `(A + BC⁻¹Bᵀ, S̃_u)`, K₂ from `(A + 2BC⁻¹Bᵀ, S̃_u)`, GᵀG from `(BᵀS̃_u⁻¹B, C)`, Ĥ from `(H, C)`; with W = p(C⁻¹H), W = I
/// without relaxation,
/// ```text
/// K:                         x ↦ A x + B(2s − C⁻¹WᵀHs), s = C⁻¹WᵀBᵀx, and S̃_u
/// Ã + N GᵀG N / λ_max(K):    x ↦ Wᵀ(H v + (s − H C⁻¹Wᵀs)/λ_max(K)), v = W x, s = BᵀS̃_u⁻¹B(v − C⁻¹WᵀHv), and C
/// ```
pub(super) fn statements(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    inner: &dyn Preconditioner<f64>,
    racp: &RacpInverse<'_>,
    exact: bool,
) -> Result<(Statements, f64), SetupError> {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let a = Csr::new(blocks.a.clone());
    let b = Csr::with_transpose(blocks.b1.clone());
    let h = blocks.h.clone().map(Csr::new);
    let settings = LanczosSettings {
        tolerance: 1e-10,
        ..LanczosSettings::default()
    };
    let mut worst = 0.0f64;
    let mut record = |(low, high): (Extreme, Extreme)| {
        let scale = high.value.abs().max(low.value.abs()).max(f64::MIN_POSITIVE);
        worst = worst.max(low.error / scale).max(high.error / scale);
        (low.value - low.error, high.value + high.error)
    };
    let mut rows = Rows {
        c,
        racp,
        work: vec![0.0; Preconditioner::work_len(c) + relaxation_work(racp, c)],
    };

    let mut inner_work = vec![0.0; inner.work_len()];
    let (mut p, mut q) = (vec![0.0; n_t], vec![0.0; n_t]);
    // A + times · B C⁻¹ Bᵀ, or K
    let mut stiffness = |times: Option<f64>, x: &[f64], y: &mut [f64]| {
        a.apply(x, y, &mut []);
        p.fill(0.0);
        b.apply_adjoint_add(1.0, x, &mut p, &mut []);
        if times.is_none() {
            rows.transpose(&mut p);
        }
        rows.solve(&p, &mut q);
        b.apply_add(times.unwrap_or(2.0), &q, y, &mut []);
        if let (None, Some(h)) = (times, &h) {
            h.apply(&q, &mut p, &mut []);
            rows.transpose(&mut p);
            rows.solve(&p, &mut q);
            b.apply_add(-1.0, &q, y, &mut []);
        }
    };
    let mut solve = |x: &[f64], y: &mut [f64]| inner.solve(x, y, &mut inner_work);
    let mut ends_of = |times: Option<f64>, solve: &mut Map<'_>| {
        let mut product = |x: &[f64], y: &mut [f64]| stiffness(times, x, y);
        extreme_eigenvalues(n_u, &mut product, Some(solve), settings)
    };
    let sigma = match exact {
        true => (1.0, 1.0),
        false => record(ends_of(Some(1.0), &mut solve)?),
    };
    let k = record(ends_of(Some(2.0), &mut solve)?);
    let k_h = match &h {
        Some(_) => record(ends_of(None, &mut solve)?),
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
    let h_ends = match &h {
        Some(h) => {
            let mut apply_h = |x: &[f64], y: &mut [f64]| h.apply(x, y, &mut []);
            let (low, high) = record(extreme_eigenvalues(
                n_t,
                &mut apply_h,
                Some(&mut solve_c),
                settings,
            )?);
            // a kernel of H up to rounding and error bars
            let zero = ZERO * high.abs().max(1.0);
            (if low.abs() <= zero { 0.0 } else { low }, high)
        }
        None => (0.0, 0.0),
    };
    let is_relaxed = racp.w().is_some();
    let cover = Cover::new(h_ends, is_relaxed, &|h| racp.relaxation_at(h));
    let (mut r, mut s, mut z) = (vec![0.0; n_t], vec![0.0; n_t], vec![0.0; n_t]);
    let mut rows = Rows {
        c,
        racp,
        work: vec![0.0; Preconditioner::work_len(c) + relaxation_work(racp, c)],
    };
    // Wᵀ(keep·H v + share·(s − H C⁻¹Wᵀ s)), v = W x, s = BᵀS̃_u⁻¹B(v − C⁻¹WᵀH v)
    let mut both = |keep: f64, share: f64, x: &[f64], y: &mut [f64]| {
        rows.forward(x, &mut r);
        y.fill(0.0);
        if let Some(h) = &h {
            h.apply(&r, y, &mut []);
        }
        s.copy_from_slice(y);
        rows.transpose(&mut s);
        rows.solve(&s, &mut z);
        r.iter_mut().zip(&z).for_each(|(r, z)| *r -= z);
        gram(&r, &mut s);
        y.iter_mut()
            .zip(&s)
            .for_each(|(y, s)| *y = keep * *y + share * s);
        if let Some(h) = &h {
            rows.transpose(&mut s);
            rows.solve(&s, &mut z);
            h.apply_add(-share, &z, y, &mut []);
        }
        rows.transpose(y);
    };
    let one_sided = LanczosSettings {
        ends: Ends::Largest,
        ..settings
    };
    let mut alone = |x: &[f64], y: &mut [f64]| both(0.0, 1.0, x, y);
    let (_, norm) = extreme_eigenvalues(n_t, &mut alone, Some(&mut solve_c), one_sided)?;
    worst = worst.max(norm.error / norm.value.abs().max(f64::MIN_POSITIVE));
    let real = match h_ends.0 >= 0.0 && cover.q_fits {
        false => None,
        true => {
            let share = 1.0 / k_h.1;
            let mut product = |x: &[f64], y: &mut [f64]| both(1.0, share, x, y);
            let loose = LanczosSettings {
                tolerance: LOWER,
                ..settings
            };
            let (low, _) = extreme_eigenvalues(n_t, &mut product, Some(&mut solve_c), loose)?;
            let high = real_ends::upper(sigma.1, squared.1, cover.a.1);
            Some((k_h.0.min((low.value - low.error).max(0.0)), high))
        }
    };
    let ingredients = Ingredients {
        k,
        g,
        h_hat: cover.a,
        k_h,
        coupling: (norm.value + norm.error).max(0.0).sqrt(),
        sigma,
        h: h_ends,
    };
    let extremes = [(h_ends.0, 1.0), (h_ends.1, 1.0)];
    let around_one = (!is_relaxed).then(|| discs::around_one(sigma.0, &extremes));
    Ok((
        Statements {
            ingredients,
            circles: cover.circles,
            right_of_zero: is_relaxed,
            around_one: around_one.flatten(),
            real,
        },
        worst,
    ))
}

/// A smallest eigenvalue of C⁻¹H below this fraction of max(1, η) is a zero of H. Unit: 1; Lanczos leaves about 1e-10.
const ZERO: f64 = 1e-8;

/// Relative accuracy of the lower end of the real eigenvalues. Unit: 1.
const LOWER: f64 = 1e-3;

fn relaxation_work(racp: &RacpInverse<'_>, c: &AugmentationMatrix) -> usize {
    racp.w()
        .map_or(0, |w| w.work_len(Preconditioner::work_len(c)))
}

/// C⁻¹, Wᵀ and W with memory of their own.
struct Rows<'a> {
    c: &'a AugmentationMatrix,
    racp: &'a RacpInverse<'a>,
    work: Vec<f64>,
}

impl Rows<'_> {
    fn solve(&mut self, x: &[f64], y: &mut [f64]) {
        self.c.solve(x, y, &mut self.work);
    }

    /// `r ← Wᵀ r`.
    fn transpose(&mut self, r: &mut [f64]) {
        if let Some(w) = self.racp.w() {
            w.apply_transpose(self.c, r, &mut self.work);
        }
    }

    /// `y = W x = C⁻¹Wᵀ C x`.
    fn forward(&mut self, x: &[f64], y: &mut [f64]) {
        y.copy_from_slice(x);
        if self.racp.w().is_some() {
            let mut image = vec![0.0; x.len()];
            self.c.apply(
                x,
                &mut image,
                &mut vec![0.0; LinearOperator::work_len(self.c)],
            );
            self.transpose(&mut image);
            self.solve(&image, y);
        }
    }
}

/// All modes between two eigenvalues of C⁻¹H.
struct Cover {
    /// Ends of Ã.
    a: (f64, f64),
    /// q ≤ 1.
    q_fits: bool,
    circles: Vec<Circle>,
}

impl Cover {
    /// Cells of h, and points of each: between two of them a coefficient leaves their range by less than its largest step.
    const CELLS: usize = 64;
    const POINTS: usize = 9;

    fn new((low, high): (f64, f64), is_relaxed: bool, p: &dyn Fn(f64) -> f64) -> Self {
        if !is_relaxed {
            return Self {
                a: (low, high),
                q_fits: true,
                circles: discs::of_modes(&[(low, 1.0), (high, 1.0)]),
            };
        }
        let mut whole = Self {
            a: (f64::INFINITY, f64::NEG_INFINITY),
            q_fits: true,
            circles: Vec::new(),
        };
        let width = (high - low) / (Self::CELLS * (Self::POINTS - 1)) as f64;
        for cell in 0..Self::CELLS {
            let modes: Vec<(f64, f64)> = (0..Self::POINTS)
                .map(|k| low + width * (cell * (Self::POINTS - 1) + k) as f64)
                .map(|h| (h, p(h)))
                .collect();
            let range = |f: &dyn Fn(f64, f64) -> f64| {
                let values: Vec<f64> = modes.iter().map(|m| f(m.1, discs::relaxed(*m))).collect();
                let step = values
                    .windows(2)
                    .fold(0.0f64, |s, v| s.max((v[1] - v[0]).abs()));
                let ends = values
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |e, v| {
                        (e.0.min(*v), e.1.max(*v))
                    });
                (ends.0 - step, ends.1 + step)
            };
            let a = range(&|_, a| a);
            whole.a = (whole.a.0.min(a.0.max(0.0)), whole.a.1.max(a.1));
            whole.q_fits &= modes.iter().all(|m| m.1 <= 1.0);
            // right of zero the smallest c₂ and c₀ and the largest c₁ give the largest set
            whole.circles.push(Circle::new(
                range(&|q, a| 2.0 * q - a).0,
                range(&|q, _| q * q).1,
                range(&|q, a| q * q * a).0.max(0.0),
            ));
        }
        whole
    }
}

/// Steps of Arnoldi.
const ARNOLDI_STEPS: usize = 160;

/// Residual relative to the largest Ritz value below which a Ritz value counts as an eigenvalue.
const CONVERGED: f64 = 1e-7;

/// What Arnoldi finds of a spectrum.
pub(super) struct Outer {
    /// Ritz values that have converged.
    pub(super) values: Vec<c64>,
    /// The largest of their residuals.
    pub(super) residual: f64,
    /// Ritz values that have not: where one lies beyond those that have, there are eigenvalues beyond them, too.
    pub(super) unsettled: Vec<c64>,
}

/// The outer eigenvalues of M⁻¹𝒜 that Arnoldi finds.
///
/// Works on `D M⁻¹𝒜 D⁻¹` with the energy scales D, so that units do not decide what is found. Multiplicities are not
/// seen.
pub(super) fn outer_eigenvalues(
    operator: &Preconditioned<'_>,
    scales: &[f64],
) -> Result<Outer, SetupError> {
    let ritz = Ritz::new(operator, scales, probe(scales.len(), 31), ARNOLDI_STEPS)?;
    let size = ritz.values.iter().fold(0.0f64, |s, v| s.max(v.norm()));
    let all = 0..ritz.values.len();
    let (converged, others): (Vec<usize>, Vec<usize>) =
        all.partition(|&j| ritz.residual(j) <= CONVERGED * size);
    let residuals = converged.iter().map(|&j| ritz.residual(j));
    let values = |list: &[usize]| list.iter().map(|&j| ritz.values[j]).collect();
    Ok(Outer {
        residual: residuals.fold(0.0, f64::max),
        values: values(&converged),
        unsettled: values(&others),
    })
}
