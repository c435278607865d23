use super::*;

/// Two planes that cross, each with a storage of its own, and a source on one face of either.
fn crossing(random: &mut Random) -> (BuiltMesh, Fluid) {
    let planes = vec![
        PlaneFracture::through("level", 2, 2.0),
        PlaneFracture::through("upright", 0, 3.0),
    ];
    let cells = [2 * (1 + random.below(3)), 1 + random.below(5), 4];
    let built = grid(cells, planes).build().unwrap();
    let faces = built.fractures.faces.len();
    let of = |place: usize, rate: f64| Source {
        place: Place::Faces(vec![place as u32]),
        given: Given::Rate(rate),
        history: 0,
        level: None,
    };
    let sources = vec![
        of(random.below(faces), 1e-3),
        of(random.below(faces), 4e-4 * random.unit()),
    ];
    let mut fluid = fluid(&[1e-11, 1e-13], sources);
    fluid.channels[0].storage = 10f64.powf(-22.0 + 12.0 * random.unit());
    // what stores nothing lives on what the other does
    if random.below(2) == 0 {
        fluid.channels[1].storage = 10f64.powf(-22.0 + 12.0 * random.unit());
    }
    (built, fluid)
}

/// Claim: a closed part takes up what is brought to it whatever its storage beside what flows, though rounding leaves nothing of the
/// storage in the rows of single faces.
#[test]
fn a_storage_that_rounding_loses_takes_up_what_is_brought() {
    let mut random = Random::new(71);
    let (mut drowned, mut others) = (0, 0);
    for _ in 0..60 {
        let (built, fluid) = crossing(&mut random);
        let balance = balance(&fluid, &built);
        let n = built.fractures.faces.len();
        let states = vec![ContactState::Stick; n];
        let dt = 10f64.powf(8.0 * random.unit());
        let step = step(&balance, n, dt);
        let p = solved(&balance, &step.pressure, &step);
        let faces = built.fractures.faces.iter().zip(&p);
        let stored: f64 = faces.map(|(face, p)| fluid.storage(face, 0.0) * p).sum();
        let brought: f64 = step.injected.iter().sum();
        let bound = match balance.drowned(&states, &step).next() {
            Some(_) => {
                drowned += 1;
                1e-13
            }
            // the threshold leaves half of the digits
            None => {
                others += 1;
                1e-7
            }
        };
        assert!((stored / brought - 1.0).abs() < bound, "{stored} {brought}");
        let record = balance.record(&states, &vec![0.0; 3 * n], &p, &step);
        assert!(record.error.abs() < bound * record.injected, "{record:?}");
    }
    assert!(drowned > 20 && others > 10, "{drowned} {others}");
}

/// Claim: the row of the whole is that of a part without an open face or a given pressure, and the derivatives are its own.
#[test]
fn the_row_of_a_whole_is_that_of_closed_parts_alone() {
    let (built, mut fluid) = crossing(&mut Random::new(5));
    for channel in &mut fluid.channels {
        channel.storage = 1e-20;
    }
    let n = built.fractures.faces.len();
    let jumps = vec![0.0; 3 * n];
    let mut states = vec![ContactState::Stick; n];
    {
        let balance = balance(&fluid, &built);
        let mut step = step(&balance, n, 1e4);
        step.injected.fill(0.0);
        assert_eq!(balance.drowned(&states, &step).count(), 1);
        let t = balance.tangent(&states, &jumps, &step.pressure, &step).t;
        let first = balance.reservoirs[0].faces[0] as usize;
        let at = |p: &[f64]| balance.evaluate(&states, &jumps, p, &step).residual[first];
        let zero = at(&step.pressure);
        for f in 0..n {
            let mut p = step.pressure.clone();
            p[f] = 1e6;
            let slope = (at(&p) - zero) / 1e6;
            let expected = t.get(first, f).copied().unwrap();
            assert!(
                (slope - expected).abs() < 1e-3 * expected,
                "{slope} {expected}"
            );
        }
        states[n / 2] = ContactState::Open;
        assert_eq!(balance.drowned(&states, &step).count(), 0);
        states[n / 2] = ContactState::Slip;
        assert_eq!(balance.drowned(&states, &step).count(), 1);
        let short = FlowStep { dt: 1e-12, ..step };
        assert_eq!(balance.drowned(&states, &short).count(), 0);
    }
    fluid.sources[0].given = Given::Pressure(1e6);
    let balance = balance(&fluid, &built);
    let step = step(&balance, n, 1e4);
    assert_eq!(balance.drowned(&states, &step).count(), 0);
}
