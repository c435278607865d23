use super::*;
use crate::contact::{ContactState, JumpStabilization};
use crate::elasticity::Elastic;
use crate::mesh::{Axis, BoxGrid, BuiltMesh, Grading, Incline, PlaneFracture};
use fracas_operators::random::Random;
use fracas_solvers::direct::{DirectChoice, Kind};

mod directed;
mod front;
mod leaning;
mod limits;
mod raised;
mod records;
mod reservoirs;
mod sealed;

const ROCK: Elastic = Elastic {
    young: 20e9,
    poisson: 0.2,
};

fn grid(cells: [usize; 3], fractures: Vec<PlaneFracture>) -> BoxGrid {
    let mut grid = BoxGrid::uniform([0.0; 3], [6.0, 5.0, 4.0], cells);
    grid.fractures = fractures;
    grid
}

fn fluid(conductivities: &[f64], sources: Vec<Source>) -> Fluid {
    let channel = |c: &f64| Channel {
        conductivity: *c,
        directed: None,
        storage: 0.0,
        initial_pressure: 0.0,
    };
    Fluid {
        viscosity: 1e-3,
        compressibility: 0.0,
        density: 0.0,
        gravity: [0.0; 3],
        reference: 0.0,
        channels: conductivities.iter().map(channel).collect(),
        sources,
        wells: Vec::new(),
    }
}

fn balance<'a>(fluid: &'a Fluid, built: &'a BuiltMesh) -> Balance<'a> {
    let form = JumpStabilization::default();
    Balance::new(fluid, &built.mesh, &built.fractures, &[ROCK], form)
}

/// Edges of one face whose middle has this coordinate along an axis.
fn outer_edges(built: &BuiltMesh, axis: usize, at: f64, fracture: Option<u16>) -> Vec<[u32; 2]> {
    let mut edges = Vec::new();
    for face in &built.fractures.faces {
        if fracture.is_some_and(|f| f != face.fracture) {
            continue;
        }
        for a in 0..4 {
            let ends = super::network::ends(face, &built.mesh, a);
            let x = ends.map(|n| built.mesh.nodes[n as usize][axis]);
            if x.iter().all(|x| (x - at).abs() < 1e-9) {
                edges.push(ends);
            }
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn held(place: Vec<[u32; 2]>, p: f64) -> Source {
    Source {
        place: Place::Edges(place),
        given: Given::Pressure(p),
        level: None,
        history: 0,
    }
}

fn step(balance: &Balance<'_>, faces: usize, dt: f64) -> FlowStep {
    balance.step([0.0, dt], vec![0.0; faces], vec![0.0; faces], |_, _| 1.0)
}

/// Solves the equations of closed faces at the controls of `step`, from the pressures at hand, and twice more for what rounding left.
fn solved(balance: &Balance<'_>, p: &[f64], step: &FlowStep) -> Vec<f64> {
    let n = p.len();
    let (closed, jumps) = (vec![ContactState::Stick; n], vec![0.0; 3 * n]);
    let mut p = p.to_vec();
    let tangent = balance.tangent(&closed, &jumps, &p, step);
    let solver = DirectChoice::default().solver().unwrap();
    let symbolic = solver.analyze(&tangent.t, Kind::General).unwrap();
    let factors = symbolic.factor(&tangent.t).unwrap();
    for _ in 0..3 {
        let point = balance.evaluate(&closed, &jumps, &p, step);
        let mut d = vec![0.0; n];
        factors.solve(&point.residual, &mut d, &mut vec![0.0; factors.work_len()]);
        p.iter_mut().zip(&d).for_each(|(p, d)| *p -= d);
    }
    p
}

/// Pressures of closed fractures, which are linear in what drives them.
fn rigid(balance: &Balance<'_>, step: &FlowStep) -> Vec<f64> {
    let n = step.pressure.len();
    let p = solved(balance, &step.pressure, step);
    let left = balance.evaluate(&vec![ContactState::Stick; n], &vec![0.0; 3 * n], &p, step);
    assert!(left.relative() < 1e-11, "{}", left.relative());
    p
}

#[test]
fn a_plane_between_two_pressures_lets_the_flow_of_darcys_law_through() {
    for tilt in [false, true] {
        let mut grid = grid([12, 5, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        grid.axes[0] = Axis::Cells {
            from: 0.0,
            to: 6.0,
            cells: 12,
            grading: Grading::Geometric { ratio: 5.0 },
        };
        if tilt {
            grid.warps = vec![Box::new(Incline {
                plane: 2,
                along: 0,
                tilt: 0.5,
                pivot: [3.0, 0.0, 2.0],
                fade: false,
            })];
        }
        let built = grid.build().unwrap();
        let sources = vec![
            held(outer_edges(&built, 0, 0.0, None), 3e6),
            held(outer_edges(&built, 0, 6.0, None), 1e6),
        ];
        let (c, dp, b) = (2e-13, 2e6, 5.0);
        let fluid = fluid(&[c], sources);
        let balance = balance(&fluid, &built);
        let n = built.fractures.faces.len();
        let step = step(&balance, n, 10.0);
        let p = rigid(&balance, &step);
        let length = 6.0 / if tilt { 0.5f64.cos() } else { 1.0 };
        let expected = c * b * dp / (1e-3 * length);
        let closed = vec![ContactState::Stick; n];
        let q = balance.fluxes(&closed, &vec![0.0; 3 * n], &p, &step);
        for (q, face) in q.chunks_exact(3).zip(&built.fractures.faces) {
            let size = q.iter().map(|q| q * q).sum::<f64>().sqrt();
            assert!(
                (size * b - expected).abs() < 1e-10 * expected,
                "{size} at {:?}",
                face.center
            );
            assert!(q[0] > 0.0 && q[1].abs() < 1e-10 * size);
        }
    }
}

/// Two planes that cross, arms of lengths 2, 4 along x and 1, 3 along z, the ends at these pressures.
fn cross(
    conductivity: [f64; 2],
    ends: [f64; 4],
    flip: bool,
    swap: bool,
) -> (f64, Vec<([f64; 3], f64)>) {
    let mut planes = vec![
        PlaneFracture::through("F", 2, 1.0),
        PlaneFracture::through("G", 0, 2.0),
    ];
    planes[1].flip = flip;
    let mut c = conductivity;
    if swap {
        planes.swap(0, 1);
        c.swap(0, 1);
    }
    let built = grid([6, 1, 4], planes).build().unwrap();
    let (f, g) = if swap { (1, 0) } else { (0, 1) };
    let places = [(0, 0.0, f), (0, 6.0, f), (2, 0.0, g), (2, 4.0, g)];
    let sources = places.into_iter().zip(ends);
    let sources = sources
        .map(|((axis, at, fracture), p)| held(outer_edges(&built, axis, at, Some(fracture)), p));
    let fluid = fluid(&c, sources.collect());
    let balance = balance(&fluid, &built);
    let n = built.fractures.faces.len();
    let step = step(&balance, n, 1.0);
    let p = rigid(&balance, &step);
    let record = balance.record(&vec![ContactState::Stick; n], &vec![0.0; 3 * n], &p, &step);
    let places = built.fractures.faces.iter().map(|face| face.center).zip(p);
    (record.error, places.collect())
}

#[test]
fn a_junction_of_unequal_arms_has_the_pressure_that_balances_their_flows() {
    for (conductivity, ends) in [
        ([1e-12, 1e-12], [4e6, 0.0, 1e6, 2e6]),
        ([3e-10, 2e-14], [4e6, 0.0, -1e6, 7e6]),
    ] {
        let arms = [2.0, 4.0, 1.0, 3.0];
        let of = |k: usize| conductivity[k / 2] / arms[k];
        let total: f64 = (0..4).map(of).sum();
        let middle = (0..4).map(|k| of(k) * ends[k]).sum::<f64>() / total;
        let (error, places) = cross(conductivity, ends, false, false);
        assert!(error.abs() < 1e-14 * 1e7 * total * 1e3 * 5.0, "{error:e}");
        for (x, p) in &places {
            let expected = match (x[2] - 1.0).abs() < 1e-9 {
                true if x[0] < 2.0 => ends[0] + (middle - ends[0]) * x[0] / 2.0,
                true => middle + (ends[1] - middle) * (x[0] - 2.0) / 4.0,
                false if x[2] < 1.0 => ends[2] + (middle - ends[2]) * x[2],
                false => middle + (ends[3] - middle) * (x[2] - 1.0) / 3.0,
            };
            assert!((p - expected).abs() < 1e-10 * 7e6, "{x:?}: {p} {expected}");
        }
        // neither orientation nor numbering matters
        for (flip, swap) in [(true, false), (false, true)] {
            let (_, others) = cross(conductivity, ends, flip, swap);
            for (x, p) in &others {
                let same = |(y, _): &&([f64; 3], f64)| (0..3).all(|i| (x[i] - y[i]).abs() < 1e-12);
                let (_, q) = places.iter().find(same).unwrap();
                assert!((p - q).abs() < 1e-9 * 7e6, "{x:?}: {p} {q}");
            }
        }
    }
}

/// A random network, its states, jumps and pressures; every second one of general quadrilaterals, with planes that lean.
struct Case {
    built: BuiltMesh,
    fluid: Fluid,
    states: Vec<ContactState>,
    jumps: Vec<f64>,
    p: Vec<f64>,
    before: [Vec<f64>; 2],
}

fn case(seed: u64, ended: bool) -> Case {
    let mut random = Random::new(seed);
    let mut number = |low: f64, high: f64| low + (high - low) * random.unit();
    let mut planes = vec![
        PlaneFracture::through("F", 2, 2.0),
        PlaneFracture::through("G", 0, 3.0),
        PlaneFracture::through("K", 1, 1.0 + number(0.0, 4.0).floor().min(2.0)),
    ];
    planes[1].spans[2] = Some([0.0, 2.0]);
    planes[2].spans[0] = Some([1.0, 5.0]);
    planes[0].flip = number(0.0, 1.0) < 0.5;
    let mut grid = grid([6, 5, 4], planes);
    let tilt = number(-0.5, 0.5);
    if seed % 2 == 1 {
        grid.warps = leaning::maps(seed, tilt);
    }
    let built = grid.build().unwrap();
    let n = built.fractures.faces.len();
    let mut sources = vec![Source {
        place: Place::Faces(vec![3, 7]),
        given: Given::Rate(number(-1e-3, 1e-3)),
        level: None,
        history: 0,
    }];
    if ended {
        sources.push(held(outer_edges(&built, 1, 0.0, None), number(0.0, 1e7)));
        sources.push(Source {
            place: Place::Faces(vec![11]),
            given: Given::Pressure(number(0.0, 1e7)),
            level: None,
            history: 0,
        });
    }
    let c: Vec<f64> = (0..3).map(|_| 10f64.powf(number(-16.0, -9.0))).collect();
    let fluid = Fluid {
        compressibility: 4e-10,
        density: 1e3,
        gravity: [0.3, 0.0, -9.81],
        channels: fluid(&c, Vec::new())
            .channels
            .into_iter()
            .map(|channel| Channel {
                storage: 1e-12,
                directed: (seed % 2 == 1).then_some(Directed {
                    along: [1.0, 2.0, -3.0],
                    ratio: 10f64.powi((seed / 2 % 5) as i32 - 2),
                }),
                ..channel
            })
            .collect(),
        ..fluid(&c, sources)
    };
    Case {
        states: (0..n)
            .map(|_| ContactState::ALL[(number(0.0, 4.0) as usize).min(3)])
            .collect(),
        jumps: (0..3 * n).map(|_| number(1e-5, 2e-3)).collect(),
        p: (0..n).map(|_| number(0.0, 2e7)).collect(),
        before: [
            (0..n).map(|_| number(0.0, 2e7)).collect(),
            (0..n).map(|_| number(0.0, 1e-3)).collect(),
        ],
        built,
        fluid,
    }
}

#[test]
fn networks_lose_nothing() {
    for seed in 0..40 {
        for ended in [false, true] {
            let case = case(seed, ended);
            let balance = balance(&case.fluid, &case.built);
            let [pressure, aperture] = case.before.clone();
            let step = balance.step([0.0, 7.0], pressure, aperture, |_, _| 1.0);
            let point = balance.evaluate(&case.states, &case.jumps, &case.p, &step);
            let record = balance.record(&case.states, &case.jumps, &case.p, &step);
            // what is left over is what the equations are left with, but on faces that are held
            let free = point.residual.iter().zip(&step.held);
            let left: f64 = free
                .filter(|(_, held)| held.is_none())
                .map(|(r, _)| r)
                .sum();
            assert!(record.error.abs() > 0.0 && point.size > 0.0);
            assert!(
                (record.error + left).abs() < 1e-12 * point.size,
                "seed {seed}: {:e} {left:e} of {:e}",
                record.error,
                point.size
            );
        }
    }
}

#[test]
fn closed_fractures_of_an_incompressible_fluid_have_an_m_matrix_without_row_sums() {
    // of rectangles
    for seed in (0..20).step_by(2) {
        let mut case = case(seed, true);
        case.fluid.compressibility = 0.0;
        case.fluid.sources.clear();
        case.fluid.channels.iter_mut().for_each(|c| c.storage = 0.0);
        let n = case.states.len();
        let balance = balance(&case.fluid, &case.built);
        let step = step(&balance, n, 3.0);
        // one open face: nothing is sealed, and no edge between open faces is stabilized
        case.states = vec![ContactState::Stick; n];
        case.states[0] = ContactState::Open;
        let t = balance.tangent(&case.states, &case.jumps, &case.p, &step).t;
        for (k, row) in t.outer_iterator().enumerate() {
            let mut sum = 0.0;
            for (l, value) in row.iter() {
                sum += value;
                assert!(
                    if l == k { *value > 0.0 } else { *value <= 0.0 },
                    "({k}, {l}): {value}"
                );
                let mirrored = t.get(l, k).copied().unwrap_or(0.0);
                assert!((value - mirrored).abs() <= 1e-15 * value.abs());
            }
            assert!(
                sum.abs() <= 1e-14 * t.get(k, k).unwrap(),
                "row {k}: {sum:e}"
            );
        }
    }
}

#[test]
fn derivatives_are_those_of_differences_in_every_state() {
    for seed in 0..12 {
        let case = case(seed, seed % 4 < 2);
        let balance = balance(&case.fluid, &case.built);
        let [pressure, aperture] = case.before.clone();
        let step = balance.step([0.0, 7.0], pressure, aperture, |_, _| 1.0);
        let n = case.states.len();
        let at =
            |jumps: &[f64], p: &[f64]| balance.evaluate(&case.states, jumps, p, &step).residual;
        let tangent = balance.tangent(&case.states, &case.jumps, &case.p, &step);
        let size = |m: &fracas_operators::sparse::SparseMatrix<f64>| {
            m.data().iter().fold(0.0f64, |m, v| m.max(v.abs()))
        };
        let scales = [size(&tangent.t), size(&tangent.by_gap)];
        for m in 0..n {
            let difference = |k: usize| {
                let h = [1.0, 1e-8][k];
                let moved = |s: f64| {
                    let (mut jumps, mut p) = (case.jumps.clone(), case.p.clone());
                    match k {
                        0 => p[m] += s,
                        _ => jumps[3 * m] += s,
                    }
                    at(&jumps, &p)
                };
                let (plus, minus) = (moved(h), moved(-h));
                (0..n)
                    .map(|r| (plus[r] - minus[r]) / (2.0 * h))
                    .collect::<Vec<_>>()
            };
            for (k, matrix) in [&tangent.t, &tangent.by_gap].into_iter().enumerate() {
                for (r, d) in difference(k).into_iter().enumerate() {
                    let exact = matrix.get(r, m).copied().unwrap_or(0.0);
                    assert!(
                        (exact - d).abs() <= 1e-6 * scales[k] + 1e-5 * exact.abs(),
                        "seed {seed}, {k} ({r}, {m}): {exact:e} {d:e} of {:e}",
                        scales[k]
                    );
                }
            }
        }
        let closed = (0..n).filter(|m| case.states[*m] != ContactState::Open);
        for m in closed {
            assert!((0..n).all(|r| tangent.by_gap.get(r, m).is_none_or(|v| *v == 0.0)));
        }
    }
}
