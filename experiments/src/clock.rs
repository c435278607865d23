//! Time that this thread was on a processor.

use std::time::Instant;

/// Of what is timed in print; the fastest counts.
pub(crate) const REPETITIONS: usize = 3;

/// Since a moment.
pub(crate) struct Clock {
    wall: Instant,
    /// [s], where the system tells.
    processor: Option<f64>,
}

/// Seconds that the calling thread has been on a processor, by the scheduler's count of nanoseconds (Linux).
fn on_processor() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * nanoseconds)
}

impl Clock {
    pub(crate) fn start() -> Self {
        Self {
            wall: Instant::now(),
            processor: on_processor(),
        }
    }

    /// Of this thread since the start; of the wall where the system does not tell.
    pub(crate) fn seconds(&self) -> f64 {
        match (self.processor, on_processor()) {
            (Some(start), Some(now)) => now - start,
            _ => self.wall.elapsed().as_secs_f64(),
        }
    }
}

/// The same work this many times: what it gives, and the least processor time [s]; a failure is not repeated.
pub(crate) fn try_fastest<T, E>(
    repetitions: usize,
    mut work: impl FnMut() -> Result<T, E>,
) -> Result<(T, f64), E> {
    let mut timed = || {
        let clock = Clock::start();
        let done = work()?;
        Ok((done, clock.seconds()))
    };
    let (done, mut least) = timed()?;
    for _ in 1..repetitions {
        least = least.min(timed()?.1);
    }
    Ok((done, least))
}
