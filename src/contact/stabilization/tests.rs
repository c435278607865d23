use super::*;
use crate::mesh::{BoxGrid, Incline, PlaneFracture, Rotate, Warp};
use fracas_operators::random::splitmix64;
use fracas_solvers::eigen::factors::inverse;

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
        let faces = ends.map(|f| &fractures.faces[f]);
        let [k, l] = faces;
        let of = |face: &FractureFace, side: FaceSide| {
            let e = side.element as usize;
            let side = match lengths {
                Lengths::Box => Side::boxed(mesh, e),
                Lengths::Deep => Side::deep(mesh, e, face),
            };
            side_stiffness(1.0, rocks[usize::from(mesh.regions[e])], side)
        };
        let areas: f64 = (0..2)
            .map(|a| {
                k.node_areas[edge.nodes_k[a] as usize] * l.node_areas[edge.nodes_l[a] as usize]
            })
            .sum();
        let pair = |k: FaceSide, l: FaceSide| {
            let (k, l) = (of(faces[0], k), of(faces[1], l));
            let sum = faer::Mat::from_fn(3, 3, |i, j| k[i][j] + l[i][j]);
            inverse(sum.as_ref()).unwrap()
        };
        let y = [pair(k.minus, l.minus), pair(k.plus, l.plus)];
        let shared = ends.map(|f| state(f).constrained());
        let shared = shared[0].min(shared[1]);
        for f in ends {
            for g in ends {
                let sign = if f == g { 1.0 } else { -1.0 };
                for i in 0..shared {
                    for j in 0..shared {
                        for (d, e) in (0..9).map(|k| (k / 3, k % 3)) {
                            h[3 * f + i][3 * g + j] += sign
                                * fractures.faces[f].frame[i][d]
                                * ((y[0][(d, e)] + y[1][(d, e)]) * areas)
                                * fractures.faces[g].frame[j][e];
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

/// A plane inside sheared cells of any thinness, turned about two axes.
fn turned(seed: u64, turns: [f64; 2]) -> crate::mesh::BuiltMesh {
    let next = |k: u64| (splitmix64(16 * seed + k) >> 11) as f64 / (1u64 << 53) as f64;
    let thin = f64::powf(1e-2, next(0));
    let mut grid = BoxGrid::uniform([0.0; 3], [4.0 * thin, 3.0, 5.0], [4, 3, 4]);
    grid.fractures = vec![PlaneFracture::through("F", 0, 2.0 * thin)];
    grid.warps = vec![Box::new(Incline {
        plane: 0,
        along: 2,
        tilt: next(1) - 0.5,
        pivot: [0.0; 3],
        fade: false,
    })];
    for (axis, angle) in [(2, turns[0]), (1, turns[1])] {
        let center = [0.3, -0.2, 1.0];
        let turn: Box<dyn Warp> = Box::new(Rotate {
            axis,
            angle,
            center,
        });
        grid.warps.push(turn);
    }
    grid.build().unwrap()
}

#[test]
fn h_turns_with_the_body() {
    let rocks = [Elastic {
        young: 3.0,
        poisson: 0.2,
    }];
    for seed in 0..20 {
        let next = |k: u64| (splitmix64(16 * seed + k) >> 11) as f64 / (1u64 << 53) as f64;
        let turns = [6.0 * next(2), 6.0 * next(3)];
        let form = |turns: [f64; 2], lengths: Lengths| {
            let built = turned(seed, turns);
            let stabilization = JumpStabilization {
                lengths,
                ..JumpStabilization::default()
            };
            let h = stabilization.assemble(&built.mesh, &built.fractures, one(&rocks));
            let about = |axis: usize, angle: f64, v: [f64; 3]| {
                let [j, k] = [(axis + 1) % 3, (axis + 2) % 3];
                let (sin, cos) = angle.sin_cos();
                let mut turned = v;
                turned[j] = cos * v[j] - sin * v[k];
                turned[k] = sin * v[j] + cos * v[k];
                turned
            };
            // tractions that turn with the body, in the frames of their faces
            let t = built
                .fractures
                .faces
                .iter()
                .enumerate()
                .flat_map(|(f, face)| {
                    let v = [0, 1, 2].map(|j| next(100 + 3 * f as u64 + j) - 0.5);
                    let v = about(1, turns[1], about(2, turns[0], v));
                    face.frame.map(|r| (0..3).map(|j| r[j] * v[j]).sum::<f64>())
                });
            let t: Vec<f64> = t.collect();
            let mut product = vec![0.0; t.len()];
            for (i, row) in h.outer_iterator().enumerate() {
                product[i] = row.iter().map(|(j, v)| v * t[j]).sum();
            }
            t.iter().zip(product).map(|(a, b)| a * b).sum::<f64>()
        };
        let apart = |lengths| {
            let [at_rest, turned] = [[0.0; 2], turns].map(|turns| form(turns, lengths));
            (turned / at_rest - 1.0).abs()
        };
        assert!(apart(Lengths::Deep) < 1e-9, "seed {seed}");
        assert!(apart(Lengths::Box) > 1e-3, "seed {seed}");
        let compliance = |turns| {
            let built = turned(seed, turns);
            let face = &built.fractures.faces[0];
            face_compliance(&built.mesh, &rocks, face)
        };
        let [at_rest, turned] = [[0.0; 2], turns].map(compliance);
        assert!((turned / at_rest - 1.0).abs() < 1e-9, "seed {seed}");
    }
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
        for j in 0..3 {
            assert!(near(side.metric[j][j].powf(-0.5), expected[j]), "{side:?}");
        }
        assert!(near(side.volume, 20.0 * deep), "{side:?}");
    }
}
