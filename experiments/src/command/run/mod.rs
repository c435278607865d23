//! `fracas run`: a scene through its load steps, in a folder that survives the process.

mod collection;
mod events;
mod history;
mod lines;
mod lock;
mod manifest;
mod page;
mod settings;
mod step_loop;
mod tree;

use super::progress::Progress;
use super::scene::{self, Overrides};
use super::{Status, interrupt, output};
use anyhow::Context;
use clap::Args;
use fracas::io::{Fingerprint, read_checkpoint};
use fracas::memory;
use fracas::nonlinear::Simulation;
use fracas::scene::Scene;
use fracas::undetermined::undetermined;
use fracas_solvers::Observer;
use lock::Lock;
use manifest::{Manifest, Outcome};
use std::io::Write;
use std::path::{Path, PathBuf};
use step_loop::StepLoop;
use tree::Tree;

/// Folder of results where none is given.
const OUT: &str = "out";

/// A checkpoint behind the end of the scene.
#[derive(Debug, thiserror::Error)]
#[error(
    "the checkpoint stands at {time} s, after the end of the scene at {end} s: give a later time.end, or an earlier checkpoint"
)]
struct Beyond {
    time: f64,
    end: f64,
}

#[derive(Args, Debug)]
pub(super) struct Run {
    /// Scene file, or the name of a scene of the gallery.
    #[arg(value_name = "SCENE")]
    scene: String,
    #[command(flatten)]
    overrides: Overrides,
    /// Folder of the results, which must be empty [default: out, or that of the checkpoint].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Goes on from a checkpoint: a file, or the folder of a run for its last one.
    #[arg(long, value_name = "CHECKPOINT")]
    restart: Option<PathBuf>,
    /// Stops after N steps; --restart goes on.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Writes fields for ParaView every N steps and at the end.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..))]
    fields_every: u32,
    /// Fills the column wall_s of history.csv, which then differs from run to run.
    #[arg(long)]
    clock: bool,
}

impl Run {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let scene = scene::load(&self.scene, &self.overrides)?;
        let work = match assembles(&scene) {
            true => memory::BLOCKS,
            false => memory::MATRIX_FREE,
        };
        memory::room_for(&self.scene, &scene, work)?;
        let checkpoint = match &self.restart {
            Some(path) => tree::checkpoint(path)?,
            None => None,
        };
        let folder = self.folder(checkpoint.as_deref());
        if checkpoint.is_none() {
            tree::require_free(&folder)?;
        }
        // a wrong path is said before the work and not after it
        let _made = output::Folder::create(&folder)?;
        let (lock, found) = Lock::take(&folder)?;
        if checkpoint.is_none() {
            // between the look and the lock another run may have come and gone
            tree::require_free(&folder)?;
        }
        let mut progress = Progress::new();
        if let Some(found) = found {
            progress.say(&found);
        }
        progress.say(&format!("{}: meshing", scene.title()));
        let body = scene.build()?;
        let undetermined = undetermined(&self.scene, &body)?;
        let fingerprint = Fingerprint::new(&body, &physics(&scene)?);
        // before anything is assembled
        let started = match &checkpoint {
            Some(path) => Some(read_checkpoint(path, fingerprint)?),
            None => None,
        };
        if let Some(state) = &started {
            let end = body.time.map_or(0.0, |time| time.end);
            if state.time > end {
                let time = state.time;
                return Err(Beyond { time, end }.into());
            }
        }
        progress.say(&"assembling");
        let simulation =
            Simulation::new(&body).with_context(|| format!("{} cannot be run", self.scene))?;
        let simulation = simulation.limited_by(memory::available_bytes);
        let restarted_with = started.as_ref().map(|state| state.step);
        let state = started.unwrap_or_else(|| simulation.initial_state());
        let manifest = Manifest::new(
            &scene,
            &body,
            &simulation,
            restarted_with,
            self.fields_every as usize,
        );
        let tree = match restarted_with {
            Some(_) if !tree::is_free(&folder)? => Tree::resume(&folder, fingerprint, &state)?,
            _ => Tree::create(&folder, fingerprint)?,
        };
        let mut step_loop = StepLoop {
            command: self,
            scene: &scene,
            body: &body,
            simulation,
            manifest,
            tree,
            progress,
            folder,
            undetermined,
            _lock: lock,
        };
        step_loop.begin(&state, checkpoint.as_deref())?;
        let outcome = step_loop.steps(state)?;
        writeln!(out, "{}", step_loop.folder.join("report.html").display())?;
        Ok(match (outcome, interrupt::asked()) {
            (Outcome::NotConverged | Outcome::Unstable, _) => Status::NotConverged,
            (Outcome::Interrupted, Some(signal)) => Status::Interrupted(signal),
            _ => Status::Done,
        })
    }

    /// Where the results go.
    fn folder(&self, checkpoint: Option<&Path>) -> PathBuf {
        let of_run = match checkpoint {
            Some(checkpoint) => tree::run_of(checkpoint),
            // a run that has none yet begins again where it is
            None => self.restart.as_deref(),
        };
        let own = self.out.as_deref().or(of_run).unwrap_or(Path::new(OUT));
        if own.as_os_str().is_empty() {
            ".".into()
        } else {
            own.into()
        }
    }
}

/// Whether the preconditioner of a run needs an assembled A.
fn assembles(scene: &Scene) -> bool {
    let size = scene.size();
    let displacements = 3 * usize::try_from(size.nodes + size.copies).unwrap_or(usize::MAX / 3);
    let sections = scene.sections();
    let is_grid = sections.mesh.file.is_none();
    sections
        .solver
        .unwrap_or_default()
        .assembles(is_grid, displacements)
}

/// True for a folder that a run has written into.
pub(super) fn is_run(folder: &Path) -> bool {
    ["history.csv", "run.json"]
        .iter()
        .any(|name| folder.join(name).exists())
}

/// What of a scene decides where a state can go: all but its names, its last time, its steps and its solver.
fn physics(scene: &Scene) -> anyhow::Result<String> {
    let mut table: toml::Table = scene.to_toml()?.parse()?;
    for key in ["title", "description", "solver"] {
        table.remove(key);
    }
    if let Some(toml::Value::Table(time)) = table.get_mut("time") {
        time.remove("end");
        time.remove("steps");
    }
    // a section that says nothing more is as good as none
    table.retain(|_, value| value.as_table().is_none_or(|t| !t.is_empty()));
    Ok(toml::to_string(&table)?)
}
