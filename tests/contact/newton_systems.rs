//! Claim: the assembled Newton systems of a run are those that it solves.

use fracas::contact::ContactState;
use fracas::nonlinear::{ContactProblem, LinearRecord, NewtonSystemError, Simulation};
use fracas::scene::named;
use fracas_operators::LinearOperator;
use fracas_solvers::Silent;
use fracas_solvers::saddle::{SaddleOperator, T, U};

/// Faces in stick, new-slip, slip, open.
fn count(states: &[ContactState]) -> [usize; 4] {
    ContactState::ALL.map(|state| states.iter().filter(|own| **own == state).count())
}

#[test]
fn its_products_are_those_of_the_operator_in_every_state() {
    let body = named("cycle")
        .unwrap()
        .small_scene()
        .unwrap()
        .build()
        .unwrap();
    let problem = ContactProblem::new(&body).unwrap();
    let layout = problem.saddle().layout();
    let (n_u, n_t) = (layout.length(U), layout.length(T));
    let number = |k: usize| (1.3 * k as f64).sin();
    let states: Vec<ContactState> = (0..n_t / 3)
        .map(|f| ContactState::from_code((f % 4) as u8).unwrap())
        .collect();
    let u: Vec<f64> = (0..n_u).map(|k| 1e-4 * number(k)).collect();
    let t: Vec<f64> = (0..n_t).map(|k| 1e5 * number(k + 7) - 2e5).collect();
    let load = problem.loads().at(0.0, 1.0);
    let start = problem.at_rest();
    let h = problem.stabilization(&states);
    let at = problem.evaluate(&states, h.as_ref(), [&u, &t], &start, &load);
    let blocks = problem.assembled(&states, h.as_ref(), &at, false).unwrap();
    let jacobian = problem.jacobian(&states, h.as_ref(), &at, false);
    let unit = problem.saddle().unit();
    let x: Vec<f64> = (0..n_u + n_t).map(|k| number(3 * k + 1)).collect();
    let mut y = vec![0.0; n_u + n_t];
    jacobian.apply(&x, &mut y, &mut vec![0.0; jacobian.work_len()]);
    // tractions of x in the balanced unit
    let scaled: Vec<f64> = (0..n_u + n_t)
        .map(|i| if i < n_u { x[i] } else { unit * x[i] })
        .collect();
    let operator = SaddleOperator::new(&blocks);
    let mut z = vec![0.0; n_u + n_t];
    operator.apply(&scaled, &mut z, &mut vec![0.0; operator.work_len()]);
    let [z_t] = layout.split_mut([T], &mut z);
    z_t.iter_mut().for_each(|z| *z *= unit);
    let rhs: Vec<f64> = blocks
        .rhs_u
        .iter()
        .copied()
        .chain(blocks.rhs_t.iter().map(|r| unit * r))
        .collect();
    for (name, a, b) in [("J x", &y, &z), ("-r", &at.residual, &rhs)] {
        for part in [layout.range(U), layout.range(T)] {
            let size = part.clone().fold(0.0f64, |m, i| m.max(a[i].abs()));
            assert!(size > 0.0, "{name}: nothing to compare");
            for i in part {
                assert!(
                    (a[i] - b[i]).abs() <= 1e-12 * size,
                    "{name} {i}: {} {}",
                    a[i],
                    b[i]
                );
            }
        }
    }
}

#[test]
fn a_run_gives_the_systems_that_it_solves() {
    let body = named("cycle")
        .unwrap()
        .small_scene()
        .unwrap()
        .build()
        .unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let mut state = simulation.initial_state();
    let done = loop {
        let done = simulation.advance(&state, &mut Silent).unwrap();
        let slips = |l: &&LinearRecord| l.faces[1] + l.faces[2] > 0;
        if done.linear.iter().any(|l| slips(&l)) {
            break done;
        }
        state = done.state;
    };
    for (k, record) in done.linear.iter().enumerate() {
        let system = simulation.newton_system(&state, k, &mut Silent).unwrap();
        assert_eq!(
            (system.attempt, system.round, system.newton),
            (record.attempt, record.active, record.newton)
        );
        assert_eq!(count(&system.states), record.faces);
    }
    let last = simulation.newton_system(&state, done.linear.len(), &mut Silent);
    assert!(
        matches!(last, Err(NewtonSystemError::NoSuch { .. })),
        "{last:?}"
    );
    // it has left no trace
    let again = simulation.advance(&state, &mut Silent).unwrap();
    assert_eq!(again.linear.len(), done.linear.len());
}
