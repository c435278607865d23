//! Claim: the blocks of a fixed contact state are the derivative of its residual, and Newton's method on them converges
//! to tractions that obey the law of every face.

use fracas::contact::{ContactState, JumpStabilization};
use fracas::jacobian::{ContactPoint, ContactSystem};
use fracas::scene::{Body, named};
use fracas_operators::{LinearOperator, Preconditioner, laws, vector};
use fracas_solvers::direct::{DirectSolver, Faer, Kind};
use fracas_solvers::saddle::{SaddleBlocks, SaddleOperator};

/// Weak fractures in an inclined, compressed block: they slip under the load.
fn body() -> Body {
    let scene = named("analogue_b").unwrap().small_scene().unwrap();
    scene
        .with_overrides(&[
            "mesh.map.incline.plane=x",
            "mesh.map.incline.dip=60 deg",
            "mesh.map.incline.fade=true",
            "boundary.2.pressure=2 MPa",
            "fracture.fault.friction_angle=10 deg",
        ])
        .unwrap()
        .build()
        .unwrap()
}

fn system(body: &Body) -> ContactSystem<'_> {
    let stick = body.stick_system(Some(JumpStabilization::default()));
    ContactSystem::new(stick, &body.forces().unwrap(), |f| body.friction_of(f)).unwrap()
}

/// Every state somewhere, neighbours in different ones.
fn mixed(faces: usize) -> Vec<ContactState> {
    use ContactState::{NewSlip, Open, Slip, Stick};
    let cycle = [Slip, Slip, Stick, Open, NewSlip, Slip, Stick];
    (0..faces).map(|f| cycle[f % cycle.len()]).collect()
}

/// `𝒜 d`.
fn product(blocks: &SaddleBlocks, d: &[f64]) -> Vec<f64> {
    let operator = SaddleOperator::new(blocks);
    let mut y = vec![0.0; d.len()];
    operator.apply(d, &mut y, &mut vec![0.0; operator.work_len()]);
    y
}

#[test]
fn the_blocks_are_the_derivative_of_the_residual() {
    let body = body();
    let system = system(&body);
    let (n_u, n_t) = (system.stick().n_u(), system.stick().n_t());
    let states = mixed(n_t / 3);
    let scaled = |n: usize, seed: u64, size: f64| -> Vec<f64> {
        laws::probe::<f64>(n, seed)
            .iter()
            .map(|v| size * v)
            .collect()
    };
    let (u, mut t) = (scaled(n_u, 1, 1e-3), scaled(n_t, 2, 1e6));
    t.iter_mut().step_by(3).for_each(|t_n| *t_n = -5e6 - *t_n);
    let (start_jump, start_t) = (scaled(n_t, 3, 1e-4), scaled(n_t, 4, 1e6));
    let (du, mut dt) = (scaled(n_u, 5, 1e-3), scaled(n_t, 6, 1e6));
    // the direction of new slip is frozen: the derivative is along tractions that leave it alone
    for f in (0..n_t / 3).filter(|f| states[*f] == ContactState::NewSlip) {
        dt[3 * f + 1..3 * f + 3].fill(0.0);
    }
    let at = |h: f64| {
        let moved = |x: &[f64], d: &[f64]| -> Vec<f64> {
            x.iter().zip(d).map(|(x, d)| x + h * d).collect()
        };
        let (u, t) = (moved(&u, &du), moved(&t, &dt));
        let point = ContactPoint {
            u: &u,
            t: &t,
            start_jump: &start_jump,
            start_t: &start_t,
        };
        system.linearize(&states, &point).unwrap()
    };
    let derivative = product(&at(0.0), &[du.clone(), dt.clone()].concat());
    let h = 1e-5;
    let (plus, minus) = (at(h).rhs(), at(-h).rhs());
    for (name, part) in [("u", 0..n_u), ("t", n_u..n_u + n_t)] {
        let size = vector::norm_inf(&derivative[part.clone()]);
        for i in part {
            let difference = (minus[i] - plus[i]) / (2.0 * h);
            assert!(
                (difference - derivative[i]).abs() < 1e-6 * size,
                "{name}, row {i}: {difference:e} against {:e}",
                derivative[i]
            );
        }
    }
}

#[test]
fn all_stick_is_the_symmetric_system_and_open_rows_are_empty() {
    let body = body();
    let system = system(&body);
    let (n_u, n_t) = (system.stick().n_u(), system.stick().n_t());
    let (u, t) = (vec![0.0; n_u], vec![0.0; n_t]);
    let point = ContactPoint {
        u: &u,
        t: &t,
        start_jump: &t,
        start_t: &t,
    };
    let stick = system
        .linearize(&vec![ContactState::Stick; n_t / 3], &point)
        .unwrap();
    assert!(stick.b2.is_none());
    assert_eq!(stick.h, system.stick().h);
    assert_eq!(stick.rhs(), system.stick().rhs());

    let open = system
        .linearize(&vec![ContactState::Open; n_t / 3], &point)
        .unwrap();
    assert_eq!(open.b2.unwrap().nnz(), 0);
    let h = open.h.unwrap();
    assert_eq!(h.nnz(), n_t);
    assert!((0..n_t).all(|i| *h.get(i, i).unwrap() > 0.0));
}

#[test]
fn newton_on_a_fixed_state_reaches_the_laws_of_every_face() {
    let body = body();
    let system = system(&body);
    let (n_u, n_t) = (system.stick().n_u(), system.stick().n_t());
    let zero = vec![0.0; n_t];
    let (mut u, mut t) = (vec![0.0; n_u], vec![0.0; n_t]);
    // the outer half of every fracture sticks
    let pattern = |slip: ContactState| -> Vec<ContactState> {
        let inside = |f: &fracas::mesh::FractureFace| {
            (f.center[1] - 12.0).abs() < 4.0 && (f.center[2] - 12.0).abs() < 4.0
        };
        let state = |f| if inside(f) { slip } else { ContactState::Stick };
        body.fractures.faces.iter().map(state).collect()
    };
    let mut residuals = Vec::new();
    for step in 0..8 {
        let states = match step {
            0 => vec![ContactState::Stick; n_t / 3],
            1 => pattern(ContactState::NewSlip),
            _ => pattern(ContactState::Slip),
        };
        let point = ContactPoint {
            u: &u,
            t: &t,
            start_jump: &zero,
            start_t: &zero,
        };
        let blocks = system.linearize(&states, &point).unwrap();
        let unit = blocks.traction_unit();
        let blocks = blocks.in_traction_unit(unit);
        residuals.push(vector::norm2(&blocks.rhs()));
        let matrix = blocks.assembled();
        let factors = Faer
            .analyze(&matrix, Kind::General)
            .unwrap()
            .factor(&matrix)
            .unwrap();
        let mut d = vec![0.0; n_u + n_t];
        factors.solve(&blocks.rhs(), &mut d, &mut vec![0.0; factors.work_len()]);
        vector::axpy(1.0, &d[..n_u], &mut u);
        vector::axpy(unit, &d[n_u..], &mut t);
    }
    let last = residuals[residuals.len() - 1] / residuals[0];
    assert!(last < 1e-10, "{residuals:?}");

    let jumps = system.jumps(&u);
    let h = system.stick().h.as_ref().unwrap();
    let mut slipping = 0;
    for (f, state) in pattern(ContactState::Slip).iter().enumerate() {
        let limit = body
            .friction_of(&body.fractures.faces[f])
            .unwrap()
            .limit(t[3 * f], 0.0);
        assert!(t[3 * f] < 0.0, "face {f} is in tension");
        if *state != ContactState::Slip {
            continue;
        }
        slipping += 1;
        let (tau, g) = (&t[3 * f + 1..3 * f + 3], &jumps[3 * f + 1..3 * f + 3]);
        let (norm_t, norm_g) = (tau[0].hypot(tau[1]), g[0].hypot(g[1]));
        assert!((norm_t - limit).abs() < 1e-8 * limit, "face {f}");
        let work = tau[0] * g[0] + tau[1] * g[1];
        assert!(
            (work - norm_t * norm_g).abs() < 1e-6 * norm_t * norm_g,
            "face {f}: slip along the traction"
        );
        assert!(h.get(3 * f, 3 * f).is_some_and(|h| *h > 0.0));
    }
    assert!(slipping >= 4);
}
