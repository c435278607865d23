//! Claim: a pressure that follows the rock on the two sides of a fracture is the mean or the larger of what changes there, face by face and at every
//! time; it acts as a given pressure does, and the traction of the rock stays as smooth as its stress.

use crate::pore_pressure::{Folder, modulus};
use fracas::nonlinear::Simulation;
use fracas::scene::{Body, PressureFrom};
use fracas_operators::random::Random;
use fracas_solvers::Silent;

const DAY: f64 = 86400.0;

/// A box cut by one fracture; `rocks` are sections of materials.
fn boxed(rocks: &str, fracture: &str, more: &str) -> String {
    let mut toml = format!(
        "title = 'Sides'\n[mesh]\nx = {{ from = '0 m', to = '4 m', cells = 4 }}\ny = {{ from = '0 m', to = '3 m', cells = 3 }}\n\
         z = {{ from = '-4 m', to = '0 m', cells = 4 }}\n[time]\nend = '10 day'\nsteps = 5\n{rocks}\n\
         [[fracture]]\nname = 'fault'\n{fracture}\n[[boundary]]\nside = 'z+'\npressure = '20 MPa'\nhistory = [['0 day', 1]]\n{more}\n"
    );
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml
}

fn rock(name: &str, place: &str, pressure: &str) -> String {
    format!("[[material]]\nname = '{name}'\nyoung = '10 GPa'\npoisson = 0.2\n{place}\n{pressure}\n")
}

/// What a step shows: time [s], pressures and tractions of faces, displacements.
struct Shown {
    time: f64,
    pressure: Vec<f64>,
    traction: Vec<f64>,
    u: Vec<f64>,
    /// Slip of the face that slipped most [m].
    slip: f64,
}

fn run(body: &Body) -> Vec<Shown> {
    let mut simulation = Simulation::new(body).unwrap();
    let mut shown = Vec::new();
    let end = simulation.run(&mut Silent, |simulation, before, done| {
        let energy = simulation.energy(before, &done.state);
        let size = energy.external_work.abs() + energy.pressure_work.abs() + energy.elastic_energy;
        assert!(energy.error.abs() <= 1e-8 * size, "{energy:?}");
        let fields = simulation.face_fields(&done.state);
        shown.push(Shown {
            time: done.state.time,
            pressure: fields.pressure,
            traction: fields.traction,
            u: simulation.displacement(&done.state),
            slip: fields.slip.iter().fold(0.0, |m, s| m.max(*s)),
        });
    });
    end.unwrap();
    shown
}

fn build(toml: &str) -> Body {
    Folder::empty("sides").read(toml).unwrap().build().unwrap()
}

/// Claim: between a sand that is depleted by d(t) and a clay that rises by r(t), under q: t_N = −q + p, p the mean or the larger of both, and the rock
/// settles as without it, by α Δp/M_c.
#[test]
fn a_column_carries_what_its_load_and_the_pressure_of_its_sides_say() {
    for (rule, biot) in [
        ("mean", 1.0),
        ("larger", 1.0),
        ("larger", 0.6),
        ("mean", 0.0),
    ] {
        for clay in [
            "",
            "pore_pressure = { points = [['0 day', '1 MPa'], ['4 day', '1 MPa'], ['10 day', '4 MPa']] }",
        ] {
            let sand = format!(
                "biot = {biot}\npore_pressure = {{ points = [['0 day', '9 MPa'], ['6 day', '3 MPa'], ['10 day', '11 MPa']] }}"
            );
            let rocks = rock("clay", "layers = [['-2 m', '0 m']]", clay)
                + &rock("sand", "layers = [['-4 m', '-2 m']]", &sand);
            let fracture = format!(
                "plane = 'z'\nat = '-2 m'\nfriction_angle = '30 deg'\npressure_from = '{rule}'"
            );
            let body = build(&boxed(&rocks, &fracture, "[solver]\ntolerance = 1e-12"));
            let shown = run(&body);
            assert!(shown.len() >= 6);
            let mut pressures = 0.0f64;
            for Shown {
                time,
                pressure,
                traction,
                u,
                ..
            } in &shown
            {
                let day = time / DAY;
                let sand = match day {
                    d if d <= 6.0 => -6e6 * d / 6.0,
                    d => -6e6 + 8e6 * (d - 6.0) / 4.0,
                };
                let clay = if clay.is_empty() {
                    0.0
                } else {
                    3e6 * (day - 4.0).max(0.0) / 6.0
                };
                let expected = match rule {
                    "mean" => 0.5 * (sand + clay),
                    _ => sand.max(clay),
                };
                pressures = pressures.max(expected.abs());
                for (p, t) in pressure.iter().zip(traction.chunks_exact(3)) {
                    assert!((p - expected).abs() < 1e-6, "{rule} {day}: {p} {expected}");
                    assert!(
                        (t[0] + 20e6 - expected).abs() < 20.0,
                        "{rule} {day}: {t:?} {expected}"
                    );
                }
                let top = body
                    .mesh
                    .nodes
                    .iter()
                    .zip(u.chunks_exact(3))
                    .filter(|(x, _)| x[2] == 0.0);
                let biot_clay = 1.0;
                let settled = 2.0 * (-40e6 + biot * sand + biot_clay * clay) / modulus(1e10, 0.2);
                for (_, u) in top {
                    assert!(
                        (u[2] - settled).abs() < 1e-7 * settled.abs(),
                        "{} {settled}",
                        u[2]
                    );
                }
            }
            assert!(pressures > 1e6);
        }
    }
}

/// Claim: it is a pressure as given ones are: two blocks with tables of their own beside a fault that slips do what the same pressure as a history does.
#[test]
fn it_acts_as_a_given_pressure_does() {
    let mut slid = 0;
    for seed in 0..6 {
        let r = &mut Random::new(seed);
        let days = [0.0, r.between(1.0, 4.0), r.between(5.0, 9.0), 10.0];
        let tables = [0; 2].map(|_| days.map(|_| r.between(5.0, 15.0)));
        let table = |own: &[f64; 4]| {
            let rows = days
                .iter()
                .zip(own)
                .map(|(d, p)| format!("['{d} day', '{p} MPa']"));
            let rows: Vec<String> = rows.collect();
            format!(
                "pore_pressure = {{ points = [{}] }}\nbiot = 0.7",
                rows.join(", ")
            )
        };
        let rocks = rock(
            "west",
            "boxes = [{ x = ['0 m', '2 m'] }]",
            &table(&tables[0]),
        ) + &rock(
            "east",
            "boxes = [{ x = ['2 m', '4 m'] }]",
            &table(&tables[1]),
        );
        let stress = "[initial_stress]\nconstant = { xx = '-24 MPa', yy = '-24 MPa', zz = '-20 MPa', xz = '5 MPa' }\n[solver]\ntolerance = 1e-11";
        let plane = "plane = 'x'\nat = '2 m'\nz = ['-3 m', '-1 m']\nfriction_angle = '8 deg'\n";
        for rule in ["mean", "larger"] {
            let own = build(&boxed(
                &rocks,
                &format!("{plane}pressure_from = '{rule}'"),
                stress,
            ));
            let shown = run(&own);
            let change = |t: f64| -> f64 {
                let changes = tables.map(|own| {
                    let k = days.partition_point(|d| *d < t / DAY).clamp(1, 3);
                    let share = (t / DAY - days[k - 1]) / (days[k] - days[k - 1]);
                    own[k - 1] + share * (own[k] - own[k - 1]) - own[0]
                });
                match rule {
                    "mean" => 0.5 * (changes[0] + changes[1]),
                    _ => changes[0].max(changes[1]),
                }
            };
            let mut rows: Vec<String> = Vec::new();
            let mut last = f64::NEG_INFINITY;
            for step in shown.iter().filter(|step| step.time >= 0.0) {
                if step.time > last {
                    rows.push(format!("['{} s', {}]", step.time, change(step.time)));
                    last = step.time;
                }
            }
            let given = format!(
                "{plane}pressure = '1 MPa'\npressure_history = [{}]",
                rows.join(", ")
            );
            let other = build(&boxed(&rocks, &given, stress));
            let known = run(&other);
            assert_eq!(known.len(), shown.len(), "{seed} {rule}");
            slid += usize::from(shown[shown.len() - 1].slip > 1e-5);
            let size = known
                .iter()
                .flat_map(|s| &s.u)
                .fold(0.0, |m: f64, u| m.max(u.abs()));
            for (a, b) in shown.iter().zip(&known) {
                assert!((a.time - b.time).abs() < 1e-6);
                let apart =
                    a.u.iter()
                        .zip(&b.u)
                        .fold(0.0, |m: f64, (u, v)| m.max((u - v).abs()));
                assert!(apart <= 1e-6 * size, "{seed} {rule}: {apart:e} of {size:e}");
                for (p, q) in a.pressure.iter().zip(&b.pressure) {
                    assert!((p - q).abs() < 1.0, "{seed} {rule}: {p} {q}");
                }
            }
        }
    }
    assert!(slid > 3, "{slid}");
}

/// Claim: with pressures that differ from face to face every face has that of its own neighbours, and a traction t_N − p that knows nothing of them
/// where the rock does not either (α = 0): −q, whatever jumps.
#[test]
fn every_face_has_the_pressure_of_its_own_sides() {
    for seed in 0..12 {
        let r = &mut Random::new(40 + seed);
        let folder = Folder::empty(&format!("sides-{seed}"));
        let mut values: Vec<[f64; 3]> = Vec::new();
        let mut text = String::from("x [m],y [m],z [m],0 day [MPa],4 day [MPa],10 day [MPa]\n");
        for e in 0..48 {
            let x = [e % 4, e / 4 % 3, e / 12].map(f64::from);
            let own = std::array::from_fn(|_| r.between(5.0, 15.0));
            text += &format!(
                "{},{},{},{},{},{}\n",
                x[0] + 0.5,
                x[1] + 0.5,
                x[2] - 3.5,
                own[0],
                own[1],
                own[2]
            );
            values.push(own);
        }
        folder.write("p.csv", text);
        // a part without a pore pressure, and one that changes by a factor
        let form = "pore_pressure = { grid = 'p.csv', interpolation = 'nearest' }\nbiot = 0";
        let rocks = rock("rock", "", form)
            + &rock(
                "tight",
                "boxes = [{ x = ['0 m', '1 m'], z = ['-4 m', '-2 m'] }]",
                "",
            )
            + &rock(
                "aquifer",
                "boxes = [{ x = ['3 m', '4 m'], z = ['-2 m', '0 m'] }]",
                "pressure_change = '-4 MPa'\npressure_history = [['0 day', 0], ['10 day', 1]]\nbiot = 0",
            );
        let rule = if r.chance(0.5) {
            PressureFrom::Mean
        } else {
            PressureFrom::Larger
        };
        let name = if rule == PressureFrom::Mean {
            "mean"
        } else {
            "larger"
        };
        let fracture = format!(
            "plane = 'z'\nat = '-2 m'\nfriction_angle = '30 deg'\npressure_from = '{name}'"
        );
        let toml = boxed(&rocks, &fracture, "[solver]\ntolerance = 1e-12");
        let body = folder.read(&toml).unwrap().build().unwrap();
        let following = &body.inventory().following;
        assert!(matches!(&following[..], [(name, own, _)] if name == "fault" && *own == rule));
        for Shown {
            time,
            pressure,
            traction,
            ..
        } in run(&body)
        {
            let day = time / DAY;
            let change = |x: usize, y: usize, z: usize| -> f64 {
                let [a, b, c] = values[x + 4 * (y + 3 * z)];
                match (x, z) {
                    (0, 0 | 1) => 0.0,
                    (3, 2 | 3) => -4.0 * day / 10.0,
                    _ if day <= 4.0 => (b - a) * day / 4.0,
                    _ => b - a + (c - b) * (day - 4.0) / 6.0,
                }
            };
            for (f, face) in body.fractures.faces.iter().enumerate() {
                let [x, y] = [0, 1].map(|d: usize| face.center[d].floor() as usize);
                let sides = [change(x, y, 1), change(x, y, 2)];
                let expected = 1e6
                    * match rule {
                        PressureFrom::Mean => 0.5 * (sides[0] + sides[1]),
                        PressureFrom::Larger => sides[0].max(sides[1]),
                    };
                assert!(
                    (pressure[f] - expected).abs() < 1e-3,
                    "{seed} {day}: {} {expected}",
                    pressure[f]
                );
                let rock = traction[3 * f] - pressure[f];
                assert!(
                    (rock + 20e6).abs() < 200.0,
                    "{seed} {day}, face {f}: {rock}"
                );
            }
        }
    }
}

/// Claim: given pressures that jump from face to face leave the traction of the rock as it is: −q.
#[test]
fn pressures_of_a_profile_leave_the_traction_of_the_rock_alone() {
    let r = &mut Random::new(8);
    let levels = [-3.5, -2.5, -1.5, -0.5].map(|z| (z, r.between(0.0, 9.0)));
    let rows = levels.map(|(z, p)| format!("{{ z = '{z} m', pressure = '{p} MPa' }}"));
    let fracture = format!(
        "plane = 'x'\nat = '2 m'\nfriction_angle = '30 deg'\nprofile = [{}]",
        rows.join(", ")
    );
    let toml = boxed(
        &rock("rock", "", ""),
        &fracture,
        "[solver]\ntolerance = 1e-12",
    );
    // the load is on x+
    let toml = toml.replace("side = 'x+'", "side = 'other'");
    let toml = toml.replace("side = 'z+'", "side = 'x+'");
    let body = build(&toml.replace("side = 'other'", "side = 'z+'"));
    for Shown {
        pressure, traction, ..
    } in run(&body)
    {
        for (f, face) in body.fractures.faces.iter().enumerate() {
            let own = levels
                .iter()
                .find(|(z, _)| (z - face.center[2]).abs() < 1e-9);
            assert!((pressure[f] - 1e6 * own.unwrap().1).abs() < 1e-6);
            let rock = traction[3 * f] - pressure[f];
            assert!((rock + 20e6).abs() < 200.0, "face {f}: {rock}");
        }
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let table = "pore_pressure = { points = [['0 day', '9 MPa'], ['6 day', '3 MPa']] }";
    let rocks = rock("sand", "layers = [['-4 m', '-2 m']]", table)
        + &rock("clay", "layers = [['-2 m', '0 m']]", "");
    let folder = Folder::empty("sides-refused");
    let said = |fracture: &str, more: &str| {
        let toml = boxed(
            &rocks,
            &format!("plane = 'z'\nfriction_angle = '30 deg'\n{fracture}"),
            more,
        );
        let found = folder.read(&toml);
        found
            .and_then(|scene| scene.build().map(|_| ()).map_err(|e| e.to_string()))
            .unwrap_err()
    };
    for (fracture, more, expected) in [
        (
            "at = '-2 m'\npressure_from = 'mean'\npressure = '1 MPa'",
            "",
            "fracture \"fault\" has `pressure_from`, which says what its pressure follows, beside `pressure`; leave one of them out",
        ),
        (
            "at = '-2 m'\npressure_from = 'mean'\nprofile = [{ z = '0 m', pressure = '1 MPa' }]",
            "",
            "beside `pressure`; leave one",
        ),
        (
            "at = '-2 m'\npressure_from = 'larger'\nconductivity = '1e-13 m3'",
            "[fluid]\nviscosity = '1 cP'\n",
            "beside the pressure of [fluid]; leave one",
        ),
        (
            "at = '-2 m'\npressure_from = 'larger'\npressure_history = [['0 day', 1]]",
            "",
            "`pressure_history` of fracture \"fault\" has no effect without `pressure`",
        ),
        (
            "at = '-1 m'\npressure_from = 'larger'",
            "",
            "fracture \"fault\" has `pressure_from`, and on neither side of it a pore pressure changes",
        ),
        (
            "at = '-2 m'\npressure_from = 'least'",
            "",
            "unknown value `least`",
        ),
    ] {
        let text = said(fracture, more);
        assert!(
            text.contains(expected) && text.contains("scene.toml:"),
            "{fracture}: {text}"
        );
    }
}
