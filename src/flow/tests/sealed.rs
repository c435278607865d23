use super::*;

#[test]
fn sealed_parts_are_found_and_keep_their_mean_pressure() {
    let mut far = PlaneFracture::through("G", 2, 3.0);
    far.spans[0] = Some([0.0, 3.0]);
    let mut near = PlaneFracture::through("F", 2, 1.0);
    near.spans[0] = Some([2.0, 6.0]);
    let built = grid([6, 5, 4], vec![near, far]).build().unwrap();
    let n = built.fractures.faces.len();
    let near = (0..n as u32).filter(|f| built.fractures.faces[*f as usize].fracture == 0);
    let near: Vec<u32> = near.collect();
    let rate = |face: u32, rate: f64| Source {
        place: Place::Faces(vec![face]),
        given: Given::Rate(rate),
        level: None,
        history: 0,
    };
    // as much out as in on the first, more in on the second, which ends in a pressure or not
    let closed = vec![ContactState::Stick; n];
    for ended in [false, true] {
        let mut sources = vec![
            rate(near[0], 1e-3),
            rate(near[3], -1e-3),
            rate(n as u32 - 1, 1e-3),
        ];
        if ended {
            sources.push(held(outer_edges(&built, 0, 0.0, Some(1)), 0.0));
        }
        let fluid = fluid(&[1e-12, 1e-12], sources);
        let balance = balance(&fluid, &built);
        let mut step = step(&balance, n, 2.0);
        step.pressure.fill(5e6);
        let sealed = balance.sealed(&closed, &step);
        assert_eq!(sealed.len(), if ended { 1 } else { 2 });
        assert_eq!((&sealed[0].faces, sealed[0].excess), (&near, 0.0));
        if !ended {
            assert!((sealed[1].excess - 2e-3).abs() < 1e-15);
            assert_eq!(balance.to_open(&sealed[1], &step), [n as u32 - 1]);
        } else {
            let p = rigid(&balance, &step);
            let mean = near.iter().map(|f| p[*f as usize]).sum::<f64>() / near.len() as f64;
            assert!((mean - 5e6).abs() < 1e-3, "{mean}");
            assert!(p[near[0] as usize] > 5e6 && p[near[3] as usize] < 5e6);
        }
        let mut open = closed.clone();
        open[near[2] as usize] = ContactState::Open;
        assert_eq!(balance.sealed(&open, &step).len(), usize::from(!ended));
    }
}
