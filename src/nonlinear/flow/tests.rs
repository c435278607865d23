use super::*;
use crate::nonlinear::Start;
use crate::scene::{Body, named};
use fracas_operators::LinearOperator;
use fracas_operators::random::Random;
use fracas_solvers::direct::{DirectChoice, Kind};
use fracas_solvers::saddle::{SaddleOperator, T, U};

/// The scene `tee` with a fluid.
fn body() -> Body {
    let scene = named("tee").unwrap();
    let mut toml = scene.toml.replace(
        "friction_angle",
        "conductivity = \"1e-12 m3\"\nstorage = \"1e-12 m/Pa\"\ninitial_pressure = \"1 MPa\"\nfriction_angle",
    );
    toml += "\n[fluid]\nviscosity = \"1e-3 Pa*s\"\ncompressibility = \"4e-10 1/Pa\"\n";
    let scene = crate::scene::Scene::from_toml(&toml, "tee.toml").unwrap();
    let sets = ["mesh.x.cells=8", "mesh.y.cells=2", "mesh.z.cells=8"];
    scene.with_overrides(&sets).unwrap().build().unwrap()
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
        let start = Start {
            jump: vec![0.0; 3 * faces],
            slip: vec![0.0; 2 * faces],
            t: vec![0.0; 3 * faces],
            torn: Vec::new(),
            limits_at: Vec::new(),
        };
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
            step: 1,
            attempt: 0,
        };
        let h = problem.stabilization(&states);
        let at = attempt.evaluate(&states, h.as_ref(), &x);
        let blocks = attempt
            .assembled(&states, (h.as_ref(), &x), &at, false)
            .unwrap();
        let flow = blocks.flow.as_ref().unwrap();
        // Q2 only where open
        let open = states.contains(&ContactState::Open);
        assert_eq!(flow.q2.nnz() > 0, open);
        let operator = SaddleOperator::new(&blocks);
        let layout = blocks.layout();
        let unit = problem.saddle().unit();
        for direction in 0..4 {
            let mut d = vec![0.0; layout.len()];
            let sizes = [(U, 1e-6), (T, 1e2), (P, 1e2)];
            for (field, size) in sizes {
                if direction == 3 || [U, T, P][direction] == field {
                    let part = &mut d[layout.range(field)];
                    part.iter_mut().for_each(|d| *d = number(-size, size));
                }
            }
            let mut product = vec![0.0; d.len()];
            operator.apply(&d, &mut product, &mut vec![0.0; operator.work_len()]);
            let moved = |s: f64| {
                let [u, t, p] = layout.split([U, T, P], &d);
                let mut y = x.clone();
                axpy(s, u, &mut y.u);
                axpy(s, t, &mut y.t);
                axpy(s, p, &mut y.p);
                attempt.evaluate(&states, h.as_ref(), &y).residual
            };
            // the residual is −r, its rows of tractions and pressures in the balanced unit
            let (plus, minus) = (moved(0.1), moved(-0.1));
            for (field, scale) in [(U, 1.0), (T, unit), (P, unit)] {
                let range = layout.range(field);
                let size = product[range.clone()]
                    .iter()
                    .fold(0.0f64, |m, v| m.max(v.abs()));
                for i in range {
                    let difference = (minus[i] - plus[i]) / (0.2 * scale);
                    assert!(
                        (difference - product[i]).abs() <= 1e-5 * size,
                        "seed {seed}, direction {direction}, {}: {i}: {difference:e} {:e}",
                        field.letter,
                        product[i]
                    );
                }
            }
        }
    }
}

#[test]
fn a_checkerboard_of_pressure_moves_no_rock_and_is_held_as_stiffly_as_one_of_traction() {
    // a closed square inside a body: its tips are not split
    let scene = named("checkerboard").unwrap();
    let mut toml = scene.toml.replace(
        "friction_angle",
        "conductivity = \"1e-30 m3\"\nfriction_angle",
    );
    if !toml.contains("conductivity") {
        toml = toml.replace(
            "[[fracture]]\n",
            "[[fracture]]\nconductivity = \"1e-30 m3\"\nfriction_angle = \"30 deg\"\n",
        );
    }
    toml += "\n[fluid]\nviscosity = \"1 Pa*s\"\n";
    let scene = crate::scene::Scene::from_toml(&toml, "checkerboard.toml").unwrap();
    let body = scene.build().unwrap();
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
