//! The wish to stop: the first SIGINT (Ctrl-C) or SIGTERM is met at the next safe point, the second one at once.

use fracas::run::Stop;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A signal that stops a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signal(u8);

impl Signal {
    /// Exit status of what it stopped, as a shell shows it: 128 and its number.
    pub(super) fn status(self) -> u8 {
        128 + self.0
    }
}

/// The first of the signals that [`listen`] waits for.
pub(super) struct Signals;

impl Stop for Signals {
    fn asked(&self) -> Option<&'static str> {
        asked().map(|signal| match i32::from(signal.0) {
            SIGINT => "interrupted",
            _ => "terminated",
        })
    }
}

/// True from the first signal on.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Its number; 0 before.
static WHICH: AtomicUsize = AtomicUsize::new(0);

/// From now on the first signal is only noted, and the second has its default action.
///
/// To be called when the input has been read: until then there is no state to write, and a signal that is only noted would not end
/// a process that waits for a pipe.
pub(super) fn listen() {
    warn(register());
}

/// Says that signals are not handled.
pub(super) fn warn(handled: io::Result<()>) {
    if let Err(error) = handled {
        let _ = writeln!(
            io::stderr(),
            "warning: signals keep their default ({error})"
        );
    }
}

fn register() -> io::Result<()> {
    for signal in [SIGINT, SIGTERM] {
        // in this order: a signal looks whether there was one before, then leaves its mark
        flag::register_conditional_default(signal, &ASKED)?;
        flag::register_usize(signal, &WHICH, signal as usize)?;
        flag::register(signal, &ASKED)?;
    }
    Ok(())
}

/// The signal that asked us to stop, if one did.
pub(super) fn asked() -> Option<Signal> {
    if !ASKED.load(Ordering::Relaxed) {
        return None;
    }
    u8::try_from(WHICH.load(Ordering::Relaxed)).ok().map(Signal)
}
