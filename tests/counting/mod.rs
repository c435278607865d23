//! An allocator that counts the allocations of every thread and the bytes in use, for tests that claim there are none, or few. It belongs to the whole process: a
//! file that uses it has one test.
#![allow(unsafe_code, reason = "an allocator that counts")]

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Barrier;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// The system's allocator, with every allocation of every thread counted.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);
static BYTES: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// Bytes that come into use.
fn taken(bytes: usize) {
    ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
    let now = BYTES.fetch_add(bytes, Ordering::SeqCst) + bytes;
    PEAK.fetch_max(now, Ordering::SeqCst);
}

// SAFETY: forwards to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        BYTES.fetch_sub(layout.size(), Ordering::SeqCst);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // in its place, as large areas of the system are
        BYTES.fetch_sub(layout.size(), Ordering::SeqCst);
        taken(size);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Allocations of all threads during `work`.
#[allow(dead_code, reason = "some files count allocations alone, some bytes")]
pub(crate) fn allocations(work: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.load(Ordering::SeqCst);
    work();
    ALLOCATIONS.load(Ordering::SeqCst) - before
}

/// The most bytes that all threads have in use during `work`, beyond those before.
#[allow(dead_code, reason = "some files count allocations alone, some bytes")]
pub(crate) fn peak_bytes<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = BYTES.load(Ordering::SeqCst);
    PEAK.store(before, Ordering::SeqCst);
    let done = work();
    (done, PEAK.load(Ordering::SeqCst) - before)
}

/// Threads that have all taken a job from another once, so that their queues exist. They live as long as the test: a thread that ends
/// allocates, too.
#[allow(dead_code, reason = "some files count allocations alone, some bytes")]
pub(crate) fn threads(number: usize) -> ThreadPool {
    let builder = ThreadPoolBuilder::new().num_threads(number);
    let pool = builder.build().expect("threads");
    let meeting = Barrier::new(number);
    for _ in 0..100 {
        pool.scope(|scope| {
            for _ in 0..number {
                scope.spawn(|_| {
                    meeting.wait();
                });
            }
        });
    }
    pool
}
