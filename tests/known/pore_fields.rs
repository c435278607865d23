//! Claim: pressures that vary in space settle every element by its own α Δp/M_c; linear ones of a lattice are exact; uniform ones do what a
//! table does, whoever solves.

use crate::pore_pressure::{Folder, modulus};
use fracas::io::vtu::{Cells, Field, Grid};
use fracas::nonlinear::{Simulation, State};
use fracas::scene::{Body, PoreField, Scene};
use fracas_operators::random::Random;
use fracas_solvers::Silent;

const DAY: f64 = 86400.0;

/// A box of 4 × 3 × 5 elements over [1, 2] × [2, 4] × [−3, 0] m, held but for its top.
pub(crate) fn scene(pressure: &str, more: &str) -> String {
    let mut toml = format!(
        "title = 'Fields'\n[mesh]\nx = {{ from = '1 m', to = '2 m', cells = 4 }}\ny = {{ from = '2 m', to = '4 m', cells = 3 }}\n\
         z = {{ from = '-3 m', to = '0 m', cells = 5 }}\n[time]\nend = '10 day'\nsteps = 4\n\
         [[material]]\nname = 'rock'\nyoung = '1 GPa'\npoisson = 0.25\nbiot = 0.8\npore_pressure = {pressure}\n{more}\n"
    );
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml
}

fn centers(body: &Body) -> Vec<[f64; 3]> {
    let of = |nodes: &[u32; 8]| {
        [0, 1, 2].map(|d| {
            nodes
                .iter()
                .map(|a| body.mesh.nodes[*a as usize][d])
                .sum::<f64>()
                / 8.0
        })
    };
    body.mesh.elements.iter().map(of).collect()
}

fn field(body: &Body) -> &PoreField {
    let [field] = &body.pore_fields[..] else {
        panic!("{:?}", body.pore_fields.len())
    };
    field
}

fn shuffled<T>(r: &mut Random, list: &mut [T]) {
    (1..list.len()).for_each(|n| list.swap(n, r.below(n + 1)));
}

/// Lines that reach over an interval.
fn lines(r: &mut Random, [low, high]: [f64; 2]) -> Vec<f64> {
    let mut lines = vec![low - r.between(0.0, 2.0), high + r.between(0.0, 2.0)];
    (0..r.below(5)).for_each(|_| lines.push(r.between(low - 1.0, high + 1.0)));
    lines.sort_by(f64::total_cmp);
    lines
}

fn csv(times: &[f64], points: &[[f64; 3]], pressure: impl Fn(usize, &[f64; 3]) -> f64) -> String {
    let mut text = String::from("x [m],y [m],z [m]");
    for t in times {
        text += &format!(",{t} day [bar]");
    }
    for x in points {
        text += &format!("\n{},{},{}", x[0], x[1], x[2]);
        (0..times.len()).for_each(|k| text += &format!(",{}", pressure(k, x)));
    }
    text
}

/// An unstructured grid of VTK, of points that no cell needs.
pub(crate) fn vtu(points: &[[f64; 3]], values: &[f64]) -> Vec<u8> {
    let grid = Grid {
        points,
        cells: Cells::Hexahedra(&[]),
        point_fields: vec![Field {
            name: "pressure",
            components: 1,
            values,
        }],
        cell_fields: Vec::new(),
    };
    let mut bytes = Vec::new();
    grid.write(&mut bytes).unwrap();
    bytes
}

#[test]
fn linear_pressures_of_a_lattice_are_exact_in_any_order() {
    for seed in 0..40 {
        let r = &mut Random::new(seed);
        let axes = [[1.0, 2.0], [2.0, 4.0], [-3.0, 0.0]].map(|ends| lines(r, ends));
        let mut points = Vec::new();
        for x in &axes[0] {
            for y in &axes[1] {
                points.extend(axes[2].iter().map(|z| [*x, *y, *z]));
            }
        }
        shuffled(r, &mut points);
        let times: Vec<f64> = (0..r.below(3) + 2)
            .scan(0.0, |t, _| {
                *t += r.between(0.5, 3.0);
                Some(*t)
            })
            .collect();
        let laws: Vec<[f64; 4]> = times
            .iter()
            .map(|_| {
                [
                    r.between(90.0, 200.0),
                    r.between(-5.0, 5.0),
                    r.between(-5.0, 5.0),
                    r.between(-5.0, 5.0),
                ]
            })
            .collect();
        let bar = |k: usize, x: &[f64; 3]| {
            let [c, slopes @ ..] = laws[k];
            c + (0..3).map(|d| slopes[d] * x[d]).sum::<f64>()
        };
        let folder = Folder::empty(&format!("lattice-{seed}"));
        let is_stepped = r.chance(0.3);
        let between = if is_stepped {
            ", between = 'steps'"
        } else {
            ""
        };
        let form = match r.chance(0.5) {
            true => {
                folder.write("p.csv", csv(&times, &points, bar));
                format!("{{ grid = 'p.csv'{between} }}")
            }
            false => {
                let files = times.iter().enumerate().map(|(k, t)| {
                    let values: Vec<f64> = points.iter().map(|x| bar(k, x)).collect();
                    // another order in every file
                    let mut order: Vec<usize> = (0..points.len()).collect();
                    shuffled(r, &mut order);
                    let points: Vec<[f64; 3]> = order.iter().map(|p| points[*p]).collect();
                    let values: Vec<f64> = order.iter().map(|p| values[*p]).collect();
                    folder.write(&format!("p{k}.vtu"), vtu(&points, &values));
                    format!("['{t} day', 'p{k}.vtu']")
                });
                let files: Vec<String> = files.collect();
                format!(
                    "{{ fields = [{}], unit = 'bar'{between} }}",
                    files.join(", ")
                )
            }
        };
        let body = folder.read(&scene(&form, "")).unwrap().build().unwrap();
        for t in [
            0.0,
            times[0],
            r.between(0.0, 12.0),
            times[times.len() - 1],
            99.0,
        ] {
            let found = field(&body).at(t * DAY);
            for (p, x) in found.iter().zip(centers(&body)) {
                let after = times.partition_point(|own| *own <= t);
                let expected = match after {
                    0 => 0.0,
                    n if n == times.len() || is_stepped => bar(n - 1, &x) - bar(0, &x),
                    n => {
                        let share = (t - times[n - 1]) / (times[n] - times[n - 1]);
                        (1.0 - share) * bar(n - 1, &x) + share * bar(n, &x) - bar(0, &x)
                    }
                };
                let error = (p - 1e5 * expected).abs();
                assert!(error < 1e-12 * 2e7, "seed {seed}, day {t}: {p} {expected}");
            }
        }
    }
}

#[test]
fn scattered_points_give_the_nearest() {
    for seed in 0..20 {
        let r = &mut Random::new(100 + seed);
        let mut at = || {
            [
                r.between(0.5, 2.5),
                r.between(1.5, 4.5),
                r.between(-3.5, 0.5),
            ]
        };
        let points: Vec<[f64; 3]> = (0..200).map(|_| at()).collect();
        let folder = Folder::empty(&format!("scattered-{seed}"));
        let bar = |k: usize, x: &[f64; 3]| k as f64 * (x[0] + 10.0 * x[1] - 3.0 * x[2]).abs();
        folder.write("p.csv", csv(&[0.0, 5.0], &points, bar));
        let form = "{ grid = 'p.csv', within = '2 m' }";
        let body = folder.read(&scene(form, "")).unwrap().build().unwrap();
        let found = field(&body).at(5.0 * DAY);
        for (p, x) in found.iter().zip(centers(&body)) {
            let square = |a: &[f64; 3]| (0..3).map(|d| (a[d] - x[d]).powi(2)).sum::<f64>();
            let all = points.iter();
            let nearest = all.min_by(|a, b| square(a).total_cmp(&square(b))).unwrap();
            assert!((p - 1e5 * bar(1, nearest)).abs() < 1e-6, "seed {seed}");
        }
    }
}

/// All states of a run.
fn run(body: &Body) -> (Simulation<'_>, Vec<State>) {
    let mut simulation = Simulation::new(body).unwrap();
    let mut states = vec![simulation.initial_state()];
    while states.len() == 1 || !simulation.is_finished(states.last().unwrap()) {
        let next = simulation
            .advance(states.last().unwrap(), &mut Silent)
            .unwrap();
        states.push(next.state);
    }
    (simulation, states)
}

#[test]
fn every_element_of_a_column_settles_by_its_own_pressure() {
    for seed in 0..6 {
        let r = &mut Random::new(seed);
        let folder = Folder::empty(&format!("column-{seed}"));
        let bars: Vec<[f64; 3]> = (0..5)
            .map(|_| std::array::from_fn(|_| r.between(0.0, 300.0)))
            .collect();
        let mut levels: Vec<usize> = (0..5).collect();
        shuffled(r, &mut levels);
        let mut text = String::from("x [m],y [m],z [m],0 day [bar],3 day [bar],7 day [bar]\n");
        for k in levels {
            let [a, b, c] = bars[k];
            text += &format!("1.5,3,{},{a},{b},{c}\n", -2.7 + 0.6 * k as f64);
        }
        folder.write("p.csv", text);
        let toml = scene("{ grid = 'p.csv' }", "[solver]\ntolerance = 1e-13\n");
        let body = folder.read(&toml).unwrap().build().unwrap();
        let (simulation, states) = run(&body);
        let days: Vec<f64> = states[1..].iter().map(|s| s.time / DAY).collect();
        // 0, quarters of ten days, and the days of the table
        let expected = [0.0, 2.5, 3.0, 5.0, 7.0, 7.5, 10.0];
        assert!(
            days.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9) && days.len() == 7,
            "{days:?}"
        );
        for state in &states[1..] {
            let t = state.time / DAY;
            let u = simulation.displacement(state);
            for nodes in &body.mesh.elements {
                let end = |top: bool| {
                    let z = |a: &&u32| body.mesh.nodes[**a as usize][2];
                    let own = nodes.iter();
                    let a = match top {
                        true => own.max_by(|a, b| z(a).total_cmp(&z(b))),
                        false => own.min_by(|a, b| z(a).total_cmp(&z(b))),
                    };
                    let a = *a.unwrap() as usize;
                    (body.mesh.nodes[a][2], u[3 * a + 2])
                };
                let [(low, under), (high, over)] = [end(false), end(true)];
                let [a, b, c] = bars[((0.5 * (low + high) + 2.7) / 0.6).round() as usize];
                let change = match t {
                    t if t <= 3.0 => (b - a) * t / 3.0,
                    t if t <= 7.0 => b - a + (c - b) * (t - 3.0) / 4.0,
                    _ => c - a,
                };
                let strain = 0.8 * 1e5 * change / modulus(1e9, 0.25);
                let found = (over - under) / (high - low);
                assert!(
                    (found - strain).abs() < 1e-9 * 0.8 * 3e7 / modulus(1e9, 0.25),
                    "seed {seed}, day {t}: {found} {strain}"
                );
            }
        }
    }
}

/// A fault across a box whose material takes its pressures from a table or from fields, with creep and an initial stress.
fn faulted(pressure: &str, solver: &str, viscosity: &str) -> String {
    let toml = scene(
        pressure,
        &format!("{viscosity}\n[solver]\ntolerance = 1e-12\n{solver}\n"),
    );
    let toml = toml.replace(
        "[[boundary]]\nside = 'x+'\nhold = 'roller'\n",
        "[[boundary]]\nside = 'x+'\npressure = '7 MPa'\n",
    );
    toml.replace("to = '2 m', cells = 4", "to = '2 m', cells = 6")
        .replace("cells = 5", "cells = 6")
        + "[[boundary]]\nside = 'z+'\npressure = '10 MPa'\n\
         [[fracture]]\nname = 'fault'\nplane = 'z'\nat = '-1.5 m'\nx = ['1 m', '1.5 m']\nfriction_angle = '9 deg'\n\
         [initial_stress]\nconstant = { xx = '-7 MPa', yy = '-7 MPa', zz = '-10 MPa' }\n"
}

#[test]
fn uniform_fields_do_what_a_table_does_whoever_solves() {
    let folder = Folder::empty("uniform");
    let points = [[1.2, 2.5, -1.0], [1.7, 3.0, -2.0], [1.1, 3.9, -0.3]];
    folder.write(
        "p.csv",
        csv(&[0.0, 4.0, 10.0], &points, |k, _| [300.0, 180.0, 220.0][k]),
    );
    let table = "{ points = [['0 day', '300 bar'], ['4 day', '180 bar'], ['10 day', '220 bar']] }";
    for viscosity in ["", "viscosity = '1e15 Pa*s'"] {
        let mut known: Option<Vec<Vec<f64>>> = None;
        for (pressure, solver) in [
            (table, "inner = 'exact'"),
            ("{ grid = 'p.csv', within = '3 m' }", "inner = 'exact'"),
            ("{ grid = 'p.csv', within = '3 m' }", "inner = 'geometric'"),
            ("{ grid = 'p.csv', within = '3 m' }", "inner = 'amg'"),
        ] {
            let toml = faulted(pressure, solver, viscosity);
            let body = folder.read(&toml).unwrap().build().unwrap();
            assert_eq!(body.pore_fields.is_empty(), pressure == table);
            let (simulation, states) = run(&body);
            let found: Vec<Vec<f64>> = (states.windows(2))
                .map(|pair| {
                    let energy = simulation.energy(&pair[0], &pair[1]);
                    let size = energy.external_work.abs() + energy.elastic_energy;
                    assert!(energy.error.abs() <= 1e-8 * size, "{energy:?}");
                    simulation.displacement(&pair[1])
                })
                .collect();
            let known = known.get_or_insert_with(|| found.clone());
            assert_eq!(known.len(), found.len(), "{pressure} {solver}");
            let all = known.iter().flatten();
            let size = all.fold(0.0, |m: f64, u| m.max(u.abs()));
            for (u, v) in known.iter().zip(&found) {
                let apart = u
                    .iter()
                    .zip(v)
                    .fold(0.0, |m: f64, (u, v)| m.max((u - v).abs()));
                assert!(
                    apart <= 1e-9 * size,
                    "{pressure} {solver} {viscosity}: {apart:e} of {size:e}"
                );
            }
        }
    }
}

#[test]
fn a_scene_with_fields_reads_back_and_knows_its_files() {
    let folder = Folder::empty("digest");
    let points = [[1.5, 3.0, -2.0], [1.5, 3.0, -1.0]];
    folder.write("p0.vtu", vtu(&points, &[3.0, 2.0]));
    folder.write("p1.vtu", vtu(&points, &[1.0, 2.5]));
    let form =
        "{ fields = [['0 day', 'p0.vtu'], ['5 day', 'p1.vtu']], unit = 'MPa', within = '2 m' }";
    let own = folder.read(&scene(form, "")).unwrap();
    let written = own.to_toml().unwrap();
    let again = Scene::from_toml(&written, "elsewhere/s.toml").unwrap();
    assert_eq!(again.to_toml().unwrap(), written);
    let [a, b] = [&own, &again].map(|scene| field(&scene.build().unwrap()).at(5.0 * DAY));
    assert_eq!(a, b);
    assert!(
        (a.iter().fold(0.0, |m: f64, p| m.min(*p)) + 2e6).abs() < 1.0,
        "{a:?}"
    );
    // a value of the file is not the one that the scene was written with
    folder.write("p1.vtu", vtu(&points, &[1.0, 2.25]));
    let text = Scene::from_toml(&written, "s.toml")
        .unwrap_err()
        .to_string();
    assert!(text.contains("the files of `pore_pressure` of material \"rock\" are not those that `digest` was taken of"), "{text}");
    let text = own.build().unwrap_err().to_string();
    assert!(text.contains("are not those that `digest`"), "{text}");
    let other = own
        .with_overrides(&["time.steps=3"])
        .unwrap()
        .build()
        .unwrap();
    assert!((field(&other).at(5.0 * DAY)[59] - 0.25e6).abs() < 1.0);
}
