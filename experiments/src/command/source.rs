//! Where a system comes from: a scene, a scene of the gallery by name, or a system folder.

use super::origin::Origin;
use super::progress::Progress;
use super::scene::{self, Overrides};
use clap::Args;
use fracas::contact::ContactState;
use fracas::solve::{Loaded, Problem, StuckBody};
use fracas_solvers::Observer;
use fracas_solvers::saddle::folder::Manifest;
use std::path::PathBuf;

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

impl Source {
    /// What is solved; a scene is read, and nothing is meshed.
    pub(super) fn problem(&self) -> anyhow::Result<Problem> {
        match (&self.place.scene, &self.place.system) {
            (Some(name), _) => Ok(Problem::Body(self.assembly.stuck(name)?)),
            (None, Some(folder)) => {
                self.assembly.is_left_alone()?;
                Ok(Problem::Folder(folder.clone()))
            }
            (None, None) => anyhow::bail!("give a scene, or --system DIR"),
        }
    }

    /// What a report says of where its system came from.
    pub(super) fn origin(&self) -> Origin<'_> {
        let overrides = &self.assembly.overrides;
        Origin::new(
            self.place.scene.as_deref(),
            self.place.system.as_deref(),
            overrides,
        )
    }

    /// Reads or assembles the system; remarks go to the progress stream.
    pub(super) fn load(&self, progress: &mut Progress) -> anyhow::Result<Loaded> {
        let loaded = self.problem()?.load(progress)?;
        progress.say(&loaded.sizes());
        Ok(loaded)
    }
}

impl Assembly {
    /// A folder holds the system as it is.
    fn is_left_alone(&self) -> anyhow::Result<()> {
        self.overrides.are_none()?;
        anyhow::ensure!(
            self.stabilization == 1.0,
            "--stabilization has no effect on a system folder, whose H is in H.mtx"
        );
        Ok(())
    }

    /// A scene with every face in stick.
    pub(super) fn stuck(&self, name: &str) -> anyhow::Result<StuckBody> {
        let mut stuck = StuckBody::of_scene(name, scene::load(name, &self.overrides)?);
        stuck.stabilization = self.stabilization;
        Ok(stuck)
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
