//! Claim: what cannot be held and what cannot be felt is found before a solve.

use fracas::mesh::{Audit, BoxGrid, BuiltMesh, Hold, KernelReason, PlaneFracture, audit};

fn built(cells: [usize; 3], fractures: Vec<PlaneFracture>) -> BuiltMesh {
    let mut grid = BoxGrid::uniform([0.0; 3], cells.map(|n| n as f64), cells);
    grid.fractures = fractures;
    grid.build().unwrap()
}

/// Audit with the given components prescribed on the given sides.
fn audited(mesh: &BuiltMesh, held: &[(usize, &[usize])]) -> Audit {
    let mut prescribed = vec![false; 3 * mesh.mesh.nodes.len()];
    for (side, components) in held {
        for node in mesh.sides[*side].iter().flat_map(|f| f.nodes) {
            for d in *components {
                prescribed[3 * node as usize + d] = true;
            }
        }
    }
    audit(&mesh.mesh, &mesh.fractures, &prescribed)
}

const ALL: &[usize] = &[0, 1, 2];

#[test]
fn rollers_hold_what_they_touch() {
    let mesh = built([4, 2, 2], vec![PlaneFracture::through("F", 0, 2.0)]);
    let audit = audited(&mesh, &[(0, &[0]), (2, &[1]), (4, &[2])]);
    let [left, right] = audit.bodies.as_slice() else {
        panic!()
    };
    assert_eq!((left.boundary_rank, left.hold), (6, Hold::Boundary));
    // rollers on y− and z− leave the right block only its translation along x
    assert_eq!((right.boundary_rank, right.hold), (5, Hold::Fractures));
    assert_eq!(audit.kernel_of_a(), 1);
    assert_eq!(right.free_axes, [true, false, false]);
}

#[test]
fn one_face_stops_three_motions_only() {
    let mesh = built([2, 1, 1], vec![PlaneFracture::through("F", 0, 1.0)]);
    let audit = audited(&mesh, &[(0, ALL)]);
    assert_eq!(audit.bodies[1].hold, Hold::Nothing { free: 3 });
    // four faces that are not on one line stop all six
    let mesh = built([2, 2, 2], vec![PlaneFracture::through("F", 0, 1.0)]);
    assert_eq!(audited(&mesh, &[(0, ALL)]).bodies[1].hold, Hold::Fractures);
}

#[test]
fn blocks_that_only_hold_each_other_are_found() {
    // four columns joined by hinges in a ring: with two of them fixed they are a triangle, free they are a four-bar
    // linkage with one motion more than a rigid body
    let planes = vec![
        PlaneFracture::through("X", 0, 1.0),
        PlaneFracture::through("Y", 1, 1.0),
    ];
    let mesh = built([2, 2, 3], planes);
    let bound = audited(&mesh, &[(0, ALL)]);
    assert!(
        bound
            .bodies
            .iter()
            .all(|b| matches!(b.hold, Hold::Boundary | Hold::Fractures))
    );
    let free = audited(&mesh, &[]);
    assert!(
        free.bodies
            .iter()
            .all(|b| b.hold == Hold::Nothing { free: 7 }),
        "{free}"
    );
}

#[test]
fn a_slab_of_one_element_between_rollers_has_empty_columns() {
    let mesh = built([4, 1, 3], vec![PlaneFracture::through("F", 0, 2.0)]);
    let audit = audited(&mesh, &[(0, ALL), (1, ALL), (2, &[1]), (3, &[1])]);
    let empty: Vec<_> = audit
        .kernel
        .findings
        .iter()
        .filter(|f| f.reason == KernelReason::EmptyColumn { component: 1 })
        .collect();
    assert_eq!(empty.len(), 3);
    let center = empty[0].center.map(|v| (v * 1e9).round() * 1e-9);
    assert_eq!(center, [2.0, 0.5, 0.5]);
    assert_eq!(audit.kernel.dimension, Some(3));
    // the uniform t_1 on the one patch, which pushes on rollers
    assert_eq!(audit.kernel.stabilized_dimension, 1);
    assert_eq!(audit.kernel.idle_dimension, 1);
    assert!(
        audit
            .to_string()
            .contains("t_1 acts on prescribed displacements only (empty column of B)")
    );
}

#[test]
fn a_fracture_of_one_face_is_not_split_and_says_so() {
    let mut tiny = PlaneFracture::through("F", 0, 2.0);
    tiny.spans = [None, Some([1.0, 2.0]), Some([1.0, 2.0])];
    let audit = audited(&built([4, 4, 4], vec![tiny]), &[(0, ALL)]);
    assert_eq!(
        (audit.kernel.dimension, audit.kernel.stabilized_dimension),
        (Some(3), 3)
    );
    assert_eq!(audit.kernel.idle_dimension, 3);
    assert_eq!(audit.fractures[0].tip_nodes, 4);
    assert_eq!(audit.kernel.findings.len(), 1);
    assert_eq!(audit.kernel.findings[0].reason, KernelReason::NotSplit);
    let text = audit.to_string();
    assert!(
        text.contains("3 traction modes push on prescribed displacements or tips only")
            && text.contains("\"F\" on 1 face, first face 0 at (2.000000, 1.500000, 1.500000) m: all four corners are tips"),
        "{text}"
    );
}

#[test]
fn counts_need_no_dense_rank() {
    let mut square = PlaneFracture::through("F", 2, 2.0);
    square.spans = [Some([1.0, 5.0]), Some([1.0, 5.0]), None];
    let audit = audited(&built([6, 6, 4], vec![square]), &[(4, ALL)]);
    assert_eq!(audit.kernel.dimension, Some(3 * 7));
    let counted: Vec<_> = audit
        .kernel
        .findings
        .iter()
        .filter_map(|f| match f.reason {
            KernelReason::Counting { faces, jumps, .. } => Some((faces, jumps)),
            _ => None,
        })
        .collect();
    assert_eq!(counted, [(16, 9); 3]);
    assert_eq!(audit.kernel.stabilized_dimension, 0);
}

/// Slender along any axis, to 1:1e8: held at an end, at both, by rollers, through joints; and what is free is counted as in a cube.
#[test]
fn slender_bodies_are_held_like_cubes() {
    for axis in 0..3 {
        for slenderness in [1.0, 1e3, 1e6, 1e8] {
            let mut size = [1.0; 3];
            size[axis] = slenderness;
            let mut grid = BoxGrid::uniform([0.0; 3], size, [4; 3]);
            let middle = 0.5 * slenderness;
            grid.fractures = vec![PlaneFracture::through("F", axis, middle)];
            let mesh = grid.build().unwrap();
            let [low, high] = [2 * axis, 2 * axis + 1];
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            let said = |held: &[(usize, &[usize])]| {
                let audit = audited(&mesh, held);
                audit.bodies.iter().map(|b| b.hold).collect::<Vec<_>>()
            };
            let at = format!("axis {axis}, 1:{slenderness:e}");
            // one end fixed, both
            let one = said(&[(low, ALL)]);
            assert_eq!(one, [Hold::Boundary, Hold::Fractures], "{at}");
            let both = said(&[(low, ALL), (high, ALL)]);
            assert_eq!(both, [Hold::Boundary; 2], "{at}");
            // rollers along the body, and one at its end
            let sides = others.map(|d| (2 * d, [d]));
            let rollers = [
                (sides[0].0, &sides[0].1[..]),
                (sides[1].0, &sides[1].1[..]),
                (low, &[axis][..]),
            ];
            assert_eq!(said(&rollers), [Hold::Boundary, Hold::Fractures], "{at}");
            // without that end both slide, without one side both turn about it, too
            let slides = [Hold::Nothing { free: 1 }; 2];
            assert_eq!(said(&rollers[..2]), slides, "{at}");
            let turns = [Hold::Nothing { free: 3 }; 2];
            assert_eq!(said(&rollers[..1]), turns, "{at}");
            assert_eq!(said(&[]), [Hold::Nothing { free: 6 }; 2], "{at}");
        }
    }
}
