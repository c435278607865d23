use super::*;
use crate::mesh::{BoxGrid, Incline, PlaneFracture};

/// The same sum, edge by edge, into a dense matrix.
fn oracle(
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
        let of = |side: FaceSide| {
            let e = side.element as usize;
            side_stiffness(1.0, rocks[usize::from(mesh.regions[e])], side_of(mesh, e))
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
                            let inverse = 1.0 / (of(k.minus)[d] + of(l.minus)[d])
                                + 1.0 / (of(k.plus)[d] + of(l.plus)[d]);
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
    let mut grid = BoxGrid::uniform([0.0; 3], [6.0, 5.0, 4.0], [6, 5, 4]);
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
    for state in states {
        let h =
            JumpStabilization::default().assemble_for(&built.mesh, &built.fractures, &rocks, state);
        let dense = oracle(&built.mesh, &built.fractures, &rocks, state);
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
