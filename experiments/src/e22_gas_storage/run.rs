//! A run from primary production to storage.

use fracas::nonlinear::{EnergyRecord, FaceFields, FaultRecord, Simulation, StepRecord};
use fracas::scene::{Body, Scene};
use fracas_solvers::Observer;

/// Seconds of a year.
const YEAR: f64 = 365.25 * 86400.0;

/// What the field is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Initial,
    Production,
    Cushion,
    Storage,
}

impl Stage {
    /// Of the step that ends in a year.
    fn of(year: f64) -> Self {
        match year {
            y if y < 0.5 => Self::Initial,
            y if y < 10.5 => Self::Production,
            y if y < 12.5 => Self::Cushion,
            _ => Self::Storage,
        }
    }

    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::Initial => "initial",
            Self::Production => "production",
            Self::Cushion => "cushion gas",
            Self::Storage => "storage",
        }
    }
}

/// What a step did.
pub(super) struct Year {
    /// Time at its end [year].
    pub(super) time: f64,
    pub(super) stage: Stage,
    pub(super) faults: Vec<FaultRecord>,
    pub(super) energy: EnergyRecord,
    pub(super) record: StepRecord,
    pub(super) fields: FaceFields,
    /// Mean slip of the central fault along its dip [mm].
    pub(super) dip_slip: f64,
}

impl Year {
    /// Moment of the step on the central fault, the first of the scene.
    pub(super) fn moment_step(&self) -> f64 {
        self.faults.first().map_or(0.0, |f| f.moment_step)
    }

    /// The same on all of them.
    pub(super) fn all_moment_step(&self) -> f64 {
        self.faults.iter().map(|f| f.moment_step).sum()
    }
}

/// A variation from its first step to its last.
pub(super) struct Run {
    pub(super) name: String,
    pub(super) body: Body,
    pub(super) years: Vec<Year>,
}

impl Run {
    pub(super) fn of(
        name: &str,
        scene: &Scene,
        observer: &mut dyn Observer,
    ) -> anyhow::Result<Self> {
        let body = scene.build()?;
        let mut years = Vec::new();
        let mut simulation = Simulation::new(&body)?;
        simulation.run(observer, |simulation, before, done| {
            let after = &done.state;
            let time = after.time / YEAR;
            years.push(Year {
                time,
                stage: Stage::of(time),
                faults: simulation.faults(before, after),
                energy: simulation.energy(before, after),
                record: done.record,
                fields: simulation.face_fields(after),
                dip_slip: dip_slip(simulation.problem().body(), &after.slip),
            });
        })?;
        drop(simulation);
        let name = name.into();
        Ok(Self { name, body, years })
    }

    fn in_stage(&self, stage: Stage) -> impl Iterator<Item = &Year> {
        self.years.iter().filter(move |y| y.stage == stage)
    }

    pub(super) fn largest(&self, stage: Stage, of: impl Fn(&Year) -> f64) -> f64 {
        self.in_stage(stage).map(of).fold(0.0, f64::max)
    }

    pub(super) fn sum(&self, stage: Stage, of: impl Fn(&Year) -> f64) -> f64 {
        self.in_stage(stage).map(of).sum()
    }

    /// Mean dip slip of the central fault at the end of a stage [mm].
    pub(super) fn end(&self, stage: Stage) -> f64 {
        self.in_stage(stage).last().map_or(0.0, |y| y.dip_slip)
    }

    /// Moment of all faults at the end of a stage [N m].
    pub(super) fn moment(&self, stage: Stage) -> f64 {
        let last = self.in_stage(stage).last();
        last.map_or(0.0, |y| y.faults.iter().map(|f| f.moment).sum())
    }

    pub(super) fn slip_max(&self) -> f64 {
        self.years
            .iter()
            .map(|y| y.record.slip_max)
            .fold(0.0, f64::max)
    }

    /// Time of the first year in which a face slips; infinite where none does.
    pub(super) fn first_slip(&self) -> f64 {
        let slips = |y: &&Year| y.time > 0.5 && y.all_moment_step() > 0.0;
        self.years
            .iter()
            .find(slips)
            .map_or(f64::INFINITY, |y| y.time)
    }

    /// Energy that creep dissipates in all [J].
    pub(super) fn crept(&self) -> f64 {
        self.years.iter().map(|y| y.energy.creep_dissipation).sum()
    }

    pub(super) fn least_creep(&self) -> f64 {
        let each = self.years.iter().map(|y| y.energy.creep_dissipation);
        each.fold(f64::INFINITY, f64::min)
    }

    pub(super) fn dissipated(&self) -> f64 {
        self.years.iter().map(|y| y.energy.dissipation).sum()
    }

    /// Largest error of the balance over the largest work of a step.
    pub(super) fn imbalance(&self) -> f64 {
        let most = |of: fn(&Year) -> f64| self.years.iter().map(of).fold(0.0, f64::max);
        most(|y| y.energy.error.abs()) / most(|y| y.energy.external_work.abs())
    }

    /// Preconditioners built per step.
    pub(super) fn setups(&self) -> f64 {
        let built: usize = self.years.iter().map(|y| y.record.setups).sum();
        built as f64 / self.years.len() as f64
    }
}

/// Area-weighted mean of γ·e_z over the first fracture [mm].
fn dip_slip(body: &Body, slip: &[f64]) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (face, own) in body.fractures.faces.iter().zip(slip.chunks_exact(2)) {
        if face.fracture == 0 {
            sum += face.area * (own[0] * face.frame[1][2] + own[1] * face.frame[2][2]);
            area += face.area;
        }
    }
    1e3 * sum / area
}
