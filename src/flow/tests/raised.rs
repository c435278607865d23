use super::*;

/// Sources that give pressures, everywhere and on edges, and a well.
fn given() -> (BuiltMesh, Fluid) {
    let built = grid([6, 5, 4], vec![PlaneFracture::through("f", 2, 2.0)])
        .build()
        .unwrap();
    let source = |place, p| Source {
        place,
        given: Given::Pressure(p),
        history: 0,
        level: None,
    };
    let sources = vec![
        source(Place::Faces(vec![8, 9]), 7e6),
        source(Place::Edges(outer_edges(&built, 0, 0.0, None)), 3e6),
    ];
    let mut fluid = fluid(&[1e-13], sources);
    fluid.wells.push(Well {
        name: "w".into(),
        cuts: vec![(20, 2.0), (21, 1.0)],
        head: [4.5, 3.0, 4.0],
        given: WellGiven::Pressure(5e6),
        history: 0,
    });
    (built, fluid)
}

#[test]
fn given_pressures_are_raised_from_those_of_a_fluid_at_rest() {
    let (built, mut fluid) = given();
    for density in [0.0, 1000.0] {
        (fluid.density, fluid.gravity) = (density, [0.0, 0.0, -9.81]);
        let balance = balance(&fluid, &built);
        let faces = built.fractures.faces.iter();
        let rest: Vec<f64> = faces.map(|face| 1e6 + fluid.head(face.center)).collect();
        let n = rest.len();
        let step = balance.step([0.0, 2.0], rest.clone(), vec![0.0; n], |_, _| 1.0);
        assert_eq!(balance.raised(&step, 1.0), step);
        let states = vec![ContactState::Stick; n];
        let at_rest = balance.raised(&step, 0.0);
        let left = |step: &FlowStep| {
            let point = balance.evaluate(&states, &vec![0.0; 3 * n], &rest, step);
            point.residual.iter().fold(0.0f64, |m, r| m.max(r.abs()))
        };
        assert!(
            left(&at_rest) < 1e-9 * left(&step),
            "{} {}",
            left(&at_rest),
            left(&step)
        );
        let half = balance.raised(&step, 0.5);
        assert_eq!(half.held[8], Some(0.5 * (rest[8] + 7e6)));
        assert_eq!(half.held[0], None);
        let well = half.wells[0].pressure.unwrap();
        let whole = step.wells[0].pressure.unwrap();
        assert!((well - 0.5 * (1e6 + whole)).abs() < 1e-6 * whole, "{well}");
    }
}
