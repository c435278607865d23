//! One observer for the active set, Newton and Krylov: progress, history, stop.

use std::fmt::Display;
use std::ops::ControlFlow;

/// What an iteration reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// One Krylov iteration with its relative residual (the recurrence's estimate).
    Krylov {
        /// Iteration, from 0 (the initial residual).
        iteration: usize,
        /// ‖r_k‖ / ‖b‖ as the method estimates it.
        relative_residual: f64,
    },
    /// One Newton step, before its linear system is solved.
    Newton {
        /// Steps taken with the present states.
        iteration: usize,
        /// Residual of the non-linear equations relative to loads and internal forces.
        residual: f64,
    },
    /// One round of the active set, after its Newton iteration.
    Round {
        /// Rounds finished.
        round: usize,
        /// Faces that take another state.
        changed: usize,
    },
    /// One step of a long set-up or sweep.
    Progress {
        /// What is being done.
        stage: &'static str,
        /// Parts done.
        done: usize,
        /// Parts in all.
        total: usize,
    },
}

/// Watches iterations; may stop them.
pub trait Observer {
    /// Called once per step; `Break` stops the iteration with [`Outcome::Stopped`](crate::krylov::Outcome).
    fn observe(&mut self, step: &Step) -> ControlFlow<()>;

    /// A line where another piece of work begins, or where something is found that the result tells as data.
    fn say(&mut self, _line: &dyn Display) {}
}

/// Watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn observe(&mut self, _step: &Step) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&Step) -> ControlFlow<()>> Observer for F {
    fn observe(&mut self, step: &Step) -> ControlFlow<()> {
        self(step)
    }
}
