//! A vector that tasks of one colour update together, each its own entries.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use crate::simd;
use crate::vector::for_each_task;
use std::marker::PhantomData;

/// Tasks grouped by colour. Colours run one after the other in a fixed order, so every entry of the result receives its
/// additions in the same order for any number of threads.
#[derive(Clone, Debug)]
pub struct Colours<T> {
    tasks: Vec<Vec<T>>,
}

impl<T: Sync> Colours<T> {
    /// # Safety
    /// Tasks of one group must never touch a common entry of the vector that [`run`](Self::run) hands them.
    pub unsafe fn new(tasks: Vec<Vec<T>>) -> Self {
        Self { tasks }
    }

    /// All tasks.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.tasks.iter().flatten()
    }

    /// Runs every task with shared access to `y`.
    pub fn run<R: Send>(&self, y: &mut [R], task: &(impl Fn(&T, &Shared<'_, R>) + Sync)) {
        let shared = Shared::new(y);
        for group in &self.tasks {
            for_each_task(0..group.len(), &|i| task(&group[i], &shared));
        }
    }
}

/// Access to a vector whose concurrent users never touch the same entries.
pub struct Shared<'a, R> {
    start: *mut R,
    len: usize,
    lifetime: PhantomData<&'a mut [R]>,
}

// SAFETY: users touch disjoint entries at any one time, by the contracts of `Colours::new`, `part`, `triple` and `set`.
unsafe impl<R: Send> Sync for Shared<'_, R> {}

impl<'a, R> Shared<'a, R> {
    /// All of `x`.
    pub fn new(x: &'a mut [R]) -> Self {
        Self {
            start: x.as_mut_ptr(),
            len: x.len(),
            lifetime: PhantomData,
        }
    }

    /// Asks for the cache line of an entry, which may lie behind the end; changes nothing but time.
    #[inline(always)]
    pub fn prefetch(&self, index: usize) {
        // SAFETY: an empty slice at the start of a live vector.
        simd::prefetch(unsafe { std::slice::from_raw_parts(self.start, 0) }, index);
    }

    /// `len` entries from `first`, writable.
    ///
    /// # Safety
    /// The entries belong to the task that calls, and it holds no other reference to them.
    #[inline(always)]
    #[expect(clippy::mut_from_ref, reason = "disjoint by colouring")]
    pub unsafe fn part(&self, first: usize, len: usize) -> &mut [R] {
        assert!(first <= self.len && len <= self.len - first);
        // SAFETY: within the vector (asserted) and exclusive (by contract).
        unsafe { std::slice::from_raw_parts_mut(self.start.add(first), len) }
    }

    /// The same, for entries known to exist.
    ///
    /// # Safety
    /// As [`part`](Self::part), and `first + len` is at most the length of the vector.
    #[inline(always)]
    #[expect(clippy::mut_from_ref, reason = "disjoint by colouring")]
    pub unsafe fn part_unchecked(&self, first: usize, len: usize) -> &mut [R] {
        debug_assert!(first <= self.len && len <= self.len - first);
        // SAFETY: within the vector and exclusive (by contract).
        unsafe { std::slice::from_raw_parts_mut(self.start.add(first), len) }
    }

    /// The three entries of a block row.
    ///
    /// # Safety
    /// The row exists, and nobody writes it while the reference lives.
    #[inline(always)]
    pub unsafe fn triple(&self, row: usize) -> &[R] {
        debug_assert!(3 * row + 3 <= self.len);
        // SAFETY: within the vector; by contract not written meanwhile.
        unsafe { std::slice::from_raw_parts(self.start.add(3 * row), 3) }
    }

    /// Writes the three entries of a block row.
    ///
    /// # Safety
    /// The row exists, and nobody else reads or writes it meanwhile.
    #[inline(always)]
    pub unsafe fn set(&self, row: usize, value: [R; 3])
    where
        R: Copy,
    {
        debug_assert!(3 * row + 3 <= self.len);
        // SAFETY: within the vector; by contract exclusive.
        unsafe {
            self.start
                .add(3 * row)
                .cast::<[R; 3]>()
                .write_unaligned(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbours of one colour are two apart, so that tasks that add to themselves and the next never meet; any order of the
    /// tasks of a colour, and any number of threads, gives the same bits.
    #[test]
    fn tasks_of_a_colour_may_run_in_any_order() {
        let n = 1000;
        let add = |order: &dyn Fn(Vec<usize>) -> Vec<usize>| {
            let every = |from: usize| order((from..n - 1).step_by(2).collect());
            // SAFETY: tasks k and k + 2 touch no common entry.
            let colours = unsafe { Colours::new(vec![every(0), every(1)]) };
            assert_eq!(colours.iter().count(), n - 1);
            let mut y: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            colours.run(&mut y, &|k, y| {
                // SAFETY: entries of this task.
                let part = unsafe { y.part(*k, 2) };
                let sum = 0.3 * part[0] + 0.7 * part[1];
                part.iter_mut().for_each(|v| *v += sum);
            });
            y
        };
        let first = add(&|tasks| tasks);
        let reversed = add(&|tasks| tasks.into_iter().rev().collect());
        let mixed = add(&|mut tasks| {
            tasks.sort_by_key(|k| k.wrapping_mul(2_654_435_761) % 1009);
            tasks
        });
        assert_eq!(first, reversed);
        assert_eq!(first, mixed);
    }

    #[test]
    #[should_panic(expected = "assertion failed")]
    fn a_part_beyond_the_end_is_refused() {
        let mut x = [0.0; 4];
        let shared = Shared::new(&mut x);
        // SAFETY: nobody else has them; the bound is what is tried.
        let _ = unsafe { shared.part(2, 3) };
    }
}
