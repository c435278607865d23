//! A run on its way: step by step, each on the disk before the next begins.

use super::Run;
use super::lock::Lock;
use super::manifest::{Manifest, Outcome};
use super::page;
use super::settings;
use super::tree::{RESOLVED, Tree};
use crate::command::interrupt::{self, Signal};
use crate::command::progress::Progress;
use crate::report::format_real;
use fracas::io::Fields;
use fracas::nonlinear::{Event, Failure, Simulation, State, StepRecord, friction_remarks};
use fracas::scene::{Body, Scene};
use fracas_solvers::Observer;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A run on its way.
pub(super) struct StepLoop<'a> {
    pub(super) command: &'a Run,
    pub(super) scene: &'a Scene,
    pub(super) body: &'a Body,
    pub(super) simulation: Simulation<'a>,
    pub(super) manifest: Manifest<'a>,
    pub(super) tree: Tree,
    pub(super) progress: Progress,
    pub(super) folder: PathBuf,
    /// What is to be said of tractions that nothing determines.
    pub(super) undetermined: Option<String>,
    /// Keeps other processes out of the folder.
    pub(super) _lock: Lock,
}

impl StepLoop<'_> {
    /// Everything that is there before the first step; the checkpoint is the last of it.
    pub(super) fn begin(&mut self, state: &State, checkpoint: Option<&Path>) -> anyhow::Result<()> {
        // before they are written over
        let changed = checkpoint.map_or_else(Vec::new, |path| settings::changed(path, self.scene));
        self.tree.file(RESOLVED, &self.scene.to_toml()?)?;
        self.stands(state, Outcome::Running, None)?;
        let from = checkpoint.map(|path| path.display().to_string());
        let event = if from.is_some() { "restart" } else { "start" };
        self.tree.log(
            state.step,
            event,
            json!({ "time_s": state.time, "checkpoint": from }),
        )?;
        let remarks = friction_remarks(self.body)
            .into_iter()
            .map(|r| r.to_string());
        for remark in self
            .undetermined
            .take()
            .into_iter()
            .chain(remarks)
            .chain(changed)
        {
            self.progress.say(&format!("warning: {remark}"));
            self.tree
                .log(state.step, "warning", json!({ "text": remark }))?;
        }
        self.tree.save(state)
    }

    /// Step by step to the end, or to where it goes no further.
    pub(super) fn steps(&mut self, mut state: State) -> anyhow::Result<Outcome> {
        let mut left = self.command.steps;
        loop {
            if self.simulation.is_finished(&state) {
                return self.end(&state, Outcome::Finished, None);
            }
            if left == Some(0) {
                return self.end(&state, Outcome::Stopped, None);
            }
            if let Some(signal) = interrupt::asked() {
                return self.interrupted(&state, signal);
            }
            left = left.map(|n| n - 1);
            let clock = Instant::now();
            match self.simulation.advance(&state, &mut self.progress) {
                Ok(accepted) => {
                    let wall_s = clock.elapsed().as_secs_f64();
                    let record = &accepted.record;
                    self.manifest.arrested += usize::from(record.arrested);
                    let every = self.command.fields_every as usize;
                    if record.step.is_multiple_of(every) {
                        self.fields(&accepted.state)?;
                    }
                    let wall_s = self.command.clock.then_some(wall_s);
                    let energy = self.simulation.energy(&state, &accepted.state);
                    self.tree.accept(&accepted, &energy, wall_s)?;
                    self.warn(&accepted.events);
                    self.progress.tell(&line(record));
                    state = accepted.state;
                }
                // nothing of the step that it was in is kept
                Err(_) if interrupt::asked().is_some() => {}
                Err(failure) => {
                    self.tree.give_up(state.step, &failure)?;
                    self.warn(&failure.events);
                    let reason = failure.to_string();
                    let outcome = match failure.reason {
                        Failure::Unstable(_) => Outcome::Unstable,
                        _ => Outcome::NotConverged,
                    };
                    return self.end(&state, outcome, Some(reason));
                }
            }
        }
    }

    /// Says what gave way: f32 to f64, an inner solver to another, equilibrium under weakening.
    fn warn(&self, events: &[Event]) {
        for event in events {
            let warning = match event {
                Event::Precision { reason } => format!("{reason}; the hierarchy is in f64"),
                Event::Inner { reason, now } => {
                    format!("{reason}; the inner solver is {now} instead")
                }
                Event::Arrested { patch } => format!("unstable: {patch}; stepped over"),
                _ => continue,
            };
            self.progress.tell(&format!("warning: {warning}"));
        }
    }

    /// Fields of the step that led to a state.
    fn fields(&mut self, state: &State) -> anyhow::Result<()> {
        let Some(step) = state.step.checked_sub(1) else {
            return Ok(());
        };
        if self.tree.collection.has(step) {
            return Ok(());
        }
        let displacement = self.simulation.displacement(state);
        let faces = self.simulation.face_fields(state);
        let fields = Fields::new(self.body, &displacement, &faces, state)?;
        self.tree.collection.add(step, state.time, &fields)
    }

    /// How to go on after a signal; fields stay those of `--fields-every`, so that going on leaves what an unbroken run leaves.
    fn interrupted(&mut self, state: &State, signal: Signal) -> anyhow::Result<Outcome> {
        let reason = format!(
            "{signal} before step {} was done: go on with fracas run {} --restart {}",
            state.step,
            self.command.scene,
            self.folder.display()
        );
        self.finish(state, Outcome::Interrupted, Some(reason))
    }

    /// The last good state with its fields, the page, and how it ended.
    fn end(
        &mut self,
        state: &State,
        outcome: Outcome,
        reason: Option<String>,
    ) -> anyhow::Result<Outcome> {
        self.fields(state)?;
        self.finish(state, outcome, reason)
    }

    /// The page, and how it ended.
    fn finish(
        &mut self,
        state: &State,
        outcome: Outcome,
        reason: Option<String>,
    ) -> anyhow::Result<Outcome> {
        let (event, lead) = match outcome {
            Outcome::NotConverged | Outcome::Unstable => (
                match outcome {
                    Outcome::Unstable => "unstable",
                    _ => "not_converged",
                },
                format!("Stopped: {}.", reason.as_deref().unwrap_or_default()),
            ),
            Outcome::Interrupted => (
                "interrupted",
                format!("Stopped: {}.", reason.as_deref().unwrap_or_default()),
            ),
            Outcome::Stopped => (
                "stopped",
                format!("Stopped before step {} as asked.", state.step),
            ),
            Outcome::Finished | Outcome::Running => ("finished", "Finished.".to_owned()),
        };
        self.tree.log(
            state.step,
            event,
            json!({ "time_s": state.time, "reason": reason }),
        )?;
        if let Some(reason) = &reason {
            self.progress.say(reason);
        }
        page::write(self.scene, &lead, &self.tree.rows, &self.folder)?;
        self.stands(state, outcome, reason)?;
        Ok(outcome)
    }

    /// Writes `run.json`.
    fn stands(
        &mut self,
        state: &State,
        outcome: Outcome,
        reason: Option<String>,
    ) -> anyhow::Result<()> {
        let text = self
            .manifest
            .text(&self.simulation, state, outcome, reason)?;
        self.tree.file("run.json", &text)
    }
}

/// A step in a line.
fn line(record: &StepRecord) -> String {
    let [stick, new_slip, slip, open] = record.faces;
    let cuts = match record.cuts {
        0 => String::new(),
        n => format!(", cut {n} times"),
    };
    format!(
        "step {}, t = {} s: {} rounds, {} Newton, {} Krylov{cuts}; {stick} stick, {new_slip} new-slip, {slip} slip, {open} open",
        record.step,
        format_real(record.time),
        record.active_it,
        record.newton_it,
        record.lin_it,
    )
}
