//! A solve as published counts are made: 𝒜 is assembled, the true residual ends the iteration, and nothing takes the place of what fails.

use super::measured::Run;
use super::outcome::Outcome;
use super::prepared::Prepared;
use super::product::Case;
use super::{Load, Study};
use anyhow::bail;
use fracas::matrix_free::{MatrixFreeSaddle, MatrixFreeSystem, RacpParts};
use fracas::memory;
use fracas::solve::{RightHandSide, Solve};
use fracas_operators::LinearOperator;
use fracas_operators::sparse::Csr;
use fracas_operators::vector::norm2;
use fracas_solvers::krylov::{Criteria, Narrowed, Outcome as Ended, System};
use fracas_solvers::saddle::{
    Cost, Elimination, Racp, RacpInverse, Ready, SaddleBlocks, SaddleMethod, SaddleOperator, T,
};
use fracas_solvers::{Observer, SetupError, Silent};
use std::sync::Arc;
use std::time::Instant;

/// Sets up, iterates and counts; gives how it ended, and why.
///
/// # Errors
/// Of the set-up.
pub(super) fn counted(
    case: &Case,
    settings: &Solve,
    prepared: &Prepared,
    study: &Study,
    watch: &mut dyn Observer,
) -> anyhow::Result<(Run, Outcome, Option<String>)> {
    let setting = &case.setting;
    let is_blind = setting.eliminate == Some(false);
    let is_single = setting.single == Some(true);
    let start = Instant::now();
    if setting.matrix_free == Some(true) || is_single {
        let racp = settings.method.matrix_free();
        let (Some(racp), Some((body, stuck))) = (racp, &prepared.body) else {
            bail!("only RACP around geometric multigrid of a scene does without an assembled A");
        };
        let system = body.stick_system(stuck.stabilization(body));
        let saddle = MatrixFreeSystem::new(&system, None)?.saddle;
        let own = saddle.rhs(&system, &body.forces()?);
        let ready: Ready = RacpParts::new(&racp, &saddle, &system, &mut Silent)?.into();
        let unit = saddle.unit();
        let single = match is_single {
            true => Some(MatrixFreeSaddle::in_traction_unit(&system, unit)?),
            false => None,
        };
        let equations = Equations {
            operator: &saddle,
            single: single.as_ref().map(|s| s as &dyn LinearOperator<f32>),
            x: vec![0.0; own.len()],
            rhs: right_hand_side(case, own),
            unit,
        };
        let n_u = prepared.blocks.n_u();
        return equations.solve(case, settings, (ready, start), n_u, (study, watch));
    }
    let (blocks, rhs, unit) = equations(case, prepared);
    let blocks = &*blocks;
    let ready = match settings.method {
        SaddleMethod::Racp(racp) if is_blind => blind(&racp, blocks)?,
        method => ready(&method, prepared, blocks)?,
    };
    // rows that determine their own traction are met from the start on
    let elimination = match settings.method {
        SaddleMethod::Racp(_) if !is_blind => Elimination::new(blocks),
        _ => None,
    };
    let zero = || vec![0.0; rhs.len()];
    let equations = Equations {
        operator: &SaddleOperator::new(blocks),
        single: None,
        x: elimination.map_or_else(zero, |e| e.start(&rhs)),
        rhs,
        unit,
    };
    equations.solve(case, settings, (ready, start), blocks.n_u(), (study, watch))
}

/// 𝒜 and b of a row, and their unit of tractions [Pa].
pub(super) fn equations(case: &Case, prepared: &Prepared) -> (Arc<SaddleBlocks>, Vec<f64>, f64) {
    let (blocks, unit) = prepared.balanced();
    let mut rhs = right_hand_side(case, blocks.rhs());
    if rhs != blocks.rhs() {
        let [rhs_t] = blocks.layout().split_mut([T], &mut rhs);
        // entries that are given by a rule are in the units of the rows
        let row_unit = if prepared.is_ours { 1.0 } else { unit };
        rhs_t.iter_mut().for_each(|b| *b *= row_unit);
    }
    (blocks, rhs, unit)
}

fn right_hand_side(case: &Case, own: Vec<f64>) -> Vec<f64> {
    let load = case.setting.rhs.as_ref().and_then(|rhs| rhs.value);
    let load = load.unwrap_or(Load::Known(RightHandSide::System));
    let entries = load.entries(own.len());
    entries.unwrap_or_else(|| load.known().entries(own))
}

/// 𝒜, in f32 as well where all is to be, b, the start, and the unit of tractions [Pa].
struct Equations<'a> {
    operator: &'a dyn LinearOperator<f64>,
    single: Option<&'a dyn LinearOperator<f32>>,
    rhs: Vec<f64>,
    x: Vec<f64>,
    unit: f64,
}

impl Equations<'_> {
    fn solve(
        self,
        case: &Case,
        settings: &Solve,
        (ready, start): (Ready, Instant),
        n_u: usize,
        (study, watch): (&Study, &mut dyn Observer),
    ) -> anyhow::Result<(Run, Outcome, Option<String>)> {
        let Ready {
            inverse,
            hierarchy,
            relaxation,
            ..
        } = ready;
        let limit = &study.limit;
        // repeated for the clock alone
        let repetitions = case
            .setting
            .repetitions
            .filter(|_| study.clock)
            .unwrap_or(1);
        let cost = Cost::new(self.operator, inverse.as_ref());
        let criteria = Criteria {
            relative_tolerance: settings.tolerance,
            max_iterations: limit.most(cost.c_app()),
        };
        let setup_s = start.elapsed().as_secs_f64();
        let asked = settings.krylov.unwrap_or_default();
        let krylov = asked.flexible_for(inverse.as_ref());
        let (mut solve_s, mut x, mut result) = (f64::INFINITY, Vec::new(), None);
        for _ in 0..repetitions {
            let start = Instant::now();
            x.clone_from(&self.x);
            result = Some(match self.single {
                None => {
                    let system = System {
                        operator: self.operator,
                        preconditioner: inverse.as_ref(),
                        rhs: &self.rhs,
                    };
                    krylov.method().solve(&system, &criteria, &mut x, watch)
                }
                Some(operator) => {
                    let Some(method) = krylov.own_method::<f32>() else {
                        bail!("{krylov} iterates in f64 alone");
                    };
                    // a power of two brings b near 1 and changes no digit
                    let size = norm2(&self.rhs).log2().round().exp2();
                    let b: Vec<f32> = self.rhs.iter().map(|b| (b / size) as f32).collect();
                    let system = System {
                        operator,
                        preconditioner: &Narrowed(inverse.as_ref()),
                        rhs: &b,
                    };
                    let mut single = vec![0.0_f32; b.len()];
                    let result = method.solve(&system, &criteria, &mut single, watch);
                    x = single.iter().map(|x| size * f64::from(*x)).collect();
                    result
                }
            });
            solve_s = solve_s.min(start.elapsed().as_secs_f64());
        }
        let (iterations, outcome, reason) = match result {
            None => bail!("`repetitions` is at least 1"),
            Some(Err(breakdown)) => (None, Outcome::Breakdown, Some(breakdown.to_string())),
            Some(Ok(report)) => {
                let (outcome, reason) = match report.outcome {
                    Ended::Converged => (Outcome::Converged, None),
                    Ended::IterationLimit => limit.met(criteria.max_iterations),
                    Ended::Stopped => limit.seconds_over(report.iterations),
                };
                let met = report.outcome == Ended::Converged;
                (met.then_some(report.iterations), outcome, reason)
            }
        };
        x[n_u..].iter_mut().for_each(|t| *t *= self.unit);
        let run = Run {
            iterations,
            cost: iterations.map(|n| cost.c_s(n, &krylov)),
            c_app: Some(cost.c_app()),
            setup_s,
            solve_s,
            memory: memory::peak_bytes(),
            hierarchy,
            relaxation,
            krylov: krylov.to_string(),
            ran: format!("{} {krylov}", settings.method),
            estimates: [None; 2],
            x,
        };
        Ok((run, outcome, reason))
    }
}

/// M⁻¹ from the assembled blocks; around geometric multigrid C, B and S̃_u come from the body.
fn ready(
    method: &SaddleMethod,
    prepared: &Prepared,
    blocks: &SaddleBlocks,
) -> anyhow::Result<Ready> {
    let (Some(racp), Some((body, stuck))) = (method.matrix_free(), &prepared.body) else {
        return Ok(method.ready(blocks)?);
    };
    let system = body.stick_system(stuck.stabilization(body));
    let saddle = MatrixFreeSystem::new(&system, None)?.saddle;
    Ok(RacpParts::new(&racp, &saddle, &system, &mut Silent)?.into())
}

/// RACP as if every row were a constraint: rows of slip and opening are augmented, too.
fn blind(racp: &Racp, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
    let direct = racp.inner.backend().solver()?;
    let c = racp.augmentation.compute(blocks, &*direct)?.matrix;
    let ready = racp.inner.prepare(blocks, &c)?;
    let mut inverse = RacpInverse::new(blocks.b1.clone(), c, ready.inverse);
    if let Some(h) = &blocks.h {
        inverse = inverse.relaxed(Box::new(Csr::new(h.clone())), racp.relaxation);
    }
    Ok(Ready {
        relaxation: inverse.relaxation(),
        inverse: Box::new(inverse),
        hierarchy: ready.hierarchy,
        parts: None,
    })
}
