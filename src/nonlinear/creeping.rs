//! Rock that creeps, within the steps of a run.

use super::simulation::Simulation;
use super::times::{SAME_TIME, Target};
use super::{ContactProblem, Failure, LinearFailure, Load, State};
use crate::creep::CreepingRock;
use crate::elasticity::loads::Voigt;
use crate::elasticity::{Elastic, ElasticityError};
use crate::scene::Body;

/// What a body that creeps remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct CreepState {
    /// Length of the step that A was last made for [s]; 0 where rock is elastic.
    pub step: f64,
    /// ε_v per integration point of the elements that creep, eight per element. Unit: 1.
    pub strain: Vec<Voigt>,
}

/// The creeping rock of a problem and what A is made of.
pub(super) struct Creeping<'a> {
    rock: CreepingRock<'a>,
    /// Elastic constants of the step at hand, per region.
    pub(super) materials: Vec<Elastic>,
    /// Its length [s].
    step: f64,
}

impl<'a> Creeping<'a> {
    /// `None` for a body that does not creep.
    pub(super) fn new(body: &'a Body) -> Result<Option<Self>, ElasticityError> {
        let rock = CreepingRock::new(&body.mesh, &body.materials, &body.viscosities, body)?;
        Ok(rock.map(|rock| Self {
            materials: rock.materials_in(0.0),
            step: 0.0,
            rock,
        }))
    }

    /// Nothing has crept yet.
    pub(super) fn initial(&self) -> CreepState {
        CreepState {
            step: 0.0,
            strain: vec![[0.0; 6]; self.rock.points()],
        }
    }
}

impl<'a> ContactProblem<'a> {
    /// The rock that creeps, where any does.
    pub fn creeping_rock(&self) -> Option<&CreepingRock<'a>> {
        self.creep.as_ref().map(|creep| &creep.rock)
    }

    /// A and what loads do through it become those of steps of `step` seconds; true where they were others.
    ///
    /// # Errors
    /// [`ElasticityError`] of the mesh.
    pub fn take_step(&mut self, step: f64) -> Result<bool, ElasticityError> {
        let Some(creep) = self.creep.as_mut().filter(|creep| creep.step != step) else {
            return Ok(false);
        };
        creep.materials = creep.rock.materials_in(step);
        creep.step = step;
        self.make_stiffness()?;
        Ok(true)
    }

    /// Nothing has crept yet; `None` where no rock creeps.
    pub(super) fn uncrept(&self) -> Option<Box<CreepState>> {
        (self.creep.as_ref()).map(|creep| Box::new(creep.initial()))
    }

    /// What the elements that creep remember at the start of the step at hand, as a load.
    pub(super) fn remember(&self, state: &State, u: &[f64], load: &mut Load) {
        if let (Some(creep), Some(own)) = (&self.creep, &state.creep) {
            let force = creep.rock.history(creep.step, u, &own.strain);
            let free = self.body().constraints.free();
            (load.force.iter_mut().zip(free)).for_each(|(f, dof)| *f += force[*dof as usize]);
        }
    }

    /// What they remember at its end.
    pub(super) fn crept(&self, state: &State, u: [&[f64]; 2]) -> Option<Box<CreepState>> {
        let (creep, own) = (self.creep.as_ref()?, state.creep.as_ref()?);
        Some(Box::new(CreepState {
            step: creep.step,
            strain: creep.rock.advanced(creep.step, u, &own.strain),
        }))
    }
}

/// Length of a step from a state [s]: that of the step before where they differ by rounding, so that A serves both.
pub(super) fn step_from(state: &State, target: Target) -> f64 {
    let step = target.time - state.time;
    match &state.creep {
        Some(own) if (step - own.step).abs() <= SAME_TIME * step => own.step,
        _ => step,
    }
}

/// What creep adds to the energy of a step.
#[derive(Default)]
pub(super) struct CreepEnergy {
    /// Forces beyond `A u` at both ends [N].
    pub(super) force: [Option<Vec<f64>>; 2],
    /// Elastic energies beyond `½ uᵀA u` at both ends [J].
    pub(super) elastic: [f64; 2],
    /// Taken and dissipated [J].
    pub(super) work: [f64; 2],
}

impl Simulation<'_> {
    /// A and what was made of it become those of steps of `step` seconds: one set-up per change.
    pub(super) fn take_step(&mut self, step: f64) -> Result<(), Failure> {
        if self.problem.take_step(step).map_err(LinearFailure::from)? {
            match &mut self.springs {
                Some(springs) => springs.forget(),
                None => self.linear.forget(&self.problem),
            }
        }
        Ok(())
    }

    /// What creep has taken from the mean stress of elements, `−2G ε_v` [Pa].
    pub fn relaxed(&self, state: &State) -> Vec<(usize, Voigt)> {
        match (self.problem.creeping_rock(), &state.creep) {
            (Some(rock), Some(own)) => rock.relaxed(&own.strain).collect(),
            _ => Vec::new(),
        }
    }

    /// Of the step from one state to another, whose displacements are `u`.
    pub(super) fn creep_energy(&self, states: [&State; 2], u: [&[f64]; 2]) -> CreepEnergy {
        let (Some(creep), [Some(from), Some(to)]) = (
            &self.problem().creep,
            states.map(|state| state.creep.as_ref()),
        ) else {
            return CreepEnergy::default();
        };
        let strain = [&from.strain[..], &to.strain];
        let [a, b] = [0, 1].map(|k| creep.rock.beyond(creep.step, u[k], strain[k]));
        CreepEnergy {
            force: [Some(a.force), Some(b.force)],
            elastic: [a.energy, b.energy],
            work: creep.rock.work(to.step, u, strain),
        }
    }
}
