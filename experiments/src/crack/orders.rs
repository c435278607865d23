//! Observed orders of convergence.

/// `ln(e_k/e_{k+1}) / ln(h_k/h_{k+1})` of neighbouring meshes.
pub fn between(sizes: &[f64], errors: &[f64]) -> Vec<f64> {
    let order = |(h, e): (&[f64], &[f64])| (e[0] / e[1]).ln() / (h[0] / h[1]).ln();
    sizes.windows(2).zip(errors.windows(2)).map(order).collect()
}

/// Slope of the least-squares line of ln e over ln h.
pub fn fitted(sizes: &[f64], errors: &[f64]) -> f64 {
    let logs = |v: &[f64]| v.iter().map(|x| x.ln()).collect::<Vec<_>>();
    let (x, y) = (logs(sizes), logs(errors));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (mx, my) = (mean(&x), mean(&y));
    let over: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let under: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    over / under
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_has_its_exponent() {
        let sizes = [0.4, 0.3, 0.1, 0.02];
        let errors = sizes.map(|h: f64| 7.0 * h.powf(1.7));
        assert!((fitted(&sizes, &errors) - 1.7).abs() < 1e-12);
        for order in between(&sizes, &errors) {
            assert!((order - 1.7).abs() < 1e-12);
        }
    }
}
