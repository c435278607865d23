//! Where a system comes from: a scene, a scene of the gallery by name, or a system folder.

use super::memory;
use super::progress::Progress;
use super::rank;
use super::scene::{self, Overrides};
use anyhow::Context;
use clap::Args;
use fracas::contact::{ContactState, JumpStabilization};
use fracas::scene::Body;
use fracas_solvers::saddle::SaddleBlocks;
use fracas_solvers::saddle::folder::{Manifest, read_folder};
use std::path::{Path, PathBuf};

/// A scene or a folder.
#[derive(Args, Debug)]
pub(super) struct Source {
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    assembly: Assembly,
}

#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
struct Place {
    /// Scene file, or the name of a scene of the gallery.
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// System folder (A.mtx, B1.mtx, …).
    #[arg(long, value_name = "DIR")]
    system: Option<PathBuf>,
}

/// How a scene becomes a system.
#[derive(Args, Debug)]
pub(super) struct Assembly {
    #[command(flatten)]
    overrides: Overrides,
    /// Factor of the jump stabilization H of a scene; 0 leaves it out.
    #[arg(long, value_name = "S", default_value = "1", allow_negative_numbers = true, value_parser = factor)]
    stabilization: f64,
}

fn factor(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value >= 0.0 && f64::is_finite(value) => Ok(value),
        _ => Err("the factor is a number ≥ 0".into()),
    }
}

/// A system with what is known about its origin.
pub(super) struct System {
    pub(super) blocks: SaddleBlocks,
    pub(super) manifest: Manifest,
    /// The meshed body, where the system comes from a scene.
    pub(super) body: Option<Body>,
    /// Remarks of the import.
    pub(super) findings: Vec<String>,
    /// False when the folder holds no right-hand side at all.
    pub(super) has_rhs: bool,
    /// True when fracas assembled the system, now or before an export: then we choose the units that it is solved in.
    pub(super) is_ours: bool,
}

impl System {
    /// The system of a body that fracas assembled.
    pub(super) fn of_body(body: Body, blocks: SaddleBlocks, manifest: Manifest) -> Self {
        Self {
            has_rhs: blocks.rhs().iter().any(|b| *b != 0.0),
            blocks,
            manifest,
            body: Some(body),
            findings: Vec::new(),
            is_ours: true,
        }
    }
}

impl Source {
    /// The scene, where it is one.
    pub(super) fn scene(&self) -> Option<&str> {
        self.place.scene.as_deref()
    }

    /// Whether it is a scene whose mesh is a grid.
    pub(super) fn is_grid(&self) -> anyhow::Result<bool> {
        let Some(name) = self.scene() else {
            return Ok(false);
        };
        let scene = scene::load(name, &self.assembly.overrides)?;
        Ok(scene.sections().mesh.file.is_none())
    }

    /// How the scene becomes a system.
    pub(super) fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Reads or assembles the system; remarks go to the progress stream.
    pub(super) fn load(&self, progress: &mut Progress) -> anyhow::Result<System> {
        let system = match (&self.place.scene, &self.place.system) {
            (Some(name), _) => self.assembly.assemble(name, progress)?,
            (None, Some(folder)) => import(folder, progress)?,
            (None, None) => anyhow::bail!("give a scene, or --system DIR"),
        };
        let blocks = &system.blocks;
        progress.say(&format!(
            "n_u = {}, n_t = {}, n_p = {}",
            blocks.n_u(),
            blocks.n_t(),
            blocks.n_p()
        ));
        Ok(system)
    }
}

fn import(folder: &Path, progress: &mut Progress) -> anyhow::Result<System> {
    let imported = read_folder(folder)?;
    let findings: Vec<String> = imported.findings.iter().map(ToString::to_string).collect();
    for finding in &findings {
        progress.say(&format!("note: {finding}"));
    }
    let (blocks, manifest, has_rhs) = (imported.blocks, imported.manifest, imported.has_rhs);
    Ok(System {
        is_ours: manifest.is_ours(),
        blocks,
        manifest,
        body: None,
        findings,
        has_rhs,
    })
}

impl Assembly {
    /// Jump stabilization, unless it is left out.
    pub(super) fn stabilization(&self, body: &Body) -> Option<JumpStabilization> {
        (self.stabilization > 0.0).then_some(JumpStabilization {
            scale: self.stabilization,
            ..body.jump_stabilization()
        })
    }

    /// Meshes a scene that fits into memory at `bytes` and whose answer is unique.
    pub(super) fn mesh(
        &self,
        name: &str,
        bytes: memory::Work,
        progress: &mut Progress,
    ) -> anyhow::Result<Body> {
        let scene = scene::load(name, &self.overrides)?;
        memory::room_for(name, &scene, bytes)?;
        progress.say(&format!("{}: meshing", scene.title()));
        let body = scene.build()?;
        if let Some(sentence) = rank::undetermined(name, &body)? {
            progress.say(&format!("warning: {sentence}"));
        }
        Ok(body)
    }

    /// Meshes a scene and assembles its blocks with every face in stick.
    pub(super) fn assemble(&self, name: &str, progress: &mut Progress) -> anyhow::Result<System> {
        let body = self.mesh(name, memory::BLOCKS, progress)?;
        progress.say("assembling");
        let blocks = body
            .saddle_blocks(self.stabilization(&body))
            .with_context(|| format!("{name} cannot be assembled"))?;
        let states = vec![ContactState::Stick; body.fractures.faces.len()];
        let manifest = self.manifest(name, 0, 0, &states);
        Ok(System::of_body(body, blocks, manifest))
    }

    /// What a folder of this scene says of itself.
    pub(super) fn manifest(
        &self,
        name: &str,
        step: usize,
        newton: usize,
        states: &[ContactState],
    ) -> Manifest {
        let mut manifest = Manifest {
            scene: Some(name.into()),
            step: Some(step),
            newton: Some(newton),
            states: Some(states.iter().map(|state| state.code()).collect()),
            units: Some("SI".into()),
            ..Manifest::default()
        };
        manifest
            .other
            .insert("stabilization".into(), self.stabilization.into());
        manifest
    }

    /// Refuses a factor of the stabilization that a run does not know.
    pub(super) fn require_run_stabilization(&self) -> anyhow::Result<()> {
        anyhow::ensure!(
            self.stabilization == 1.0,
            "--stabilization {} and --step exclude each other: a run stabilizes with factor 1",
            self.stabilization
        );
        Ok(())
    }
}
