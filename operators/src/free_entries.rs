//! Entries of a vector that are not fixed: to their places in full numbering and back, in parallel.

use crate::Real;
use crate::vector::for_row_ranges;

/// Entries of a task.
const GRAIN: usize = 16_384;

/// `full ← factor · free`, zero at the `fixed` places, which ascend.
///
/// # Cost
/// One pass over both; nothing is allocated, and the result does not depend on the number of threads.
pub fn spread<S: Real, R: Real>(free: &[S], factor: f64, fixed: &[u32], full: &mut [R]) {
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

fn copy<S: Real, R: Real>(from: &[S], factor: f64, to: &mut [R]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = R::of(factor * from.to_f64_exact());
    }
}

/// `update(full, free)` for every entry that is not at one of the `fixed` places, which ascend.
///
/// # Cost
/// As [`spread`].
pub fn gather<S: Real, R: Real>(
    full: &[R],
    fixed: &[u32],
    free: &mut [S],
    update: &(impl Fn(R, &mut S) + Sync),
) {
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
                update(*from, to);
            }
            at = stop;
            passed += 1;
        }
    });
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
                let expected = match fixed.binary_search(&(i as u32)) {
                    Ok(_) => Some(0.0),
                    Err(_) => next.next().map(|v| 2.0 * v),
                };
                assert_eq!(Some(*v), expected);
            }
            let mut back = vec![f64::NAN; m];
            gather(&full, &fixed, &mut back, &|full, free| *free = 0.5 * full);
            assert_eq!(back, free);
        }
    }
}
