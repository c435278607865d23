//! What this machine can do: streaming bandwidth and fused multiply-adds per second.

use crate::clock;
use fracas_operators::Real;
use fracas_operators::simd::{Kernel, Lanes, Level};
use fracas_operators::vector::{axpby, dot, for_each_task};
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
    let fused = best(|| for_each_task(0..threads, &|_| Level::best().run::<R>(Fused)));
    Ceilings {
        stream: 3.0 * bytes * STREAMED as f64 / stream,
        read: 2.0 * bytes * STREAMED as f64 / read,
        flops: threads as f64
            * (Fused::ROUNDS * Fused::CHAINS * 2 * Level::best().width::<R>()) as f64
            / fused,
    }
}

/// Independent chains of multiply-adds, enough to hide their latency.
struct Fused;

impl Fused {
    const CHAINS: usize = 16;
    const ROUNDS: usize = 4_000_000;
}

impl<R: Real> Kernel<R> for Fused {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let (factor, term) = (L::splat(R::of(0.999)), L::splat(R::of(1e-3)));
        let mut chains = [L::splat(R::zero()); Self::CHAINS];
        for (i, chain) in chains.iter_mut().enumerate() {
            *chain = L::splat(black_box(R::of(i as f64)));
        }
        for _ in 0..Self::ROUNDS {
            for chain in &mut chains {
                *chain = chain.mul_add(factor, term);
            }
        }
        let mut out = [R::zero(); 16];
        for chain in chains {
            chain.store(&mut out);
            black_box(&out);
        }
    }
}
