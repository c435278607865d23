//! How far a round opens a fracture.

use super::*;

/// Faces that share an edge with a face of `of`.
fn neighbours(balance: &Balance<'_>, of: &[usize]) -> Vec<usize> {
    let mut found = Vec::new();
    for arms in balance.network.meetings() {
        let faces: Vec<usize> = arms.iter().map(|arm| arm.face as usize).collect();
        if faces.iter().any(|f| of.contains(f)) {
            found.extend(faces);
        }
    }
    found
}

#[test]
fn a_fluid_opens_whole_rings_around_open_faces_and_no_more_than_three_times_their_area() {
    let (mut cut, mut all, mut many) = (0, 0, 0);
    for seed in 0..200 {
        let r = &mut Random::new(seed);
        let built = grid([8, 7, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        let built = built.build().unwrap();
        let n = built.fractures.faces.len();
        let fluid = fluid(&[1e-14], Vec::new());
        let balance = balance(&fluid, &built);
        let step = step(&balance, n, 1.0);
        let (few, most) = (r.between(0.0, 0.3), r.between(0.0, 1.0));
        let mut states = vec![ContactState::Stick; n];
        for state in &mut states {
            if r.chance(few) {
                *state = ContactState::Open;
            }
        }
        let is_open = |f: &usize| states[*f] == ContactState::Open;
        let open: Vec<usize> = (0..n).filter(is_open).collect();
        let closed = (0..n).filter(|f| !is_open(f));
        let wanted: Vec<usize> = closed.filter(|_| r.chance(most)).collect();
        let taken = balance.front(&states, &wanted, &step);
        assert!(taken.iter().all(|f| wanted.contains(f)), "seed {seed}");
        assert_eq!(taken.is_empty(), wanted.is_empty(), "seed {seed}");
        let beside = neighbours(&balance, &open);
        let first: Vec<usize> = wanted
            .iter()
            .copied()
            .filter(|f| beside.contains(f))
            .collect();
        if first.is_empty() {
            // nothing leads there
            assert_eq!(taken.len(), wanted.len(), "seed {seed}");
            all += 1;
            continue;
        }
        assert!(first.iter().all(|f| taken.contains(f)), "seed {seed}");
        let grown = open.len() + taken.len();
        assert!(
            taken.len() == first.len() || grown <= 3 * open.len(),
            "seed {seed}"
        );
        cut += usize::from(taken.len() < wanted.len());
        many += usize::from(taken.len() > first.len());
    }
    assert!(cut > 20 && all > 5 && many > 5, "{cut} {all} {many}");
}

#[test]
fn where_no_face_is_open_the_fluid_begins_where_it_comes_in() {
    let built = grid([8, 7, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
    let built = built.build().unwrap();
    let n = built.fractures.faces.len();
    let source = Source {
        place: Place::Faces(vec![10]),
        given: Given::Rate(1e-3),
        level: None,
        history: 0,
    };
    let fluid = fluid(&[1e-14], vec![source]);
    let balance = balance(&fluid, &built);
    let step = step(&balance, n, 2.0);
    let states = vec![ContactState::Slip; n];
    let all: Vec<usize> = (0..n).collect();
    assert_eq!(balance.front(&states, &all, &step), [10]);
    // it does not come to any of these
    assert_eq!(balance.front(&states, &all[20..], &step), &all[20..]);
    let area = built.fractures.faces[0].area;
    assert!((balance.widest(&step) - 2e-3 / area).abs() < 1e-12 / area);
}
