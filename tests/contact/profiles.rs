//! Claim: what a `profile` says of friction, cohesion and pressure along z holds on every face, at its centre. `FRACAS_SEEDS=200` runs
//! more cases.

use crate::scenes::body;
use crate::slip::{seeds, sheared, steps};
use fracas::contact::ContactState;
use fracas_operators::random::Random;

/// Levels as lines between pairs of `(z, value)`.
fn along(levels: &[(f64, f64)], z: f64) -> f64 {
    let clamped = z.clamp(levels[0].0, levels[levels.len() - 1].0);
    let pair = levels.windows(2).find(|w| clamped <= w[1].0).unwrap();
    let [(low, a), (high, b)] = [pair[0], pair[1]];
    a + (clamped - low) / (high - low) * (b - a)
}

/// Random values at three levels of a height.
fn levels(r: &mut Random, height: f64, [least, most]: [f64; 2]) -> Vec<(f64, f64)> {
    let shares = [
        r.between(-0.2, 0.3),
        r.between(0.35, 0.6),
        r.between(0.65, 1.2),
    ];
    let level = |share: f64| (share * height, r.between(least, most));
    shares.map(level).to_vec()
}

#[test]
fn faces_have_the_friction_and_the_pressure_of_their_depth() {
    let (mut slipping, mut sticking) = (0, 0);
    for seed in seeds() {
        let r = &mut Random::new(900 + seed);
        let text = sheared(r, "friction_angle = '1 deg'\n");
        let plain = body(&text, &[]);
        let top = plain.mesh.nodes.iter().fold(0.0, |m: f64, x| m.max(x[2]));
        let angles = levels(r, top, [0.2, 3.0]);
        let cohesions = levels(r, top, [0.0, 1.0]);
        let pressures = levels(r, top, [0.0, 20.0]);
        // each key at levels of its own
        let mut all: Vec<(f64, String)> = Vec::new();
        for (key, unit, levels) in [
            ("friction_angle", "deg", &angles),
            ("cohesion", "MPa", &cohesions),
            ("pressure", "MPa", &pressures),
        ] {
            let row = |(z, value): &(f64, f64)| (*z, format!("{key} = '{value} {unit}'"));
            all.extend(levels.iter().map(row));
        }
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let row = |(z, key): &(f64, String)| format!("{{ z = '{z} m', {key} }}");
        let profile: Vec<String> = all.iter().map(row).collect();
        let profile = format!("profile = [{}]\n", profile.join(", "));
        let body = body(&text.replace("friction_angle = '1 deg'\n", &profile), &[]);
        let faces = &body.fractures.faces;
        steps(&body, |_, step| {
            let factor = match step.after.time {
                t if t <= 1.0 => t,
                t if t <= 3.0 => 2.0 - t,
                t => t - 4.0,
            };
            for (f, face) in faces.iter().enumerate() {
                let z = face.center[2];
                let pressure = 1e6 * factor * along(&pressures, z);
                let p = step.fields.pressure[f];
                assert!(
                    (p - pressure).abs() < 1e-3,
                    "seed {seed}, z {z}: {p} {pressure}"
                );
                let t = &step.after.t[3 * f..][..3];
                let tangent = along(&angles, z).to_radians().tan();
                let limit = (1e6 * along(&cohesions, z) - t[0] * tangent).max(0.0);
                let shear = t[1].hypot(t[2]);
                match step.after.states[f] {
                    ContactState::Slip => {
                        slipping += 1;
                        assert!(
                            (shear - limit).abs() < 1e-5 * 1e8,
                            "seed {seed}: {shear} {limit}"
                        );
                    }
                    ContactState::Stick => {
                        sticking += 1;
                        assert!(shear < limit + 1e-5 * 1e8, "seed {seed}: {shear} {limit}");
                    }
                    ContactState::NewSlip | ContactState::Open => {}
                }
            }
        });
    }
    assert!(slipping > 100 && sticking > 100, "{slipping} {sticking}");
}
