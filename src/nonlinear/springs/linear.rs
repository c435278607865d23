//! The linear systems of rock and springs: a preconditioner for as long as it serves.

use super::law::Spring;
use super::operator::SpringJacobian;
use crate::mesh::FractureFace;
use crate::nonlinear::assembled::Assembled;
use crate::nonlinear::kept::{Kept, Ready};
use crate::nonlinear::krylov::{self, Asked, Ended, Solved, small_eigenvalue};
use crate::nonlinear::workspace::Resources;
use crate::nonlinear::{ContactProblem, LinearFailure, Prepared};
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::Observer;
use fracas_solvers::krylov::{Cg, KrylovChoice, System, least};
use fracas_solvers::saddle::{
    AugmentationMatrix, Block, EnergyNorms, InnerChoice, Racp, SaddleBlocks, TRUSTED,
};

/// Iterations after which a preconditioner that was made for other springs is made anew. Unit: 1.
const PATIENCE: usize = 40;

/// Solves tangents with S̃⁻¹ of `S = A + B C⁻¹Bᵀ`, `C = A_f K̃⁻¹` and K̃ the symmetric part of K in the springs of some step.
///
/// With stiff springs S of one contact state says little of another one.
pub(in crate::nonlinear) struct SpringLinear {
    /// As chosen, and as they were set up.
    chosen: Racp,
    settings: Racp,
    max_krylov: usize,
    blocks: Option<SaddleBlocks>,
    assembled: Assembled,
    kept: Kept,
    /// The settings have been set up before.
    served: bool,
    /// Ritz value nearest to zero of the systems since the preconditioner or the states of springs changed: one of them alone may take
    /// too few iterations to see it.
    smallest_ritz: Option<f64>,
    /// Smaller ones have been looked for.
    probed: bool,
}

impl SpringLinear {
    pub(in crate::nonlinear) fn new(settings: Racp, max_krylov: usize) -> Self {
        Self {
            chosen: settings,
            settings,
            max_krylov,
            blocks: None,
            assembled: Assembled::default(),
            kept: Kept::default(),
            served: false,
            smallest_ritz: None,
            probed: false,
        }
    }

    /// A is another one.
    pub(super) fn forget(&mut self) {
        *self = Self::new(self.chosen, self.max_krylov);
    }

    /// A step begins, with the preconditioner that was kept for it.
    pub(super) fn begin_step(&mut self, prepared: Option<&Prepared>) {
        self.other_springs();
        self.kept.begin_step(prepared);
    }

    /// Systems are those of springs in other states from now on.
    pub(super) fn other_springs(&mut self) {
        (self.smallest_ritz, self.probed) = (None, false);
    }

    /// What the preconditioner to keep was made for.
    pub(super) fn carried(&self) -> Option<Prepared> {
        self.kept.carried()
    }

    /// Gives up a preconditioner that was made for other springs than these; false where it was made for them.
    pub(super) fn renews(
        &mut self,
        problem: &ContactProblem<'_>,
        (springs, stiffness): (&[Spring], &[f64]),
    ) -> bool {
        let wanted = wanted(problem, springs, stiffness).c;
        let given_up = self.kept.ready.take_if(|ready| ready.of.c != wanted);
        if given_up.is_some() {
            self.other_springs();
        }
        given_up.is_some()
    }

    /// `x ← J⁻¹ b` to a relative residual; CG where J is symmetric.
    pub(in crate::nonlinear) fn solve(
        &mut self,
        problem: &ContactProblem<'_>,
        (springs, stiffness): (&[Spring], &[f64]),
        rhs: &[f64],
        tolerance: f64,
        x: &mut [f64],
        (resources, observer): (&mut Resources, &mut dyn Observer),
    ) -> Result<Solved, LinearFailure> {
        let jacobian = jacobian(problem, springs);
        let symmetric = springs.iter().all(Spring::is_symmetric);
        if let Some(pending) = self.kept.pending.take() {
            self.kept.ready = Some(self.prepare(problem, pending, stiffness, resources)?);
        }
        let short = symmetric.then_some(KrylovChoice::Cg(Cg {}));
        let (mut spent, mut fresh) = (0, false);
        loop {
            let (ready, made) = match self.kept.ready.take() {
                Some(ready) => (ready, fresh),
                None => {
                    let of = wanted(problem, springs, stiffness);
                    (self.prepare(problem, of, stiffness, resources)?, true)
                }
            };
            let system = System {
                operator: &jacobian,
                preconditioner: ready.inverse.as_ref(),
                rhs,
            };
            let available = resources.work.available();
            let next = (resources.fallbacks).without_stagnation(problem, self.settings, available);
            let asked = Asked {
                short,
                tolerance,
                max_iterations: self.max_krylov,
                patience: (!made).then_some(PATIENCE),
                gives_way: made && next.is_some(),
            };
            x.fill(0.0);
            match krylov::solve(&system, asked, x, observer, &mut resources.work)? {
                Ended::Dropped { iterations } => spent += iterations,
                Ended::Stalled(stalled) => {
                    spent += stalled.iterations;
                    let Some(next) = next else {
                        unreachable!("gives way to nothing");
                    };
                    let before = std::mem::replace(&mut self.settings, next);
                    let reason = stalled.reason(before.inner);
                    resources.fallbacks.give_way(before, next, reason);
                    (self.chosen, self.served, fresh) = (next, false, true);
                    match self.prepare(problem, ready.of.clone(), stiffness, resources) {
                        Ok(other) => self.kept.ready = Some(other),
                        Err(_) => {
                            // it goes on to its limit
                            (self.chosen, self.settings) = (before, before);
                            self.kept.ready = Some(ready);
                            resources.fallbacks.take_back(before);
                        }
                    }
                    self.other_springs();
                }
                Ended::Solved(solved) => {
                    self.kept.ready = Some(ready);
                    if made {
                        self.other_springs();
                    }
                    self.smallest_ritz = least([self.smallest_ritz, solved.smallest_ritz]);
                    return Ok(Solved {
                        iterations: spent + solved.iterations,
                        setup: made,
                        ..solved
                    });
                }
            }
        }
    }

    /// `e_u ← S̃⁻¹ r`, an estimate of the error that leaves the residual r, with `e_t = D Bᵀ e_u`; and the Ritz value nearest to zero
    /// that was seen, by a [look](small_eigenvalue), too, where S̃ is of one level.
    ///
    /// Where that value θ is small, as near a load at which slip runs away, `e_u = J⁻¹ r` to a relative residual of θ/10, which is worth
    /// less than a tenth of S̃⁻¹r; the value is 1 then.
    pub(super) fn error_of(
        &mut self,
        problem: &ContactProblem<'_>,
        (springs, stiffness): (&[Spring], &[f64]),
        (residual, norms): (&[f64], &EnergyNorms<'_>),
        (resources, observer): (&mut Resources, &mut dyn Observer),
    ) -> Result<(Vec<f64>, Option<f64>), LinearFailure> {
        let ready = match self.kept.ready.take() {
            Some(ready) => ready,
            None => {
                let of = wanted(problem, springs, stiffness);
                let of = self.kept.pending.take().unwrap_or(of);
                self.prepare(problem, of, stiffness, resources)?
            }
        };
        let ready = self.kept.ready.insert(ready);
        let jacobian = jacobian(problem, springs);
        let mut e = vec![0.0; residual.len() + 3 * springs.len()];
        let (u, t) = e.split_at_mut(residual.len());
        let scratch = ready
            .inverse
            .work_len()
            .max(LinearOperator::work_len(&jacobian));
        let mut work = vec![0.0; scratch];
        ready.inverse.solve(residual, u, &mut work);
        jacobian.tractions(u, t, &mut work);
        if !self.probed {
            let inverse = ready.inverse.as_ref();
            let system = System {
                operator: &jacobian,
                preconditioner: inverse,
                rhs: residual,
            };
            let found = small_eigenvalue(&system, norms, observer);
            self.smallest_ritz = least([self.smallest_ritz, found]);
            self.probed = true;
        }
        if let Some(ritz) = self.smallest_ritz.filter(|ritz| *ritz < TRUSTED) {
            let system = System {
                operator: &jacobian,
                preconditioner: ready.inverse.as_ref(),
                rhs: residual,
            };
            let asked = Asked {
                short: None,
                tolerance: TRUSTED * ritz.abs().max(f64::EPSILON),
                max_iterations: self.max_krylov,
                patience: None,
                gives_way: false,
            };
            let mut solved = vec![0.0; u.len()];
            let ended = krylov::solve(&system, asked, &mut solved, observer, &mut resources.work);
            if let Ok(Ended::Solved(found)) = ended
                && found.relative_residual <= asked.tolerance
            {
                u.copy_from_slice(&solved);
                jacobian.tractions(u, t, &mut work);
                return Ok((e, Some(1.0)));
            }
        }
        Ok((e, self.smallest_ritz))
    }

    /// S̃⁻¹ with this C.
    fn prepare(
        &mut self,
        problem: &ContactProblem<'_>,
        of: Prepared,
        stiffness: &[f64],
        resources: &mut Resources,
    ) -> Result<Ready, LinearFailure> {
        let mut settings = self.settings;
        let mut left = resources.fallbacks.others(problem, settings).into_iter();
        let inverse = loop {
            match self.inverse(problem, settings, &of.c, stiffness, resources) {
                Ok(inverse) => break inverse,
                Err(failure) => {
                    let tried = (self.settings, self.served);
                    settings = resources.fallbacks.instead(&mut left, tried, failure)?
                }
            }
        };
        if !std::mem::replace(&mut self.served, true) {
            // what cannot be set up at first is not tried again
            self.settings = settings;
        }
        Ok(Ready { of, inverse })
    }

    /// S̃⁻¹ with this C by these settings.
    fn inverse(
        &mut self,
        problem: &ContactProblem<'_>,
        racp: Racp,
        c: &[Block],
        stiffness: &[f64],
        resources: &mut Resources,
    ) -> Result<Box<dyn Preconditioner<f64>>, LinearFailure> {
        let matrix = AugmentationMatrix::from_face_blocks(c.to_vec())?;
        Ok(match racp.inner {
            InnerChoice::Geometric(geometric) => {
                Box::new(resources.fallbacks.build(problem, geometric, &matrix)?)
            }
            inner => {
                let blocks = match &mut self.blocks {
                    Some(blocks) => blocks,
                    none => none.insert(problem.stick_blocks()?),
                };
                let fallbacks = &mut resources.fallbacks;
                if self.assembled.plans(inner) {
                    let stuck: Vec<Spring> = stiffness.iter().map(|k| Spring::stuck(*k)).collect();
                    let stick = wanted(problem, &stuck, stiffness).c;
                    if stick != c {
                        // a restart, which begins with other springs, finds the same plan; where that fails the build below plans
                        let stick = AugmentationMatrix::from_face_blocks(stick)?;
                        let _ = self.assembled.build(inner, blocks, &stick, fallbacks);
                    }
                }
                self.assembled.build(inner, blocks, &matrix, fallbacks)?
            }
        })
    }
}

/// What a preconditioner for these springs is made for: C of their compliances times the areas.
fn wanted(problem: &ContactProblem<'_>, springs: &[Spring], stiffness: &[f64]) -> Prepared {
    let faces = problem.faces().iter().zip(problem.compliance());
    let block = |((face, omega), (spring, kappa)): ((&FractureFace, &f64), (&Spring, &f64))| {
        spring
            .compliance(*kappa, *omega)
            .map(|row| row.map(|v| face.area * v))
    };
    Prepared {
        states: springs.iter().map(|s| s.state).collect(),
        c: faces
            .zip(springs.iter().zip(stiffness))
            .map(block)
            .collect(),
    }
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
