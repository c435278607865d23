//! Memory that the system refuses: the number asked for and exit status 2, instead of an abort.
//!
//! What can be refused in a typed error is refused there. Everything else that asks for more than there is ends in an abort
//! of the standard library, which prints the number; here the abort becomes the status of an input that does not fit.
#![allow(unsafe_code, reason = "an allocator")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The allocator of the system, with a note per thread of what it refused last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Noted;

thread_local! {
    /// Bytes that this thread was last refused; 0 for none.
    static REFUSED: Cell<usize> = const { Cell::new(0) };
}

/// The note outlives later success: a backtrace on the way to the abort allocates, too.
fn noted(pointer: *mut u8, size: usize) -> *mut u8 {
    if pointer.is_null() {
        // a thread at its end has no note left to write
        let _ = REFUSED.try_with(|note| note.set(size));
    }
    pointer
}

// Safety: all of it is the allocator of the system.
unsafe impl GlobalAlloc for Noted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        noted(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        noted(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as the caller promises.
        noted(unsafe { System.realloc(pointer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// What is said after the standard library has printed the number of bytes. It begins a line of its own: another thread that is refused,
/// too, may have printed half of one.
const SENTENCE: &[u8] = b"\nerror: out of memory: the system does not give these bytes; use fewer cells, a smaller system or fewer threads, or free memory\n";

/// True where this thread was refused memory.
#[cfg(unix)]
fn was_refused() -> bool {
    REFUSED.try_with(Cell::get).is_ok_and(|bytes| bytes > 0)
}

/// Makes an abort for want of memory an exit with `status`, and so a panic of a library that unwraps a refusal; every other abort or
/// panic stays one.
///
/// # Errors
/// Where signals cannot be handled.
#[cfg(unix)]
pub fn exit_on_refusal(status: i32) -> std::io::Result<()> {
    use std::io::Write;
    use std::mem::ManuallyDrop;
    use std::os::fd::FromRawFd;
    let refused = move || {
        // Safety: standard error, written to without buffer or lock, and not closed
        let mut stderr = ManuallyDrop::new(unsafe { std::fs::File::from_raw_fd(2) });
        let _ = stderr.write_all(SENTENCE);
        signal_hook::low_level::exit(status);
    };
    let other = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // dense matrices of faer are made by Result<_, AllocError>::unwrap
        let is_refusal = panic
            .payload()
            .downcast_ref::<String>()
            .is_some_and(|s| s.contains("AllocError"));
        match was_refused() && is_refusal {
            true => refused(),
            false => other(panic),
        }
    }));
    let aborted = move || {
        if was_refused() {
            refused();
        }
    };
    // Safety: the action reads a constant-initialized note of its own thread, writes to a descriptor and exits
    unsafe { signal_hook::low_level::register(signal_hook::consts::SIGABRT, aborted) }?;
    Ok(())
}

/// Where there is no such signal the abort stays.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn exit_on_refusal(_: i32) -> std::io::Result<()> {
    Ok(())
}

/// Lets all threads allocate from one arena where the address space has a limit.
///
/// glibc reserves 64 MiB of addresses for every thread that allocates while another one does: what a limit leaves would depend on
/// which threads meet, and a larger limit could leave less.
pub fn share_arena_below_limit() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if fracas::memory::limits_addresses() {
        // Safety: a setting of the allocator, before any thread starts
        unsafe { libc::mallopt(libc::M_ARENA_MAX, 1) };
    }
}
