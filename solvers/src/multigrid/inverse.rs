//! The ready preconditioner: f64 and free unknowns outside.

use super::cycle::Hierarchy;
use crate::amg::scratch::{cast, doubles};
use crate::amg::{LevelSummary, Summary};
use fracas_operators::vector::{for_row_ranges, norm2};
use fracas_operators::{Preconditioner, Properties, Real};

/// Entries that one task copies.
const GRAIN: usize = 16_384;

/// A hierarchy in one of the two precisions.
pub enum SomeHierarchy {
    /// 32 bits.
    Single(Hierarchy<f32>),
    /// 64 bits.
    Double(Hierarchy<f64>),
}

/// One multigrid cycle per solve: `z ← f M⁻¹ r`.
pub struct MultigridInverse {
    hierarchy: SomeHierarchy,
    /// What the operator was divided by, and f.
    factor: f64,
    below: Vec<LevelSummary>,
    spaces: &'static str,
}

impl MultigridInverse {
    /// The cycle of `hierarchy`, whose operator is the given one divided by `scale`, times `over_correction`. Unknowns
    /// are those of the finest level without its fixed ones. `below` describes what is under the coarsest level,
    /// `spaces` what the coarse spaces reproduce.
    pub fn new(
        hierarchy: SomeHierarchy,
        scale: f64,
        over_correction: f64,
        below: Vec<LevelSummary>,
        spaces: &'static str,
    ) -> Self {
        Self {
            hierarchy,
            factor: over_correction / scale,
            below,
            spaces,
        }
    }

    /// The hierarchy.
    pub fn hierarchy(&self) -> &SomeHierarchy {
        &self.hierarchy
    }

    /// Levels, complexities, bytes.
    pub fn summary(&self) -> Summary {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => h.summary(&self.below, self.spaces),
            SomeHierarchy::Double(h) => h.summary(&self.below, self.spaces),
        }
    }

    fn solve_with<R: Real>(&self, h: &Hierarchy<R>, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let length = norm2(r);
        if length == 0.0 || !length.is_finite() {
            return z.copy_from_slice(r);
        }
        // a power of two brings r into the range of R and changes no digit
        let size = length.log2().round().exp2();
        let finest = &h.levels()[0];
        let (b, work) = cast::<R>(work).split_at_mut(finest.size());
        let (x, work) = work.split_at_mut(finest.size());
        spread(r, 1.0 / size, &finest.fixed, b);
        h.solve(b, x, work);
        gather(x, self.factor * size, &finest.fixed, z);
    }
}

/// `full ← factor · free`, zero where fixed.
fn spread<R: Real>(free: &[f64], factor: f64, fixed: &[u32], full: &mut [R]) {
    assert_eq!(free.len() + fixed.len(), full.len());
    for_row_ranges(0, GRAIN, full, &|start, part| {
        let passed = fixed.partition_point(|f| (*f as usize) < start);
        let (mut at, mut from) = (0, start - passed);
        for f in &fixed[passed..] {
            let Some(stop) = (*f as usize).checked_sub(start).filter(|s| *s < part.len()) else {
                break;
            };
            copy(&free[from..], factor, &mut part[at..stop]);
            from += stop - at;
            part[stop] = R::zero();
            at = stop + 1;
        }
        copy(&free[from..], factor, &mut part[at..]);
    });
}

fn copy<R: Real>(from: &[f64], factor: f64, to: &mut [R]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = R::of(factor * from);
    }
}

/// `free ← factor · full` without the fixed entries.
fn gather<R: Real>(full: &[R], factor: f64, fixed: &[u32], free: &mut [f64]) {
    assert_eq!(free.len() + fixed.len(), full.len());
    for_row_ranges(0, GRAIN, free, &|start, part| {
        // fixed[i] − i free entries stand before the i-th fixed one
        let free_before = |i: usize| fixed[i] as usize - i;
        let (mut low, mut high) = (0, fixed.len());
        while low < high {
            let middle = (low + high) / 2;
            if free_before(middle) <= start {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        let (mut passed, mut at) = (low, 0);
        while at < part.len() {
            let next = if passed < fixed.len() {
                free_before(passed) - start
            } else {
                part.len()
            };
            let stop = next.min(part.len());
            let from = &full[start + at + passed..];
            for (to, from) in part[at..stop].iter_mut().zip(from) {
                *to = factor * from.to_f64_exact();
            }
            at = stop;
            passed += 1;
        }
    });
}

impl Preconditioner<f64> for MultigridInverse {
    fn size(&self) -> usize {
        let free = |size: usize, fixed: &[u32]| size - fixed.len();
        match &self.hierarchy {
            SomeHierarchy::Single(h) => free(h.levels()[0].size(), &h.levels()[0].fixed),
            SomeHierarchy::Double(h) => free(h.levels()[0].size(), &h.levels()[0].fixed),
        }
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        assert!(r.len() == self.size() && z.len() == self.size());
        match &self.hierarchy {
            SomeHierarchy::Single(h) => self.solve_with(h, r, z, work),
            SomeHierarchy::Double(h) => self.solve_with(h, r, z, work),
        }
    }

    fn work_len(&self) -> usize {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => doubles::<f32>(2 * h.levels()[0].size() + h.work_len()),
            SomeHierarchy::Double(h) => 2 * h.levels()[0].size() + h.work_len(),
        }
    }

    fn flops(&self) -> u64 {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => h.flops(0),
            SomeHierarchy::Double(h) => h.flops(0),
        }
    }

    fn properties(&self) -> Properties {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => h.properties().and(Properties::SINGLE),
            SomeHierarchy::Double(h) => h.properties(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_entries_go_to_their_places_and_back() {
        let n = 2 * GRAIN + 77;
        for fixed in [
            vec![],
            vec![0, 1, 2, n as u32 - 1],
            (0..n as u32).filter(|i| i % 7 == 3).collect::<Vec<_>>(),
            (GRAIN as u32 - 3..GRAIN as u32 + 2).collect(),
        ] {
            let m = n - fixed.len();
            let free: Vec<f64> = (0..m).map(|i| i as f64 + 1.0).collect();
            let mut full = vec![f64::NAN; n];
            spread(&free, 2.0, &fixed, &mut full);
            let mut next = free.iter();
            for (i, v) in full.iter().enumerate() {
                let expected = if fixed.binary_search(&(i as u32)).is_ok() {
                    0.0
                } else {
                    2.0 * next.next().unwrap()
                };
                assert_eq!(*v, expected);
            }
            let mut back = vec![f64::NAN; m];
            gather(&full, 0.5, &fixed, &mut back);
            assert_eq!(back, free);
        }
    }
}
