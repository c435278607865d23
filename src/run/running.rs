//! A run on its way: step by step, each on the disk before the next begins.

use super::beyond::Beyond;
use super::changed::changed;
use super::manifest::Manifest;
use super::tree::{RESOLVED, Tree};
use super::{Done, Ended, History, Outcome, RunError, RunFolder, Stop, Stored, Taken};
use crate::io::Fields;
use crate::nonlinear::{
    Accepted, Event, Failure, LinearFailure, Simulation, SlipOnset, State, StepFailure,
    friction_remarks,
};
use fracas_solvers::{Observer, Step};
use serde_json::json;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::time::Instant;

/// A run on its way in its folder.
pub struct Running<'a> {
    folder: &'a RunFolder,
    simulation: Simulation<'a>,
    manifest: Manifest<'a>,
    tree: Tree,
    state: State,
    /// Steps that are left of those asked for.
    left: Option<usize>,
    beyond: Beyond,
}

impl<'a> Running<'a> {
    /// Everything that is there before the first step; the checkpoint is the last of it.
    pub(super) fn begin(
        folder: &'a RunFolder,
        simulation: Simulation<'a>,
        tree: Tree,
        state: State,
        restarted_with: Option<usize>,
        observer: &mut dyn Observer,
    ) -> Result<Self, RunError> {
        let (scene, every) = (&folder.scene, folder.settings.fields_every);
        let manifest = Manifest::new(scene, &folder.body, &simulation, restarted_with, every);
        let mut running = Self {
            left: folder.settings.steps,
            folder,
            simulation,
            manifest,
            tree,
            state,
            beyond: Beyond::default(),
        };
        // before they are written over
        let checkpoint = folder.checkpoint.as_deref();
        let changed = checkpoint.map_or_else(Vec::new, |path| changed(path, scene));
        running.tree.file(RESOLVED, &scene.to_toml()?)?;
        running.stands(Outcome::Running, None, &[])?;
        let from = checkpoint.map(|path| path.display().to_string());
        let event = if from.is_some() { "restart" } else { "start" };
        let (step, time) = (running.state.step, running.state.time);
        let more = json!({ "time_s": time, "checkpoint": from });
        running.tree.log(step, event, more)?;
        let remarks = friction_remarks(&folder.body)
            .into_iter()
            .map(|remark| remark.to_string());
        let undetermined = folder.undetermined.clone().into_iter();
        let moved = scene.geology().into_iter();
        let moved = moved.flat_map(|geology| geology.warnings());
        for remark in moved.chain(undetermined).chain(remarks).chain(changed) {
            observer.say(&format_args!("warning: {remark}"));
            let more = json!({ "text": remark });
            running.tree.log(step, "warning", more)?;
        }
        running.tree.save(&running.state)?;
        Ok(running)
    }

    /// The state that the next step starts from.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The simulation, whose fields belong to [`state`](Self::state).
    pub fn simulation(&self) -> &Simulation<'a> {
        &self.simulation
    }

    /// The rows of all steps, those before a restart included.
    pub fn history(&self) -> &History {
        &self.tree.rows
    }

    /// When slip began so far, with the names of the fractures; nothing where the scene does not look for it.
    pub fn onsets(&self) -> impl Iterator<Item = (&str, &SlipOnset)> {
        self.simulation.onsets(&self.state)
    }

    /// Steps that are to come, where none is cut and the run is not stopped.
    pub fn steps_left(&self) -> usize {
        let all = self.simulation.steps_left(&self.state);
        self.left.map_or(all, |left| left.min(all))
    }

    /// Steps whose fields are on the disk, and their times [s], increasing.
    pub fn steps_with_fields(&self) -> &[(usize, f64)] {
        self.tree.collection.steps()
    }

    /// Reads the fields of one of [`steps_with_fields`](Self::steps_with_fields); none of another step.
    ///
    /// # Errors
    /// [`RunError`] of the files.
    pub fn stored(&self, step: usize) -> Result<Option<Stored>, RunError> {
        let found = self.steps_with_fields().iter().find(|(s, _)| *s == step);
        found
            .map(|(step, time)| Stored::read(&self.tree.collection, *step, *time))
            .transpose()
    }

    /// The next step, on the disk when this returns, or how the run ended where there is none.
    ///
    /// # Errors
    /// [`RunError`] of a file; a step that fails is an end.
    pub fn advance(
        &mut self,
        stop: &dyn Stop,
        observer: &mut dyn Observer,
    ) -> Result<Taken, RunError> {
        if self.simulation.is_finished(&self.state) {
            return self.end(Outcome::Finished, None);
        }
        if self.left == Some(0) {
            return self.end(Outcome::Stopped, None);
        }
        if let Some(what) = stop.asked() {
            return self.interrupted(what);
        }
        self.left = self.left.map(|n| n - 1);
        let clock = Instant::now();
        let mut stoppable = Stoppable { stop, observer };
        match self.simulation.advance(&self.state, &mut stoppable) {
            Ok(accepted) => self.accept(accepted, clock.elapsed().as_secs_f64()),
            // nothing of the step that it was in is kept
            Err(failure) => match stop.asked() {
                Some(what) => self.interrupted(what),
                None => self.give_up(*failure),
            },
        }
    }

    fn accept(&mut self, accepted: Accepted, wall_s: f64) -> Result<Taken, RunError> {
        let settings = &self.folder.settings;
        self.manifest.arrested += usize::from(accepted.record.arrested);
        if accepted.record.step.is_multiple_of(settings.fields_every) {
            write_fields(
                self.folder,
                &self.simulation,
                &mut self.tree,
                &accepted.state,
            )?;
        }
        let wall_s = settings.clock.then_some(wall_s);
        let energy = self.simulation.energy(&self.state, &accepted.state);
        let faults = self.simulation.faults(&self.state, &accepted.state);
        self.tree.accept(&accepted, (&energy, &faults), wall_s)?;
        let fields = || self.simulation.face_fields(&accepted.state);
        let (step, fractures) = (accepted.record.step, &self.folder.body.fractures);
        (self.beyond).add(step, &accepted.events, fields, fractures);
        let Accepted {
            state,
            record,
            linear,
            events,
            flow: _,
            wells: _,
        } = accepted;
        self.state = state;
        Ok(Taken::Step(Box::new(Done {
            record,
            linear,
            events,
        })))
    }

    fn give_up(&mut self, failure: StepFailure) -> Result<Taken, RunError> {
        self.tree.give_up(self.state.step, &failure)?;
        let reason = failure.to_string();
        if let Failure::Linear(LinearFailure::NoRoom { .. }) = failure.reason {
            // no answer about the rock: with more memory the run goes on from here
            self.end(Outcome::NotConverged, Some(reason.clone()))?;
            return Err(RunError::NoRoom { reason });
        }
        let outcome = match failure.reason {
            Failure::Unstable(_) => Outcome::Unstable,
            _ => Outcome::NotConverged,
        };
        match self.end(outcome, Some(reason))? {
            Taken::Ended(ended) => Ok(Taken::Ended(Ended {
                events: failure.events,
                ..ended
            })),
            step => Ok(step),
        }
    }

    /// How to go on; fields stay those of `fields_every`, so that going on leaves what an unbroken run leaves.
    fn interrupted(&mut self, what: &str) -> Result<Taken, RunError> {
        let reason = format!(
            "{what} before step {} was done: go on with fracas run {} --restart {}",
            self.state.step,
            self.folder.name,
            self.folder.path.display()
        );
        self.log_end(Outcome::Interrupted, Some(reason))
    }

    /// The last good state with its fields.
    fn end(&mut self, outcome: Outcome, reason: Option<String>) -> Result<Taken, RunError> {
        write_fields(self.folder, &self.simulation, &mut self.tree, &self.state)?;
        self.log_end(outcome, reason)
    }

    fn log_end(&mut self, outcome: Outcome, reason: Option<String>) -> Result<Taken, RunError> {
        let (step, time) = (self.state.step, self.state.time);
        let more = json!({ "time_s": time, "reason": reason });
        let remarks: Vec<String> = self.beyond.remark().into_iter().collect();
        for remark in &remarks {
            self.tree.log(step, "warning", json!({ "text": remark }))?;
        }
        self.tree.log(step, outcome.event(), more)?;
        Ok(Taken::Ended(Ended {
            outcome,
            step,
            reason,
            events: Vec::new(),
            remarks,
        }))
    }

    /// Says in `run.json` how the run ended: the last file, after those that the caller adds to the folder.
    ///
    /// # Errors
    /// [`RunError`] of the file.
    pub fn close(mut self, ended: &Ended) -> Result<(), RunError> {
        self.stands(ended.outcome, ended.reason.clone(), &ended.events)
    }

    /// Writes `run.json`.
    fn stands(
        &mut self,
        outcome: Outcome,
        reason: Option<String>,
        events: &[Event],
    ) -> Result<(), RunError> {
        let (simulation, state) = (&self.simulation, &self.state);
        let text = self
            .manifest
            .text(simulation, state, (outcome, reason), events)?;
        self.tree.file("run.json", &text)
    }
}

/// Fields of the step that led to a state.
fn write_fields(
    folder: &RunFolder,
    simulation: &Simulation<'_>,
    tree: &mut Tree,
    state: &State,
) -> Result<(), RunError> {
    let Some(step) = state.step.checked_sub(1) else {
        return Ok(());
    };
    if tree.collection.has(step) {
        return Ok(());
    }
    let displacement = simulation.displacement(state);
    let faces = simulation.face_fields(state);
    let relaxed = simulation.relaxed(state);
    let fields = Fields::new(&folder.body, &displacement, &faces, state, relaxed)?;
    tree.collection.add(step, state.time, &fields)
}

/// Stops iterations where the caller wants to.
struct Stoppable<'a> {
    stop: &'a dyn Stop,
    observer: &'a mut dyn Observer,
}

impl Observer for Stoppable<'_> {
    fn observe(&mut self, step: &Step) -> ControlFlow<()> {
        self.observer.observe(step)?;
        match self.stop.asked() {
            Some(_) => ControlFlow::Break(()),
            None => ControlFlow::Continue(()),
        }
    }

    fn say(&mut self, line: &dyn Display) {
        self.observer.say(line);
    }
}
