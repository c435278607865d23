//! What is told of a step: flow per width, and where the fluid went.

use super::*;

fn closed(n: usize) -> (Vec<ContactState>, Vec<f64>) {
    (vec![ContactState::Stick; n], vec![0.0; 3 * n])
}

fn rate(faces: Vec<u32>, rate: f64) -> Source {
    Source {
        place: Place::Faces(faces),
        given: Given::Rate(rate),
        level: None,
        history: 0,
    }
}

fn well(cuts: Vec<(u32, f64)>, given: WellGiven) -> Well {
    Well {
        name: "w".into(),
        cuts,
        head: [3.0, 2.5, 1000.0],
        given,
        history: 0,
    }
}

/// A pressure that grows evenly in the plane, held on every outer edge: q = −C/μ ∇p on every face, whatever their sizes.
#[test]
fn an_even_gradient_has_the_same_flow_on_every_face() {
    for seed in 0..30 {
        let r = &mut Random::new(seed);
        let mut grid = grid([7, 6, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        for (axis, [to, cells]) in [[6.0, 7.0], [5.0, 6.0]].into_iter().enumerate() {
            grid.axes[axis] = Axis::Cells {
                from: 0.0,
                to,
                cells: cells as usize,
                grading: Grading::Geometric {
                    ratio: r.between(0.1, 10.0),
                },
            };
        }
        let built = grid.build().unwrap();
        let (gradient, c) = (
            [r.between(-1e6, 1e6), r.between(-1e6, 1e6)],
            10f64.powf(r.between(-18.0, -8.0)),
        );
        let mut sources = Vec::new();
        for (axis, at) in [(0, 0.0), (0, 6.0), (1, 0.0), (1, 5.0)] {
            for edge in outer_edges(&built, axis, at, None) {
                let [a, b] = edge.map(|n| built.mesh.nodes[n as usize]);
                let p = (0..2).map(|k| gradient[k] * 0.5 * (a[k] + b[k])).sum();
                sources.push(held(vec![edge], p));
            }
        }
        let fluid = fluid(&[c], sources);
        let balance = balance(&fluid, &built);
        let n = built.fractures.faces.len();
        let step = step(&balance, n, 1.0);
        let p = rigid(&balance, &step);
        let (states, jumps) = closed(n);
        let size = c / 1e-3 * gradient[0].hypot(gradient[1]);
        for q in balance.fluxes(&states, &jumps, &p, &step).chunks_exact(3) {
            for k in 0..3 {
                let expected = if k < 2 { -c / 1e-3 * gradient[k] } else { 0.0 };
                assert!((q[k] - expected).abs() < 1e-8 * size, "seed {seed}: {q:?}");
            }
        }
    }
}

#[test]
fn flow_lies_in_the_plane_of_its_face_and_none_is_told_of_a_well_in_the_middle() {
    for seed in 0..40 {
        let mut case = case(seed, true);
        let r = &mut Random::new(seed + 900);
        let n = case.states.len();
        let cuts = vec![(r.whole(0, n as u32 - 1), 3.0)];
        case.fluid.wells = vec![well(cuts, WellGiven::Rate(r.between(-1.0, 1.0), None))];
        let balance = balance(&case.fluid, &case.built);
        let [pressure, aperture] = case.before.clone();
        let step = balance.step([0.0, 7.0], pressure, aperture, |_, _| 1.0);
        let q = balance.fluxes(&case.states, &case.jumps, &case.p, &step);
        for (q, face) in q.chunks_exact(3).zip(&case.built.fractures.faces) {
            let across: f64 = (0..3).map(|i| q[i] * face.frame[0][i]).sum();
            let size = q.iter().map(|q| q * q).sum::<f64>().sqrt();
            assert!(across.abs() <= 1e-12 * size, "seed {seed}: {q:?}");
        }
    }
    // from the middle of a square with held edges as much flows to every side
    let built = grid([5, 5, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
    let built = built.build().unwrap();
    let sides = [(0, 0.0), (0, 6.0), (1, 0.0), (1, 5.0)];
    let sources = sides.map(|(axis, at)| held(outer_edges(&built, axis, at, None), 0.0));
    let mut fluid = fluid(&[1e-12], sources.into());
    fluid.wells = vec![well(vec![(12, 3.0)], WellGiven::Rate(1e-6, None))];
    let balance = balance(&fluid, &built);
    let n = built.fractures.faces.len();
    let step = step(&balance, n, 1.0);
    let (states, jumps) = closed(n);
    let q = balance.fluxes(&states, &jumps, &rigid(&balance, &step), &step);
    let size = q.iter().fold(0.0f64, |m, q| m.max(q.abs()));
    assert!(
        size > 1e-8 && (36..39).all(|i| q[i].abs() < 1e-10 * size),
        "{:?}",
        &q[36..39]
    );
}

/// Pressures and rates of any kind on closed networks whose conductivities differ by 14 orders, as far as f64 tells their storage beside them.
#[test]
fn closed_networks_keep_their_volume_at_any_conductivity() {
    for seed in 0..300 {
        let r = &mut Random::new(seed + 5_000);
        let mut planes = vec![PlaneFracture::through("F", 2, 2.0)];
        if r.chance(0.5) {
            planes.push(PlaneFracture::through("G", 0, 3.0));
        }
        let count = planes.len();
        let built = grid([6, 5, 4], planes).build().unwrap();
        let n = built.fractures.faces.len();
        let mut face = || r.whole(0, n as u32 - 1);
        let faces: Vec<u32> = (0..4).map(|_| face()).collect();
        let mut sources = vec![rate(vec![faces[0]], r.between(-1e-6, 1e-6))];
        if r.chance(0.5) {
            sources.push(held(
                outer_edges(&built, 1, 0.0, Some(0)),
                r.between(-1e6, 1e7),
            ));
        }
        let conductivity: Vec<f64> = (0..count)
            .map(|_| 10f64.powf(r.between(-20.0, -6.0)))
            .collect();
        let mut fluid = fluid(&conductivity, sources);
        fluid.wells = vec![well(
            vec![(faces[1], 3.0)],
            WellGiven::Rate(r.between(-1e-6, 1e-6), None),
        )];
        if r.chance(0.7) {
            let cuts = vec![(faces[2], 2.0), (faces[3], 3.0)];
            let cuts = if faces[2] == faces[3] {
                cuts[..1].to_vec()
            } else {
                cuts
            };
            fluid
                .wells
                .push(well(cuts, WellGiven::Pressure(r.between(-1e6, 1e7))));
        }
        let storage = 10f64.powf(r.between(-12.0, -10.0));
        fluid.channels.iter_mut().for_each(|c| c.storage = storage);
        let balance = balance(&fluid, &built);
        let mut step = step(&balance, n, 10f64.powf(r.between(0.0, 3.0)));
        step.pressure.fill(r.between(0.0, 5e6));
        let p = solved(&balance, &step.pressure, &step);
        let (states, jumps) = closed(n);
        let record = balance.record(&states, &jumps, &p, &step);
        let moved = record.injected + record.out + record.stored_compression.abs();
        let loss = record.error.abs() / moved;
        assert!(loss <= 1e-10, "seed {seed}: {record:?}");
        // given rates are told as they are given
        let wells = balance.wells(&states, &jumps, &p, &step);
        assert_eq!(wells[0].rate, step.wells[0].rate);
    }
}

#[test]
fn every_source_and_well_counts_as_what_it_does_itself() {
    for seed in 0..30 {
        let r = &mut Random::new(seed + 70);
        let built = grid([6, 5, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        let built = built.build().unwrap();
        let n = built.fractures.faces.len();
        let all: Vec<u32> = (0..n as u32).collect();
        // on one face, on all of them, and by a well through the first
        let rates: Vec<f64> = (0..3).map(|_| r.between(-1e-7, 1e-7)).collect();
        let mut fluid = fluid(&[1e-13], vec![rate(vec![3], rates[0]), rate(all, rates[1])]);
        fluid.wells = vec![well(vec![(3, 3.0)], WellGiven::Rate(rates[2], None))];
        fluid.channels[0].storage = 1e-11;
        let balance = balance(&fluid, &built);
        let step = step(&balance, n, 10.0);
        let p = rigid(&balance, &step);
        let (states, jumps) = closed(n);
        let record = balance.record(&states, &jumps, &p, &step);
        let of = |sign: f64| {
            rates
                .iter()
                .map(|q| 10.0 * (sign * q).max(0.0))
                .sum::<f64>()
        };
        assert!(
            (record.injected - of(1.0)).abs() < 1e-18,
            "seed {seed}: {record:?}"
        );
        assert!(
            (record.out - of(-1.0)).abs() < 1e-18,
            "seed {seed}: {record:?}"
        );
    }
}
