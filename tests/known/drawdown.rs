//! Claim: what diffuses into an aquitard is exact: its elements settle by their means, early times go with erfc, late ones are steady, and
//! any history is that of fine differences.

use crate::pore_pressure::{Folder, modulus};
use fracas::nonlinear::Simulation;
use fracas::scene::{Body, Scene};
use fracas_operators::random::Random;
use fracas_solvers::Silent;

const YEAR: f64 = 365.25 * 86400.0;

/// A column of `cells` elements from −250 m to −200 m under a sand, held but for its top.
fn column(cells: usize, drawdown: &str, end: f64) -> String {
    let lines: Vec<String> = (0..=cells)
        .map(|k| {
            format!(
                "'{} m'",
                -250.0 + 50.0 * (k as f64 / cells as f64).powf(1.3)
            )
        })
        .collect();
    let mut toml = format!(
        "title = 'Aquitard'\n[mesh]\nx = {{ from = '0 m', to = '10 m', cells = 1 }}\ny = {{ from = '0 m', to = '10 m', cells = 1 }}\n\
         z = {{ lines = [{}, '-190 m'] }}\n[time]\nend = '{end} year'\nsteps = 4\n[solver]\ntolerance = 1e-13\n\
         [[material]]\nname = 'sand'\nyoung = '2 GPa'\npoisson = 0.2\n\
         [[material]]\nname = 'clay'\nyoung = '1 GPa'\npoisson = 0.3\nbiot = 0.9\nlayers = [['-250 m', '-200 m']]\n\
         pore_pressure = {{ drawdown = {drawdown} }}\n",
        lines.join(", ")
    );
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml
}

fn body(drawdown: &str) -> Body {
    let toml = column(9, drawdown, 40.0);
    let scene = Scene::from_toml(&toml, "s.toml").unwrap();
    scene.build().unwrap()
}

/// z of the ends of each element of the clay, above its bottom [m], and its change at a time [Pa].
fn changes(body: &Body, time: f64) -> Vec<([f64; 2], f64)> {
    let field = &body.pore_fields[0];
    let ends = |e: &u32| {
        let z = body.mesh.elements[*e as usize].map(|a| body.mesh.nodes[a as usize][2] + 250.0);
        [
            z.into_iter().fold(f64::INFINITY, f64::min),
            z.into_iter().fold(0.0, f64::max),
        ]
    };
    let all = field.elements.iter().map(ends);
    all.zip(field.at(time).iter().copied()).collect()
}

const TABLE: &str = "points = [['0 year', '30 bar'], ['6 year', '12 bar'], ['15 year', '12 bar'], ['20 year', '25 bar']]";

#[test]
fn every_element_of_an_aquitard_settles_by_its_mean() {
    for ends in [
        "from = 'bottom'",
        "from = 'top', far = 'held'",
        "from = 'both'",
    ] {
        let body = body(&format!("{{ diffusivity = '3e-6 m2/s', {ends}, {TABLE} }}"));
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        let mut years = Vec::new();
        while state.step == 0 || !simulation.is_finished(&state) {
            state = simulation.advance(&state, &mut Silent).unwrap().state;
            years.push((1e6 * state.time / YEAR).round() / 1e6);
            let u = simulation.displacement(&state);
            let all = changes(&body, state.time);
            let mut largest = 0.0f64;
            for (e, (_, change)) in body.pore_fields[0].elements.iter().zip(all) {
                let nodes = body.mesh.elements[*e as usize].map(|a| a as usize);
                let z = nodes.map(|a| (body.mesh.nodes[a][2], u[3 * a + 2]));
                let low = z
                    .iter()
                    .copied()
                    .fold((f64::INFINITY, 0.0), |m, x| if x.0 < m.0 { x } else { m });
                let high =
                    z.iter().copied().fold(
                        (f64::NEG_INFINITY, 0.0),
                        |m, x| if x.0 > m.0 { x } else { m },
                    );
                let strain = 0.9 * change / modulus(1e9, 0.3);
                let found = (high.1 - low.1) / (high.0 - low.0);
                largest = largest.max(strain.abs());
                assert!(
                    (found - strain).abs() <= 1e-9 * 0.9 * 1.8e6 / modulus(1e9, 0.3),
                    "{ends}: {found} {strain}"
                );
            }
            assert!(state.time == 0.0 || largest > 1e-4);
        }
        assert_eq!(years, [0.0, 6.0, 10.0, 15.0, 20.0, 30.0, 40.0]);
    }
}

/// erfc by Simpson's rule on its tail.
fn erfc(x: f64) -> f64 {
    let (n, end) = (2000, 7.0);
    if x >= end {
        return 0.0;
    }
    let h = (end - x) / f64::from(n);
    let of = |k: i32| (-(x + h * f64::from(k)).powi(2)).exp();
    let inner: f64 = (1..n).map(|k| f64::from(2 + 2 * (k % 2)) * of(k)).sum();
    2.0 / std::f64::consts::PI.sqrt() * h / 3.0 * (of(0) + inner + of(n))
}

#[test]
fn early_times_go_with_erfc_and_late_ones_are_steady() {
    let step = "points = [['0 year', '30 bar'], ['1 year', '20 bar']], between = 'steps'";
    for (ends, is_top) in [
        ("from = 'bottom'", false),
        ("from = 'top'", true),
        ("from = 'top', far = 'held'", true),
    ] {
        let body = body(&format!("{{ diffusivity = '2e-7 m2/s', {ends}, {step} }}"));
        for years in [0.5, 2.0, 4.0] {
            for ([a, b], change) in changes(&body, (1.0 + years) * YEAR) {
                // Simpson's rule over the element
                let n = 200;
                let of = |k: i32| {
                    let z = a + (b - a) * f64::from(k) / f64::from(n);
                    let x = if is_top { 50.0 - z } else { z };
                    erfc(x / (2.0 * (2e-7 * years * YEAR).sqrt()))
                };
                let inner: f64 = (1..n).map(|k| f64::from(2 + 2 * (k % 2)) * of(k)).sum();
                let mean = (of(0) + inner + of(n)) / f64::from(3 * n);
                // what is left at the far face is below 1e-10
                assert!(
                    (change + 1e6 * mean).abs() < 1e-3,
                    "{ends}, {years}: {change} {mean}"
                );
            }
        }
        assert!(
            changes(&body, YEAR)
                .iter()
                .all(|(_, change)| *change == 0.0)
        );
    }
    for (ends, steady) in [
        ("from = 'bottom'", [1.0, 1.0]),
        ("from = 'both'", [1.0, 1.0]),
        ("from = 'bottom', far = 'held'", [1.0, 0.0]),
        ("from = 'top', far = 'held'", [0.0, 1.0]),
    ] {
        let body = body(&format!("{{ diffusivity = '1e-2 m2/s', {ends}, {step} }}"));
        for ([a, b], change) in changes(&body, 30.0 * YEAR) {
            let middle = 0.5 * (a + b) / 50.0;
            let expected = -1e6 * (steady[0] * (1.0 - middle) + steady[1] * middle);
            assert!(
                (change - expected).abs() < 1e-6,
                "{ends}: {change} {expected}"
            );
        }
    }
}

/// Crank and Nicolson between the points of a table, finite volumes in z: means over elements at a time.
fn by_differences(
    table: &[[f64; 2]],
    kappa: f64,
    driven: [bool; 2],
    closed: [bool; 2],
    end: f64,
    ends: &[[f64; 2]],
) -> Vec<f64> {
    const CELLS: usize = 1000;
    let h = 50.0 / CELLS as f64;
    let face = |t: f64| {
        let after = table.partition_point(|row| row[0] <= t);
        match after {
            0 => 0.0,
            n if n == table.len() => table[n - 1][1] - table[0][1],
            n => {
                let [[t0, p0], [t1, p1]] = [table[n - 1], table[n]];
                p0 + (p1 - p0) * (t - t0) / (t1 - t0) - table[0][1]
            }
        }
    };
    let mut stops: Vec<f64> = table
        .iter()
        .map(|row| row[0])
        .filter(|t| *t > 0.0 && *t < end)
        .collect();
    stops.push(end);
    let (mut p, mut now) = (vec![0.0; CELLS], 0.0);
    for stop in stops {
        let steps = 1 + (800.0 * (stop - now) / end) as usize;
        let dt = (stop - now) / steps as f64;
        let r = 0.5 * kappa * dt / (h * h);
        let mut low = vec![0.0; CELLS];
        let mut main = vec![0.0; CELLS];
        for k in 0..CELLS {
            let at = [k == 0, k + 1 == CELLS];
            let of = |s: usize| match at[s] {
                true if closed[s] => 0.0,
                true => 2.0,
                false => 1.0,
            };
            main[k] = 1.0 + r * (of(0) + of(1));
            if k > 0 {
                low[k] = -r / main[k - 1];
                main[k] += low[k] * r;
            }
        }
        for n in 0..steps {
            let t = now + dt * (n as f64 + 0.5);
            let faces = driven.map(|is| if is { face(t) } else { 0.0 });
            let old = p.clone();
            for k in 0..CELLS {
                let mut sum = 0.0;
                let mut given = 0.0;
                for (s, at) in [k == 0, k + 1 == CELLS].into_iter().enumerate() {
                    match at {
                        true if closed[s] => {}
                        true => {
                            sum -= 2.0 * old[k];
                            given += 4.0 * faces[s];
                        }
                        false => sum += old[if s == 0 { k - 1 } else { k + 1 }] - old[k],
                    }
                }
                p[k] = old[k] + r * (sum + given);
                if k > 0 {
                    p[k] -= low[k] * p[k - 1];
                }
            }
            p[CELLS - 1] /= main[CELLS - 1];
            for k in (0..CELLS - 1).rev() {
                p[k] = (p[k] + r * p[k + 1]) / main[k];
            }
        }
        now = stop;
    }
    // means of what is constant in cells
    let integral = |z: f64| {
        let n = ((z / h) as usize).min(CELLS - 1);
        h * p[..n].iter().sum::<f64>() + (z - n as f64 * h) * p[n]
    };
    ends.iter()
        .map(|[a, b]| (integral(*b) - integral(*a)) / (b - a))
        .collect()
}

#[test]
fn any_history_is_that_of_fine_differences() {
    for seed in 0..12 {
        let r = &mut Random::new(seed);
        let mut t = if r.chance(0.5) {
            0.0
        } else {
            r.between(0.5, 5.0)
        };
        let table: Vec<[f64; 2]> = (0..2 + r.below(6))
            .map(|_| {
                let row = [t, r.between(0.0, 200.0)];
                t += r.between(1.0, 8.0);
                row
            })
            .collect();
        let kappa = r.scale(3e-8, 3e-5);
        let (ends, driven, closed) = r.one_of(&[
            ("from = 'bottom'", [true, false], [false, true]),
            ("from = 'top', far = 'closed'", [false, true], [true, false]),
            ("from = 'top', far = 'held'", [false, true], [false, false]),
            ("from = 'both'", [true, true], [false, false]),
        ]);
        let rows: Vec<String> = table
            .iter()
            .map(|[t, p]| format!("['{t} year', '{p} bar']"))
            .collect();
        let body = body(&format!(
            "{{ diffusivity = '{kappa} m2/s', {ends}, points = [{}] }}",
            rows.join(", ")
        ));
        let end = table[0][0] + r.between(1.0, 30.0);
        let found = changes(&body, end * YEAR);
        let intervals: Vec<[f64; 2]> = found.iter().map(|(own, _)| *own).collect();
        let si: Vec<[f64; 2]> = table.iter().map(|[t, p]| [t * YEAR, p * 1e5]).collect();
        let expected = by_differences(&si, kappa, driven, closed, end * YEAR, &intervals);
        for ((interval, p), q) in found.iter().zip(&expected) {
            assert!(
                (p - q).abs() < 2e-4 * 2e7,
                "seed {seed}, {ends}, {interval:?}: {p} {q}"
            );
        }
    }
}

#[test]
fn aquitards_are_refused_where_their_layer_is_not_known() {
    let good = format!("{{ diffusivity = '1e-7 m2/s', from = 'bottom', {TABLE} }}");
    let said = |toml: &str| match Scene::from_toml(toml, "s.toml").map(|scene| scene.build()) {
        Ok(Ok(_)) => panic!("accepted {toml}"),
        Ok(Err(error)) | Err(error) => error.to_string(),
    };
    let toml = column(9, &good, 40.0);
    for (from, to, expected) in [
        (
            "layers = [['-250 m', '-200 m']]",
            "layers = [['-250 m', '-200 m'], ['-200 m', '-190 m']]",
            "reach from -250 m to -200 m and elsewhere; give its bottom and top",
        ),
        (
            "layers = [['-250 m', '-200 m']]",
            "boxes = [{ x = ['0 m', '10 m'] }]",
            "have no z in common",
        ),
        (
            "from = 'bottom'",
            "from = 'bottom', z = ['-200 m', '-250 m']",
            "`z` of `drawdown` of material \"clay\" from -200 m to -250 m is empty",
        ),
        (
            "from = 'bottom'",
            "from = 'bottom', z = ['-240 m', '-200 m']",
            "element 0 of material \"clay\" around (5.000000, 5.000000, ",
        ),
        (
            "from = 'bottom'",
            "from = 'both', far = 'held'",
            "`far` of `drawdown` of material \"clay\" has no effect without `from = \"bottom\"` or `\"top\"`",
        ),
        (
            "from = 'bottom'",
            "from = 'bottom', column = 'clay'",
            "`column` of `drawdown` of material \"clay\" has no effect without `file`",
        ),
        (
            "from = 'bottom'",
            "from = 'bottom', file = 'a.csv'",
            "`drawdown` of material \"clay\" needs exactly one of `points`, `file`; it has 2",
        ),
        ("from = 'bottom'", "from = 'left'", "unknown value `left`"),
        (
            "1e-7 m2/s",
            "0 m2/s",
            "a diffusivity is \"0 m2/s\", but it must be positive",
        ),
        ("1e-7 m2/s", "1e-7 m/s", "m2/s, m2/day"),
        (
            "['6 year', '12 bar']",
            "['16 year', '12 bar']",
            "`drawdown` of material \"clay\", row 3: time ",
        ),
        (
            "'40 year'",
            "'0.0 year'",
            "`pore_pressure` of material \"clay\" begins at 0 year, and the run ends at 0 year",
        ),
        (
            " } }",
            " }, between = 'steps' }",
            "write it inside `drawdown`",
        ),
        ("[time]\nend = '40 year'\nsteps = 4\n", "", "without [time]"),
    ] {
        assert!(toml.contains(from), "{from}");
        let text = said(&toml.replacen(from, to, 1));
        assert!(text.contains(expected), "{to}: {text}");
    }
    // a table of the aquifer from a file
    let folder = Folder::empty("aquifer");
    folder.write(
        "wells.csv",
        "time [year],aquifer [bar]\n0,30\n6,12\n15,12\n20,25\n",
    );
    let form =
        "{ diffusivity = '1e-7 m2/s', from = 'bottom', file = 'wells.csv', column = 'aquifer' }";
    let scene = folder.read(&column(9, form, 40.0)).unwrap();
    let again = Scene::from_toml(&scene.to_toml().unwrap(), "elsewhere.toml").unwrap();
    let [own, other] = [&scene, &Scene::from_toml(&toml, "s.toml").unwrap()]
        .map(|scene| changes(&scene.build().unwrap(), 17.0 * YEAR));
    assert_eq!(own, other);
    assert_eq!(again.sections(), scene.sections());
}
