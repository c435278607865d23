//! One linear system: a short recurrence where one applies, GMRES where that ends early or does not apply.

use super::LinearFailure;
use super::workspace::{Workspace, fitted};
use crate::inner::{Hope, Standstill};
use fracas_operators::random::signed;
use fracas_solvers::Observer;
use fracas_solvers::krylov::{Breakdown, Criteria, KrylovChoice, Outcome, System, Watch};
use fracas_solvers::saddle::{EnergyNorms, Left, T, U, nearest_eigenvalue, probe};

/// Relative residual up to which a system that rounding or the limit of iterations keeps from its tolerance is taken: Newton
/// corrects it, and fails where it cannot. Unit: 1.
pub(super) const USEFUL: f64 = 1e-2;

/// Of an inner solver that has a rival.
const WEAK: &str = "the preconditioner is too weak for this system, as slender bodies, flat cells, large contrasts or open faces may make it; another inner solver in [solver], such as exact, may help";

/// How a system is to be solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    /// What takes the place of GMRES where the operator is symmetric; a preconditioner that is not linear to double
    /// precision forbids it as long as there is room for a basis.
    pub(super) short: Option<KrylovChoice>,
    pub(super) tolerance: f64,
    pub(super) max_iterations: usize,
    /// Iterations after which a preconditioner that was made for something else is given up; a breakdown with it is no
    /// failure either.
    pub(super) patience: Option<usize>,
    /// Another inner solver goes on where the iteration gets nowhere.
    pub(super) gives_way: bool,
}

/// The Ritz value nearest to zero that a [`probe`] of a system of a run finds, where M may hide one.
pub(super) fn small_eigenvalue(
    system: &System<'_, f64>,
    norms: &EnergyNorms<'_>,
    observer: &mut dyn Observer,
) -> Option<f64> {
    let krylov = KrylovChoice::default().flexible_for(system.preconditioner);
    probe(krylov.method(), system, norms, (None, Left::Half), observer).ritz
}

/// Steps of a look at what is free since M was made. Unit: 1.
const FREED: usize = 12;

/// The Ritz value nearest to zero of a few steps from random forces on the sides of faces of which M holds jumps that are `freed`: what M is bad at
/// is there. Between plates of 1:200 that had opened, three iterations had 0.75 beside an eigenvalue of 0.0014, and displacements were wrong by
/// 4.6e-3 where 5e-6 was said.
pub(super) fn eigenvalue_of_freed(
    system: &System<'_, f64>,
    norms: &EnergyNorms<'_>,
    freed: &[usize],
    observer: &mut dyn Observer,
) -> Option<f64> {
    let layout = norms.layout();
    let mut tractions = vec![0.0; system.rhs.len()];
    let faces = &mut tractions[layout.range(T)];
    for i in freed.iter().flat_map(|f| 3 * f..3 * f + 3) {
        faces[i] = signed(i as u64);
    }
    let mut forces = vec![0.0; tractions.len()];
    let mut work = vec![0.0; system.operator.work_len()];
    system.operator.apply(&tractions, &mut forces, &mut work);
    let displacements = layout.range(U);
    (forces.iter_mut().enumerate())
        .filter(|(i, _)| !displacements.contains(i))
        .for_each(|(_, force)| *force = 0.0);
    let krylov = KrylovChoice::default().flexible_for(system.preconditioner);
    let system = System {
        rhs: &forces,
        ..*system
    };
    nearest_eigenvalue(krylov.method(), &system, FREED, observer)
}

/// An iteration that got nowhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stalled {
    pub(super) krylov: &'static str,
    pub(super) iterations: usize,
    pub(super) relative_residual: f64,
}

/// A solved system.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved {
    pub(super) krylov: &'static str,
    /// Those of a method or with a preconditioner that was then dropped included.
    pub(super) iterations: usize,
    /// True, recomputed.
    pub(super) relative_residual: f64,
    /// Ritz value of M⁻¹A nearest to zero, where the method knows one.
    pub(super) smallest_ritz: Option<f64>,
    /// The observer wants to stop.
    pub(super) stopped: bool,
    /// A preconditioner was built for it.
    pub(super) setup: bool,
}

/// How it ended.
#[derive(Debug)]
pub(super) enum Ended {
    Solved(Solved),
    /// The preconditioner is given up.
    Dropped {
        iterations: usize,
    },
    /// Another inner solver is to go on.
    Stalled(Stalled),
}

/// `x ← A⁻¹ b` from the x at hand with the short recurrence, from zero with GMRES, whose restart fits into memory; `work` grows to
/// what they need.
///
/// Where a short recurrence ends early GMRES takes its place, and the name in the answer says so.
///
/// # Errors
/// [`LinearFailure`] of a preconditioner that may not be dropped.
pub(super) fn solve(
    system: &System<'_, f64>,
    asked: Asked,
    x: &mut [f64],
    observer: &mut dyn Observer,
    work: &mut Workspace,
) -> Result<Ended, LinearFailure> {
    let m = system.preconditioner;
    let vectors = work.vectors(m);
    let general = || fitted(vectors, false, m).map(|fitted| fitted.choice);
    let properties = m.properties();
    let short = match asked.short.filter(|_| properties.linear) {
        Some(_) if properties.single && fitted(vectors, true, m)?.reason.is_none() => None,
        short => short,
    };
    let criteria = Criteria {
        relative_tolerance: asked.tolerance,
        max_iterations: asked
            .patience
            .unwrap_or(usize::MAX)
            .min(asked.max_iterations),
    };
    let hope = Hope {
        tolerance: asked.tolerance,
        limit: asked.max_iterations,
    };
    let mut gave_up = None;
    let mut run = |choice: KrylovChoice, x: &mut [f64]| {
        let method = choice.method();
        let work = work.of(method, system, &criteria);
        let mut standstill = Standstill::new(observer, false, asked.gives_way.then_some(hope));
        let solved = method.solve_in(system, &criteria, x, Watch::of(&mut standstill), work);
        gave_up = standstill.gave_up;
        (choice.name(), solved)
    };
    let mut spent = 0;
    let first = match short {
        Some(short) => short,
        None => {
            x.fill(0.0);
            general()?
        }
    };
    let (krylov, solved) = match run(first, x) {
        (_, Err(breakdown)) if short.is_some() && asked.patience.is_none() => {
            spent = breakdown.iteration();
            x.fill(0.0);
            run(general()?, x)
        }
        tried => tried,
    };
    let (iterations, relative_residual, outcome, smallest_ritz) = match solved {
        Ok(report) => (
            report.iterations,
            report.relative_residual,
            report.outcome,
            report.smallest_ritz,
        ),
        Err(breakdown) if asked.patience.is_some() => {
            let iterations = breakdown.iteration();
            return Ok(Ended::Dropped { iterations });
        }
        Err(Breakdown::Stagnation {
            iteration,
            relative_residual,
            smallest_ritz,
            ..
        }) if relative_residual <= USEFUL => (
            iteration,
            relative_residual,
            Outcome::Converged,
            smallest_ritz,
        ),
        Err(breakdown) => return Err(breakdown.into()),
    };
    let iterations = spent + iterations;
    let is_over = outcome == Outcome::IterationLimit || gave_up.is_some();
    match (outcome, asked.patience) {
        (Outcome::IterationLimit, Some(_)) => Ok(Ended::Dropped { iterations }),
        _ if asked.gives_way && is_over => Ok(Ended::Stalled(Stalled {
            krylov,
            iterations,
            relative_residual,
        })),
        (Outcome::IterationLimit, None) if relative_residual > USEFUL => {
            Err(LinearFailure::IterationLimit {
                krylov,
                iterations,
                residual: relative_residual,
                tolerance: asked.tolerance,
                advice: WEAK,
            })
        }
        _ => Ok(Ended::Solved(Solved {
            krylov,
            iterations,
            relative_residual,
            smallest_ritz,
            stopped: outcome == Outcome::Stopped,
            setup: false,
        })),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::nonlinear::FreeMemory;
    use fracas_operators::{Dense, Identity, Preconditioner, Properties, Shape};
    use fracas_solvers::Silent;
    use fracas_solvers::krylov::{Cg, Sqmr};

    /// `[0 1; 1 0]`, on which SQMR from e_1 breaks down at once.
    fn swap() -> Dense<f64> {
        Dense::from_fn(Shape::square(2), |i, j| f64::from(u8::from(i != j)))
    }

    fn asked(short: Option<KrylovChoice>, patience: Option<usize>) -> Asked {
        Asked {
            short,
            tolerance: 1e-10,
            max_iterations: 50,
            patience,
            gives_way: false,
        }
    }

    fn ended(operator: &Dense<f64>, asked: Asked, x: &mut [f64]) -> Result<Ended, LinearFailure> {
        let rhs: Vec<f64> = (0..x.len()).map(|i| f64::from(u8::from(i == 0))).collect();
        let system = System {
            operator,
            preconditioner: &Identity { n: rhs.len() },
            rhs: &rhs,
        };
        solve(&system, asked, x, &mut Silent, &mut Workspace::default())
    }

    #[test]
    fn gmres_takes_over_and_its_name_and_all_iterations_are_told() {
        let mut x = [0.0; 2];
        let sqmr = Some(KrylovChoice::Sqmr(Sqmr {}));
        let Ended::Solved(solved) = ended(&swap(), asked(sqmr, None), &mut x).unwrap() else {
            panic!("nothing to drop");
        };
        assert_eq!(solved.krylov, "gmres");
        assert!(
            solved.iterations > 2,
            "the breakdown counts: {}",
            solved.iterations
        );
        assert!(x[0].abs() < 1e-12 && (x[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_meets_its_limit_fails_or_gives_way() {
        let limited = |gives_way| {
            let asked = Asked {
                max_iterations: 1,
                gives_way,
                ..asked(None, None)
            };
            ended(&swap(), asked, &mut [0.0; 2])
        };
        let stalled = limited(true).unwrap();
        assert!(matches!(
            stalled,
            Ended::Stalled(Stalled { iterations: 1, .. })
        ));
        let failure = limited(false).unwrap_err();
        assert!(matches!(failure, LinearFailure::IterationLimit { .. }));
    }

    /// A preconditioner in f32.
    struct Single(Identity);

    impl Preconditioner<f64> for Single {
        fn size(&self) -> usize {
            self.0.n
        }
        fn solve(&self, r: &[f64], z: &mut [f64], _: &mut [f64]) {
            z.copy_from_slice(r);
        }
        fn flops(&self) -> u64 {
            0
        }
        fn properties(&self) -> Properties {
            Properties::SINGLE
        }
    }

    #[test]
    fn memory_decides_between_a_basis_a_short_recurrence_and_none() {
        let n = 30;
        let operator = Dense::from_fn(Shape::square(n), |i, j| match i.abs_diff(j) {
            0 => 4.0,
            1 => -1.0,
            _ => 0.0,
        });
        let solved = |free: FreeMemory| {
            let system = System {
                operator: &operator,
                preconditioner: &Single(Identity { n }),
                rhs: &[1.0; 30],
            };
            let mut work = Workspace::limited_by(free);
            let sqmr = asked(Some(KrylovChoice::Sqmr(Sqmr {})), None);
            match solve(&system, sqmr, &mut [0.0; 30], &mut Silent, &mut work) {
                Ok(Ended::Solved(solved)) => solved.krylov,
                Ok(Ended::Dropped { .. }) => panic!("nothing to drop"),
                Err(LinearFailure::NoRoom { vectors, n: 30 }) if vectors < 8 => "none",
                Ok(Ended::Stalled(_)) => unreachable!("gives way to nothing"),
                Err(other) => panic!("{other}"),
            }
        };
        // half of it for 30 numbers a vector
        assert_eq!(solved(|| None), "fgmres");
        assert_eq!(solved(|| Some(2 * 84 * 240)), "fgmres");
        assert_eq!(solved(|| Some(2 * 83 * 240)), "sqmr");
        assert_eq!(solved(|| Some(2 * 8 * 240)), "sqmr");
        assert_eq!(solved(|| Some(2 * 7 * 240)), "none");
    }

    #[test]
    fn with_patience_a_breakdown_and_a_limit_drop_the_preconditioner() {
        let sqmr = Some(KrylovChoice::Sqmr(Sqmr {}));
        let dropped = ended(&swap(), asked(sqmr, Some(9)), &mut [0.0; 2]);
        assert!(matches!(dropped, Ok(Ended::Dropped { iterations: 1 })));
        let n = 40;
        let spread = Dense::from_fn(Shape::square(n), |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        let cg = Some(KrylovChoice::Cg(Cg {}));
        let dropped = ended(&spread, asked(cg, Some(9)), &mut vec![0.0; n]);
        assert!(matches!(dropped, Ok(Ended::Dropped { iterations: 9 })));
        let limit = Asked {
            max_iterations: 9,
            ..asked(cg, None)
        };
        let failed = ended(&spread, limit, &mut vec![0.0; n]);
        assert!(matches!(
            failed,
            Err(LinearFailure::IterationLimit {
                iterations: 9,
                krylov: "cg",
                ..
            })
        ));
    }
}
