//! What a run tells of its iterations and of its fluid, step by step, in few numbers.

use fracas::nonlinear::digits_of;

/// Residual above which a system tells nothing of its rate, relative: below half of the eight digits the rest would be a guess. Unit: 1.
const TELLING: f64 = 1e-4;

/// Iterations per factor of 1e-8 of the residual, of an iteration that made it `relative_residual` times as large; none where it did not go
/// far enough to tell, or nothing iterated.
pub(crate) fn to_eight_digits(
    krylov: &str,
    iterations: usize,
    relative_residual: f64,
) -> Option<usize> {
    let tells = relative_residual < TELLING && krylov != "direct";
    tells.then(|| (8.0 * iterations as f64 / digits_of(relative_residual)).ceil() as usize)
}

/// Errors of the balance of all steps together over what was injected, from both of every step [m³]; none where nothing was. Unit: 1.
pub(crate) fn lost(steps: impl IntoIterator<Item = [f64; 2]>) -> Option<f64> {
    let add = |[a, b]: [f64; 2], [injected, error]: [f64; 2]| [a + injected, b + error];
    let [injected, error] = steps.into_iter().fold([0.0; 2], add);
    (injected != 0.0).then(|| (error / injected).abs())
}

/// The least of `all` that at least `share` of them do not exceed; none of none.
pub(crate) fn quantile(mut all: Vec<usize>, share: f64) -> Option<usize> {
    all.sort_unstable();
    let rank = (share * all.len() as f64).ceil() as usize;
    all.get(rank.saturating_sub(1)).copied()
}

/// The median of `all`, of two in the middle the larger one; none of none.
pub(crate) fn median(mut all: Vec<usize>) -> Option<usize> {
    all.sort_unstable();
    all.get(all.len() / 2).copied()
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
        assert_eq!(quantile(all.clone(), 0.95), Some(19));
        assert_eq!(quantile(all.clone(), 1.0), Some(20));
        assert_eq!(median(all), Some(11));
        assert_eq!(quantile((1..=18).collect(), 0.95), Some(18));
        assert_eq!(median(vec![7]), Some(7));
        assert_eq!(quantile(Vec::new(), 0.5), None);
        assert_eq!(median(Vec::new()), None);
    }
}
