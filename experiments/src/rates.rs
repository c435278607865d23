//! What the systems of a run tell of the rate of their iteration.

/// Residual above which a system tells nothing of its rate, relative. Unit: 1.
const TOLD: f64 = 1e-4;

/// Iterations per factor of 1e-8 of the residual, of an iteration that made it `relative_residual` times as large; none where it did not go
/// far enough to tell, or nothing iterated.
pub(crate) fn to_eight_digits(
    krylov: &str,
    iterations: usize,
    relative_residual: f64,
) -> Option<usize> {
    let tells = relative_residual < TOLD && krylov != "direct";
    tells.then(|| {
        let digits = -relative_residual.max(f64::EPSILON).log10();
        (8.0 * iterations as f64 / digits).ceil() as usize
    })
}

/// The least of `all` that more than `share` of them do not exceed, or the largest; 0 of none.
pub(crate) fn quantile(mut all: Vec<usize>, share: f64) -> usize {
    all.sort_unstable();
    let below = (share * all.len() as f64) as usize;
    all.get(below).or(all.last()).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_that_stays_tells_nothing() {
        assert_eq!(to_eight_digits("fgmres", 10, 1e-8), Some(10));
        assert_eq!(to_eight_digits("fgmres", 10, 1e-5), Some(16));
        assert_eq!(to_eight_digits("fgmres", 10, 1e-3), None);
        assert_eq!(to_eight_digits("direct", 1, 1e-12), None);
        // rounding counts as all digits that there are
        assert_eq!(to_eight_digits("gmres", 4, 0.0), Some(3));
    }

    #[test]
    fn quantiles_are_values_of_the_list() {
        let all: Vec<usize> = (1..=20).rev().collect();
        assert_eq!(quantile(all.clone(), 0.95), 20);
        assert_eq!(quantile(all.clone(), 0.5), 11);
        assert_eq!(quantile(all.clone(), 0.94), 19);
        assert_eq!(quantile(all, 1.0), 20);
        assert_eq!(quantile(vec![7], 0.5), 7);
        assert_eq!(quantile(Vec::new(), 0.5), 0);
    }
}
