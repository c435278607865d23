//! Claim: an inner solver that the program chose and with which the iteration gets nowhere gives way to one that solves the system; one that was
//! asked for by name does not.

use fracas::contact::ContactState;
use fracas::nonlinear::{Event, Simulation};
use fracas::scene::Scene;
use fracas::solve::{End, InnerRule, Problem, Solve, Solved, Solver};
use fracas_operators::random::Random;
use fracas_solvers::Silent;
use fracas_solvers::saddle::folder::{Manifest, write_folder};
use fracas_solvers::saddle::{Racp, SaddleMethod};

/// Networks that are tried.
const NETWORKS: u64 = 3;

/// Beyond the displacements up to which the program factorizes: 12 × 12 × 12 cells, flat along one axis by 1:3 to 1:300, fractures on every or
/// every second line across two axes, held on two sides and pressed on others, so much that nothing slips or opens.
fn network(seed: u64) -> Scene {
    let r = &mut Random::new(seed);
    let axes = ["x", "y", "z"];
    let flat = r.whole(0, 2) as usize;
    let open = (flat + r.whole(1, 2) as usize) % 3;
    let thick = 1.0 / r.scale(3.0, 300.0);
    let mut toml = format!("title = 'seed {seed}'\n[mesh]\n");
    for (d, axis) in axes.iter().enumerate() {
        let to = if d == flat { 12.0 * thick } else { 12.0 };
        toml += &format!("{axis} = {{ from = '0 m', to = '{to} m', cells = 12 }}\n");
    }
    toml += "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n";
    for axis in axes.iter().enumerate().filter(|(d, _)| *d != open) {
        let (d, axis) = axis;
        let every = if d == flat { r.whole(1, 2) } else { 2 };
        toml += &format!(
            "[[fracture]]\nname = '{axis}'\nplane = '{axis}'\nevery = {every}\nfriction_angle = '30 deg'\ncohesion = '1 GPa'\n"
        );
    }
    for (d, axis) in axes.iter().enumerate() {
        let far = if d == open {
            "hold = 'fixed'"
        } else {
            "pressure = '1 MPa'"
        };
        let near = if d == open { "fixed" } else { "roller" };
        toml += &format!(
            "[[boundary]]\nside = '{axis}-'\nhold = '{near}'\n[[boundary]]\nside = '{axis}+'\n{far}\n"
        );
    }
    Scene::from_toml(&toml, "scene.toml").unwrap()
}

/// Few enough iterations for multigrid to get nowhere in some networks, and enough for a factorization.
fn chosen() -> Solve {
    Solve {
        inner: InnerRule::Auto,
        max_iterations: 60,
        ..Solve::default()
    }
}

fn exact() -> Solve {
    Solve {
        inner: InnerRule::Fixed,
        max_iterations: 1000,
        ..Solve::default()
    }
}

/// Largest difference of displacements and of tractions, each relative to the largest.
fn apart(a: &Solved, b: &Solved) -> f64 {
    let off = |a: &[f64], b: &[f64]| {
        let largest = |v: &mut dyn Iterator<Item = f64>| v.fold(0.0f64, |m, v| m.max(v.abs()));
        largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest(&mut b.iter().copied())
    };
    off(a.displacements(), b.displacements()).max(off(a.tractions(), b.tractions()))
}

#[test]
fn flat_networks_are_solved_whichever_inner_solver_gets_nowhere() {
    let mut gave_way = 0;
    for seed in 0..NETWORKS {
        let problem = Problem::from(network(seed));
        // geometric multigrid has no time to converge in the first ones
        let few = Solve {
            max_iterations: if seed < 2 { 8 } else { 60 },
            ..chosen()
        };
        let mut solver = few.set_up(&problem, &mut Silent).unwrap();
        solver.set_max_iterations(few.max_iterations);
        let solved = solver.solve(&mut Silent).unwrap();
        let reference = exact().solve(&problem, &mut Silent).unwrap();
        assert!(reference.has_converged(), "seed {seed}");
        gave_way += solved.inner_fallbacks;
        if !solved.has_converged() {
            // a limit is a limit: the factorization has no more iterations than multigrid
            assert_eq!(solved.inner.as_deref(), Some("exact"), "seed {seed}");
            assert!(reference.iterations > few.max_iterations, "seed {seed}");
            continue;
        }
        let off = apart(&solved, &reference);
        assert!(off < 1e-6, "seed {seed}: off by {off:.1e}");
    }
    assert!(gave_way > 0);
}

/// The seed of a slow network for what follows.
fn slow() -> Scene {
    network(0)
}

/// After the iterations that are told, by an inner solver that is not the first one.
fn gives_way(solver: &mut Solver, most: usize) -> Solved {
    solver.set_max_iterations(most);
    let solved = solver.solve(&mut Silent).unwrap();
    assert_eq!(solved.inner_fallbacks, 1);
    assert_eq!(solved.inner.as_deref(), Some("exact"));
    let told = solved
        .findings
        .iter()
        .any(|f| f.to_string().contains("goes on from"));
    assert!(told, "{:?}", solved.findings);
    solved
}

#[test]
fn the_next_right_hand_side_begins_with_what_took_its_place_and_all_iterations_are_counted() {
    let problem = Problem::from(slow());
    let mut solver = chosen().set_up(&problem, &mut Silent).unwrap();
    let b: Vec<f64> = (0..solver.unknowns())
        .map(|i| (0.7 * i as f64).sin())
        .collect();
    solver.set_rhs(b.clone());
    let first = gives_way(&mut solver, 8);
    let mut reference = exact().set_up(&problem, &mut Silent).unwrap();
    reference.set_rhs(b);
    let reference = reference.solve(&mut Silent).unwrap();
    solver.set_max_iterations(1000);
    let second = solver.solve(&mut Silent).unwrap();
    assert!(second.has_converged());
    assert_eq!(second.inner_fallbacks, 1);
    assert!(apart(&second, &reference) < 1e-6);
    // those of the first inner solver beside those of the second
    assert!(first.iterations > 8 && first.iterations <= 16);
}

#[test]
fn a_folder_goes_on_from_half_of_its_matrix_with_all_of_it() {
    let body = slow().build().unwrap();
    let h = Some(body.jump_stabilization());
    let blocks = body.saddle_blocks(h).unwrap();
    let folder = std::env::temp_dir().join(format!("fracas-giving-way-{}", std::process::id()));
    write_folder(&folder, &blocks, &Manifest::default()).unwrap();
    let problem = Problem::Folder(folder.clone());
    let mut solver = chosen().set_up(&problem, &mut Silent).unwrap();
    gives_way(&mut solver, 8);
    solver.set_max_iterations(1000);
    let solved = solver.solve(&mut Silent).unwrap();
    let reference = exact().solve(&problem, &mut Silent).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(solved.has_converged() && reference.has_converged());
    assert!(apart(&solved, &reference) < 1e-6);
}

#[test]
fn an_inner_solver_asked_for_by_name_is_not_replaced_and_the_refusal_says_what_to_take() {
    let settings = Solve {
        method: SaddleMethod::Racp(Racp::geometric()),
        max_iterations: 4,
        ..exact()
    };
    let solved = settings.solve(&slow().into(), &mut Silent).unwrap();
    assert_eq!(solved.outcome, End::IterationLimit);
    assert_eq!(solved.inner_fallbacks, 0);
    let reason = solved.reason.unwrap();
    assert!(reason.contains("take inner = \"exact\""), "{reason}");
}

/// Of 400 iterations a run is left 6 per system: multigrid gives way, and the step ends as with the factorization.
#[test]
fn a_run_goes_on_with_another_inner_solver_and_keeps_it() {
    let advanced = |overrides: &[&str]| {
        let body = slow().with_overrides(overrides).unwrap().build().unwrap();
        let mut simulation = Simulation::new(&body).unwrap();
        let done = simulation.advance(&simulation.initial_state(), &mut Silent);
        let done = done.unwrap_or_else(|failure| panic!("{overrides:?}: {}", failure.reason));
        let inner = simulation.preconditioner().inner.name();
        (done, inner, simulation.inner_fallbacks())
    };
    let (done, inner, fallbacks) = advanced(&["solver.max_krylov=6"]);
    let (reference, named, none) = advanced(&["solver.inner=exact"]);
    assert_eq!((inner, named, fallbacks, none), ("exact", "exact", 1, 0));
    let told = |e: &&Event| matches!(e, Event::Inner { now: "exact", reason } if reason.contains("leaves a relative residual"));
    assert_eq!(done.events.iter().filter(told).count(), 1);
    assert!(done.record.lin_it > 6, "the iterations in vain are counted");
    let sticks = |s: &ContactState| *s == ContactState::Stick;
    assert!(
        done.state
            .states
            .iter()
            .chain(&reference.state.states)
            .all(sticks)
    );
    let largest = |v: &[f64]| v.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let off: Vec<f64> = (done.state.u.iter().zip(&reference.state.u))
        .map(|(a, b)| a - b)
        .collect();
    assert!(largest(&off) < 1e-5 * largest(&reference.state.u));
}
