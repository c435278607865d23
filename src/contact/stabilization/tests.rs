use super::*;
use crate::mesh::{BoxGrid, Incline, PlaneFracture};

/// The same sum, edge by edge, into a dense matrix.
fn oracle(
    lengths: Lengths,
    mesh: &HexMesh,
    fractures: &FractureMesh,
    rocks: &[Elastic],
    state: impl Fn(usize) -> ContactState,
) -> Vec<Vec<f64>> {
    let n = 3 * fractures.faces.len();
    let mut h = vec![vec![0.0; n]; n];
    for edge in &fractures.edges {
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
    for (lengths, state) in [Lengths::Deep, Lengths::Box].into_iter().zip(states) {
        let stabilization = JumpStabilization {
            lengths,
            ..JumpStabilization::default()
        };
        let h = stabilization.assemble_for(&built.mesh, &built.fractures, &rocks, state);
        let dense = oracle(lengths, &built.mesh, &built.fractures, &rocks, state);
        let size = dense.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(size > 0.0 && h.nnz() > h.rows() / 2);
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
