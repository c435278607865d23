//! Claim: the matrix-free equations and their Jacobian are what they are said to be: derivatives of each other, equal to the
//! assembled form, independent of threads and of the inner solver.

use fracas::contact::{ContactState, JumpStabilization};
use fracas::jacobian::{ContactPoint, ContactSystem};
use fracas::nonlinear::{ContactProblem, Simulation, Start, State};
use fracas::scene::{Body, named};
use fracas_operators::LinearOperator;
use fracas_operators::vector::norm2;
use fracas_solvers::Silent;

fn body() -> Body {
    named("inclined")
        .unwrap()
        .small_scene()
        .unwrap()
        .build()
        .unwrap()
}

/// Reproducible numbers in [−1, 1].
fn numbers(n: usize, seed: u64) -> Vec<f64> {
    let mut x = seed;
    let next = |_| {
        x = x
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(next).collect()
}

fn states(faces: usize) -> Vec<ContactState> {
    (0..faces).map(|f| ContactState::ALL[f % 4]).collect()
}

/// A point where slip is of the size of `ω t` and every face is compressed.
fn point(problem: &ContactProblem<'_>) -> (Vec<f64>, Vec<f64>, Start) {
    let faces = problem.faces().len();
    let n_u = problem.body().constraints.free_len();
    let u = numbers(n_u, 1).iter().map(|v| 1e-4 * v).collect();
    let mut t: Vec<f64> = numbers(3 * faces, 2).iter().map(|v| 1e6 * v).collect();
    t.iter_mut().step_by(3).for_each(|t| *t -= 5e6);
    // the assembled form knows no initial stress
    let mut start = Start {
        jump: numbers(3 * faces, 3).iter().map(|v| 1e-5 * v).collect(),
        slip: numbers(2 * faces, 7).iter().map(|v| 1e-5 * v).collect(),
        t: numbers(3 * faces, 4).iter().map(|v| 1e5 * v).collect(),
        ..problem.at_rest()
    };
    start.t.iter_mut().step_by(3).for_each(|t| *t = 0.0);
    (u, t, start)
}

#[test]
fn the_jacobian_is_the_derivative_of_the_residual() {
    let body = body();
    let problem = ContactProblem::new(&body).unwrap();
    let states = states(problem.faces().len());
    let h = problem.stabilization(&states);
    let (u, t, start) = point(&problem);
    let load = problem.loads().at(0.0, 1.0);
    let residual = |u: &[f64], t: &[f64]| {
        problem
            .evaluate(&states, h.as_ref(), [u, t], &start, &load)
            .residual
    };
    let at = problem.evaluate(&states, h.as_ref(), [&u, &t], &start, &load);
    let jacobian = problem.jacobian(&states, h.as_ref(), &at, false);
    let unit = problem.saddle().unit();
    let (d_u, d_t) = (numbers(u.len(), 5), numbers(t.len(), 6));
    // δ = (1e-9 m, and as much in units of traction)
    let step = 1e-9;
    let moved = |s: f64| {
        let u: Vec<f64> = u.iter().zip(&d_u).map(|(u, d)| u + s * step * d).collect();
        let t: Vec<f64> = t
            .iter()
            .zip(&d_t)
            .map(|(t, d)| t + s * step * unit * d)
            .collect();
        residual(&u, &t)
    };
    let (plus, minus) = (moved(1.0), moved(-1.0));
    let direction: Vec<f64> = d_u.iter().chain(&d_t).map(|d| step * d).collect();
    let mut product = vec![0.0; direction.len()];
    jacobian.apply(
        &direction,
        &mut product,
        &mut vec![f64::NAN; jacobian.work_len()],
    );
    // the residual is −r, the Jacobian that of r
    let error: Vec<f64> = (0..product.len())
        .map(|i| 0.5 * (plus[i] - minus[i]) + product[i])
        .collect();
    let (error, size) = (norm2(&error), norm2(&product));
    assert!(error < 1e-5 * size, "{error:e} of {size:e}");
}

#[test]
fn with_stick_and_open_faces_it_is_the_assembled_jacobian() {
    let body = body();
    let problem = ContactProblem::new(&body).unwrap();
    let faces = problem.faces().len();
    let of = |f| {
        if f % 3 == 0 {
            ContactState::Open
        } else {
            ContactState::Stick
        }
    };
    let states: Vec<ContactState> = (0..faces).map(of).collect();
    let h = problem.stabilization(&states);
    let (u, t, start) = point(&problem);
    let load = problem.loads().at(0.0, 1.0);
    let at = problem.evaluate(&states, h.as_ref(), [&u, &t], &start, &load);
    let jacobian = problem.jacobian(&states, h.as_ref(), &at, false);

    let stick = body.stick_system(Some(JumpStabilization::default()));
    let system =
        ContactSystem::new(stick, &body.forces().unwrap(), |f| body.friction_of(f)).unwrap();
    let point = ContactPoint {
        u: &u,
        t: &t,
        start_jump: &start.jump,
        start_t: &start.t,
    };
    let unit = problem.saddle().unit();
    let blocks = system
        .linearize(&states, &point)
        .unwrap()
        .into_traction_unit(unit);
    let assembled = blocks.rhs();
    let close = |a: &[f64], b: &[f64]| {
        let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        assert!(
            norm2(&difference) < 1e-12 * norm2(a),
            "{:e}",
            norm2(&difference) / norm2(a)
        );
    };
    close(&assembled, &at.residual);

    let x = numbers(assembled.len(), 7);
    let operator = fracas_solvers::saddle::SaddleOperator::new(&blocks);
    let (mut y, mut z) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    operator.apply(&x, &mut y, &mut vec![0.0; operator.work_len()]);
    jacobian.apply(&x, &mut z, &mut vec![0.0; jacobian.work_len()]);
    close(&y, &z);
}

/// Embedded fractures that dip 60 deg and are weaker than the stress on them.
fn sliding() -> Body {
    let scene = named("analogue_b").unwrap().small_scene().unwrap();
    let overrides = [
        "mesh.map.incline.plane=x",
        "mesh.map.incline.dip=60 deg",
        "mesh.map.incline.fade=true",
        "boundary.2.pressure=2 MPa",
        "fracture.fault.friction_angle=10 deg",
    ];
    scene.with_overrides(&overrides).unwrap().build().unwrap()
}

fn solved(body: &Body) -> State {
    let mut simulation = Simulation::new(body).unwrap();
    let end = simulation.run(&mut Silent, |_, _, _| ());
    end.unwrap_or_else(|failure| panic!("{failure}"))
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let body = sliding();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| solved(&body))
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one, two);
    assert!(
        one.states.contains(&ContactState::Slip),
        "nothing slips: {:?}",
        one.states
    );
}

#[test]
fn every_inner_solver_finds_the_same_solution() {
    use fracas::scene::RunInner;
    let mut body = sliding();
    body.solver.tolerance = 1e-10;
    let mut of = |inner| {
        body.solver.inner = inner;
        solved(&body)
    };
    let exact = of(RunInner::Exact);
    for inner in [RunInner::Amg, RunInner::Geometric] {
        let other = of(inner);
        assert_eq!(exact.states, other.states, "{inner:?}");
        for (a, b) in [(&exact.u, &other.u), (&exact.t, &other.t)] {
            let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            assert!(
                norm2(&difference) < 1e-6 * norm2(a),
                "{inner:?}: {:e}",
                norm2(&difference) / norm2(a)
            );
        }
    }
}
