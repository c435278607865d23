//! Claim: what is uniform in every level layer is reproduced exactly beside a fault that sticks and crosses them: tractions of layers that are
//! strained or depleted, and rest under their weight, whatever the contrast, the dip, the grading, and where the fault ends. A fault that is
//! opened keeps nothing of the stress of before.

use fracas::contact::{ContactState, Interfaces, JumpStabilization};
use fracas::nonlinear::{Simulation, State};
use fracas::scene::{Body, Scene};
use fracas_operators::random::Random;
use fracas_solvers::Silent;

const POISSON: f64 = 0.25;

/// Scenes tried of each kind.
const CASES: u64 = 24;

/// Layers from the ground down, each of at least three rows of cells, and a fault.
struct Section {
    /// Young's modulus [Pa] and fall of pore pressure [Pa] per layer.
    rocks: Vec<[f64; 2]>,
    /// z of their tops [m], descending, and of the bottom.
    tops: Vec<f64>,
    toml: String,
}

/// Random layers; the fault reaches the ground, the base, both or neither.
fn section(r: &mut Random, strain: f64) -> Section {
    let n = r.whole(2, 4) as usize;
    let mut lines = vec![0.0];
    let (mut tops, mut rocks, mut materials) = (Vec::new(), Vec::new(), String::new());
    for i in 0..n {
        let z: f64 = *lines.last().unwrap();
        tops.push(z);
        let height = r.between(20.0, 60.0);
        let growth = r.between(0.7, 1.4);
        // where the fault ends within a layer its patch has a row less
        let rows = r.whole(3, 5);
        (0..rows).fold(z, |z, k| {
            lines.push(z - height * growth.powi(k as i32));
            *lines.last().unwrap()
        });
        let young = r.scale(1e9, 1e11);
        // less than what opens the fault
        rocks.push([young, r.between(0.0, strain * young)]);
        let [young, fall] = rocks[i];
        materials += &format!(
            "[[material]]\nname = 'm{i}'\nyoung = '{young} Pa'\npoisson = {POISSON}\ndensity = '{} kg/m3'\nPORE{i}layers = [['{} m', '{z} m']]\n",
            r.between(1500.0, 2700.0),
            lines.last().unwrap(),
        );
        let pore = format!("pressure_change = '{} Pa'\n", -fall);
        materials = materials.replace(&format!("PORE{i}"), &pore);
    }
    tops.push(*lines.last().unwrap());
    lines.reverse();
    let last = lines.len() - 1;
    let below = if r.chance(0.5) { 0 } else { 1 };
    let above = if r.chance(0.5) { last } else { last - 1 };
    let quoted: Vec<String> = lines.iter().map(|z| format!("'{z} m'")).collect();
    let toml = format!(
        "title = 'layers'\n[mesh]\nx = {{ from = '-300 m', to = '300 m', cells = 6 }}\ny = {{ from = '0 m', to = '60 m', cells = {} }}\nz = {{ lines = [{}] }}\n\
         {materials}[[fracture]]\nname = 'f'\nplane = 'x'\nat = '0 m'\nz = ['{} m', '{} m']\nfriction_angle = '60 deg'\ncohesion = '1 GPa'\n",
        r.whole(1, 2),
        quoted.join(", "),
        lines[below],
        lines[above],
    );
    Section { rocks, tops, toml }
}

fn rollers(sides: &[&str]) -> String {
    let of = |side: &&str| format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    sides.iter().map(of).collect()
}

fn at_rest(toml: &str) -> (Body, State) {
    let scene = Scene::from_toml(toml, "layers.toml").unwrap_or_else(|e| panic!("{e}\n{toml}"));
    let body = scene.build().unwrap_or_else(|e| panic!("{e}\n{toml}"));
    let mut simulation = Simulation::new(&body).unwrap();
    let start = simulation.initial_state();
    let state = simulation.advance(&start, &mut Silent).unwrap().state;
    (body, state)
}

impl Section {
    fn layer_at(&self, z: f64) -> usize {
        self.tops[1..].iter().take_while(|top| **top > z).count()
    }
}

#[test]
fn layers_that_are_strained_and_depleted_have_their_tractions() {
    for seed in 0..CASES {
        let r = &mut Random::new(seed);
        let strain = r.between(1e-5, 1e-3);
        let section = section(r, strain);
        let toml = format!(
            "{}{}[[boundary]]\nside = 'x+'\ndisplacement = {{ x = '{} m' }}\n",
            section.toml,
            rollers(&["x-", "y-", "y+", "z-"]),
            -600.0 * strain
        );
        let (body, state) = at_rest(&toml);
        // plane strain along y, nothing above: total stress across the fault
        let exact = |layer: usize| {
            let [young, fall] = section.rocks[layer];
            let free = (1.0 - 2.0 * POISSON) / (1.0 - POISSON);
            -young / (1.0 - POISSON * POISSON) * strain + free * fall
        };
        let size = (0..section.rocks.len()).fold(0.0f64, |m, l| m.max(exact(l).abs()));
        for (face, t) in body.fractures.faces.iter().zip(state.t.chunks_exact(3)) {
            let expected = exact(section.layer_at(face.center[2]));
            let off = (t[0] - expected).abs().max(t[1].abs()).max(t[2].abs());
            assert!(off < 1e-6 * size, "seed {seed}: {t:?}, {expected}\n{toml}");
        }
    }
}

#[test]
fn level_layers_rest_under_their_weight_wherever_a_fault_ends() {
    for seed in 0..CASES {
        let r = &mut Random::new(1000 + seed);
        let [k_x, k_y] = [0, 1].map(|_| r.between(0.5, 1.1));
        let section = section(r, 1e-4);
        let mut toml = section.toml.clone();
        for i in 0..section.rocks.len() {
            let pore = format!("pressure_change = '{} Pa'\n", -section.rocks[i][1]);
            toml = toml.replace(&pore, "");
        }
        let fluid = if r.chance(0.5) {
            ", fluid = '1000 kg/m3'"
        } else {
            ""
        };
        let [bottom, top] = [section.tops.last().unwrap(), &0.0];
        // it stays within half of the box
        let lean = (150.0 / bottom.abs()).atan().to_degrees().min(40.0);
        let dip = 90.0 + r.between(-lean, lean);
        toml += &format!(
            "[mesh.map]\nshear = [{{ plane = 'x', at = '0 m', level = '-50 m', dip = '{dip} deg', z = ['{bottom} m', '{top} m'] }}]\n[gravity]\nz = '-10 m/s2'\n[initial_stress]\nweight = {{ horizontal = [{k_x}, {k_y}]{fluid} }}\n{}",
            rollers(&["x-", "x+", "y-", "y+", "z-"])
        );
        let (body, state) = at_rest(&toml);
        let moved = state.u.iter().fold(0.0f64, |m, u| m.max(u.abs()));
        assert!(moved < 1e-9, "seed {seed}: {moved} m\n{toml}");
        for (face, t) in body.fractures.faces.iter().zip(state.t.chunks_exact(3)) {
            let pull = body.initial_pull_at(face, face.center, face.frame[0]);
            for k in 0..3 {
                let expected: f64 = (0..3).map(|i| face.frame[k][i] * pull[i]).sum();
                assert!(
                    (t[k] - expected).abs() < 1e-6 * t[0].abs(),
                    "seed {seed}: {t:?}\n{toml}"
                );
            }
        }
    }
}

#[test]
fn an_opened_fault_is_the_side_of_half_a_body() {
    for seed in 0..CASES {
        let r = &mut Random::new(2000 + seed);
        let [k_x, k_y] = [0, 1].map(|_| r.between(0.5, 1.1));
        let section = section(r, 1e-4);
        let [bottom, top] = [*section.tops.last().unwrap(), 0.0];
        // more than the stress of its deepest face, at most 2700 kg/m³
        let pressure = r.between(1.1, 2.0) * 27000.0 * k_x * bottom.abs();
        let (body, _) = section.toml.split_once("[[fracture]]").unwrap();
        let weight = format!(
            "[gravity]\nz = '-10 m/s2'\n[initial_stress]\nweight = {{ horizontal = [{k_x}, {k_y}] }}\n"
        );
        let whole = format!(
            "{body}{weight}[[fracture]]\nname = 'f'\nplane = 'x'\nat = '0 m'\nz = ['{bottom} m', '{top} m']\nfriction_angle = '30 deg'\npressure = '{pressure} Pa'\n{}",
            rollers(&["x-", "x+", "y-", "y+", "z-"])
        );
        let half = format!(
            "{}{weight}[[boundary]]\nside = 'x+'\npressure = '{pressure} Pa'\n{}",
            body.replace("to = '300 m', cells = 6", "to = '0 m', cells = 3"),
            rollers(&["x-", "y-", "y+", "z-"])
        );
        let (whole, half) = (at_rest(&whole), at_rest(&half));
        assert!(whole.1.t.iter().all(|t| *t == 0.0), "seed {seed}");
        let moved = |(body, state): &(Body, State)| -> Vec<[[f64; 3]; 2]> {
            let u = body.constraints.expand(&state.u);
            let of_node = |n: u32| {
                let place = body.mesh.nodes[n as usize];
                [place, [0, 1, 2].map(|i| u[3 * n as usize + i])]
            };
            let elements = body.mesh.elements.iter().map(|e| e.map(of_node));
            let is_left = |nodes: &[[[f64; 3]; 2]; 8]| nodes.iter().all(|[x, _]| x[0] <= 0.0);
            elements.filter(is_left).flatten().collect()
        };
        let (found, expected) = (moved(&whole), moved(&half));
        let size = expected
            .iter()
            .flat_map(|[_, u]| u)
            .fold(0.0f64, |m, u| m.max(u.abs()));
        assert_eq!(found.len(), expected.len());
        for ([x, u], [y, v]) in found.iter().zip(&expected) {
            assert_eq!(x, y, "seed {seed}");
            let off = (0..3).fold(0.0f64, |m, i| m.max((u[i] - v[i]).abs()));
            assert!(off < 1e-6 * size, "seed {seed}: {u:?}, {v:?} at {x:?}");
        }
    }
}

#[test]
fn materials_are_told_apart_by_what_they_do() {
    for seed in 0..CASES {
        let r = &mut Random::new(3000 + seed);
        let section = section(r, 1e-4);
        let [young, fall] = section.rocks[0];
        let mut one = section.toml.clone();
        for [own, own_fall] in &section.rocks[1..] {
            one = one.replace(
                &format!("young = '{own} Pa'"),
                &format!("young = '{young} Pa'"),
            );
            one = one.replace(&format!("'{} Pa'", -own_fall), &format!("'{} Pa'", -fall));
        }
        let pressed = one.replacen(&format!("'{} Pa'", -fall), "'0 Pa'", 1);
        let h = |toml: &str| {
            let toml = format!("{toml}{}", rollers(&["x-", "x+", "y-", "y+", "z-"]));
            let body = Scene::from_toml(&toml, "layers.toml")
                .unwrap()
                .build()
                .unwrap();
            let of = |form| body.stick_system(Some(form)).stabilization().unwrap();
            let apart = body.jump_stabilization();
            let joined = JumpStabilization {
                interfaces: Interfaces::Joined,
                ..apart
            };
            [of(apart), of(joined)]
        };
        let ([own, all], [parts, whole]) = (h(&one), h(&pressed));
        assert!(own == all && whole == all, "seed {seed}");
        assert!(parts.nnz() < all.nnz(), "seed {seed}");
    }
}

/// The load ends where a face opens, and a face may open with it and close without it: the work of every step goes somewhere all the same.
#[test]
fn the_energy_of_faults_that_open_from_above_closes() {
    let (mut open, mut disputed) = (0, 0);
    for seed in 0..CASES {
        let r = &mut Random::new(4000 + seed);
        let section = section(r, 1e-4);
        let [k_x, k_y] = [0, 1].map(|_| r.between(0.5, 1.1));
        let bottom = section.tops.last().unwrap();
        let pressure = r.between(0.1, 1.0) * 20000.0 * k_x * bottom.abs();
        let toml = format!(
            "{}pressure = '{pressure} Pa'\npressure_history = [['0 s', 0], ['1 s', 1], ['2 s', 0]]\n[time]\nend = '2 s'\nsteps = 12\n[gravity]\nz = '-10 m/s2'\n[initial_stress]\nweight = {{ horizontal = [{k_x}, {k_y}] }}\n{}",
            section.toml.replace("cohesion = '1 GPa'\n", ""),
            rollers(&["x-", "x+", "y-", "y+", "z-"])
        );
        let scene =
            Scene::from_toml(&toml, "layers.toml").unwrap_or_else(|e| panic!("{e}\n{toml}"));
        let body = scene.build().unwrap_or_else(|e| panic!("{e}\n{toml}"));
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        let mut largest = 0.0f64;
        while state.step == 0 || !simulation.is_finished(&state) {
            let done = simulation.advance(&state, &mut Silent);
            let after = done
                .unwrap_or_else(|e| panic!("seed {seed}: {}\n{toml}", e.reason))
                .state;
            let energy = simulation.energy(&state, &after);
            largest = largest.max(
                energy.external_work.abs() + energy.pressure_work.abs() + energy.elastic_energy,
            );
            assert!(
                energy.error.abs() < 1e-7 * largest,
                "seed {seed}: {energy:?}\n{toml}"
            );
            let is_open = |f: usize| after.states[f] == ContactState::Open;
            open += (0..after.states.len()).filter(|f| is_open(*f)).count();
            disputed += (0..after.states.len())
                .filter(|f| is_open(*f) && !after.released[*f])
                .count();
            state = after;
        }
    }
    println!("{open} open faces, {disputed} of them under the pull of closed ones");
    assert!(open > 100 && disputed > 0, "{open}, {disputed}");
}
