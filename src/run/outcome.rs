//! How a step went, and how a run ended.

use crate::nonlinear::{Event, LinearRecord, StepRecord};
use serde::Serialize;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a run stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Not at its end; its process was killed if nothing writes here any more.
    Running,
    /// At the end of its time.
    Finished,
    /// At the end of the steps that were asked for.
    Stopped,
    /// A step did not converge.
    NotConverged,
    /// It was asked to stop; a restart goes on.
    Interrupted,
    /// Slip ran away.
    Unstable,
}

/// What a run did next.
#[derive(Clone, Debug)]
pub enum Taken {
    /// A step, which is on the disk.
    Step(Box<Done>),
    /// None.
    Ended(Ended),
}

/// A step that is done.
#[derive(Clone, Debug)]
pub struct Done {
    /// Its line of `history.csv`.
    pub record: StepRecord,
    /// Its linear solves, failed attempts included.
    pub linear: Vec<LinearRecord>,
    /// What happened on the way.
    pub events: Vec<Event>,
}

/// How a run ended.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Ended {
    /// How.
    pub outcome: Outcome,
    /// The step that was not done.
    pub step: usize,
    /// Why a step did not converge, or how to go on.
    pub reason: Option<String>,
    /// What happened in the step that failed.
    pub events: Vec<Event>,
    /// What is better told about the steps that were done.
    pub remarks: Vec<String>,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.outcome, &self.reason) {
            (Outcome::Finished | Outcome::Running, _) => f.write_str("Finished."),
            (Outcome::Stopped, _) => write!(f, "Stopped before step {} as asked.", self.step),
            (_, reason) => write!(f, "Stopped: {}.", reason.as_deref().unwrap_or_default()),
        }
    }
}

impl Outcome {
    /// In `log.jsonl`.
    pub(super) fn event(self) -> &'static str {
        match self {
            Self::Finished | Self::Running => "finished",
            Self::Stopped => "stopped",
            Self::NotConverged => "not_converged",
            Self::Interrupted => "interrupted",
            Self::Unstable => "unstable",
        }
    }
}

/// The wish of a caller to stop, which is met at the next safe point; nothing of the step at hand is kept.
pub trait Stop {
    /// What befell the run, once it has: `interrupted`.
    fn asked(&self) -> Option<&'static str>;
}

impl Stop for AtomicBool {
    fn asked(&self) -> Option<&'static str> {
        self.load(Ordering::Relaxed).then_some("interrupted")
    }
}
