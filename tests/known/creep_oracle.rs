//! Claim: over random hexahedra, rocks, viscosities, loads and steps, creep is that of a dense implementation that shares no code, and its
//! operators are the same assembled and not.

use fracas::nonlinear::{ContactProblem, Simulation};
use fracas::scene::{Body, Scene};
use fracas_operators::random::signed;
use fracas_operators::{LinearOperator, sparse::Csr};
use fracas_solvers::Silent;
use std::fmt::Write;

fn number(seed: u64, k: u64) -> f64 {
    signed(seed.wrapping_mul(0x9e37_79b9).wrapping_add(k))
}

/// A distorted box of rocks of which about half creep, under gravity, an initial stress, a load that changes and a side that moves.
fn scene(seed: u64) -> String {
    let between = |k: u64, low: f64, high: f64| low + 0.5 * (high - low) * (1.0 + number(seed, k));
    let cells = |k: u64| 2 + (1.5 * (1.0 + number(seed, k))) as usize;
    let mut toml = format!(
        "title = 'Random creep'\n[mesh]\nx = {{ from = '0 m', to = '3 m', cells = {} }}\ny = {{ from = '0 m', to = '2 m', cells = {} }}\n\
         z = {{ from = '0 m', to = '4 m', cells = {} }}\n[mesh.map.distort]\namplitude = 0.15\nseed = {}\n",
        cells(1),
        cells(2),
        cells(3),
        seed % 1000
    );
    for (m, layer) in [
        "",
        "layers = [['0 m', '1.4 m']]",
        "layers = [['2.1 m', '4 m']]",
    ]
    .iter()
    .enumerate()
    {
        let k = 10 * m as u64 + 20;
        let creeps = m != (seed % 3) as usize;
        let viscosity = match creeps {
            true => format!(
                "viscosity = '{:e} Pa*s'",
                10f64.powf(between(k, 15.5, 18.0))
            ),
            false => String::new(),
        };
        let _ = writeln!(
            toml,
            "[[material]]\nname = 'm{m}'\nyoung = '{} GPa'\npoisson = {}\ndensity = '2000 kg/m3'\n{viscosity}\n{layer}",
            10f64.powf(between(k + 1, 0.0, 1.5)),
            between(k + 2, 0.05, 0.4)
        );
    }
    let bend = between(60, 0.1, 0.9);
    let _ = writeln!(
        toml,
        "[time]\nend = '3e7 s'\nsteps = 4\n[gravity]\nz = '-9.81 m/s2'\n\
         [initial_stress]\nconstant = {{ xx = '{} MPa', zz = '-2 MPa', xy = '0.3 MPa' }}\ngradient = {{ yy = '0.1 MPa/m' }}\n\
         [[boundary]]\nside = 'z-'\nhold = 'fixed'\n\
         [[boundary]]\nside = 'z+'\ntraction = {{ x = '2 MPa', z = '-3 MPa' }}\nhistory = [['0 s', 0.3], ['{} s', 1], ['3e7 s', -0.5]]\n\
         [[boundary]]\nside = 'x+'\ndisplacement = {{ x = '0.2 mm' }}\nhistory = [['0 s', {}], ['2e7 s', 1]]\n[solver]\ntolerance = 1e-12",
        between(61, -3.0, 1.0),
        3e7 * bend,
        between(62, -1.0, 1.0)
    );
    toml
}

/// Deviatoric stresses and displacements step by step, in dense matrices: at each Gauss point
/// `s' = e^(−x) s + 2G (1 − e^(−x))/x Δe`.
struct Dense<'b> {
    body: &'b Body,
    /// Total deviator per element and Gauss point, 3×3.
    s: Vec<[[[f64; 3]; 3]; 8]>,
    u: Vec<f64>,
}

/// Gradients of the eight shape functions and the weight at Gauss point q.
fn gradients(x: &[[f64; 3]; 8], q: usize) -> ([[f64; 3]; 8], f64, [f64; 8]) {
    const SIGNS: [[f64; 3]; 8] = [
        [-1.0, -1.0, -1.0],
        [1.0, -1.0, -1.0],
        [1.0, 1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
    ];
    let p = SIGNS[q].map(|s| s / 3f64.sqrt());
    let one = |a: usize, d: usize| 1.0 + SIGNS[a][d] * p[d];
    let shape = std::array::from_fn(|a| one(a, 0) * one(a, 1) * one(a, 2) / 8.0);
    let local: [[f64; 3]; 8] = std::array::from_fn(|a| {
        std::array::from_fn(|d| SIGNS[a][d] * one(a, (d + 1) % 3) * one(a, (d + 2) % 3) / 8.0)
    });
    let mut j = [[0.0; 3]; 3];
    for a in 0..8 {
        for r in 0..3 {
            for c in 0..3 {
                j[r][c] += local[a][r] * x[a][c];
            }
        }
    }
    // J⁻ᵀ by its cofactors: rows of local gradients are divided by J
    let minor = |r: usize, c: usize| {
        let [r, c] = [r, c].map(|i| [(i + 1) % 3, (i + 2) % 3]);
        j[r[0]][c[0]] * j[r[1]][c[1]] - j[r[0]][c[1]] * j[r[1]][c[0]]
    };
    let det: f64 = (0..3).map(|c| j[0][c] * minor(0, c)).sum();
    let of_node = |a: usize| {
        std::array::from_fn(|i| (0..3).map(|r| minor(r, i) * local[a][r]).sum::<f64>() / det)
    };
    (std::array::from_fn(of_node), det, shape)
}

fn deviator(mut s: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mean = (s[0][0] + s[1][1] + s[2][2]) / 3.0;
    (0..3).for_each(|i| s[i][i] -= mean);
    s
}

fn full(v: [f64; 6]) -> [[f64; 3]; 3] {
    [[v[0], v[3], v[5]], [v[3], v[1], v[4]], [v[5], v[4], v[2]]]
}

impl<'b> Dense<'b> {
    fn new(body: &'b Body) -> Self {
        let mut dense = Self {
            body,
            s: vec![[[[0.0; 3]; 3]; 8]; body.mesh.elements.len()],
            u: vec![0.0; 3 * body.mesh.nodes.len()],
        };
        let stress = body.initial_stress.unwrap();
        for e in 0..dense.s.len() {
            let x = dense.corners(e);
            for q in 0..8 {
                let (_, _, shape) = gradients(&x, q);
                let at = [0, 1, 2].map(|i| (0..8).map(|a| shape[a] * x[a][i]).sum());
                dense.s[e][q] = deviator(full(stress.at(at)));
            }
        }
        dense
    }

    fn corners(&self, e: usize) -> [[f64; 3]; 8] {
        self.body.mesh.elements[e].map(|a| self.body.mesh.nodes[a as usize])
    }

    /// Displacements after a step to `time`, with these prescribed ones.
    fn step(&mut self, time: f64, dt: f64, held: &[f64]) {
        let body = self.body;
        let n = self.u.len();
        let mut k = faer::Mat::<f64>::zeros(n, n);
        let mut f = vec![0.0; n];
        for h in 0..body.histories.len() {
            let factor = body.histories[h].at(time);
            for (f, own) in f.iter_mut().zip(body.forces_of(h).unwrap()) {
                *f += factor * own;
            }
        }
        let stress = body.initial_stress.unwrap();
        let mut kept = Vec::new();
        for (e, nodes) in body.mesh.elements.iter().enumerate() {
            let region = usize::from(body.mesh.regions[e]);
            let rock = body.materials[region];
            let shear = rock.young / 2.0 / (1.0 + rock.poisson);
            let bulk = rock.young / 3.0 / (1.0 - 2.0 * rock.poisson);
            let (alpha, phi) = match body.viscosities[region] {
                Some(eta) if dt > 0.0 => {
                    let x = dt * shear / eta;
                    ((-x).exp(), (1.0 - (-x).exp()) / x)
                }
                _ => (1.0, 1.0),
            };
            kept.push((alpha, phi, shear));
            let x = self.corners(e);
            let mut own = [[0.0; 24]; 24];
            for q in 0..8 {
                let (g, w, shape) = gradients(&x, q);
                let at = [0, 1, 2].map(|i| (0..8).map(|a| shape[a] * x[a][i]).sum());
                let first = deviator(full(stress.at(at)));
                let strain = deviator(strain(&g, nodes, &self.u));
                let soft = phi * shear;
                for (a, na) in nodes.iter().enumerate() {
                    for i in 0..3 {
                        for j in 0..3 {
                            // what is remembered, less the initial stress, which is a load
                            let memory = alpha * self.s[e][q][i][j]
                                - first[i][j]
                                - 2.0 * soft * strain[i][j];
                            f[3 * *na as usize + i] -= w * g[a][j] * memory;
                        }
                    }
                    for b in 0..8 {
                        let dot: f64 = (0..3).map(|d| g[a][d] * g[b][d]).sum();
                        for i in 0..3 {
                            for j in 0..3 {
                                let delta = if i == j { dot } else { 0.0 };
                                let entry = (bulk - 2.0 / 3.0 * soft) * g[a][i] * g[b][j]
                                    + soft * (g[a][j] * g[b][i] + delta);
                                own[3 * a + i][3 * b + j] += w * entry;
                            }
                        }
                    }
                }
            }
            for (r, row) in own.iter().enumerate() {
                for (c, entry) in row.iter().enumerate() {
                    let [r, c] = [r, c].map(|local| 3 * nodes[local / 3] as usize + local % 3);
                    k[(r, c)] += entry;
                }
            }
        }
        for (dof, _) in body.constraints.prescribed() {
            let d = *dof as usize;
            for c in 0..n {
                k[(d, c)] = if c == d { 1.0 } else { 0.0 };
            }
            f[d] = held[d];
        }
        use faer::linalg::solvers::Solve;
        let rhs = faer::Mat::from_fn(n, 1, |i, _| f[i]);
        let solved = k.partial_piv_lu().solve(&rhs);
        let next: Vec<f64> = (0..n).map(|i| solved[(i, 0)]).collect();
        for (e, nodes) in body.mesh.elements.iter().enumerate() {
            let x = self.corners(e);
            let (alpha, phi, shear) = kept[e];
            for q in 0..8 {
                let (g, _, _) = gradients(&x, q);
                let [a, b] = [&self.u, &next].map(|u| deviator(strain(&g, nodes, u)));
                for i in 0..3 {
                    for j in 0..3 {
                        let s = &mut self.s[e][q][i][j];
                        *s = alpha * *s + 2.0 * shear * phi * (b[i][j] - a[i][j]);
                    }
                }
            }
        }
        self.u = next;
    }
}

fn strain(g: &[[f64; 3]; 8], nodes: &[u32; 8], u: &[f64]) -> [[f64; 3]; 3] {
    let mut h = [[0.0; 3]; 3];
    for (a, node) in nodes.iter().enumerate() {
        for i in 0..3 {
            for j in 0..3 {
                h[i][j] += u[3 * *node as usize + i] * g[a][j];
            }
        }
    }
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (h[i][j] + h[j][i])))
}

#[test]
fn a_dense_implementation_finds_the_same() {
    let mut lengths = 0;
    for seed in 0..24 {
        let toml = scene(seed);
        let body = Scene::from_toml(&toml, "random.toml")
            .unwrap()
            .build()
            .unwrap();
        let mut simulation = Simulation::new(&body).unwrap();
        let mut dense = Dense::new(&body);
        let mut state = simulation.initial_state();
        let mut before = 0.0;
        while state.step == 0 || !simulation.is_finished(&state) {
            let accepted = simulation.advance(&state, &mut Silent).unwrap();
            let next = accepted.state;
            let held = simulation.problem().loads().prescribed_at(next.time, 1.0);
            let zero = vec![0.0; held.free_len()];
            let dt = next.time - state.time;
            lengths += usize::from((dt - before).abs() > 1e-6 * dt);
            before = dt;
            dense.step(next.time, dt, &held.expand(&zero));
            let u = simulation.displacement(&next);
            let size = dense.u.iter().fold(0.0f64, |m, u| m.max(u.abs()));
            for (i, (a, b)) in u.iter().zip(&dense.u).enumerate() {
                assert!(
                    (a - b).abs() <= 1e-7 * size,
                    "seed {seed}, {} s, dof {i}: {a} {b}\n{toml}",
                    next.time
                );
            }
            let energy = simulation.energy(&state, &next);
            let work = energy.external_work.abs() + energy.elastic_energy;
            assert!(energy.error.abs() <= 1e-7 * work, "seed {seed}: {energy:?}");
            assert!(energy.creep_dissipation >= 0.0, "seed {seed}: {energy:?}");
            state = next;
        }
    }
    assert!(lengths > 60, "steps change their length: {lengths}");
}

#[test]
fn products_are_the_same_assembled_and_not() {
    for seed in 0..6 {
        let toml = scene(seed).replace(
            "[time]",
            "[[fracture]]\nname = 'cut'\nplane = 'z'\nat = '2 m'\nfriction_angle = '30 deg'\n[time]",
        );
        let toml = toml.replacen("to = '4 m', cells = ", "to = '4 m', cells = 4 #", 1);
        let toml = match seed % 2 {
            0 => toml,
            _ => toml.replace(
                &format!(
                    "[mesh.map.distort]\namplitude = 0.15\nseed = {}\n",
                    seed % 1000
                ),
                "",
            ),
        };
        let toml = toml
            .replace("4 #2 }", "4 }")
            .replace("4 #3 }", "4 }")
            .replace("4 #4 }", "4 }");
        let body = Scene::from_toml(&toml, "random.toml")
            .unwrap()
            .build()
            .unwrap();
        let mut problem = ContactProblem::new(&body).unwrap();
        let elastic = problem.stick_blocks().unwrap();
        for step in [0.0, 1e5, 3e7, 1e9] {
            problem.take_step(step).unwrap();
            let blocks = problem.stick_blocks().unwrap();
            let n = blocks.n_u();
            let x: Vec<f64> = (0..n).map(|k| number(seed + 77, k as u64)).collect();
            let of = |a: &dyn LinearOperator<f64>| {
                let mut y = vec![0.0; n];
                a.apply(&x, &mut y, &mut vec![0.0; a.work_len()]);
                y
            };
            let (a, b) = (
                of(problem.saddle().stiffness()),
                of(&Csr::new(blocks.a.clone())),
            );
            let size = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            for (a, b) in a.iter().zip(&b) {
                assert!((a - b).abs() <= 1e-12 * size, "step {step}: {a} {b}");
            }
            // H does not follow the length of a step, A does
            assert_eq!(blocks.h, elastic.h);
            let softer = (of(&Csr::new(elastic.a.clone())).iter().zip(&b)).any(|(a, b)| a != b);
            assert_eq!(softer, step > 0.0);
        }
    }
}
