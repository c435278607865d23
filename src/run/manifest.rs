//! `run.json`: what was run, with which settings, and how it ended.

use super::{Outcome, RunError, onsets};
use crate::memory;
use crate::nonlinear::{Event, Simulation, State};
use crate::scene::{Body, Scene, SolverSection, TimeSection};
use fracas_solvers::saddle::Racp;
use serde::Serialize;
use serde_json::Value;

/// Content of `run.json`. No clock and no host, so that equal runs give equal bytes.
#[derive(Serialize)]
pub(super) struct Manifest<'a> {
    version: &'static str,
    title: &'a str,
    outcome: Outcome,
    /// Why a step did not converge, or how to go on after a signal.
    reason: Option<String>,
    /// Accepted steps.
    steps: usize,
    time_s: f64,
    /// Step that this process started with, where it went on from a checkpoint.
    restarted_with: Option<usize>,
    sizes: Sizes,
    time: Option<&'a TimeSection>,
    solver: SolverSection,
    /// In use, also where the scene leaves the choice.
    preconditioner: Racp,
    /// Times that this process took f64 because f32 would have lost too much; why is in `log.jsonl`.
    precision_fallbacks: usize,
    /// Times that an inner solver could not be set up and another took its place; why is in `log.jsonl`.
    inner_fallbacks: usize,
    /// High-water mark of this process [bytes], where the system tells.
    peak_memory_bytes: Option<u64>,
    /// Steps of this process in which slip ran away and came to rest.
    pub(super) arrested: usize,
    tolerances: [Tolerance; 2],
    fields_every: usize,
    /// When slip began, where the scene looks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    onset: Option<Vec<Value>>,
}

#[derive(Serialize)]
struct Sizes {
    nodes: usize,
    elements: usize,
    faces: usize,
    n_u: usize,
    n_t: usize,
    /// Pressures, where a fluid flows.
    #[serde(skip_serializing_if = "Option::is_none")]
    n_p: Option<usize>,
}

/// A dimensionless tolerance and what it is relative to.
#[derive(Serialize)]
struct Tolerance {
    name: &'static str,
    value: f64,
    relative_to: &'static str,
    /// That quantity now, where it is one for all faces.
    scale: Option<f64>,
    unit: &'static str,
}

impl<'a> Manifest<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        body: &Body,
        simulation: &Simulation<'_>,
        restarted_with: Option<usize>,
        fields_every: usize,
    ) -> Self {
        let sections = scene.sections();
        let solver = sections.solver.unwrap_or_default();
        Self {
            version: concat!("fracas ", env!("CARGO_PKG_VERSION")),
            title: scene.title(),
            outcome: Outcome::Running,
            reason: None,
            steps: 0,
            time_s: 0.0,
            restarted_with,
            sizes: Sizes {
                nodes: body.mesh.nodes.len(),
                elements: body.mesh.elements.len(),
                faces: body.fractures.faces.len(),
                n_u: body.constraints.free_len(),
                n_t: 3 * body.fractures.faces.len(),
                n_p: body.fluid.as_ref().map(|_| body.fractures.faces.len()),
            },
            time: sections.time.as_ref(),
            solver,
            preconditioner: simulation.preconditioner(),
            precision_fallbacks: simulation.precision_fallbacks(),
            inner_fallbacks: simulation.inner_fallbacks(),
            peak_memory_bytes: None,
            arrested: 0,
            tolerances: [
                Tolerance {
                    name: "tolerance",
                    value: solver.tolerance,
                    relative_to: "the largest force that loads or tractions had so far, as a Euclidean norm",
                    scale: None,
                    unit: "N",
                },
                Tolerance {
                    name: "state_tolerance",
                    value: solver.state_tolerance,
                    relative_to: "the largest traction that a face had so far, or that its normal jump would cost",
                    scale: None,
                    unit: "Pa",
                },
            ],
            fields_every,
            onset: body.onset.map(|_| Vec::new()),
        }
    }

    /// The file for a state and how the run stands in it; `begun` are the events of a step that failed from there.
    pub(super) fn text(
        &mut self,
        simulation: &Simulation<'_>,
        state: &State,
        (outcome, reason): (Outcome, Option<String>),
        begun: &[Event],
    ) -> Result<String, RunError> {
        (self.steps, self.time_s) = (state.step, state.time);
        (self.outcome, self.reason) = (outcome, reason);
        if let Some(told) = &mut self.onset {
            let found = simulation.onsets(state);
            *told = found
                .map(|(name, onset)| onsets::json(name, onset))
                .collect();
            told.extend(begun.iter().filter_map(|event| match event {
                Event::Onset { fracture, onset } => Some(onsets::json(fracture, onset)),
                _ => None,
            }));
        }
        self.preconditioner = simulation.preconditioner();
        self.precision_fallbacks = simulation.precision_fallbacks();
        self.inner_fallbacks = simulation.inner_fallbacks();
        self.peak_memory_bytes = memory::peak_bytes();
        self.tolerances[0].scale = Some(state.force);
        self.tolerances[1].scale = Some(state.traction);
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        Ok(text)
    }
}
