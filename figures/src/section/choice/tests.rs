//! Planes show what there is to see, and sections have the area and the values of the body.
#![allow(clippy::unwrap_used)]

use super::super::{Section, plane::Plane, planes};
use fracas::scene::{Body, Scene};

/// A box of these cells of 1 m, with fractures and a map of its nodes.
fn body(cells: [usize; 3], more: &str) -> Body {
    let [x, y, z] = cells.map(|n| format!("{{ from = \"0 m\", to = \"{n} m\", cells = {n} }}"));
    let toml = format!(
        "title = \"box\"\n[mesh]\nx = {x}\ny = {y}\nz = {z}\n[[material]]\nname = \"rock\"\nyoung = \"10 GPa\"\npoisson = 0.2\n\
         [[boundary]]\nside = \"z-\"\nhold = \"fixed\"\n{more}"
    );
    Scene::from_toml(&toml, "box.toml")
        .unwrap()
        .build()
        .unwrap()
}

fn area(section: &Section) -> f64 {
    let of = |q: &[[f64; 2]; 4]| {
        let term = |k: usize| {
            let (a, b) = (q[k], q[(k + 1) % 4]);
            0.5 * (a[0] * b[1] - a[1] * b[0])
        };
        (0..4).map(term).sum::<f64>().abs()
    };
    section.patches.quads.iter().map(of).sum()
}

fn axis(plane: &Plane) -> Option<usize> {
    (0..3).find(|k| plane.normal[*k].abs() > 1.0 - 1e-9)
}

#[test]
fn every_scene_of_the_gallery_has_sections_through_its_fractures() {
    for known in fracas::scene::gallery() {
        let body = known.small_scene().unwrap().build().unwrap();
        let planes = planes(&body);
        assert!((1..=3).contains(&planes.len()), "{}", known.name);
        let mut traces = 0;
        for plane in planes {
            let section = Section::new(&body, plane, 10_000);
            assert!(!section.patches.quads.is_empty(), "{}", known.name);
            assert!(!section.edges.is_empty(), "{}", known.name);
            traces += section.traces.len();
        }
        let has_fractures = !body.fractures.faces.is_empty();
        assert_eq!(traces > 0, has_fractures, "{}", known.name);
    }
}

#[test]
fn a_sheet_is_shown_along_itself_and_other_bodies_across_their_fractures() {
    let fracture = "[[fracture]]\nname = \"f\"\nplane = \"x\"\nat = \"3 m\"\nfriction_angle = \"30 deg\"\n[[boundary]]\nside = \"x+\"\nhold = \"fixed\"\n";
    for (cells, normal) in [([6, 6, 6], 1), ([6, 6, 1], 2), ([6, 1, 6], 1)] {
        let body = body(cells, fracture);
        let planes = planes(&body);
        assert_eq!(
            (planes.len(), axis(&planes[0])),
            (1, Some(normal)),
            "{cells:?}"
        );
        // between grid lines
        let [a, b] = [planes[0].offset, planes[0].offset.floor() + 0.5];
        assert!((a - b).abs() < 1e-9, "{a}");
    }
}

#[test]
fn sections_have_the_area_of_the_body_and_the_values_of_a_linear_field() {
    let body = body([5, 4, 3], "");
    let field: Vec<f64> = (body.mesh.nodes.iter())
        .flat_map(|x| [x[0] - 2.0 * x[1], x[2], 1.0 + x[0] + x[1] + x[2]])
        .collect();
    let h = std::f64::consts::FRAC_1_SQRT_2;
    for (normal, offset, expected) in [
        ([0.0, 1.0, 0.0], 1.7, 15.0),
        // on a grid plane: one side alone
        ([0.0, 0.0, 1.0], 1.0, 20.0),
        // x + z = 4 between (1, 3) and (4, 0)
        ([h, 0.0, h], 4.0 * h, 4.0 * 3.0 / h),
        // a corner: a triangle of sides √2
        ([1.0 / 3f64.sqrt(); 3], 1.0 / 3f64.sqrt(), 0.5 * 3f64.sqrt()),
    ] {
        let plane = Plane { normal, offset };
        let section = Section::new(&body, plane, 10_000);
        // heights are read in planes that dip
        let found = area(&section) * section.directions[1].stretch();
        assert!((found - expected).abs() < 1e-9, "{normal:?}: {found}");
        for e in &section.patches.of {
            let [a, b, c] = section.mean(&body.mesh, *e, &field);
            // 1 + x + y + z is 1 + y + 4 where x + z = 4; every field is that of one point of the plane
            let point = [
                c - 1.0 - b - (c - 1.0 - b - a) / 3.0,
                (c - 1.0 - b - a) / 3.0,
                b,
            ];
            let at: f64 = (0..3).map(|k| normal[k] * point[k]).sum();
            assert!((at - offset).abs() < 1e-9, "{point:?}");
        }
    }
}

#[test]
fn edges_of_materials_are_lines() {
    let layer = "[[material]]\nname = \"layer\"\nyoung = \"1 GPa\"\npoisson = 0.3\nlayers = [[\"1 m\", \"2 m\"]]\n";
    let body = body([6, 4, 4], layer);
    let section = Section::new(
        &body,
        Plane {
            normal: [0.0, 1.0, 0.0],
            offset: 1.5,
        },
        10_000,
    );
    let level = |z: f64| {
        let is_level = |line: &&Vec<[f64; 2]>| line.iter().all(|p| (p[1] - z).abs() < 1e-9);
        section.edges.iter().filter(is_level).count()
    };
    assert_eq!([level(1.0), level(2.0), level(3.0)], [1, 1, 0]);
}
