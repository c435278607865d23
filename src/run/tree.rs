//! The folder of a run: what is written when, so that a process may die at any time.
//!
//! Per step: fields, rows, checkpoint. The checkpoint comes last, so everything up to its step is there whenever it is;
//! what lies after it is taken back when the run goes on.

use super::RunError;
use super::collection::Collection;
use super::error::At;
use super::events;
use super::history::{self, HISTORY, History, SOLVER};
use super::lines::{Cut, Lines, first_column, json_step};
use super::lock;
use super::onsets::{self, ONSET};
use crate::io::{
    CheckpointError, Checkpoints, Fingerprint, newest_checkpoint, read_checkpoint, unfinished,
    write_atomically,
};
use crate::nonlinear::{
    Accepted, EnergyRecord, Event, FaultRecord, LinearRecord, State, StepFailure,
};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Why a run cannot write where it was told to.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// There is a run already.
    #[error(
        "{0} holds a run: go on with restart = \"{0}\", or choose another folder",
        out.display()
    )]
    Run {
        /// The folder.
        out: PathBuf,
    },
    /// There is something else.
    #[error("{} is not empty: choose another folder", out.display())]
    Occupied {
        /// The folder.
        out: PathBuf,
    },
    /// A history that the checkpoint does not belong to.
    #[error(
        "{} does not lead up to the checkpoint, which starts step {step}: it has {}; write to the folder of the checkpoint, or an empty one",
        path.display(),
        found.map_or("no steps".to_owned(), |(a, b)| format!("steps {a} to {b}"))
    )]
    History {
        /// The file.
        path: PathBuf,
        /// That the checkpoint starts.
        step: usize,
        /// First and last step of the history.
        found: Option<(usize, usize)>,
    },
}

/// What a folder has beside the files of every run.
#[derive(Clone, Copy, Debug)]
pub(super) struct More<'a> {
    /// First line of `flow.csv`, where the scene has a fluid.
    pub(super) flow: Option<&'a str>,
    /// The scene looks for the onset of slip.
    pub(super) onset: bool,
}

/// An open run folder.
#[derive(Debug)]
pub(super) struct Tree {
    out: PathBuf,
    history: Lines,
    solver: Lines,
    energy: Lines,
    /// `energy.csv` has columns of creep.
    creeps: bool,
    /// `fault.csv` has columns of the path of slip.
    paths: bool,
    /// `fault.csv`, where there are fractures.
    fault: Option<Lines>,
    /// `flow.csv`, where the scene has a fluid.
    flow: Option<Lines>,
    /// `onset.csv`, where the scene looks for the onset of slip.
    onset: Option<Lines>,
    log: Lines,
    checkpoints: Checkpoints,
    pub(super) collection: Collection,
    /// Rows of the history, as numbers.
    pub(super) rows: History,
}

/// What a run writes before its first checkpoint: only headings, no results.
const BEGUN: [&str; 12] = [
    CHECKPOINT,
    HISTORY_FILE,
    SOLVER_FILE,
    ENERGY_FILE,
    FAULT_FILE,
    FLOW_FILE,
    ONSET_FILE,
    LOG_FILE,
    "scene.pvd",
    RESOLVED,
    "run.json",
    lock::NAME,
];

/// True for a folder that does not exist, is empty, or was left by a run that died before its first checkpoint.
pub(super) fn is_free(out: &Path) -> Result<bool, RunError> {
    let Some(mut names) = names(out)? else {
        return Ok(true);
    };
    let checkpoints = names.contains(CHECKPOINT) && checkpoints_in(&out.join(CHECKPOINT))? > 0;
    if checkpoints || !names.iter().all(|name| BEGUN.contains(&name.as_str())) {
        return Ok(false);
    }
    // its temporary file alone is none
    let history = match std::fs::read(out.join(HISTORY_FILE)) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
        read => Some(read.at(UNUSABLE, out)?),
    };
    // the lock or the heading say whose these files are
    let locked = names.remove(lock::NAME);
    names.remove(CHECKPOINT);
    Ok(match history {
        Some(text) => text == HISTORY.as_bytes(),
        None => locked || names.is_empty(),
    })
}

/// Names in a folder, those of temporary files as what they were to become; `None` where there is no folder.
fn names(folder: &Path) -> Result<Option<BTreeSet<String>>, RunError> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        entries => entries.at(UNUSABLE, folder)?,
    };
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        let name = entry.at(UNUSABLE, folder)?.file_name();
        let name = name.to_string_lossy();
        Ok(unfinished(&name).unwrap_or(&name).to_owned())
    };
    entries.map(name).collect::<Result<_, RunError>>().map(Some)
}

/// Checkpoints in their folder, unfinished ones left out.
fn checkpoints_in(folder: &Path) -> Result<usize, RunError> {
    let entries = std::fs::read_dir(folder).at(UNUSABLE, folder)?;
    let whole = |entry: &std::io::Result<std::fs::DirEntry>| {
        entry.as_ref().map_or(true, |e| {
            unfinished(&e.file_name().to_string_lossy()).is_none()
        })
    };
    Ok(entries.filter(whole).count())
}

const UNUSABLE: &str = "cannot use";

/// True for a folder that a run began and that is free nevertheless: it died before its first checkpoint.
fn is_stillborn(out: &Path) -> Result<bool, RunError> {
    Ok(is_free(out)? && names(out)?.is_some_and(|names| !names.is_empty()))
}

/// True for a folder that a run has written into.
pub fn holds_run(folder: &Path) -> bool {
    [HISTORY_FILE, "run.json"]
        .iter()
        .any(|name| folder.join(name).exists())
}

/// Refuses a folder that holds anything.
pub(super) fn require_free(out: &Path) -> Result<(), RunError> {
    if is_free(out)? {
        return Ok(());
    }
    let out = out.to_path_buf();
    let refused = match newest_checkpoint(&out.join(CHECKPOINT)) {
        Ok(_) => Refused::Run { out },
        Err(_) => Refused::Occupied { out },
    };
    Err(refused.into())
}

/// The scene of a run as it was read.
pub(super) const RESOLVED: &str = "resolved.toml";

/// Subfolder of the checkpoints.
pub(super) const CHECKPOINT: &str = "checkpoint";

const HISTORY_FILE: &str = "history.csv";
const SOLVER_FILE: &str = "solver.csv";
const ENERGY_FILE: &str = "energy.csv";
const FAULT_FILE: &str = "fault.csv";
const FLOW_FILE: &str = "flow.csv";
const ONSET_FILE: &str = "onset.csv";
const LOG_FILE: &str = "log.jsonl";

/// The folder of the run that a checkpoint belongs to, as its path says.
pub(super) fn run_of(checkpoint: &Path) -> Option<&Path> {
    let folder = checkpoint.parent();
    folder.filter(|f| f.ends_with(CHECKPOINT))?.parent()
}

/// The checkpoint that was asked for: a file, or the last one of a run folder or of its `checkpoint`; `None` for the folder
/// of a run that died before its first one.
pub(super) fn checkpoint(path: &Path) -> Result<Option<PathBuf>, RunError> {
    if !path.is_dir() {
        return Ok(Some(path.into()));
    }
    if is_stillborn(path)? {
        return Ok(None);
    }
    let inner = path.join(CHECKPOINT);
    let newest = newest_checkpoint(if inner.is_dir() { &inner } else { path })?;
    Ok(Some(newest))
}

impl Tree {
    /// Begins a folder; its first checkpoint is that of [`Tree::save`].
    pub(super) fn create(
        out: &Path,
        fingerprint: Fingerprint,
        state: &State,
        more: More<'_>,
    ) -> Result<Self, RunError> {
        let creeps = state.creep.is_some();
        let paths = !state.path.is_empty();
        let heading = history::fault_heading(paths);
        let fault =
            (!state.states.is_empty()).then(|| Lines::create(out.join(FAULT_FILE), &heading));
        let flow = (more.flow).map(|heading| Lines::create(out.join(FLOW_FILE), heading));
        let onset = (more.onset).then(|| Lines::create(out.join(ONSET_FILE), ONSET));
        let folder = out.join(CHECKPOINT);
        std::fs::create_dir_all(&folder).at("cannot create the folder", &folder)?;
        Ok(Self {
            history: Lines::create(out.join(HISTORY_FILE), HISTORY)?,
            solver: Lines::create(out.join(SOLVER_FILE), SOLVER)?,
            energy: Lines::create(out.join(ENERGY_FILE), &history::energy_heading(creeps))?,
            creeps,
            paths,
            fault: fault.transpose()?,
            flow: flow.transpose()?,
            onset: onset.transpose()?,
            log: Lines::create(out.join(LOG_FILE), "")?,
            checkpoints: Checkpoints::new(folder, fingerprint),
            collection: Collection::create(out)?,
            rows: History::default(),
            out: out.into(),
        })
    }

    /// Goes on in a folder from `state`: whatever belongs to the steps that it starts is taken back.
    pub(super) fn resume(
        out: &Path,
        fingerprint: Fingerprint,
        state: &State,
        more: More<'_>,
    ) -> Result<Self, RunError> {
        let folder = out.join(CHECKPOINT);
        let step = state.step;
        let [history, solver, energy, fault, flow, log] = [
            HISTORY_FILE,
            SOLVER_FILE,
            ENERGY_FILE,
            FAULT_FILE,
            FLOW_FILE,
            LOG_FILE,
        ]
        .map(|name| out.join(name));
        let (creeps, paths) = (state.creep.is_some(), !state.path.is_empty());
        // nothing is changed before everything is known to fit
        let rows = Cut::read(&history, HISTORY, step, first_column)?;
        belongs(&history, &rows, state)?;
        same_run(&folder, fingerprint)?;
        let solved = Cut::read(&solver, SOLVER, step, first_column)?;
        let works = Cut::read(
            &energy,
            &history::energy_heading(creeps),
            step,
            first_column,
        )?;
        let slipped = match state.states.is_empty() {
            true => None,
            false => Some(Cut::read(
                &fault,
                &history::fault_heading(paths),
                step,
                first_column,
            )?),
        };
        let flowed = (more.flow).map(|heading| Cut::read(&flow, heading, step, first_column));
        let flowed = flowed.transpose()?;
        let onset = out.join(ONSET_FILE);
        // a scene may look for it from here on
        let begun = (more.onset && onset.exists())
            .then(|| Cut::read(&onset, ONSET, step, first_column))
            .transpose()?;
        let logged = Cut::read(&log, "", step, json_step)?;
        let checkpoints = Checkpoints::new(folder, fingerprint);
        // later checkpoints first: none may outlive the rows that led to it
        checkpoints
            .forget_after(step)
            .at("cannot take back checkpoints in", out)?;
        Ok(Self {
            rows: History::read(&rows.kept),
            history: Lines::cut(history, &rows)?,
            solver: Lines::cut(solver, &solved)?,
            energy: Lines::cut(energy, &works)?,
            creeps,
            paths,
            fault: slipped.map(|cut| Lines::cut(fault, &cut)).transpose()?,
            flow: flowed.map(|cut| Lines::cut(flow, &cut)).transpose()?,
            onset: match (more.onset, begun) {
                (false, _) => None,
                (true, Some(cut)) => Some(Lines::cut(onset, &cut)?),
                (true, None) => Some(Lines::create(onset, ONSET)?),
            },
            log: Lines::cut(log, &logged)?,
            collection: Collection::cut(out, step)?,
            checkpoints,
            out: out.into(),
        })
    }

    /// Writes a whole file of the folder.
    pub(super) fn file(&self, name: &str, text: &str) -> Result<(), RunError> {
        let path = self.out.join(name);
        write_atomically(&path, |out| out.write_all(text.as_bytes())).at("cannot write", &path)
    }

    /// A line of `log.jsonl`.
    pub(super) fn log(&mut self, step: usize, event: &str, more: Value) -> Result<(), RunError> {
        self.log.append(&log_line(step, event, more))
    }

    /// The lines of an accepted step, its row of the history last, and its checkpoint.
    pub(super) fn accept(
        &mut self,
        accepted: &Accepted,
        (energy, faults): (&EnergyRecord, &[FaultRecord]),
        wall_s: Option<f64>,
    ) -> Result<(), RunError> {
        let record = &accepted.record;
        let (step, time) = (record.step, record.time);
        let done = json!({ "time_s": time, "setups": record.setups, "reuses": record.reuses });
        let lines = event_lines(step, &accepted.events) + &log_line(step, "accepted", done);
        self.log.append(&lines)?;
        self.solver(&accepted.linear)?;
        let works = history::energy_row(record, energy, self.creeps);
        self.energy.append(&works)?;
        if let Some(lines) = &mut self.fault {
            lines.append(&history::fault_rows(record, faults, self.paths))?;
        }
        if let (Some(lines), Some(flow)) = (&mut self.flow, &accepted.flow) {
            lines.append(&history::flow_row(record, flow, &accepted.wells))?;
        }
        self.begin(step, &accepted.events)?;
        let row = history::row(record, wall_s);
        self.history.append(&row)?;
        self.rows.push(&row);
        self.save(&accepted.state)
    }

    /// The lines of a step that was given up.
    pub(super) fn give_up(&mut self, step: usize, failure: &StepFailure) -> Result<(), RunError> {
        self.log.append(&event_lines(step, &failure.events))?;
        self.begin(step, &failure.events)?;
        self.solver(&failure.linear)
    }

    /// The onsets among events.
    fn begin(&mut self, step: usize, events: &[Event]) -> Result<(), RunError> {
        match &mut self.onset {
            Some(lines) => lines.append(&onsets::rows(step, events)),
            None => Ok(()),
        }
    }

    fn solver(&mut self, records: &[LinearRecord]) -> Result<(), RunError> {
        let rows: String = records.iter().map(history::solver_row).collect();
        self.solver.append(&rows)
    }

    /// The checkpoint of a state: from here on its step cannot be lost.
    pub(super) fn save(&self, state: &State) -> Result<(), RunError> {
        self.checkpoints
            .save(state)
            .at("cannot write a checkpoint in", &self.out)?;
        Ok(())
    }
}

/// Step, event, and the members of the object `more`.
fn log_line(step: usize, event: &str, more: Value) -> String {
    let mut line = json!({ "step": step, "event": event });
    if let (Value::Object(line), Value::Object(more)) = (&mut line, more) {
        line.extend(more);
    }
    format!("{line}\n")
}

fn event_lines(step: usize, events: &[Event]) -> String {
    let line = |event| {
        let (name, more) = events::event(event);
        log_line(step, name, more)
    };
    events.iter().map(line).collect()
}

/// Refuses a history that is not the one before `state`: a row per step, the last at its time.
fn belongs(path: &Path, rows: &Cut, state: &State) -> Result<(), RunError> {
    let steps = &rows.steps;
    let consecutive = steps.windows(2).all(|w| w[1] == w[0] + 1);
    let joins = steps.first().is_none_or(|first| *first <= state.step);
    let last = rows.kept.last().and_then(|row| history::numbers(row));
    let arrives = match last {
        Some(row) => {
            row[history::column("step")] + 1.0 == state.step as f64
                && row[history::column("time_s")] == state.time
        }
        None => rows.kept.is_empty(),
    };
    if consecutive && joins && arrives {
        return Ok(());
    }
    Err(Refused::History {
        path: path.into(),
        step: state.step,
        found: steps.first().copied().zip(steps.last().copied()),
    }
    .into())
}

/// Refuses a folder whose own checkpoint belongs to another mesh or scene; a damaged one says nothing about that.
fn same_run(folder: &Path, fingerprint: Fingerprint) -> Result<(), RunError> {
    let own = newest_checkpoint(folder).and_then(|path| read_checkpoint(&path, fingerprint));
    match own {
        Err(error @ (CheckpointError::OtherMesh { .. } | CheckpointError::OtherScene { .. })) => {
            Err(error.into())
        }
        _ => Ok(()),
    }
}
