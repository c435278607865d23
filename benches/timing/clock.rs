//! Time that a shared machine does not blur: processor time of one thread, wall time of several.
#![allow(unsafe_code, reason = "asks the system for processor time")]

use std::time::Duration;

#[repr(C)]
struct Timespec {
    seconds: i64,
    nanoseconds: i64,
}

unsafe extern "C" {
    fn clock_gettime(clock: i32, time: *mut Timespec) -> i32;
}

/// Processor time of the calling thread (Linux).
const THREAD_TIME: i32 = 3;
/// Wall time.
const MONOTONIC: i32 = 1;

/// Time since an arbitrary start: of this thread's processor if the current pool has one thread, else of the wall.
pub fn now() -> Duration {
    let clock = if rayon::current_num_threads() == 1 {
        THREAD_TIME
    } else {
        MONOTONIC
    };
    let mut time = Timespec {
        seconds: 0,
        nanoseconds: 0,
    };
    // SAFETY: `time` has the layout of `struct timespec` on 64-bit Linux.
    let status = unsafe { clock_gettime(clock, &mut time) };
    assert_eq!(status, 0, "clock {clock} is not available");
    Duration::new(time.seconds as u64, time.nanoseconds as u32)
}
