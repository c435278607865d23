//! `x^(−½)` as a sum of few poles.

/// Distance of poles in ln √σ: `x^(−½)` is met to 2 exp(−π²/STEP), 3 %, between them. Unit: 1.
const STEP: f64 = 2.3;

/// How far poles reach beyond the ends of the interval, in ln √σ. Unit: 1.
const BEYOND: f64 = 0.7;

/// Points at which the weights of the poles are fitted. Unit: 1.
const POINTS: usize = 60;

/// Sweeps of the fit, each of which keeps weights positive. Unit: 1.
const SWEEPS: usize = 400;

/// `x^(−½) ≈ Σ c_i/(x + σ_i)`, `(σ_i, c_i)` all positive, on an interval: three to six of them.
///
/// # Source
/// Poles by the trapezoidal rule of `x^(−½) = (2/π) ∫ eˢ/(x + e²ˢ) ds` (N. Hale, N. J. Higham, L. N. Trefethen, SIAM J. Numer. Anal. 46
/// (2008) 2505–2523); weights fitted.
pub(super) fn poles((low, high): (f64, f64)) -> Vec<(f64, f64)> {
    let (first, last) = (0.5 * low.ln() - BEYOND, 0.5 * high.ln() + BEYOND);
    let n = ((last - first) / STEP).ceil().max(1.0) as usize + 1;
    let step = (last - first) / (n - 1) as f64;
    let node = |i: usize| first + step * i as f64;
    let sigma: Vec<f64> = (0..n).map(|i| (2.0 * node(i)).exp()).collect();
    let weight = |i: usize| 2.0 / std::f64::consts::PI * step * node(i).exp();
    let mut c: Vec<f64> = (0..n).map(weight).collect();
    let x = (0..POINTS).map(|k| low * (high / low).powf(k as f64 / (POINTS - 1) as f64));
    // g_ki = √x_k/(x_k + σ_i), to be one with c; c ← c (gᵀ1)/(gᵀg c)
    let g: Vec<Vec<f64>> = x
        .map(|x| sigma.iter().map(|s| x.sqrt() / (x + s)).collect())
        .collect();
    for _ in 0..SWEEPS {
        let met: Vec<f64> = (g.iter())
            .map(|g| g.iter().zip(&c).map(|(g, c)| g * c).sum())
            .collect();
        for (i, c) in c.iter_mut().enumerate() {
            let wanted: f64 = g.iter().map(|g| g[i]).sum();
            let found: f64 = g.iter().zip(&met).map(|(g, met)| g[i] * met).sum();
            *c *= wanted / found;
        }
    }
    sigma.into_iter().zip(c).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_meet_the_inverse_root_within_a_tenth_and_are_few() {
        for low in [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6] {
            let poles = poles((low, 8.0));
            assert!(poles.len() <= 6, "{} poles", poles.len());
            assert!(poles.iter().all(|(sigma, c)| *sigma > 0.0 && *c > 0.0));
            for k in 0..=200 {
                let x = low * (8.0 / low).powf(f64::from(k) / 200.0);
                let value: f64 = poles.iter().map(|(sigma, c)| c / (x + sigma)).sum();
                let met = x.sqrt() * value;
                assert!((met - 1.0).abs() < 0.1, "{met} at {x:e} of {low:e}");
            }
        }
    }
}
