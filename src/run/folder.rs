//! A folder that a run has taken, with its scene and the state that it goes on from.

use super::error::At;
use super::lock::Lock;
use super::tree::{self, More, Tree};
use super::{Run, RunError, Running};
use crate::io::{Fingerprint, NewFolder, read_checkpoint};
use crate::memory;
use crate::nonlinear::{Simulation, State};
use crate::scene::{Body, Scene};
use crate::undetermined::undetermined;
use fracas_solvers::Observer;
use std::path::{Path, PathBuf};

/// Folder of results where none is given.
const OUT: &str = "out";

/// A run folder that no other process writes to, until this value goes.
pub struct RunFolder {
    pub(super) settings: Run,
    pub(super) name: String,
    pub(super) scene: Scene,
    pub(super) body: Body,
    /// What is to be said of tractions that nothing determines.
    pub(super) undetermined: Option<String>,
    pub(super) path: PathBuf,
    pub(super) checkpoint: Option<PathBuf>,
    fingerprint: Fingerprint,
    /// Of the checkpoint.
    state: Option<State>,
    begun: bool,
    // in this order: the lock goes, then the folder where nothing was written into it
    _lock: Lock,
    _new: NewFolder,
}

impl RunFolder {
    pub(super) fn open(
        settings: Run,
        name: &str,
        scene: Scene,
        observer: &mut dyn Observer,
    ) -> Result<Self, RunError> {
        memory::room_for(name, &scene, work_of(&scene))?;
        let checkpoint = match &settings.restart {
            Some(path) => tree::checkpoint(path)?,
            None => None,
        };
        let path = folder(&settings, checkpoint.as_deref());
        if checkpoint.is_none() {
            tree::require_free(&path)?;
        }
        // a wrong path is said before the work and not after it
        let new = NewFolder::create(&path).at("cannot create the folder", &path)?;
        let (lock, found) = Lock::take(&path)?;
        if checkpoint.is_none() {
            // between the look and the lock another run may have come and gone
            tree::require_free(&path)?;
        }
        if let Some(found) = found {
            observer.say(&found);
        }
        observer.say(&format_args!("{}: meshing", scene.title()));
        let body = scene.build()?;
        let undetermined = undetermined(name, &body)?;
        let fingerprint = Fingerprint::new(&body, &physics(&scene)?);
        // before anything is assembled
        let state = match &checkpoint {
            Some(path) => Some(read_checkpoint(path, fingerprint)?),
            None => None,
        };
        if let Some(State { time, .. }) = state {
            let end = body.time.map_or(0.0, |time| time.end);
            if time > end {
                return Err(RunError::Beyond { time, end });
            }
        }
        Ok(Self {
            settings,
            name: name.into(),
            scene,
            body,
            undetermined,
            path,
            checkpoint,
            fingerprint,
            state,
            begun: false,
            _lock: lock,
            _new: new,
        })
    }

    /// Where the results go.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Assembles, takes back what belongs to later steps than the checkpoint's, and writes all that is there before a step.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn begin(&mut self, observer: &mut dyn Observer) -> Result<Running<'_>, RunError> {
        if std::mem::replace(&mut self.begun, true) {
            let path = self.path.clone();
            return Err(RunError::Begun { path });
        }
        let started = self.state.take();
        let folder: &Self = self;
        observer.say(&"assembling");
        let simulation = Simulation::new(&folder.body).map_err(|source| RunError::Simulation {
            name: folder.name.clone(),
            source,
        })?;
        let simulation = simulation.limited_by(memory::available_bytes);
        let restarted_with = started.as_ref().map(|state| state.step);
        let state = started.unwrap_or_else(|| simulation.initial_state());
        let fluid = folder.body.fluid.as_ref();
        let heading = fluid.map(|fluid| {
            super::history::flow_heading(fluid.wells.iter().map(|well| well.name.as_str()))
        });
        let more = More {
            flow: heading.as_deref(),
            onset: folder.body.onset.is_some(),
        };
        let tree = match restarted_with {
            Some(_) if !tree::is_free(&folder.path)? => {
                Tree::resume(&folder.path, folder.fingerprint, &state, more)?
            }
            _ => Tree::create(&folder.path, folder.fingerprint, &state, more)?,
        };
        Running::begin(folder, simulation, tree, state, restarted_with, observer)
    }
}

/// Where the results go.
fn folder(settings: &Run, checkpoint: Option<&Path>) -> PathBuf {
    let of_run = match checkpoint {
        Some(checkpoint) => tree::run_of(checkpoint),
        // a run that has none yet begins again where it is
        None => settings.restart.as_deref(),
    };
    let own = settings.out.as_deref().or(of_run).unwrap_or(Path::new(OUT));
    if own.as_os_str().is_empty() {
        ".".into()
    } else {
        own.into()
    }
}

/// What a run of a scene needs memory for.
pub fn work_of(scene: &Scene) -> memory::Work {
    match assembles(scene) {
        true => memory::BLOCKS,
        false => memory::MATRIX_FREE,
    }
}

/// Whether the preconditioner of a run needs an assembled A.
fn assembles(scene: &Scene) -> bool {
    let size = scene.size();
    let displacements = 3 * usize::try_from(size.nodes + size.copies).unwrap_or(usize::MAX / 3);
    let sections = scene.sections();
    let is_grid = sections.mesh.file.is_none() && !scene.is_thin();
    sections
        .solver
        .unwrap_or_default()
        .assembles(is_grid, displacements)
}

/// What of a scene decides where a state can go: all but its names, its last time, its steps, the onset it looks for, and its solver. Files are
/// known by what they hold, wherever they lie: meshes by their fingerprint, fields of pressure by their digest.
fn physics(scene: &Scene) -> Result<String, RunError> {
    let mut table: toml::Table = scene.to_toml()?.parse()?;
    for key in ["title", "description", "solver"] {
        table.remove(key);
    }
    if let Some(toml::Value::Table(time)) = table.get_mut("time") {
        for key in ["end", "steps", "onset"] {
            time.remove(key);
        }
    }
    let strip = |file: &mut toml::Value| {
        let name = file.as_str().map(Path::new).and_then(Path::file_name);
        let name = name.map(|name| name.to_string_lossy().into_owned());
        *file = name.unwrap_or_default().into();
    };
    let file = table.get_mut("mesh").and_then(|mesh| mesh.get_mut("file"));
    file.into_iter().for_each(strip);
    let materials = table.get_mut("material").and_then(|m| m.as_array_mut());
    let pores = materials.into_iter().flatten();
    for pores in pores.filter_map(|m| m.get_mut("pore_pressure")?.as_table_mut()) {
        if pores.contains_key("digest") {
            pores.remove("grid");
            let fields = pores.get_mut("fields").and_then(|f| f.as_array_mut());
            let rows = fields.into_iter().flatten();
            rows.filter_map(|row| row.as_array_mut())
                .for_each(|row| row.truncate(1));
        }
    }
    // a section that says nothing more is as good as none
    table.retain(|_, value| value.as_table().is_none_or(|t| !t.is_empty()));
    Ok(toml::to_string(&table)?)
}
