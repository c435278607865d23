//! What a product, an M⁻¹ and a message take.

use super::super::Times;
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::distributed::Ranks;
use std::time::Instant;

/// Repetitions, the quickest of which counts.
const ROUNDS: usize = 5;

/// Messages and answers of one mean.
const MESSAGES: usize = 200;

/// Numbers of a long message: 1 MiB.
const LONG: usize = 1 << 17;

/// The quickest of some rounds, each as long as its slowest rank [s].
fn quickest(ranks: Ranks, mut work: impl FnMut()) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        // all begin together
        ranks.sum(&mut [0.0]);
        let start = Instant::now();
        work();
        least = least.min(ranks.max(start.elapsed().as_secs_f64()));
    }
    least
}

impl Times {
    /// Of these, by all ranks together.
    pub(super) fn of(
        ranks: Ranks,
        operator: &dyn LinearOperator<f64>,
        inverse: &dyn Preconditioner<f64>,
    ) -> Self {
        let n = inverse.size();
        let (x, mut y) = (vec![1.0; n], vec![0.0; n]);
        let mut work = vec![0.0; operator.work_len().max(inverse.work_len())];
        let product_s = quickest(ranks, || operator.apply(&x, &mut y, &mut work));
        let application_s = quickest(ranks, || inverse.solve(&x, &mut y, &mut work));
        let sum_s = quickest(ranks, || (0..MESSAGES).for_each(|_| ranks.sum(&mut [0.0])));
        let ping = |numbers, times| ranks.max(ranks.ping(numbers, times));
        let short = ping(1, MESSAGES);
        let long = ping(LONG, MESSAGES / 10);
        Self {
            product_s,
            application_s,
            sum_s: sum_s / MESSAGES as f64,
            message_s: short,
            per_byte_s: (long - short).max(0.0) / (8 * LONG) as f64,
        }
    }
}
