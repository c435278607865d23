//! Fused multiply-adds in registers: what a processor does when nothing waits for memory.

use fracas_operators::Real;
use fracas_operators::simd::{Kernel, Lanes, Level};
use fracas_operators::vector::for_each_task;
use std::hint::black_box;

/// Runs so many tasks of [`operations`] each in the current pool.
pub fn run<R: Real>(tasks: usize) {
    for_each_task(0..tasks, &|_| Level::best().run::<R>(Fused));
}

/// Operations of one task, two per multiply-add.
pub fn operations<R: Real>() -> f64 {
    (Fused::ROUNDS * Fused::CHAINS * 2 * Level::best().width::<R>()) as f64
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
