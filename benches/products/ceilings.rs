//! What this machine can do: streaming bandwidth and fused multiply-adds per second.

use fracas_benches::{clock, fused};
use fracas_operators::Real;
use fracas_operators::vector::{axpby, dot};
use std::hint::black_box;

/// Ceilings of the current thread pool.
pub(crate) struct Ceilings {
    /// `y ← α x + β y`: two reads and one write, no line fetched only to be overwritten [B/s].
    pub(crate) stream: f64,
    /// `xᵀy` [B/s].
    pub(crate) read: f64,
    /// Fused multiply-adds, two operations each [1/s].
    pub(crate) flops: f64,
}

/// Entries of a streamed vector: 256 MiB in f64, several times any cache.
const STREAMED: usize = 32 << 20;

/// Best of this many repetitions: a ceiling is what is possible.
const REPETITIONS: usize = 7;

fn best(mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = clock::now();
        run();
        (clock::now() - start).as_secs_f64()
    };
    (0..REPETITIONS).map(time).fold(f64::INFINITY, f64::min)
}

/// Measures all three for scalar `R`.
pub(crate) fn measure<R: Real>() -> Ceilings {
    let bytes = std::mem::size_of::<R>() as f64;
    let x = vec![R::one(); STREAMED];
    let mut y = vec![R::one(); STREAMED];
    let stream = best(|| axpby(R::of(0.5), &x, R::of(0.5), &mut y));
    let read = best(|| {
        black_box(dot(&x, &y));
    });
    let threads = rayon::current_num_threads();
    let fused = best(|| fused::run::<R>(threads));
    Ceilings {
        stream: 3.0 * bytes * STREAMED as f64 / stream,
        read: 2.0 * bytes * STREAMED as f64 / read,
        flops: threads as f64 * fused::operations::<R>() / fused,
    }
}
