//! A vector that the chunks of one colour update together, each its own entries.

use std::marker::PhantomData;

/// Shared access to a vector whose concurrent users never touch the same entries.
pub(crate) struct Shared<'a, R> {
    start: *mut R,
    len: usize,
    lifetime: PhantomData<&'a mut [R]>,
}

// SAFETY: users touch disjoint entries at any one time, by the contracts of `triple` and `set`.
unsafe impl<R: Send> Sync for Shared<'_, R> {}

impl<'a, R: Copy> Shared<'a, R> {
    pub(crate) fn new(x: &'a mut [R]) -> Self {
        Self {
            start: x.as_mut_ptr(),
            len: x.len(),
            lifetime: PhantomData,
        }
    }

    /// The three entries of a block row.
    ///
    /// # Safety
    /// Nobody writes them while the reference lives.
    #[inline(always)]
    pub(crate) unsafe fn triple(&self, row: usize) -> &[R] {
        debug_assert!(3 * row + 3 <= self.len);
        // SAFETY: within the vector; by contract not written meanwhile.
        unsafe { std::slice::from_raw_parts(self.start.add(3 * row), 3) }
    }

    /// Writes the three entries of a block row.
    ///
    /// # Safety
    /// Nobody else reads or writes them meanwhile.
    #[inline(always)]
    pub(crate) unsafe fn set(&self, row: usize, value: [R; 3]) {
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
