//! Tasks that add to overlapping parts of one vector: those of one colour touch no common node and run in parallel.

use fracas_operators::simd;
use fracas_operators::vector::for_each_task;
use std::marker::PhantomData;

/// Tasks grouped by colour. Colours run one after the other in a fixed order, so every entry of the result receives its
/// additions in the same order for any number of threads.
#[derive(Clone, Debug)]
pub(crate) struct Colours<T> {
    tasks: Vec<Vec<T>>,
}

impl<T: Sync> Colours<T> {
    /// # Safety
    /// Tasks of one group must never touch a common entry of the vector that [`run`](Self::run) hands them.
    pub(crate) unsafe fn new(tasks: Vec<Vec<T>>) -> Self {
        Self { tasks }
    }

    /// All tasks.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.tasks.iter().flatten()
    }

    /// Runs every task with shared access to `y`.
    pub(crate) fn run<R: Send>(&self, y: &mut [R], task: &(impl Fn(&T, &Shared<'_, R>) + Sync)) {
        let shared = Shared {
            start: y.as_mut_ptr(),
            len: y.len(),
            lifetime: PhantomData,
        };
        for group in &self.tasks {
            for_each_task(0..group.len(), &|i| task(&group[i], &shared));
        }
    }
}

/// A vector to which the tasks of one colour add, each to its own entries.
pub(crate) struct Shared<'a, R> {
    start: *mut R,
    len: usize,
    lifetime: PhantomData<&'a mut [R]>,
}

// SAFETY: threads use disjoint entries, by the contract of `Colours::new`.
unsafe impl<R: Send> Sync for Shared<'_, R> {}

impl<R> Shared<'_, R> {
    /// Asks for the cache line of an entry, which may lie behind the end; changes nothing but time.
    #[inline(always)]
    pub(crate) fn prefetch(&self, index: usize) {
        // SAFETY: an empty slice at the start of a live vector.
        simd::prefetch(unsafe { std::slice::from_raw_parts(self.start, 0) }, index);
    }

    /// `len` entries from `first`, writable.
    ///
    /// # Safety
    /// The entries belong to the task that calls, and it holds no other reference to them.
    #[inline(always)]
    #[expect(clippy::mut_from_ref, reason = "disjoint by colouring")]
    pub(crate) unsafe fn part(&self, first: usize, len: usize) -> &mut [R] {
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
    pub(crate) unsafe fn part_unchecked(&self, first: usize, len: usize) -> &mut [R] {
        debug_assert!(first <= self.len && len <= self.len - first);
        // SAFETY: within the vector and exclusive (by contract).
        unsafe { std::slice::from_raw_parts_mut(self.start.add(first), len) }
    }
}
