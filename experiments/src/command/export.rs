//! `fracas export`: a system folder, of a scene with every face in stick or of a Newton step of its run.

use super::progress::Progress;
use super::source::Assembly;
use super::{Status, output};
use anyhow::Context;
use clap::Args;
use fracas::contact::ContactState;
use fracas::io::{NewFolder, face_table};
use fracas::memory;
use fracas::nonlinear::{NewtonSystemError, Simulation, StepFailure};
use fracas::run::holds_run;
use fracas::scene::{Body, Method};
use fracas::solve::StuckBody;
use fracas_operators::matrix_market::write_dense;
use fracas_solvers::Observer;
use fracas_solvers::saddle::SaddleBlocks;
use fracas_solvers::saddle::folder::{Manifest, write_folder};
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Args, Debug)]
pub(super) struct Export {
    /// Scene file, or the name of a scene of the gallery.
    #[arg(value_name = "SCENE")]
    scene: String,
    #[command(flatten)]
    assembly: Assembly,
    /// Folder to write.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Runs the scene to step N, 0 being the equilibrium at time 0, and writes one of its linear systems.
    #[arg(long, value_name = "N")]
    step: Option<usize>,
    /// Which of them: row K of the step in solver.csv, from 0.
    #[arg(long, value_name = "K", requires = "step", default_value = "0")]
    newton: usize,
}

/// What a folder is written from.
struct Exported {
    body: Arc<Body>,
    blocks: SaddleBlocks,
    manifest: Manifest,
}

/// A step that is not in the run.
#[derive(Debug, thiserror::Error)]
#[error("the run of {scene} has steps 0 to {last}, and no step {step}")]
struct NoSuchStep {
    scene: String,
    step: usize,
    last: usize,
}

/// A folder whose files are those of a run.
#[derive(Debug, thiserror::Error)]
#[error("{} holds a run, and a system would lie among its files: choose another --out", out.display())]
struct HoldsRun {
    out: PathBuf,
}

impl Export {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        if holds_run(&self.out) {
            let out = self.out.clone();
            return Err(HoldsRun { out }.into());
        }
        // a wrong path is said before the work and not after it
        let _folder =
            NewFolder::create(&self.out).with_context(|| output::cannot_create(&self.out))?;
        let mut progress = Progress::new();
        let stuck = self.assembly.stuck(&self.scene)?;
        let Exported {
            body,
            blocks,
            manifest,
        } = match self.step {
            None => self.in_stick(&stuck, &mut progress)?,
            Some(step) => match self.of_run(&stuck, step, &mut progress)? {
                Ok(system) => system,
                Err(failure) => {
                    progress.say(&failure);
                    return Ok(Status::NotConverged);
                }
            },
        };
        write_folder(&self.out, &blocks, &manifest)?;
        write_dense(&self.out.join("faces.mtx"), &face_table(&body.fractures))?;
        writeln!(out, "{}", self.out.display())?;
        Ok(Status::Done)
    }

    /// The system with every face in stick.
    fn in_stick(&self, stuck: &StuckBody, progress: &mut Progress) -> anyhow::Result<Exported> {
        let (body, blocks) = stuck.assemble(progress)?;
        let states = vec![ContactState::Stick; body.fractures.faces.len()];
        Ok(Exported {
            manifest: self.assembly.manifest(&self.scene, 0, 0, &states),
            body,
            blocks,
        })
    }

    /// The system of a Newton step, or the step of the run that failed before it.
    fn of_run(
        &self,
        stuck: &StuckBody,
        step: usize,
        progress: &mut Progress,
    ) -> anyhow::Result<Result<Exported, Box<StepFailure>>> {
        self.assembly.require_run_stabilization()?;
        let body = stuck.mesh(memory::BLOCKS, progress)?;
        // before the steps that lead to it
        if body.solver.method != Method::Lagrange {
            return Err(NewtonSystemError::Springs.into());
        }
        let (states, blocks, other) = {
            let mut simulation =
                Simulation::new(&body).with_context(|| format!("{} cannot be run", self.scene))?;
            let mut state = simulation.initial_state();
            loop {
                if state.step > 0 && simulation.is_finished(&state) {
                    return Err(NoSuchStep {
                        scene: self.scene.clone(),
                        step,
                        last: state.step - 1,
                    }
                    .into());
                }
                if state.step == step {
                    break;
                }
                progress.say(&format_args!("step {}", state.step));
                match simulation.advance(&state, progress) {
                    Ok(accepted) => state = accepted.state,
                    Err(failure) => return Ok(Err(failure)),
                }
            }
            let time = state.time;
            match simulation.newton_system(&state, self.newton, progress) {
                Ok(system) => {
                    let other = json!({
                        "from_time_s": time,
                        "attempt": system.attempt,
                        "round": system.round,
                        "newton_of_round": system.newton,
                    });
                    (system.states, system.blocks, other)
                }
                Err(NewtonSystemError::Step(failure)) => return Ok(Err(failure)),
                Err(error) => return Err(error.into()),
            }
        };
        let mut manifest = self
            .assembly
            .manifest(&self.scene, step, self.newton, &states);
        if let Value::Object(other) = other {
            manifest.other.extend(other);
        }
        Ok(Ok(Exported {
            body,
            blocks,
            manifest,
        }))
    }
}
