//! What GMRES can at most leave after k steps, by the resolvent and by the field of values.

use super::ellipse::{Arc, Ellipse};
use super::resolvent::Resolvent;
use crate::eigen::{LanczosSettings, extreme_eigenvalues};
use crate::krylov::{Criteria, Gmres, KrylovMethod, System};
use crate::spectrum::FieldOfValues;
use crate::spectrum::report::Eigenvalues;
use crate::{Observer, SetupError, Step};
use faer::c64;
use fracas_operators::{AdjointOperator, Dense, Identity, LinearOperator};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::{PI, SQRT_2};
use std::ops::ControlFlow;

/// Relative residual that steps are counted to. Unit: 1.
pub const STEPS_TO: f64 = 1e-8;

/// Steps after which nothing is counted.
const MOST: usize = 10_000;

/// Where GMRES ends: below this its residual is rounding. Unit: 1.
const ROUNDING: f64 = 1e-12;

/// Relative accuracy of σ_min on curves. Unit: 1.
const ACCURACY: f64 = 1e-6;

/// Places of curves between the spectrum and zero, in logarithms.
const SHARES: [f64; 7] = [0.03, 0.08, 0.15, 0.25, 0.35, 0.5, 0.7];

/// Half a piece of a curve is at most this much of σ_min in its middle: K is then had to 1/(1 − 0.2). Unit: 1.
const FINE: f64 = 0.2;

/// Pieces of a curve that are tried before it is given up: it runs too near to an eigenvalue.
const PIECES: usize = 300;

/// Bounds of `‖r_k‖/‖r_0‖` of GMRES for T y = r_0 from y = 0, beside one that ran, in the inner product of T.
///
/// * By the resolvent, on any curve Γ around the spectrum that leaves zero outside: `‖p(T)‖ ≤ K max_Γ|p|`,
///   `K = (1/2π)∮_Γ ‖(zI − T)⁻¹‖ |dz| ≤ L_Γ/(2πε)`, ε = min σ_min on Γ, which is then outside of the ε-pseudospectrum. Between its points
///   `σ_min(zI − T)` changes by no more than z does, so that the sum that stands for K is not below it.
/// * By the field of values W: `2 max|p|` on a disc around W (Okubo–Ando), `(1 + √2) max|p|` on an ellipse (Crouzeix–Palencia), and
///   `(1 − μ²/‖T‖²)^{k/2}`, μ = min Re W (Elman).
///
/// Γ are ellipses, p Chebyshev polynomials with p(0) = 1, and the least of all counts for each k.
///
/// # Source
/// L. N. Trefethen & M. Embree, *Spectra and Pseudospectra* (2005), §26; M. Crouzeix & C. Palencia, SIAM J. Matrix Anal. Appl. 38 (2017)
/// 649–655; S. C. Eisenstat, H. C. Elman & M. H. Schultz, SIAM J. Numer. Anal. 20 (1983) 345–357.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GmresBounds {
    /// ‖T‖.
    pub norm: f64,
    /// μ, the least Re z of the field of values.
    pub coercivity: f64,
    /// `‖r_k‖/‖r_0‖` of GMRES without restarts, k = 0, 1, …
    pub measured: Vec<f64>,
    /// By the resolvent, as long as `measured`; ones where no curve leaves zero outside.
    pub resolvent: Vec<f64>,
    /// By the field of values, as long as `measured`; ones where zero lies in it.
    pub field_of_values: Vec<f64>,
    /// Steps to 1e-8: measured, by the resolvent, by the field of values; null where that is not reached.
    pub steps: [Option<usize>; 3],
}

/// Constant and polynomials.
type Bound = (f64, Ellipse);

fn least(bounds: &[Bound], k: usize) -> f64 {
    let of = |(constant, ellipse): &Bound| constant * ellipse.polynomial(k);
    bounds.iter().map(of).fold(1.0, f64::min)
}

impl GmresBounds {
    pub(super) fn new(
        t: &Dense<f64>,
        resolvent: &Resolvent,
        eigenvalues: &Eigenvalues,
        field: &FieldOfValues,
        r_0: &[f64],
    ) -> Result<Self, SetupError> {
        let corners: Vec<[f64; 2]> = field
            .re
            .iter()
            .zip(&field.im)
            .map(|(x, y)| [*x, *y])
            .collect();
        let by_field: Vec<Bound> = (Ellipse::around(&corners).into_iter())
            .map(|ellipse| match ellipse.is_circle() {
                true => (2.0, ellipse),
                false => (1.0 + SQRT_2, ellipse),
            })
            .collect();
        let points: Vec<[f64; 2]> = eigenvalues.iter().map(|(re, im)| [re, im]).collect();
        let curves: Vec<Ellipse> = (Ellipse::around(&points).iter())
            .flat_map(|ellipse| SHARES.map(|share| ellipse.toward_zero(share)))
            .collect();
        let by_resolvent: Vec<Option<Bound>> = (curves.par_iter())
            .map(|curve| Ok(constant(resolvent, curve)?.map(|k| (k, *curve))))
            .collect::<Result<_, SetupError>>()?;
        let by_resolvent: Vec<Bound> = by_resolvent.into_iter().flatten().collect();
        let (norm, coercivity) = (norm(t)?, field.least_real_part());
        let elman = 1.0 - (coercivity.max(0.0) / norm).powi(2);
        let of_field = |k: usize| {
            let k_half = 0.5 * k as f64;
            least(&by_field, k).min(elman.max(0.0).powf(k_half))
        };
        let of_resolvent = |k: usize| least(&by_resolvent, k);
        let measured = residuals(t, r_0);
        let reached = |f: &dyn Fn(usize) -> f64| (0..MOST).find(|k| f(*k) <= STEPS_TO);
        let each = |f: &dyn Fn(usize) -> f64| (0..measured.len()).map(f).collect();
        Ok(Self {
            norm,
            coercivity,
            resolvent: each(&of_resolvent),
            field_of_values: each(&of_field),
            steps: [
                measured.iter().position(|r| *r <= STEPS_TO),
                reached(&of_resolvent),
                reached(&of_field),
            ],
            measured,
        })
    }
}

/// `(1/2π)∮ ‖(zI − T)⁻¹‖ |dz|` from above; `None` where the curve comes too near to the spectrum.
fn constant(resolvent: &Resolvent, curve: &Ellipse) -> Result<Option<f64>, SetupError> {
    let mut arcs = Arc::upper_half(8);
    let (mut sum, mut tried) = (0.0, 0);
    while !arcs.is_empty() {
        tried += arcs.len();
        if tried > PIECES {
            return Ok(None);
        }
        let (points, lengths): (Vec<c64>, Vec<f64>) = (arcs.iter())
            .map(|arc| curve.arc(arc))
            .map(|([x, y], length)| (c64::new(x, y), length))
            .unzip();
        let sigmas = resolvent.smallest(&points, ACCURACY)?;
        let mut halves = Vec::new();
        for (arc, (length, sigma)) in arcs.iter().zip(lengths.into_iter().zip(sigmas)) {
            match 0.5 * length <= FINE * sigma {
                true => sum += length / (sigma - 0.5 * length),
                // as many pieces as this one falls into, if σ_min stays what it is
                false if length > 2.0 * FINE * sigma * PIECES as f64 => return Ok(None),
                false => halves.extend(arc.halves()),
            }
        }
        arcs = halves;
    }
    // the lower half is its mirror image
    Ok(Some(2.0 * sum / (2.0 * PI)))
}

/// ‖T‖ from above.
fn norm(t: &Dense<f64>) -> Result<f64, SetupError> {
    let n = t.shape().rows;
    let mut image = vec![0.0; n];
    let mut gram = |x: &[f64], y: &mut [f64]| {
        t.apply(x, &mut image, &mut []);
        y.fill(0.0);
        t.apply_adjoint_add(1.0, &image, y, &mut []);
    };
    let settings = LanczosSettings {
        tolerance: ACCURACY,
        ..LanczosSettings::one_sided()
    };
    let (_, high) = extreme_eigenvalues(n, &mut gram, None, settings)?;
    Ok((high.value + high.error).sqrt())
}

/// Relative residuals of GMRES without restarts; a breakdown ends them.
pub(super) fn residuals(t: &Dense<f64>, r_0: &[f64]) -> Vec<f64> {
    struct History(Vec<f64>);
    impl Observer for History {
        fn observe(&mut self, step: &Step) -> ControlFlow<()> {
            if let Step::Krylov {
                relative_residual, ..
            } = step
            {
                self.0.push(*relative_residual);
            }
            ControlFlow::Continue(())
        }
    }
    let n = r_0.len();
    let system = System {
        operator: t,
        preconditioner: &Identity { n },
        rhs: r_0,
    };
    let criteria = Criteria {
        relative_tolerance: ROUNDING,
        max_iterations: n,
    };
    let (mut x, mut history) = (vec![0.0; n], History(Vec::new()));
    // what it found until then is what is asked for
    let _ = Gmres::restarted(n.max(1)).solve(&system, &criteria, &mut x, &mut history);
    history.0
}
