use super::*;
use crate::flow::{Channel, Fluid};
use crate::nonlinear::coupled::of_open;
use crate::nonlinear::factorized::through_pressure;
use crate::nonlinear::pressed::{CoupledJacobian, Pressed, PressureSolver, of_contact};
use crate::scene::Body;
use crate::scene::sample::{Sample, fluid};
use fracas_operators::LinearOperator;
use fracas_operators::random::Random;
use fracas_solvers::direct::{DirectChoice, Kind};
use fracas_solvers::saddle::{T, U};

/// A tee with a fluid.
fn body() -> Body {
    let mut body = Sample::tee([8, 2, 8]).body();
    let channel = Channel {
        conductivity: 1e-12,
        directed: None,
        storage: 1e-12,
        initial_pressure: 1e6,
    };
    body.fluid = Some(Fluid {
        compressibility: 4e-10,
        ..fluid(&body, 1e-3, channel)
    });
    body
}

#[test]
fn the_jacobian_of_three_fields_is_the_derivative_in_every_state() {
    let body = body();
    let problem = ContactProblem::new(&body).unwrap();
    let faces = problem.faces().len();
    for seed in 0..3 {
        let mut random = Random::new(seed);
        let mut number = |low: f64, high: f64| low + (high - low) * random.unit();
        let states: Vec<ContactState> = (0..faces)
            .map(|_| ContactState::ALL[(number(0.0, 4.0) as usize).min(3)])
            .collect();
        let load = problem.loads().at(0.0, 1.0);
        let start = problem.at_rest();
        let x = Iterate {
            u: (0..body.constraints.free_len())
                .map(|_| number(-1e-3, 1e-3))
                .collect(),
            t: (0..3 * faces).map(|_| number(-3e6, -1e6)).collect(),
            p: (0..faces).map(|_| number(0.0, 1e7)).collect(),
            wells: Vec::new(),
        };
        let step = FlowStep {
            dt: 3.0,
            pressure: (0..faces).map(|_| number(0.0, 1e7)).collect(),
            aperture: (0..faces).map(|_| number(0.0, 1e-3)).collect(),
            injected: vec![1e-3; faces],
            sources: Vec::new(),
            held: vec![None; faces],
            held_edges: Vec::new(),
            wells: Vec::new(),
            joined: Vec::new(),
        };
        let attempt = Attempt {
            problem: &problem,
            start: &start,
            load: &load,
            scale: 1.0,
            traction: 1.0,
            size: problem.saddle().layout().values(0.0),
            held: None,
            flow: Some(&step),
            holds: false,
            step: 1,
            attempt: 0,
        };
        let h = problem.stabilization(&states);
        let at = attempt.evaluate(&states, h.as_ref(), &x);
        let unit = problem.saddle().unit();
        let stick = problem.stick_blocks().unwrap().into_traction_unit(unit);
        let b = stick.b1.clone();
        let blocks = attempt.coupled((stick, unit), &states, (h.as_ref(), &x), &at, false);
        let flow = blocks.flow.as_ref().unwrap();
        // Q2 only where open
        let open = states.contains(&ContactState::Open);
        assert_eq!(flow.q2.nnz() > 0, open);
        let rock = problem.jacobian(&states, h.as_ref(), &at, false);
        let whole = Csr::new(&blocks.assembled() + &through_pressure(&rock, &blocks));
        let (flow, _) = attempt.flow_blocks((&b, unit), &states, &at, &x).unwrap();
        let mut pressures = PressureSolver::default();
        pressures.prepare(&flow.t.clone().into(), &flow).unwrap();
        let pressed = Pressed::new(&pressures, &flow);
        let q1 = of_open(&flow.q1, &states);
        let layout = attempt.layout();
        let coupled = CoupledJacobian::new(&rock, (&q1, &pressed), &states, layout);
        for direction in 0..4 {
            let mut d = vec![0.0; layout.len()];
            let sizes = [(U, 1e-6), (T, 1e2 / unit), (P, 1e2 / unit)];
            for (field, size) in sizes {
                if direction == 3 || [U, T, P][direction] == field {
                    let part = &mut d[layout.range(field)];
                    part.iter_mut().for_each(|d| *d = number(-size, size));
                }
            }
            let product = |operator: &dyn LinearOperator<f64>| {
                let mut product = vec![0.0; d.len()];
                operator.apply(&d, &mut product, &mut vec![0.0; operator.work_len()]);
                product
            };
            // the residual is −r
            let difference = |d: &[f64]| {
                let moved = |s: f64| {
                    let mut y = x.clone();
                    y.step(&x, s, &layout, d);
                    attempt.evaluate(&states, h.as_ref(), &y).residual
                };
                let (plus, minus) = (moved(0.1), moved(-0.1));
                let pairs = minus.iter().zip(&plus);
                pairs.map(|(m, p)| (m - p) / 0.2).collect::<Vec<f64>>()
            };
            let mut of_t = d.clone();
            of_contact(&layout, &states, &mut of_t);
            let mut scaled = difference(&of_t);
            pressed.scale(&layout, &mut scaled);
            let pairs = [
                (product(&whole), difference(&d)),
                (product(&coupled), scaled),
            ];
            for ((product, difference), what) in pairs.into_iter().zip(["assembled", "as operator"])
            {
                for field in [U, T, P] {
                    let range = layout.range(field);
                    let size = product[range.clone()]
                        .iter()
                        .fold(0.0f64, |m, v| m.max(v.abs()));
                    for i in range {
                        assert!(
                            (difference[i] - product[i]).abs() <= 1e-5 * size,
                            "{what}, seed {seed}, direction {direction}, {}: {i}: {:e} {:e}",
                            field.letter,
                            difference[i],
                            product[i]
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_checkerboard_of_pressure_moves_no_rock_and_is_held_as_stiffly_as_one_of_traction() {
    // a closed square inside a body: its tips are not split
    let mut body = Sample::checkerboard([12; 3]).body();
    let channel = Channel {
        conductivity: 1e-30,
        directed: None,
        storage: 0.0,
        initial_pressure: 0.0,
    };
    body.fluid = Some(fluid(&body, 1.0, channel));
    let problem = ContactProblem::new(&body).unwrap();
    let faces = problem.faces().len();
    let open = vec![ContactState::Open; faces];
    let step = FlowStep {
        dt: 1e-9,
        pressure: vec![0.0; faces],
        aperture: vec![0.0; faces],
        injected: vec![0.0; faces],
        sources: Vec::new(),
        held: vec![None; faces],
        held_edges: Vec::new(),
        wells: Vec::new(),
        joined: Vec::new(),
    };
    let zero = vec![0.0; 3 * faces];
    let held = problem
        .balance()
        .unwrap()
        .tangent(&open, &zero, &step.pressure, &step)
        .t;
    let stick = problem.stick_blocks().unwrap();
    let factors = DirectChoice::default().solver().unwrap();
    let factors = factors
        .analyze(&stick.a, Kind::Spd)
        .unwrap()
        .factor(&stick.a)
        .unwrap();
    // volume that pressures open, and that stabilization moves: pᵀ(−Q2 A⁻¹ Q1)p and pᵀY p
    let energies = |p: &[f64]| {
        let force = problem.pressure_forces(p, 1.0);
        let mut u = vec![0.0; force.len()];
        factors.solve(&force, &mut u, &mut vec![0.0; factors.work_len()]);
        let opened: f64 = force.iter().zip(&u).map(|(f, u)| f * u).sum();
        let moved: f64 = held
            .outer_iterator()
            .zip(p)
            .map(|(row, p_k)| p_k * row.iter().map(|(l, v)| v * p[l]).sum::<f64>())
            .sum();
        [opened, moved]
    };
    let centers: Vec<[f64; 3]> = problem.faces().iter().map(|f| f.center).collect();
    let width = problem.faces()[0].area.sqrt();
    let even = |f: usize| {
        let n = problem.faces()[f].frame[0];
        let sum: f64 = (0..3)
            .filter(|i| n[*i].abs() < 0.5)
            .map(|i| (centers[f][i] / width).floor())
            .sum();
        sum.rem_euclid(2.0) < 0.5
    };
    let checkerboard: Vec<f64> = (0..faces)
        .map(|f| if even(f) { 1e6 } else { -1e6 })
        .collect();
    let [uniform, _] = energies(&vec![1e6; faces]);
    let [opened, moved] = energies(&checkerboard);
    assert!(opened < 1e-12 * uniform, "{opened:e} {uniform:e}");
    // as the jump stabilization holds a checkerboard of normal tractions
    let h = stick.h.as_ref().unwrap();
    let of_traction: f64 = (0..faces)
        .map(|k| {
            let row = h.outer_view(3 * k).unwrap();
            checkerboard[k]
                * row
                    .iter()
                    .filter(|(l, _)| l % 3 == 0)
                    .map(|(l, v)| v * checkerboard[l / 3])
                    .sum::<f64>()
        })
        .sum();
    assert!(
        moved > 0.0 && (moved - of_traction).abs() < 1e-9 * moved,
        "{moved:e} {of_traction:e}"
    );
    println!(
        "a checkerboard costs {:.3} of a uniform pressure",
        moved / uniform
    );
    assert!(moved > 0.05 * uniform);
}
