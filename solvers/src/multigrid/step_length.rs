//! How far a step of a K-cycle goes.

use fracas_operators::Real;

/// Longest step of a K-cycle. λ(M⁻¹A) ≤ 1 of a cycle, so that a step beyond 2 would enlarge what the cycle has solved, for the sake
/// of what it hardly sees; and it would do so in one direction now, in another the next time, which no outer iteration can make up for.
/// `layered_crossing` with contrast 4·10³ and ν = 0.49 in the stiff rock, 24³ cells, geometric: 30 iterations, without a bound 215; V 44,
/// W 35. Unit: 1.
const LONGEST: f64 = 2.0;

/// Step to the minimum of `½ curvature t² − slope t`, at most 2; `None` where there is none.
pub(super) fn step<R: Real>(slope: R, curvature: R) -> Option<R> {
    let step = slope / curvature;
    let longest = R::of(LONGEST);
    (curvature > R::zero() && step.is_finite()).then(|| if step > longest { longest } else { step })
}
