//! Coupled runs of experiments: a scene from its first step to its last, and what its systems cost.

use crate::rates::{lost, median, to_eight_digits};
use crate::report::{Cell, Check, Table};
use fracas::nonlinear::{Accepted, FaceFields, Simulation};
use fracas::scene::{Body, Scene};
use fracas_solvers::Observer;

/// A body and its steps.
pub(crate) struct FlowRun {
    pub(crate) name: String,
    pub(crate) body: Body,
    pub(crate) steps: Vec<Accepted>,
    /// Fields of the faces after every step.
    pub(crate) fields: Vec<FaceFields>,
}

impl FlowRun {
    /// Runs a scene to its end.
    pub(crate) fn of(
        name: &str,
        scene: &Scene,
        observer: &mut dyn Observer,
    ) -> anyhow::Result<Self> {
        let body = scene.build()?;
        let (mut steps, mut fields) = (Vec::new(), Vec::new());
        let mut simulation = Simulation::new(&body)?;
        simulation.run(observer, |simulation, _, done| {
            steps.push(done.clone());
            fields.push(simulation.face_fields(&done.state));
        })?;
        drop(simulation);
        Ok(Self {
            name: name.to_owned(),
            body,
            steps,
            fields,
        })
    }

    /// Steps in which fluid flows.
    fn flowing(&self) -> impl Iterator<Item = &Accepted> {
        self.steps.iter().filter(|step| step.flow.is_some())
    }

    /// Iterations that a factor of 1e-8 takes, for every system with flow that was solved well enough to tell.
    fn iterations(&self) -> Vec<usize> {
        let systems = self.flowing().flat_map(|step| &step.linear);
        let told =
            systems.filter_map(|l| to_eight_digits(l.krylov, l.iterations, l.relative_residual));
        told.collect()
    }

    /// The median of [`iterations`](Self::iterations).
    pub(crate) fn median_iterations(&self) -> usize {
        median(self.iterations()).unwrap_or(0)
    }

    /// Newton steps per step, the median.
    pub(crate) fn newton(&self) -> usize {
        median(self.flowing().map(|s| s.record.newton_it).collect()).unwrap_or(0)
    }

    /// Volume lost over the whole run, over what came in.
    pub(crate) fn loss(&self) -> f64 {
        let flows = self.steps.iter().filter_map(|step| step.flow);
        lost(flows.map(|flow| [flow.injected, flow.error])).unwrap_or(f64::NAN)
    }

    fn faces(&self, state: usize) -> usize {
        let counts = self.steps.iter().map(|s| s.record.faces[state]);
        counts.max().unwrap_or(0)
    }

    /// A row of [`table`].
    pub(crate) fn row(&self, printed: &str) -> Vec<Cell> {
        let iterations = self.iterations();
        let rounds = self.flowing().map(|s| s.record.active_it).collect();
        vec![
            self.name.clone().into(),
            (3 * self.body.mesh.nodes.len()).into(),
            (3 * self.body.fractures.faces.len()).into(),
            self.body.fractures.faces.len().into(),
            printed.into(),
            self.flowing().count().into(),
            median(rounds).into(),
            self.newton().into(),
            self.median_iterations().into(),
            iterations.iter().max().copied().into(),
            self.faces(3).into(),
            self.faces(2).into(),
        ]
    }

    /// What holds for every run.
    pub(crate) fn checks(&self) -> Vec<Check> {
        let of = |claim: &str| format!("{}: {claim}", self.name);
        vec![
            Check::at_most(
                of("volume lost over the volume injected"),
                1e-10,
                self.loss(),
            ),
            Check::at_most(
                of("Krylov iterations per factor of 1e-8, the median"),
                25.0,
                self.median_iterations() as f64,
            ),
            Check::at_most(
                of("Newton steps of a step, the median"),
                6.0,
                self.newton() as f64,
            ),
        ]
    }
}

/// A row per run.
pub(crate) fn table(id: &str, caption: &str) -> Table {
    Table::new(
        id,
        caption,
        &[
            "mesh",
            "n_u",
            "n_t",
            "n_p",
            "printed n_u + n_t + n_p",
            "steps",
            "n_it active set, median",
            "n_it Newton, median",
            "n_it Krylov to 1e-8, median",
            "n_it Krylov to 1e-8, most",
            "most open faces",
            "most slipping faces",
        ],
    )
}
