//! Wells with limits in closed networks: what they do is what every other choice of their states contradicts.

use super::*;

/// How far potentials may be beyond a limit, relative to the largest; rates relative to the largest of them. Unit: 1.
const SLACK: f64 = 1e-7;

/// Rate of every well [m³/s] and how far its pressure is below its limit, in the direction in which it works [Pa].
fn done(balance: &Balance<'_>, p: &[f64], step: &FlowStep) -> Vec<(f64, f64)> {
    let n = p.len();
    let (closed, jumps) = (vec![ContactState::Stick; n], vec![0.0; 3 * n]);
    let records = balance.wells(&closed, &jumps, p, step);
    let wells = records.iter().zip(&step.wells);
    wells
        .map(|(record, well)| {
            let head = balance.fluid().head([3.0, 2.5, 9.0]);
            let room = well.pressure.unwrap_or(f64::NAN) - (record.pressure - head);
            (record.rate, room * well.rate.signum())
        })
        .collect()
}

/// True where rates and pressures agree with the controls, and no fluid is lost.
fn agrees(balance: &Balance<'_>, p: &[f64], step: &FlowStep) -> bool {
    let n = p.len();
    let (closed, jumps) = (vec![ContactState::Stick; n], vec![0.0; 3 * n]);
    let point = balance.evaluate(&closed, &jumps, p, step);
    let largest = step.wells.iter().fold(0.0f64, |m, w| m.max(w.rate.abs()));
    let highest = p.iter().fold(1e6f64, |m, p| m.max(p.abs()));
    let wells = done(balance, p, step).into_iter().zip(&step.wells);
    let holds = |((rate, room), well): ((f64, f64), &WellStep)| {
        let (rate, asked) = (rate * well.rate.signum(), well.rate.abs());
        let pressed = match well.control {
            Control::Rate => room >= -SLACK * highest,
            Control::Shut => room <= SLACK * highest,
            Control::Limit => rate >= -SLACK * largest && rate <= asked + SLACK * largest,
            Control::Pressure => true,
        };
        pressed || well.pressure.is_none()
    };
    let record = balance.record(&closed, &jumps, p, step);
    let kept = record.error.abs() <= SLACK * step.dt * largest;
    kept && point.relative() < 1e-9 && wells.into_iter().all(holds)
}

/// A random closed network with one to four wells that have limits, some of no storage at all.
fn network(seed: u64) -> (BuiltMesh, Fluid, f64) {
    let r = &mut Random::new(seed.wrapping_mul(0x9E37_79B9) + 41);
    let mut planes = vec![PlaneFracture::through("F", 2, 2.0)];
    if r.chance(0.5) {
        planes.push(PlaneFracture::through("G", 0, 3.0));
    }
    let count = planes.len();
    let built = grid([6, 5, 4], planes).build().unwrap();
    let faces = built.fractures.faces.len() as u32;
    let storage = if r.chance(0.5) { 0.0 } else { 1e-11 };
    let mut sources = Vec::new();
    if r.chance(0.3) {
        sources.push(Source {
            place: Place::Faces(vec![r.whole(0, faces - 1)]),
            given: Given::Rate(r.between(-1e-6, 1e-6)),
            level: None,
            history: 0,
        });
    }
    let mut wells = Vec::new();
    for number in 0..r.whole(1, 4) {
        let rate = r.between(-2e-6, 2e-6);
        let limit = r.chance(0.8).then(|| r.between(-1e7, 3e7));
        let first = r.whole(0, faces - 2);
        let cuts = match r.chance(0.4) {
            true => vec![(first, r.between(1.0, 4.0)), (first + 1, 2.0)],
            false => vec![(first, r.between(1.0, 4.0))],
        };
        wells.push(Well {
            name: format!("w{number}"),
            cuts,
            head: [3.0, 2.5, 9.0],
            given: WellGiven::Rate(rate, limit),
            history: 0,
        });
    }
    let conductivity: Vec<f64> = (0..count)
        .map(|_| 10f64.powf(r.between(-17.0, -11.0)))
        .collect();
    let mut fluid = fluid(&conductivity, sources);
    fluid.wells = wells;
    fluid.channels.iter_mut().for_each(|c| c.storage = storage);
    if r.chance(0.3) {
        (fluid.density, fluid.gravity) = (1e3, [0.0, 0.0, -9.81]);
    }
    (built, fluid, 10f64.powf(r.between(0.0, 5.0)))
}

#[test]
fn wells_with_limits_do_what_all_other_choices_of_their_states_contradict() {
    let (mut seen, mut refused, mut most) = ([0; 3], 0, 0);
    for seed in 0..200 {
        let (built, fluid, dt) = network(seed);
        let balance = balance(&fluid, &built);
        let n = built.fractures.faces.len();
        let (closed, jumps) = (vec![ContactState::Stick; n], vec![0.0; 3 * n]);
        let mut step = step(&balance, n, dt);
        let r = &mut Random::new(seed + 7);
        step.pressure.fill(r.between(0.0, 2e7));
        // and all rates turned round, from where these end
        for _ in 0..2 {
            // every choice of states that does not contradict itself
            let limited: Vec<usize> = (0..step.wells.len())
                .filter(|i| step.wells[*i].limit().is_some())
                .collect();
            let mut choices = Vec::new();
            for code in 0..3usize.pow(limited.len() as u32) {
                let mut controls = step.controls();
                for (digit, well) in limited.iter().enumerate() {
                    let of = [Control::Rate, Control::Limit, Control::Shut];
                    controls[*well] = of[code / 3usize.pow(digit as u32) % 3];
                }
                let chosen = step.controlled(&controls).into_owned();
                let p = solved(&balance, &step.pressure, &chosen);
                if agrees(&balance, &p, &chosen) {
                    choices.push(done(&balance, &p, &chosen));
                }
            }
            let sealed = balance.sealed(&closed, &step);
            if sealed.iter().any(|part| part.excess != 0.0) {
                // more comes in, or is asked for, than closed faces and limits can do
                refused += 1;
                assert!(choices.is_empty(), "seed {seed}");
                break;
            }
            // the choice that the balance makes, from one solution to the next
            let (mut p, mut now, mut steps) = (step.pressure.clone(), step.clone(), 0);
            loop {
                let alone = steps > 4 * limited.len();
                if let Some(controls) = balance.switched(&closed, &jumps, &p, &now, alone) {
                    now = now.controlled(&controls).into_owned();
                }
                p = solved(&balance, &p, &now);
                steps += 1;
                let next = balance.switched(&closed, &jumps, &p, &now, alone);
                if next.is_none() || steps == 60 {
                    break;
                }
            }
            assert!(steps < 60, "seed {seed}");
            most = most.max(steps);
            assert!(agrees(&balance, &p, &now), "seed {seed}: {:?}", now.wells);
            assert!(!choices.is_empty(), "seed {seed}");
            let largest = now.wells.iter().fold(0.0f64, |m, w| m.max(w.rate.abs()));
            let own = done(&balance, &p, &now);
            for choice in &choices {
                for ((rate, _), (other, _)) in own.iter().zip(choice) {
                    let apart = (rate - other).abs();
                    assert!(apart < 1e-5 * largest, "seed {seed}: {rate:e} {other:e}");
                }
            }
            for well in limited {
                match now.wells[well].control {
                    Control::Rate => seen[0] += 1,
                    Control::Limit => seen[1] += 1,
                    Control::Shut => seen[2] += 1,
                    Control::Pressure => {}
                }
            }
            step.pressure = p;
            step.wells
                .iter_mut()
                .for_each(|well| well.rate = -well.rate);
        }
    }
    assert!(
        seen.iter().all(|count| *count > 12) && refused > 5 && most <= 40,
        "{seen:?} {refused} {most}"
    );
}
