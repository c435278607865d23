//! The linear systems of rock and springs: a preconditioner for as long as it serves.

use super::law::Spring;
use super::operator::SpringJacobian;
use crate::contact::ContactState;
use crate::matrix_free::MatrixFreeError;
use crate::mesh::FractureFace;
use crate::nonlinear::linear::{Solved, USEFUL};
use crate::nonlinear::{ContactProblem, LinearFailure, RunPreconditioner};
use fracas_operators::Preconditioner;
use fracas_solvers::Observer;
use fracas_solvers::krylov::{Breakdown, Cg, Criteria, KrylovChoice, Outcome, Report, System};
use fracas_solvers::saddle::{AugmentationMatrix, SaddleBlocks};

/// Iterations after which a preconditioner that was made for other springs is made anew. Unit: 1.
const PATIENCE: usize = 40;

/// A preconditioner and the states of the springs that it was made for.
struct Ready {
    states: Vec<ContactState>,
    inverse: Box<dyn Preconditioner<f64>>,
}

/// Solves tangents with S̃⁻¹ of `S = A + B C⁻¹Bᵀ`, `C = A_f K̃⁻¹` and K̃ the symmetric part of K in the springs of some step.
///
/// With stiff springs S of one contact state says little of another one.
pub(super) struct SpringLinear {
    settings: RunPreconditioner,
    max_krylov: usize,
    blocks: Option<SaddleBlocks>,
    ready: Option<Ready>,
    /// States of a preconditioner that a restart has to make again.
    owed: Option<Vec<ContactState>>,
    work: Vec<f64>,
}

impl SpringLinear {
    pub(super) fn new(settings: RunPreconditioner, max_krylov: usize) -> Self {
        Self {
            settings,
            max_krylov,
            blocks: None,
            ready: None,
            owed: None,
            work: Vec::new(),
        }
    }

    /// A step begins. What is kept from the step before is what a restart can make again: slip depends on its direction,
    /// stick and open faces on their states alone.
    pub(super) fn begin_step(&mut self, prepared: Option<&Vec<ContactState>>) {
        self.owed = None;
        if self.ready.as_ref().map(|ready| &ready.states) != prepared {
            self.ready = None;
            self.owed = prepared.cloned();
        }
    }

    /// The states of the preconditioner to keep.
    pub(super) fn carried(&self) -> Option<Vec<ContactState>> {
        let states = self.ready.as_ref().map(|ready| &ready.states);
        let kept = states.filter(|states| !states.contains(&ContactState::Slip));
        kept.cloned()
    }

    /// `x ← J⁻¹ b` to a relative residual; CG where J is symmetric.
    pub(super) fn solve(
        &mut self,
        problem: &ContactProblem<'_>,
        (springs, stiffness): (&[Spring], &[f64]),
        rhs: &[f64],
        tolerance: f64,
        x: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<Solved, LinearFailure> {
        let jacobian = jacobian(problem, springs);
        let symmetric = springs.iter().all(|s| s.state != ContactState::Slip);
        if let Some(owed) = self.owed.take() {
            let held: Vec<Spring> = owed.iter().map(|s| Spring::held(*s)).collect();
            self.ready = Some(self.prepare(problem, &held, stiffness)?);
        }
        let mut spent = 0;
        let mut made = false;
        loop {
            let ready = match self.ready.take() {
                Some(ready) => ready,
                None => {
                    made = true;
                    self.prepare(problem, springs, stiffness)?
                }
            };
            let limit = if made { self.max_krylov } else { PATIENCE };
            let system = System {
                operator: &jacobian,
                preconditioner: ready.inverse.as_ref(),
                rhs,
            };
            let criteria = Criteria {
                relative_tolerance: tolerance,
                max_iterations: limit.min(self.max_krylov),
            };
            let tried = run(&system, symmetric, &criteria, x, observer, &mut self.work);
            let (krylov, solved) = match tried {
                // short recurrences may end early where GMRES does not
                (_, Err(breakdown)) if symmetric && made => {
                    spent += breakdown.iteration();
                    run(&system, false, &criteria, x, observer, &mut self.work)
                }
                tried => tried,
            };
            let (iterations, relative_residual, outcome) = match solved {
                Ok(r) => (r.iterations, r.relative_residual, r.outcome),
                Err(Breakdown::Stagnation {
                    iteration,
                    relative_residual,
                    ..
                }) if made && relative_residual <= USEFUL => {
                    (iteration, relative_residual, Outcome::Converged)
                }
                Err(breakdown) if made => return Err(breakdown.into()),
                // the springs of another state are no reason to give up
                Err(breakdown) => {
                    spent += breakdown.iteration();
                    continue;
                }
            };
            spent += iterations;
            if outcome == Outcome::IterationLimit {
                if made {
                    return Err(LinearFailure::IterationLimit {
                        krylov,
                        iterations,
                        residual: relative_residual,
                        tolerance,
                    });
                }
                continue;
            }
            self.ready = Some(ready);
            return Ok(Solved {
                krylov,
                iterations: spent,
                relative_residual,
                stopped: outcome == Outcome::Stopped,
                setup: made,
            });
        }
    }

    /// S̃⁻¹ for these springs.
    fn prepare(
        &mut self,
        problem: &ContactProblem<'_>,
        springs: &[Spring],
        stiffness: &[f64],
    ) -> Result<Ready, LinearFailure> {
        let faces = problem.faces().iter().zip(problem.compliance());
        let block = |((face, omega), (spring, kappa)): ((&FractureFace, &f64), (&Spring, &f64))| {
            spring
                .compliance(*kappa, *omega)
                .map(|row| row.map(|v| face.area * v))
        };
        let c = faces
            .zip(springs.iter().zip(stiffness))
            .map(block)
            .collect();
        let c = AugmentationMatrix::from_face_blocks(c)?;
        let inverse = match self.settings {
            RunPreconditioner::Assembled(racp) => {
                let blocks = match &mut self.blocks {
                    Some(blocks) => blocks,
                    none => none.insert(problem.stick_blocks()?),
                };
                racp.inner.prepare(blocks, &c)?.inverse
            }
            RunPreconditioner::MatrixFree(racp) => {
                let built = racp.inner.build(&problem.stick_system(), &c);
                Box::new(built.map_err(MatrixFreeError::from)?)
            }
        };
        Ok(Ready {
            states: springs.iter().map(|s| s.state).collect(),
            inverse,
        })
    }
}

/// CG or GMRES from zero.
fn run(
    system: &System<'_, f64>,
    symmetric: bool,
    criteria: &Criteria,
    x: &mut [f64],
    observer: &mut dyn Observer,
    work: &mut Vec<f64>,
) -> (&'static str, Result<Report, Breakdown>) {
    let m = system.preconditioner;
    let krylov = match symmetric && m.is_linear() && !m.is_single() {
        true => KrylovChoice::Cg(Cg {}),
        false => KrylovChoice::default(),
    }
    .flexible_for(m);
    let method = krylov.method::<f64>();
    let needed = method.work_len(system, criteria);
    if work.len() < needed {
        work.resize(needed, 0.0);
    }
    x.fill(0.0);
    let solved = method.solve_in(system, criteria, x, observer, &mut work[..needed]);
    (krylov.name(), solved)
}

/// The tangent of springs.
fn jacobian<'p>(problem: &'p ContactProblem<'_>, springs: &[Spring]) -> SpringJacobian<'p> {
    let saddle = problem.saddle();
    let s2 = saddle.unit() * saddle.unit();
    let faces = problem.faces().iter().zip(springs);
    SpringJacobian {
        a: saddle.stiffness(),
        b: saddle.coupling(),
        faces: faces
            .map(|(face, spring)| spring.tangent.map(|row| row.map(|k| k / (face.area * s2))))
            .collect(),
    }
}
