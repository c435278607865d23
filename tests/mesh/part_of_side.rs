//! Claim: a load on a part of a side acts on its faces, a hold on its nodes, and ends inside faces are told.

use fracas::scene::Scene;

fn scene(boundary: &str) -> Scene {
    let text = format!(
        "title = 'part'\n[mesh]\nx = {{ from = '0 m', to = '6 m', cells = 6 }}\ny = {{ from = '0 m', to = '4 m', cells = 4 }}\nz = {{ from = '0 m', to = '2 m', cells = 2 }}\n\
         [[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n\
         [[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'z+'\n{boundary}"
    );
    Scene::from_toml(&text, "part.toml").unwrap()
}

fn said(boundary: &str) -> String {
    scene(boundary).build().unwrap_err().to_string()
}

#[test]
fn a_load_on_a_part_has_its_area_and_a_hold_its_nodes() {
    let body = scene("pressure = '2 MPa'\nx = ['1 m', '3 m']\ny = ['1 m', '4 m']\n");
    let push = &body.build().unwrap().inventory().pushes[0];
    assert_eq!(push.faces, 6);
    assert!((push.area - 6.0).abs() < 1e-12, "{push:?}");
    assert!((push.force[2] + 12e6).abs() < 1e-3, "{push:?}");
    let whole = scene("pressure = '2 MPa'\nx = ['-1 m', '7 m']\n");
    assert_eq!(whole.build().unwrap().inventory().pushes[0].faces, 24);
    let held = |keys: &str| scene(keys).build().unwrap().inventory().held[2];
    let below = held("traction = { x = '1 MPa' }\n");
    let above = held("hold = 'roller'\nx = ['2 m', '3 m']\ny = ['0 m', '1 m']\n");
    assert_eq!(above, below + 4);
}

#[test]
fn a_side_at_the_end_of_a_span_belongs_to_it_as_it_is_rounded() {
    // half a turn takes y+ to y = 0, but for rounding
    let turned = "pressure = '2 MPa'\n[[boundary]]\nside = 'y+'\npressure = '1 MPa'\ny = ['0 m', '3 m']\n\
                  [mesh.map.rotate]\naxis = 'z'\nangle = '180 deg'\n";
    let found = scene(turned).build().unwrap().inventory();
    assert!(
        (found.pushes[1].area - 12.0).abs() < 1e-9,
        "{:?}",
        found.pushes
    );
}

#[test]
fn an_end_inside_a_face_and_an_empty_part_are_told() {
    let found = said("pressure = '2 MPa'\nx = ['1 m', '3.5 m']\n");
    assert!(
        found.contains("3.5 m lies inside a face of z+, from 3 m to 4 m"),
        "{found}"
    );
    assert!(found.contains("part.toml:16"), "{found}");
    let found = said("hold = 'fixed'\ny = ['9 m', '12 m']\n");
    assert!(
        found.contains("no face of z+ lies between 9 m and 12 m along y"),
        "{found}"
    );
    let found = said("hold = 'fixed'\ny = ['3 m', '1 m']\n");
    assert!(found.contains("`y` goes from 3 m to 1 m"), "{found}");
}
