//! What is going on, on standard error: a bar on a terminal, a line per stage elsewhere.

use crate::sentence::with_flags;
use fracas_solvers::{Observer, Step};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;

/// Shows the steps of set-ups and iterations.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    /// Stages announced since the last piece of work.
    announced: Vec<&'static str>,
    /// Where in the cycles around Krylov the run is.
    place: String,
}

impl Progress {
    /// A bar if standard error is a terminal.
    pub(super) fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{elapsed:>4} {msg} {wide_bar} {pos}/{len}");
            ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self {
            bar,
            announced: Vec::new(),
            place: String::new(),
        }
    }

    /// Says a line in the course of one piece of work: stages that were announced are not announced again.
    pub(super) fn tell(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| line(text)),
            None => line(text),
        }
    }
}

/// Standard error may be closed; that is no reason to stop.
fn line(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

impl Observer for Progress {
    fn say(&mut self, text: &dyn Display) {
        self.announced.clear();
        self.tell(&with_flags(&text.to_string()));
    }

    fn observe(&mut self, step: &Step) -> ControlFlow<()> {
        match (step, &self.bar) {
            (
                Step::Krylov {
                    iteration,
                    relative_residual,
                },
                Some(bar),
            ) => {
                let place = &self.place;
                bar.set_message(format!(
                    "{place}iteration {iteration}, residual {relative_residual:.2e}"
                ));
                bar.tick();
            }
            (
                Step::Newton {
                    iteration,
                    residual,
                },
                Some(_),
            ) => self.place = format!("Newton {iteration} ({residual:.1e}), "),
            (Step::Round { round, changed }, Some(bar)) => {
                bar.set_message(format!("round {round}: {changed} faces change state"));
                bar.tick();
            }
            (Step::Progress { stage, done, total }, Some(bar)) => {
                bar.set_message(*stage);
                bar.set_length(*total as u64);
                bar.set_position(*done as u64);
            }
            (Step::Progress { stage, .. }, None) if !self.announced.contains(stage) => {
                self.announced.push(stage);
                line(stage);
            }
            _ => {}
        }
        ControlFlow::Continue(())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
