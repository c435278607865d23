//! Claim: a scene tells how large its mesh will be without meshing.

use fracas::scene::Scene;
use fracas_operators::random::Random;

const REST: &str = r#"
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "z+"
hold = "fixed"
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "x+"
hold = "fixed"
[[boundary]]
side = "y-"
hold = "fixed"
[[boundary]]
side = "y+"
hold = "fixed"
"#;

/// Numbers below `end`, one after the other.
fn draws(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut random = Random::new(seed);
    move |end| random.bits() % end
}

fn grid(cells: [u64; 3]) -> String {
    let axis = |(name, n): (&str, u64)| {
        format!("{name} = {{ from = \"0 m\", to = \"{n} m\", cells = {n} }}\n")
    };
    let axes: String = ["x", "y", "z"].into_iter().zip(cells).map(axis).collect();
    format!("title = \"family\"\n[mesh]\n{axes}{REST}")
}

/// Faces and copies as counted and as built.
fn sizes(scene: &str) -> [[u128; 2]; 2] {
    let scene = Scene::from_toml(scene, "family.toml").expect("a scene");
    let (size, body) = (scene.size(), scene.build().expect("a body"));
    assert_eq!(size.nodes, scene.nodes());
    let copies = body.mesh.nodes.len() as u128 - size.nodes;
    [
        [size.faces, body.fractures.faces.len() as u128],
        [size.copies, copies],
    ]
}

#[test]
fn networks_are_counted_exactly() {
    for seed in 0..12 {
        let mut draw = draws(seed);
        let mut scene = grid([3 + draw(5), 3 + draw(5), 3 + draw(5)]);
        for axis in ["x", "y", "z"] {
            let every = 1 + draw(3);
            if every < 3 {
                scene += &format!(
                    "[[fracture]]\nname = \"{axis}\"\nplane = \"{axis}\"\nevery = {every}\n"
                );
            }
        }
        for [counted, built] in sizes(&scene) {
            assert_eq!(counted, built, "seed {seed}");
        }
    }
}

#[test]
fn rectangles_are_counted_up_to_their_rims() {
    for seed in 0..12 {
        let mut draw = draws(100 + seed);
        let cells = [8 + draw(5), 8 + draw(5), 8 + draw(5)];
        let (mut scene, mut rims) = (grid(cells), 0);
        for (d, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let at = 1 + draw(cells[d] - 1);
            scene +=
                &format!("[[fracture]]\nname = \"{axis}\"\nplane = \"{axis}\"\nat = \"{at} m\"\n");
            for (e, other) in ["x", "y", "z"].into_iter().enumerate().filter(|o| o.0 != d) {
                let from = draw(cells[e] - 3);
                let to = from + 2 + draw(cells[e] - from - 1);
                scene += &format!("{other} = [\"{from} m\", \"{to} m\"]\n");
                rims += 2 * u128::from(to - from + 1);
            }
        }
        let [faces, [counted, built]] = sizes(&scene);
        assert_eq!(faces[0], faces[1], "seed {seed}");
        assert!(
            counted.abs_diff(built) <= rims,
            "seed {seed}: {counted} {built}"
        );
    }
}

#[test]
fn a_network_of_millions_is_counted_without_meshing() {
    let scene = grid([400, 400, 400])
        + "[[fracture]]\nname = \"x\"\nplane = \"x\"\nevery = 1\n[[fracture]]\nname = \"y\"\nplane = \"y\"\nevery = 1\n";
    let size = Scene::from_toml(&scene, "large.toml")
        .expect("a scene")
        .size();
    assert_eq!(size.nodes, 401 * 401 * 401);
    assert_eq!(size.faces, 2 * 399 * 400 * 400);
    assert_eq!(size.copies, 2 * 399 * 401 * 401 + 399 * 399 * 401);
}
