//! What is going on, on standard error: a bar on a terminal, a line per stage elsewhere.

use crate::sentence::with_flags;
use fracas_solvers::words::by_number;
use fracas_solvers::{Observer, Step};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Shows the steps of set-ups and iterations.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    /// Stages announced since the last piece of work.
    announced: Vec<&'static str>,
    /// Where in the cycles around Krylov the run is.
    place: String,
    /// Steps of a run that are done and to come, and since when.
    steps: Option<(usize, usize, Instant)>,
}

impl Progress {
    /// A bar if standard error is a terminal.
    pub(super) fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style =
                ProgressStyle::with_template("{elapsed:>4} {prefix}{msg} {wide_bar} {pos}/{len}");
            ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self {
            bar,
            announced: Vec::new(),
            place: String::new(),
            steps: None,
        }
    }

    /// Counts a step of a run, with these to come after it; before the first step it counts none.
    pub(super) fn step(&mut self, left: usize) {
        self.steps = Some(match self.steps {
            None => (0, left, Instant::now()),
            Some((done, _, since)) => (done + 1, left, since),
        });
        self.place.clear();
        if let (Some(bar), Some((done, left, since))) = (&self.bar, self.steps) {
            bar.set_prefix(counted(done, left, since.elapsed()));
            bar.set_length((done + left) as u64);
            bar.set_position(done as u64);
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

/// `step 4 of 41, 2 min left: `, from the mean of the steps so far.
fn counted(done: usize, left: usize, taken: Duration) -> String {
    let total = done + left;
    if left == 0 {
        return String::new();
    }
    let rest = match done {
        0 => String::new(),
        _ => {
            let seconds = taken.as_secs_f64() * left as f64 / done as f64;
            format!(", {} left", HumanDuration(Duration::from_secs_f64(seconds)))
        }
    };
    format!("step {} of {total}{rest}: ", done + 1)
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
                let change = by_number(*changed, "face changes", "faces change");
                bar.set_message(format!("round {round}: {changed} {change} state"));
                bar.tick();
            }
            // the bar is that of the steps
            (Step::Progress { stage, .. }, Some(bar)) if self.steps.is_some() => {
                bar.set_message(*stage);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_the_mean_of_the_steps() {
        let taken = Duration::from_secs(60);
        assert_eq!(counted(0, 40, taken), "step 1 of 40: ");
        assert_eq!(counted(10, 30, taken), "step 11 of 40, 3 minutes left: ");
        assert_eq!(counted(40, 0, taken), "");
    }
}
