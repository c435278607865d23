use super::*;
use crate::mesh::{BoxGrid, Incline, PlaneFracture};

/// A body of one material.
fn one(rock: &[Elastic; 1]) -> Rocks<'_> {
    Rocks {
        elastic: rock,
        first_alike: &[0],
    }
}

/// The same sum, edge by edge, into a dense matrix.
fn oracle(
    (lengths, junctions): (Lengths, Junctions),
    mesh: &HexMesh,
    fractures: &FractureMesh,
    rocks: &[Elastic],
    state: impl Fn(usize) -> ContactState,
) -> Vec<Vec<f64>> {
    let n = 3 * fractures.faces.len();
    let mut h = vec![vec![0.0; n]; n];
    let crossings = fractures.crossings.iter().filter(|crossing| {
        let sticks = |f: &u32| state(*f as usize) == ContactState::Stick;
        junctions == Junctions::Joined && crossing.others.iter().all(sticks)
    });
    for edge in fractures.edges.iter().chain(crossings.map(|c| &c.edge)) {
        let ends = edge.faces.map(|f| f as usize);
        let [k, l] = ends.map(|f| &fractures.faces[f]);
        let of = |face: &FractureFace, side: FaceSide| {
            let e = side.element as usize;
            let side = match lengths {
                Lengths::Box => Side::new(mesh, e),
                Lengths::Deep => Side::deep(mesh, e, face),
            };
            side_stiffness(1.0, rocks[usize::from(mesh.regions[e])], side)
        };
        let areas: f64 = (0..2)
            .map(|a| {
                k.node_areas[edge.nodes_k[a] as usize] * l.node_areas[edge.nodes_l[a] as usize]
            })
            .sum();
        let shared = ends.map(|f| state(f).constrained());
        let shared = shared[0].min(shared[1]);
        for f in ends {
            for g in ends {
                let sign = if f == g { 1.0 } else { -1.0 };
                for i in 0..shared {
                    for j in 0..shared {
                        for d in 0..3 {
                            let inverse = 1.0 / (of(k, k.minus)[d] + of(l, l.minus)[d])
                                + 1.0 / (of(k, k.plus)[d] + of(l, l.plus)[d]);
                            h[3 * f + i][3 * g + j] += sign
                                * fractures.faces[f].frame[i][d]
                                * (inverse * areas)
                                * fractures.faces[g].frame[j][d];
                        }
                    }
                }
            }
        }
    }
    h
}

#[test]
fn rows_gathered_face_by_face_are_the_sum_over_edges() {
    let mut grid = BoxGrid::uniform([0.0; 3], [6.0, 5.0, 4.0], [12, 5, 4]);
    grid.fractures = vec![
        PlaneFracture::through("F", 0, 2.0),
        PlaneFracture::through("G", 2, 2.0),
    ];
    grid.warps = vec![Box::new(Incline {
        plane: 0,
        along: 2,
        tilt: 0.4,
        pivot: [2.0, 0.0, 2.0],
        fade: true,
    })];
    let built = grid.build().unwrap();
    let rocks = [Elastic {
        young: 3.0,
        poisson: 0.2,
    }];
    let mixed = |f: usize| ContactState::ALL[[0, 0, 0, 2, 0, 3, 1][f % 7]];
    let stick = |_: usize| ContactState::Stick;
    let states: [&(dyn Fn(usize) -> ContactState + Sync); 2] = [&stick, &mixed];
    let mut entries = Vec::new();
    for (choice, state) in [
        ((Lengths::Deep, Junctions::Joined), states[0]),
        ((Lengths::Deep, Junctions::Apart), states[0]),
        ((Lengths::Deep, Junctions::Joined), states[1]),
        ((Lengths::Box, Junctions::Apart), states[1]),
    ] {
        let (lengths, junctions) = choice;
        let stabilization = JumpStabilization {
            lengths,
            junctions,
            ..JumpStabilization::default()
        };
        let h = stabilization.assemble_for(&built.mesh, &built.fractures, one(&rocks), state);
        let dense = oracle(choice, &built.mesh, &built.fractures, &rocks, state);
        let size = dense.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(size > 0.0 && h.nnz() > h.rows() / 2);
        entries.push(h.nnz());
        for (i, row) in dense.iter().enumerate() {
            for (j, expected) in row.iter().enumerate() {
                let found = h.get(i, j).copied().unwrap_or(0.0);
                assert!((found - expected).abs() <= 1e-14 * size, "({i}, {j})");
                assert!(
                    h.get(i, j).is_none_or(|v| *v != 0.0),
                    "stored zero ({i}, {j})"
                );
            }
        }
    }
    // two fractures meet along five edges, each of them with two pairs of neighbours
    assert_eq!(built.fractures.crossings.len(), 2 * 5);
    assert!(entries[0] > entries[1], "{entries:?}");
}

#[test]
fn faces_are_neighbours_across_a_fracture_while_it_sticks() {
    let mut grid = BoxGrid::uniform([0.0; 3], [4.0, 1.0, 4.0], [4, 1, 4]);
    grid.fractures = vec![
        PlaneFracture::through("F", 0, 2.0),
        PlaneFracture::through("G", 2, 2.0),
    ];
    let built = grid.build().unwrap();
    let rocks = [Elastic {
        young: 3.0,
        poisson: 0.2,
    }];
    let of = |f: usize| built.fractures.faces[f].fracture;
    let coupled = |state: ContactState| {
        let h = JumpStabilization::default().assemble_for(
            &built.mesh,
            &built.fractures,
            one(&rocks),
            |f| {
                if of(f) == 1 {
                    state
                } else {
                    ContactState::Stick
                }
            },
        );
        // F is coupled along all of its height, or falls apart at G
        let faces = (0..built.fractures.faces.len()).filter(|f| of(*f) == 0);
        let blocks = faces.map(|f| h.outer_view(3 * f).unwrap().nnz());
        blocks.sum::<usize>()
    };
    let [stick, slip, open] =
        [ContactState::Stick, ContactState::Slip, ContactState::Open].map(coupled);
    // four faces in a row: 4 + 2·3 entries of t_N, and 4 + 2·2 without the pair in the middle
    assert_eq!([stick, slip, open], [10, 8, 8]);
}

#[test]
fn an_element_thinner_than_its_face_is_wide_is_stretched_along_the_normal_alone() {
    for (thickness, deep) in [(2.0, 4.0), (4.0, 4.0), (8.0, 8.0)] {
        let mut grid = BoxGrid::uniform([0.0; 3], [2.0 * thickness, 8.0, 10.0], [2, 2, 2]);
        grid.fractures = vec![PlaneFracture::through("F", 0, thickness)];
        let built = grid.build().unwrap();
        let face = &built.fractures.faces[0];
        let side = Side::deep(&built.mesh, face.plus.element as usize, face);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12 * b;
        let expected = [deep, 4.0, 5.0];
        assert!(
            (0..3).all(|j| near(side.extent[j], expected[j])),
            "{side:?}"
        );
        assert!(near(side.volume, 20.0 * deep), "{side:?}");
    }
}
