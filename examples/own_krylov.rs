//! A Krylov method of one's own on the house's bookkeeping: generalized conjugate residuals, the true residual checked at the end.
//!
//! `cargo run --release --example own_krylov`

use fracas::scene::named;
use fracas_operators::vector::{axpy, dot, norm2};
use fracas_solvers::Silent;
use fracas_solvers::krylov::run::{End, Run, carve, drive, work_len};
use fracas_solvers::krylov::{
    Breakdown, Criteria, CustomKrylov, KrylovChoice, KrylovMethod, Outcome, Report, System, Watch,
};
use fracas_solvers::saddle::{SaddleMethod, SaddleOperator};

/// Steps before the directions are thrown away.
const RESTART: usize = 20;

/// Generalized conjugate residuals: directions p with orthonormal `q = A p`, `x ← x + (q·r) p`.
#[derive(Debug)]
struct ConjugateResiduals;

impl KrylovMethod<f64> for ConjugateResiduals {
    fn name(&self) -> &'static str {
        "conjugate_residuals"
    }

    fn work_len(&self, system: &System<f64>, _: &Criteria) -> usize {
        work_len(system, 2 * RESTART)
    }

    fn solve_in(
        &self,
        system: &System<f64>,
        criteria: &Criteria,
        x: &mut [f64],
        watch: Watch<'_, f64>,
        work: &mut [f64],
    ) -> Result<Report, Breakdown> {
        drive(self.name(), system, criteria, x, watch, work, cycle)
    }
}

fn cycle(
    run: &mut Run<f64>,
    x: &mut [f64],
    r: &mut [f64],
    mut work: &mut [f64],
) -> Result<End, Breakdown> {
    let mut before: Vec<[&[f64]; 2]> = Vec::new();
    while before.len() < RESTART {
        let [p, q] = [0; 2].map(|_| carve(&mut work, x.len()));
        run.solve(r, p);
        run.product(p, q);
        for [p_j, q_j] in &before {
            let beta = dot(q, q_j);
            axpy(-beta, p_j, p);
            axpy(-beta, q_j, q);
        }
        let size = run.finite(norm2(q).recip())?;
        p.iter_mut().chain(&mut *q).for_each(|v| *v *= size);
        let alpha = dot(r, q);
        axpy(alpha, p, x);
        axpy(-alpha, q, r);
        before.push([p, q]);
        if let Some(end) = run.step(norm2(r))?
            && run.ends(end, x)
        {
            return Ok(end);
        }
    }
    Ok(End::Restart)
}

impl CustomKrylov for ConjugateResiduals {
    fn products_per_iteration(&self) -> usize {
        1
    }

    fn is_flexible(&self) -> bool {
        true
    }
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    KrylovChoice::register(&ConjugateResiduals)?;
    let scene = named("crossing")
        .ok_or("a scene of the gallery")?
        .small_scene()?;
    let blocks = scene.build()?.saddle_blocks(Some(Default::default()))?;
    let m = SaddleMethod::default().ready(&blocks)?.inverse;
    let system = System {
        operator: &SaddleOperator::new(&blocks),
        preconditioner: &m,
        rhs: &blocks.rhs(),
    };
    let criteria = Criteria {
        relative_tolerance: 1e-8,
        max_iterations: 500,
    };
    for name in ["conjugate_residuals", "gmres"] {
        let krylov: KrylovChoice = name.parse()?;
        let mut x = vec![0.0; system.size()];
        let report = krylov
            .method()
            .solve(&system, &criteria, &mut x, &mut Silent)?;
        let (iterations, residual) = (report.iterations, report.relative_residual);
        println!("{krylov}: {iterations} iterations, ‖b − 𝒜x‖/‖b‖ = {residual:.1e}");
        assert_eq!(report.outcome, Outcome::Converged);
    }
    Ok(())
}
