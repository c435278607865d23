//! A solve as published counts are made: 𝒜 is assembled, the true residual ends the iteration, and nothing takes the place of what fails.

use super::measured::Run;
use super::outcome::Outcome;
use super::prepared::Prepared;
use super::product::Case;
use super::{Limit, Load};
use fracas::matrix_free::{MatrixFreeSystem, RacpParts};
use fracas::memory;
use fracas::solve::{RightHandSide, Solve};
use fracas_operators::sparse::Csr;
use fracas_solvers::krylov::{Criteria, Outcome as Ended, System};
use fracas_solvers::saddle::{
    Cost, Elimination, Iterated, Racp, RacpInverse, Ready, SaddleBlocks, SaddleMethod,
    SaddleOperator,
};
use fracas_solvers::{Observer, SetupError, Silent};
use std::time::Instant;

/// Sets up, iterates and counts; gives how it ended, and why.
///
/// # Errors
/// Of the set-up.
pub(super) fn counted(
    case: &Case,
    settings: &Solve,
    prepared: &Prepared,
    limit: &Limit,
    watch: &mut dyn Observer,
) -> anyhow::Result<(Run, Outcome, Option<String>)> {
    let blocks = &*prepared.balanced();
    let start = Instant::now();
    let is_blind = case.setting.eliminate == Some(false);
    let ready = match settings.method {
        SaddleMethod::Racp(racp) if is_blind => blind(&racp, blocks)?,
        method => ready(&method, prepared, blocks)?,
    };
    let setup_s = start.elapsed().as_secs_f64();
    let inverse = ready.inverse.as_ref();
    let operator = SaddleOperator::new(blocks);
    let c_app = Cost::new(&operator, inverse).c_app();
    let criteria = Criteria {
        relative_tolerance: settings.tolerance,
        max_iterations: limit.most(c_app),
    };
    let load = case.setting.rhs.as_ref().and_then(|rhs| rhs.value);
    let load = load.unwrap_or(Load::Known(RightHandSide::System));
    let own = || load.known().entries(blocks.rhs());
    let rhs = load.entries(blocks.size()).unwrap_or_else(own);
    // rows that determine their own traction are met from the start on
    let elimination = match settings.method {
        SaddleMethod::Racp(_) if !is_blind => Elimination::new(blocks),
        _ => None,
    };
    let zero = || vec![0.0; rhs.len()];
    let mut x = elimination.map_or_else(zero, |e| e.start(&rhs));
    let system = System {
        operator: &operator,
        preconditioner: inverse,
        rhs: &rhs,
    };
    let krylov = settings.krylov.unwrap_or_default();
    let iterated = Iterated::new(&system, krylov, &criteria, &mut x, watch);
    let (outcome, reason) = match &iterated.result {
        Err(breakdown) => (Outcome::Breakdown, Some(breakdown.to_string())),
        Ok(report) => match report.outcome {
            Ended::Converged => (Outcome::Converged, None),
            Ended::IterationLimit => limit.met(criteria.max_iterations),
            Ended::Stopped => limit.seconds_over(report.iterations),
        },
    };
    let run = Run {
        iterations: iterated.iterations(),
        cost: iterated.c_s(),
        c_app: Some(c_app),
        setup_s,
        solve_s: iterated.solve_s,
        memory: memory::peak_bytes(),
        hierarchy: ready.hierarchy,
        relaxation: ready.relaxation,
        krylov: iterated.krylov.to_string(),
        ran: format!("{} {}", settings.method, iterated.krylov),
        estimates: [None; 2],
        x,
    };
    Ok((run, outcome, reason))
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
