//! Claim: splitting gives every fracture two sides and changes nothing else, for through-going, embedded, T and X
//! fractures alike.

use fracas::mesh::{BoxGrid, BuiltMesh, Distort, Incline, PlaneFracture, audit};
use proptest::prelude::*;

fn cube(cells: usize, fractures: Vec<PlaneFracture>) -> BuiltMesh {
    let n = cells as f64;
    let mut grid = BoxGrid::uniform([0.0; 3], [n; 3], [cells; 3]);
    grid.fractures = fractures;
    grid.build().unwrap()
}

fn rectangle(axis: usize, at: f64, spans: [Option<[f64; 2]>; 3]) -> PlaneFracture {
    PlaneFracture {
        spans,
        ..PlaneFracture::through("F", axis, at)
    }
}

/// Copies of the grid node at `x`.
fn copies(built: &BuiltMesh, x: [f64; 3]) -> usize {
    built.mesh.nodes.iter().filter(|n| **n == x).count()
}

fn body_count(built: &BuiltMesh) -> usize {
    let free = vec![false; 3 * built.mesh.nodes.len()];
    audit(&built.mesh, &built.fractures, &free).bodies.len()
}

#[test]
fn through_going_fracture_makes_two_bodies() {
    let built = cube(4, vec![PlaneFracture::through("F", 0, 2.0)]);
    assert_eq!(built.mesh.nodes.len(), 125 + 25);
    assert_eq!(built.fractures.faces.len(), 16);
    assert_eq!(built.fractures.edges.len(), 24); // 2·4·3
    assert_eq!(body_count(&built), 2);
}

#[test]
fn embedded_fracture_keeps_its_tips_single() {
    let span = Some([1.0, 3.0]);
    let built = cube(4, vec![rectangle(0, 2.0, [None, span, span])]);
    assert_eq!(built.mesh.nodes.len(), 125 + 1);
    assert_eq!(copies(&built, [2.0, 2.0, 2.0]), 2);
    assert_eq!(copies(&built, [2.0, 1.0, 2.0]), 1);
    assert_eq!(body_count(&built), 1);
    let free = vec![false; 3 * built.mesh.nodes.len()];
    let counts = &audit(&built.mesh, &built.fractures, &free).fractures[0];
    assert_eq!(
        (counts.faces, counts.tip_nodes, counts.junction_edges),
        (4, 8, 0)
    );
}

#[test]
fn fracture_that_reaches_one_side_opens_there_only() {
    let built = cube(4, vec![rectangle(2, 2.0, [Some([0.0, 2.0]), None, None])]);
    assert_eq!(copies(&built, [0.0, 0.0, 2.0]), 2);
    assert_eq!(copies(&built, [2.0, 2.0, 2.0]), 1);
    assert_eq!(body_count(&built), 1);
}

#[test]
fn tee_gives_three_copies_and_cross_four_and_three_planes_eight() {
    let half = [Some([0.0, 2.0]), None, None];
    let tee = cube(
        4,
        vec![PlaneFracture::through("A", 0, 2.0), rectangle(1, 2.0, half)],
    );
    assert_eq!(copies(&tee, [2.0, 2.0, 1.0]), 3);
    assert_eq!(body_count(&tee), 3);
    assert_eq!(tee.fractures.edges.len(), 20 + 10); // A's 24 without the junction, and B's

    let planes: Vec<_> = (0..3)
        .map(|d| PlaneFracture::through("P", d, 2.0))
        .collect();
    let cross = cube(4, planes[..2].to_vec());
    assert_eq!(copies(&cross, [2.0, 2.0, 1.0]), 4);
    assert_eq!(body_count(&cross), 4);
    let counts = audit(
        &cross.mesh,
        &cross.fractures,
        &vec![false; 3 * cross.mesh.nodes.len()],
    );
    assert_eq!(counts.fractures[0].junction_edges, 4);

    let eight = cube(4, planes);
    assert_eq!(copies(&eight, [2.0; 3]), 8);
    assert_eq!(body_count(&eight), 8);
}

#[test]
fn normals_areas_and_frames_of_a_flat_and_of_a_tilted_plane() {
    for flip in [false, true] {
        let fracture = PlaneFracture {
            flip,
            ..PlaneFracture::through("F", 0, 2.0)
        };
        let mut grid = BoxGrid::uniform([0.0; 3], [4.0; 3], [4; 3]);
        grid.fractures = vec![fracture];
        let sign = if flip { -1.0 } else { 1.0 };
        for face in grid.build().unwrap().fractures.faces {
            assert_eq!(face.frame[0], [sign, 0.0, 0.0]);
            let across = i64::from(face.plus.element) - i64::from(face.minus.element);
            assert_eq!(across, if flip { -1 } else { 1 });
        }
        // dip 60°: n = (sin 60°, 0, −cos 60°), area 16 / sin 60°
        let dip = 60f64.to_radians();
        grid.warps.push(Box::new(Incline {
            plane: 0,
            along: 2,
            tilt: std::f64::consts::FRAC_PI_2 - dip,
            pivot: [2.0; 3],
            fade: false,
        }));
        let tilted = grid.build().unwrap();
        let area: f64 = tilted.fractures.faces.iter().map(|f| f.area).sum();
        approx::assert_relative_eq!(area, 16.0 / dip.sin(), max_relative = 1e-13);
        for face in &tilted.fractures.faces {
            approx::assert_relative_eq!(face.frame[0][0], sign * dip.sin(), max_relative = 1e-13);
            approx::assert_relative_eq!(face.frame[0][2], -sign * dip.cos(), max_relative = 1e-13);
            assert_eq!(
                face.frame[1].map(|v| (v * 1e12).round()),
                [0.0, sign * 1e12, 0.0]
            );
        }
    }
}

#[test]
fn fractures_stay_planar_under_distortion_and_volume_is_kept() {
    let mut grid = BoxGrid::uniform([0.0; 3], [4.0; 3], [4; 3]);
    grid.fractures = vec![PlaneFracture::through("F", 1, 1.0)];
    for smooth in [false, true] {
        grid.warps = vec![Box::new(Distort {
            amplitude: 0.2,
            seed: 7,
            smooth,
            planar: true,
        })];
        let built = grid.build().unwrap();
        let volume: f64 = (0..64).map(|e| built.volume(e)).sum();
        approx::assert_relative_eq!(volume, 64.0, max_relative = 1e-13);
        let area: f64 = built.fractures.faces.iter().map(|f| f.area).sum();
        approx::assert_relative_eq!(area, 16.0, max_relative = 1e-13);
        assert!(
            built
                .fractures
                .faces
                .iter()
                .all(|f| (f.frame[0][1] - 1.0).abs() < 1e-14)
        );
        assert!(
            built
                .mesh
                .nodes
                .iter()
                .any(|x| (x[0] - x[0].round()).abs() > 1e-3)
        );
    }
}

#[test]
fn sides_close_the_surface() {
    let built = cube(3, vec![PlaneFracture::through("F", 0, 1.0)]);
    for (side, faces) in built.sides.iter().enumerate() {
        assert_eq!(faces.len(), 9);
        for face in faces {
            let x = face.nodes.map(|n| built.mesh.nodes[n as usize]);
            let n = fracas::mesh::face_geometry(&x).frame[0];
            assert_eq!(n[side / 2], if side % 2 == 0 { -1.0 } else { 1.0 });
        }
    }
}

#[test]
fn an_inverted_element_is_named_with_its_place() {
    let mut grid = BoxGrid::uniform([0.0; 3], [4.0; 3], [4; 3]);
    grid.warps.push(Box::new(Incline {
        plane: 0,
        along: 2,
        tilt: 80f64.to_radians(),
        pivot: [2.0; 3],
        fade: true,
    }));
    let text = grid.build().unwrap_err().to_string();
    assert!(text.starts_with("element "), "{text}");
    assert!(text.contains("is inverted: min det J = -"), "{text}");
    assert!(
        text.ends_with("lower the angle of `incline`, widen the box, or let it not fade"),
        "{text}"
    );
}

#[test]
fn a_map_without_sense_is_refused() {
    let mut grid = BoxGrid::uniform([0.0; 3], [1.0; 3], [2; 3]);
    grid.warps.push(Box::new(Distort {
        amplitude: 0.7,
        seed: 0,
        smooth: false,
        planar: false,
    }));
    assert_eq!(
        grid.build().unwrap_err().to_string(),
        "map distort: amplitude is 0.7, but it must be at least 0 and less than 0.5 (of a cell)"
    );
}

fn any_fracture(n: usize) -> impl Strategy<Value = PlaneFracture> {
    let span = (0..n).prop_flat_map(move |from| (Just(from), from + 1..=n));
    (
        0..3usize,
        1..n,
        prop::array::uniform3(prop::option::of(span)),
        any::<bool>(),
    )
        .prop_map(|(axis, at, spans, flip)| PlaneFracture {
            name: "F".into(),
            axis,
            at: at as f64,
            spans: spans.map(|s| s.map(|(from, to)| [from as f64, to as f64])),
            flip,
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_fracture_sets(fractures in prop::collection::vec(any_fracture(4), 1..6)) {
        let mut grid = BoxGrid::uniform([0.0; 3], [4.0; 3], [4; 3]);
        for fracture in fractures {
            grid.fractures.push(fracture);
            if grid.build().is_err() {
                grid.fractures.pop(); // it overlaps an earlier one
            }
        }
        let built = grid.build().unwrap();
        let (mesh, faces) = (&built.mesh, &built.fractures.faces);

        let volume: f64 = (0..mesh.elements.len()).map(|e| built.volume(e)).sum();
        prop_assert!((volume - 64.0).abs() < 1e-10);
        for (a, o) in mesh.origin.iter().enumerate() {
            prop_assert_eq!(mesh.nodes[a], mesh.nodes[*o as usize]);
            prop_assert_eq!(mesh.origin[*o as usize], *o);
        }
        // every node is used
        let mut used = vec![false; mesh.nodes.len()];
        for n in mesh.elements.iter().flatten() {
            used[*n as usize] = true;
        }
        prop_assert!(used.iter().all(|u| *u));

        for face in faces {
            prop_assert_ne!(face.minus.element, face.plus.element);
            prop_assert!((face.area - 1.0).abs() < 1e-13);
            for a in 0..4 {
                let (m, p) = (face.minus.nodes[a], face.plus.nodes[a]);
                prop_assert_eq!(mesh.nodes[m as usize], mesh.nodes[p as usize]);
                prop_assert!(mesh.elements[face.minus.element as usize].contains(&m));
                prop_assert!(mesh.elements[face.plus.element as usize].contains(&p));
            }
            let [n, t1, t2] = face.frame;
            let cross = [
                n[1] * t1[2] - n[2] * t1[1],
                n[2] * t1[0] - n[0] * t1[2],
                n[0] * t1[1] - n[1] * t1[0],
            ];
            prop_assert_eq!(cross, t2);
            // n points from − to +
            let c = |e: u32| mesh.elements[e as usize].iter().fold([0.0; 3], |s, a| {
                let x = mesh.nodes[*a as usize];
                [s[0] + x[0], s[1] + x[1], s[2] + x[2]]
            });
            let (m, p) = (c(face.minus.element), c(face.plus.element));
            let along: f64 = (0..3).map(|d| n[d] * (p[d] - m[d])).sum();
            prop_assert!(along > 0.0);
        }
        // an unfractured pair of neighbours still shares its four nodes, a fractured face none unless at tips
        let cut: std::collections::HashSet<(u32, u32)> = faces
            .iter()
            .map(|f| (f.minus.element.min(f.plus.element), f.minus.element.max(f.plus.element)))
            .collect();
        for e in 0..64u32 {
            for (axis, stride) in [(0, 1u32), (1, 4), (2, 16)] {
                if (e / stride) % 4 == 3 {
                    continue;
                }
                let other = e + stride;
                let shared = mesh.elements[e as usize]
                    .iter()
                    .filter(|n| mesh.elements[other as usize].contains(n))
                    .count();
                if cut.contains(&(e, other)) {
                    prop_assert!(shared <= 4);
                } else {
                    prop_assert_eq!(shared, 4, "axis {}", axis);
                }
            }
        }
        // oracle: flood the cells around every grid node across uncut faces; as many copies as components
        let cell = |c: [i64; 3]| c.iter().all(|v| (0..4).contains(v)).then(|| (c[0] + 4 * c[1] + 16 * c[2]) as u32);
        for a in 0..125i64 {
            let node = [a % 5, a / 5 % 5, a / 25];
            let mut left: Vec<[i64; 3]> = (0..8)
                .map(|o| [node[0] - (o & 1), node[1] - (o >> 1 & 1), node[2] - (o >> 2)])
                .filter(|c| cell(*c).is_some())
                .collect();
            let mut components = 0;
            while let Some(first) = left.pop() {
                components += 1;
                let mut front = vec![first];
                while let Some(c) = front.pop() {
                    left.retain(|d| {
                        let distance: i64 = (0..3).map(|i| (c[i] - d[i]).abs()).sum();
                        let (p, q) = (cell(c).unwrap(), cell(*d).unwrap());
                        let joined = distance == 1 && !cut.contains(&(p.min(q), p.max(q)));
                        if joined {
                            front.push(*d);
                        }
                        !joined
                    });
                }
            }
            let copies = mesh.origin.iter().filter(|o| i64::from(**o) == a).count();
            prop_assert_eq!(copies, components);
        }
        // edges join faces of one fracture at coinciding nodes
        for edge in &built.fractures.edges {
            let [k, l] = edge.faces.map(|f| &faces[f as usize]);
            prop_assert_eq!(k.fracture, l.fracture);
            for (a, b) in edge.nodes_k.iter().zip(edge.nodes_l) {
                let (i, j) = (k.minus.nodes[*a as usize], l.minus.nodes[b as usize]);
                prop_assert_eq!(mesh.origin[i as usize], mesh.origin[j as usize]);
            }
        }
    }
}
