//! What every method owes: exact preconditioners, special right-hand sides, counting, true residuals, breakdowns.

use super::oracle::*;
use super::*;
use crate::{Observer, Silent, Step};
use fracas_operators::laws::probe;
use fracas_operators::vector::norm2;
use fracas_operators::{Counted, Dense, Identity, LinearOperator, Shape};
use std::ops::ControlFlow;

fn methods() -> Vec<(KrylovChoice, Dense<f64>)> {
    // every method with a system that it is made for
    KrylovChoice::all()
        .into_iter()
        .map(|choice| {
            let a = match choice {
                KrylovChoice::Cg(_) => spd(30, 1),
                KrylovChoice::Minres(_) | KrylovChoice::Sqmr(_) => indefinite(30, 1),
                _ => unsymmetric(30, 1),
            };
            (choice, a)
        })
        .collect()
}

#[test]
fn an_exact_preconditioner_needs_one_iteration() {
    let b = probe(30, 2);
    for (choice, a) in methods() {
        let a = if choice.name() == "minres" {
            spd(30, 4)
        } else {
            a
        };
        let (x, report) = solve(choice.method(), &a, &exact(&a), &b, until(1e-9, 10));
        assert_eq!(report.unwrap().iterations, 1, "{choice}");
        assert!(deviation(&x, &direct(&a, &b)) < 1e-8, "{choice}");
    }
}

#[test]
fn a_zero_right_hand_side_costs_nothing_and_forgets_the_start() {
    for (choice, a) in methods() {
        let system = System {
            operator: &a,
            preconditioner: &Identity { n: 30 },
            rhs: &[0.0; 30],
        };
        let mut x = vec![3.0; 30];
        let report = choice
            .method()
            .solve(&system, &until(1e-9, 10), &mut x, &mut Silent)
            .unwrap();
        assert_eq!(
            (report.iterations, report.products, report.outcome),
            (0, 0, Outcome::Converged)
        );
        assert!(x.iter().all(|v| *v == 0.0), "{choice}");
    }
}

#[test]
fn an_empty_system_is_solved() {
    for choice in KrylovChoice::all() {
        let empty = Dense::zeros(Shape::square(0));
        let (_, report) = solve(
            choice.method(),
            &empty,
            &Identity { n: 0 },
            &[],
            until(1e-9, 10),
        );
        assert_eq!(report.unwrap().iterations, 0, "{choice}");
    }
}

#[test]
fn a_start_is_used_and_a_solution_as_start_costs_one_product() {
    let b = probe(30, 2);
    for (choice, a) in methods() {
        let system = System {
            operator: &a,
            preconditioner: &Identity { n: 30 },
            rhs: &b,
        };
        let solution = direct(&a, &b);
        let mut x = solution.clone();
        let report = choice
            .method()
            .solve(&system, &until(1e-9, 10), &mut x, &mut Silent)
            .unwrap();
        assert_eq!((report.iterations, report.products), (0, 1), "{choice}");
        let mut x = probe(30, 11);
        let report = choice
            .method()
            .solve(&system, &until(1e-9, 200), &mut x, &mut Silent)
            .unwrap();
        assert_eq!(report.outcome, Outcome::Converged, "{choice}");
        assert!(deviation(&x, &solution) < 1e-7, "{choice}");
    }
}

#[test]
fn the_reported_residual_is_recomputed_and_every_application_is_counted() {
    let b = probe(30, 2);
    for (choice, a) in methods() {
        for limit in [0, 1, 4, 300] {
            let (counted, identity) = (Counted::new(&a), Counted::new(Identity { n: 30 }));
            let (x, report) = solve(choice.method(), &counted, &identity, &b, until(1e-9, limit));
            let report = report.unwrap();
            let mut r = b.clone();
            a.apply_add(-1.0, &x, &mut r, &mut []);
            let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
            assert!(
                (norm(&r) / norm(&b) - report.relative_residual).abs() < 1e-13,
                "{choice}"
            );
            assert_eq!(report.products, counted.applications(), "{choice}");
            assert_eq!(
                report.preconditioner_solves,
                identity.applications(),
                "{choice}"
            );
            let converged = report.relative_residual <= 1e-9;
            assert_eq!(report.outcome == Outcome::Converged, converged, "{choice}");
            assert!(report.iterations <= limit);
        }
    }
}

#[test]
fn nan_is_found_where_it_enters() {
    let at = |report: Result<Report, Breakdown>| match report {
        Err(Breakdown::NotFinite { iteration, .. }) => iteration,
        other => panic!("{other:?}"),
    };
    for (choice, a) in methods() {
        let (method, n) = (choice.method(), 30);
        let mut b: Vec<f64> = probe(n, 2);
        let mut poisoned = a.clone();
        *poisoned.entry_mut(3, 3) = f64::NAN;
        let identity = Identity { n };
        assert_eq!(
            at(solve(method, &poisoned, &identity, &b, until(1e-9, 50)).1),
            1,
            "{choice}"
        );
        let m = Explicit(poisoned);
        assert_eq!(
            at(solve(method, &a, &m, &b, until(1e-9, 50)).1),
            1,
            "{choice}"
        );
        b[7] = f64::NAN;
        assert_eq!(
            at(solve(method, &a, &identity, &b, until(1e-9, 50)).1),
            0,
            "{choice}"
        );
        b[7] = 1e200;
        let (_, report) = solve(method, &a, &identity, &b, until(1e-9, 50));
        assert!(
            matches!(report, Err(Breakdown::OutOfRange { .. })),
            "{choice}"
        );
    }
}

#[test]
fn a_tolerance_below_rounding_stagnates_with_the_attained_residual() {
    let b = probe(30, 2);
    for (choice, a) in methods() {
        let (x, report) = solve(
            choice.method(),
            &a,
            &Identity { n: 30 },
            &b,
            until(1e-30, 5000),
        );
        match report {
            Err(Breakdown::Stagnation {
                relative_residual, ..
            }) => {
                assert!(relative_residual < 1e-13, "{choice}: {relative_residual:e}");
                assert!(deviation(&x, &direct(&a, &b)) < 1e-12, "{choice}");
            }
            other => panic!("{choice}: {other:?}"),
        }
    }
}

#[test]
fn the_observer_sees_every_iteration_and_stops_it() {
    let b = probe(30, 2);
    for (choice, a) in methods() {
        let system = System {
            operator: &a,
            preconditioner: &Identity { n: 30 },
            rhs: &b,
        };
        for last in [0, 3] {
            let mut seen = Vec::new();
            let mut watch = |step: &Step| {
                if let Step::Krylov { iteration, .. } = step {
                    seen.push(*iteration);
                }
                if seen.len() > last {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            let mut x = vec![0.0; 30];
            let report = choice
                .method()
                .solve(&system, &until(1e-14, 99), &mut x, &mut watch)
                .unwrap();
            assert_eq!(report.outcome, Outcome::Stopped, "{choice}");
            assert_eq!(report.iterations, last, "{choice}");
            assert_eq!(seen, (0..=last).collect::<Vec<_>>(), "{choice}");
            assert_eq!(x.iter().any(|v| *v != 0.0), last > 0, "{choice}");
        }
    }
}

#[test]
fn single_precision_reaches_single_precision() {
    for (choice, a) in methods() {
        let n = 30;
        let a = Dense::from_fn(Shape::square(n), |i, j| a.entry(i, j) as f32);
        let b: Vec<f32> = probe(n, 2);
        let system = System {
            operator: &a,
            preconditioner: &Identity { n },
            rhs: &b,
        };
        let mut x = vec![0.0; n];
        let report = choice
            .own_method()
            .unwrap()
            .solve(&system, &until(1e-5, 99), &mut x, &mut Silent)
            .unwrap();
        assert_eq!(report.outcome, Outcome::Converged, "{choice}");
    }
}

/// Lets an iteration go on to these relative residuals, one after the other, and then takes x.
struct Further<'a> {
    steps: &'a [f64],
    operator: &'a dyn LinearOperator<f64>,
    b: &'a [f64],
    asked: usize,
}

impl Judge<f64> for Further<'_> {
    fn judge(&mut self, candidate: &Candidate<'_, f64>, _: &mut dyn Observer) -> Verdict {
        let mut r = self.b.to_vec();
        self.operator.apply_add(-1.0, candidate.x, &mut r, &mut []);
        let relative_residual = norm2(&r) / norm2(self.b);
        let estimated = candidate.estimated_residual;
        assert!((relative_residual - estimated).abs() <= 1e-3 * estimated);
        self.asked += 1;
        Verdict {
            relative_residual,
            further: self.steps.get(self.asked - 1).copied(),
        }
    }
}

/// The solve that such a judge lets go on, and how often it was asked.
fn going_on(
    method: &dyn KrylovMethod<f64>,
    system: &System<f64>,
    (steps, criteria): (&[f64], Criteria),
) -> (Vec<f64>, Report, usize) {
    let mut judge = Further {
        steps,
        operator: system.operator,
        b: system.rhs,
        asked: 0,
    };
    let watch = Watch {
        observer: &mut Silent,
        judge: Some(&mut judge),
    };
    let mut x = vec![0.0; system.size()];
    let report = method.solve_watched(system, &criteria, &mut x, watch);
    (x, report.unwrap(), judge.asked)
}

#[test]
fn what_a_judge_lets_go_on_is_the_iteration_to_the_last_residual() {
    let b = probe(30, 2);
    for (choice, a) in methods() {
        let system = System {
            operator: &a,
            preconditioner: &Explicit(spd(30, 3)),
            rhs: &b,
        };
        let m = system.preconditioner;
        let (whole, expected) = solve(choice.method(), &a, m, &b, until(1e-8, 300));
        let asked = (&[1e-3, 1e-6, 1e-8][..], until(1e-1, 300));
        let (x, report, times) = going_on(choice.method(), &system, asked);
        let iterations = [expected.unwrap().iterations, report.iterations];
        // BiCGStab may end after half an iteration
        let [alone, judged] = iterations;
        assert!(alone.abs_diff(judged) <= 1, "{choice}: {iterations:?}");
        assert_eq!(times, 4, "{choice}");
        assert!(report.relative_residual <= 1e-8, "{choice}");
        assert!(deviation(&x, &whole) < 1e-5, "{choice}");
    }
}

#[test]
fn a_judge_has_no_more_iterations_than_there_are() {
    let b = probe(30, 2);
    for (choice, a) in methods() {
        let system = System {
            operator: &a,
            preconditioner: &Identity { n: 30 },
            rhs: &b,
        };
        let asked = (&[1e-13; 300][..], until(0.9, 5));
        let (_, report, _) = going_on(choice.method(), &system, asked);
        assert!(report.iterations <= 5, "{choice}");
    }
}
