//! What is wrong with a file or with a scene that names it.

use crate::scenes::folder;
use crate::writer::{Element, FORMS, Msh};
use fracas::mesh::{GmshFile, GmshMesh};
use fracas::scene::Scene;
use proptest::prelude::*;
use std::path::PathBuf;

const SCENE: &str = r#"title = "Two cubes"

[mesh]
file = "m.msh"

[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25

[[fracture]]
name = "F"
surface = "fault"

[[boundary]]
surface = "left"
hold = "fixed"

[[boundary]]
surface = "right"
hold = "fixed"
"#;

/// Two unit cubes side by side along x, numbered like a grid; the face between them is the fault.
fn cubes() -> Msh {
    let mut msh = Msh::default();
    for z in 0..2u32 {
        for y in 0..2u32 {
            for x in 0..3u32 {
                msh.nodes
                    .push((msh.nodes.len() as u64 + 1, [x, y, z].map(f64::from)));
            }
        }
    }
    for (dimension, number, name) in [
        (3, 1, "rock"),
        (2, 1, "left"),
        (2, 2, "fault"),
        (2, 3, "right"),
    ] {
        msh.names.push((dimension, number, name.into()));
    }
    for x in 0..3 {
        add(&mut msh, 3, x + 1, [1, 4, 10, 7].map(|n| n + x as u64));
    }
    for x in 0..2 {
        add(&mut msh, 5, 1, [1, 2, 5, 4, 7, 8, 11, 10].map(|n| n + x));
    }
    msh
}

fn add<const N: usize>(msh: &mut Msh, kind: i32, group: i32, nodes: [u64; N]) {
    let id = 40 + msh.elements.len() as u64;
    let dimension = if N == 8 || kind == 4 { 3 } else { 2 };
    msh.elements.push(Element {
        id,
        kind,
        dimension,
        groups: vec![group],
        nodes: nodes.into(),
    });
}

fn build(name: &str, bytes: &[u8], scene: &str) -> Result<(), String> {
    let here: PathBuf = folder(name);
    std::fs::write(here.join("m.msh"), bytes).unwrap();
    let path = here.join("s.toml");
    std::fs::write(&path, scene).unwrap();
    let built = Scene::load(&path).and_then(|s| s.build());
    let here = format!("{}/", here.display());
    built
        .map(|_| ())
        .map_err(|e| e.to_string().replace(&here, ""))
}

/// The message for the cubes after a change of the mesh, the same in all four forms but for places in the file.
#[track_caller]
fn refused(name: &str, change: impl Fn(&mut Msh), expected: &str) {
    for (f, form) in FORMS.into_iter().enumerate() {
        let mut msh = cubes();
        change(&mut msh);
        let text = build(&format!("{name}{f}"), &msh.write(form), SCENE).unwrap_err();
        assert!(text.contains(expected), "{name} {form:?}: {text}");
        assert!(text.starts_with("s.toml:"), "{text}");
    }
}

/// The message after a change of the scene.
#[track_caller]
fn refused_scene(name: &str, from: &str, to: &str, expected: &str) {
    assert!(SCENE.contains(from), "{from}");
    let text = build(name, &cubes().write(FORMS[2]), &SCENE.replacen(from, to, 1)).unwrap_err();
    assert!(text.starts_with(expected), "{text}");
}

/// The message after a change of a text file.
#[track_caller]
fn refused_text(name: &str, from: &str, to: &str, expected: &str) {
    for form in [FORMS[0], FORMS[2]] {
        let text = String::from_utf8(cubes().write(form)).unwrap();
        if !text.contains(from) {
            continue;
        }
        let text = text.replacen(from, to, 1);
        let found = build(name, text.as_bytes(), SCENE).unwrap_err();
        assert!(found.contains(expected), "{found}");
        return;
    }
    panic!("no file has {from}");
}

#[test]
fn the_cubes_themselves_are_fine_in_all_four_forms() {
    for (f, form) in FORMS.into_iter().enumerate() {
        build(&format!("fine{f}"), &cubes().write(form), SCENE).unwrap();
    }
    // line ends of another system, sections that nobody asked for
    for form in [FORMS[0], FORMS[2]] {
        let text = String::from_utf8(cubes().write(form)).unwrap();
        let text = text.replace("$Nodes", "$Comments\nno $End\n$EndComments\n$Nodes");
        build("lines", text.replace('\n', "\r\n").as_bytes(), SCENE).unwrap();
    }
}

#[test]
fn bodies_that_are_none_are_refused() {
    let no_body = |m: &mut Msh| m.elements.retain(|e| e.kind == 3);
    refused(
        "none",
        no_body,
        "s.toml:4:8: m.msh: has no hexahedron (type 5), but 3 surface elements; mesh in three dimensions",
    );
    let tetrahedra = |m: &mut Msh| {
        add(m, 4, 1, [1, 2, 4, 7]);
        add(m, 4, 1, [2, 3, 5, 8]);
    };
    refused(
        "tets",
        tetrahedra,
        "m.msh: has 2 tetrahedra, the first of them element 45 at (0.250000, 0.250000, 0.250000) m; the body must be of eight-node hexahedra alone",
    );
    let inverted = |m: &mut Msh| m.elements[4].nodes.swap(0, 1);
    refused(
        "inverted",
        inverted,
        "m.msh: hexahedron 44 at (1.500000, 0.500000, 0.500000) m is inverted or flat: min det J = ",
    );
    let flat = |m: &mut Msh| m.elements[4].nodes[2] = 5;
    refused("flat", flat, "hexahedron 44 at ");
    let twice = |m: &mut Msh| {
        let mut copy = m.elements[4].clone();
        copy.id = 77;
        m.elements.push(copy);
    };
    refused(
        "twice",
        twice,
        "m.msh: hexahedra 44 and 77 at (1.500000, 0.500000, 0.500000) m have the same nodes",
    );
    let overlap = |m: &mut Msh| {
        m.nodes.extend([
            (13, [1.5, 0.0, 0.0]),
            (14, [1.5, 1.0, 0.0]),
            (15, [1.5, 0.0, 1.0]),
            (16, [1.5, 1.0, 1.0]),
        ]);
        add(m, 5, 1, [2, 13, 14, 5, 8, 15, 16, 11]);
    };
    refused(
        "overlap",
        overlap,
        "overlap: both lie on one side of the face at (1.000000, 0.500000, 0.500000) m",
    );
}

/// The right cube with nodes of its own, moved by `shift`.
fn apart(m: &mut Msh, shift: [f64; 3]) {
    for node in [2, 5, 8, 11] {
        let (_, x) = m.nodes[node as usize - 1];
        m.nodes
            .push((node + 100, [0, 1, 2].map(|d: usize| x[d] + shift[d])));
        let (_, x) = m.nodes[node as usize];
        m.nodes[node as usize].1 = [x[0], x[1] + shift[1], x[2] + shift[2]];
        for n in m.elements[4].nodes.iter_mut().filter(|n| **n == node) {
            *n += 100;
        }
    }
}

#[test]
fn meshes_that_are_torn_or_have_hanging_nodes_are_refused() {
    refused(
        "torn",
        |m| apart(m, [0.0; 3]),
        "m.msh: nodes 2 and 102 both lie at (1.000000, 0.000000, 0.000000) m, so the mesh is torn there",
    );
    refused(
        "nearly",
        |m| apart(m, [5e-7, 0.0, 0.0]),
        "nodes 2 and 102 both lie at",
    );
    refused(
        "shifted",
        |m| apart(m, [0.0, 0.6, 0.0]),
        "touch at (1.000000, 0.950000, 0.050000) m without sharing a face: the mesh has hanging nodes there",
    );
    // a real gap makes two bodies, and the fault a side of one
    refused(
        "gap",
        |m| apart(m, [0.01, 0.0, 0.0]),
        "lies on the boundary of the body",
    );
    // the right cube cut into two, so that the face between them has two neighbours on one side
    let halved = |m: &mut Msh| {
        m.nodes.extend([
            (13, [1.0, 0.5, 0.0]),
            (14, [2.0, 0.5, 0.0]),
            (15, [1.0, 0.5, 1.0]),
            (16, [2.0, 0.5, 1.0]),
        ]);
        m.elements.pop();
        add(m, 5, 1, [2, 3, 14, 13, 8, 9, 16, 15]);
        add(m, 5, 1, [13, 14, 6, 5, 15, 16, 12, 11]);
    };
    refused(
        "hanging",
        halved,
        "m.msh: hexahedra 43 and 44 touch at (1.000000, 0.050000, 0.050000) m without sharing a face",
    );
}

#[test]
fn surfaces_that_are_no_fractures_or_boundaries_are_refused() {
    let diagonal = |m: &mut Msh| m.elements[1].nodes = vec![1, 5, 11, 7];
    refused(
        "diagonal",
        diagonal,
        "s.toml:13:11: m.msh: physical surface \"fault\" touches nothing: none of its 1 quadrilaterals is a face of a hexahedron; the first, element 41, lies at (0.500000, 0.500000, 0.500000) m",
    );
    let both = |m: &mut Msh| add(m, 3, 2, [1, 5, 11, 7]);
    refused(
        "partly",
        both,
        "m.msh: quadrilateral 45 of physical surface \"fault\" at (0.500000, 0.500000, 0.500000) m is no face of a hexahedron; embed",
    );
    let far = |m: &mut Msh| {
        m.nodes
            .extend((0..4).map(|i| (50 + i, [9.0 + (i % 2) as f64, 9.0 + (i / 2) as f64, 9.0])));
        m.elements[1].nodes = vec![50, 51, 53, 52];
    };
    refused(
        "far",
        far,
        "touches nothing: none of its 1 quadrilaterals is a face of a hexahedron; the first, element 41, lies at (9.500000, 9.500000, 9.000000) m",
    );
    let triangle = |m: &mut Msh| add(m, 2, 2, [2, 5, 8]);
    refused(
        "triangle",
        triangle,
        "physical surface \"fault\" has 1 triangles, the first of them element 45 at (1.000000, 0.333333, 0.333333) m; faces of hexahedra are four-node",
    );
    let empty = |m: &mut Msh| drop(m.elements.remove(1));
    refused(
        "empty",
        empty,
        "s.toml:13:11: m.msh: physical surface \"fault\" has no quadrilateral; mesh its entities",
    );
    // a surface that is in the file twice counts once
    let mut msh = cubes();
    for _ in 0..2 {
        let mut copy = msh.elements[0].clone();
        copy.id = 90;
        msh.elements.push(copy);
        let mut copy = msh.elements[1].clone();
        copy.id = 91;
        copy.nodes.reverse();
        msh.elements.push(copy);
    }
    for form in FORMS {
        build("repeated", &msh.write(form), SCENE).unwrap();
    }
}

#[test]
fn scenes_that_do_not_fit_their_file_are_refused_with_their_line() {
    for (name, from, to, expected) in [
        (
            "outside",
            "surface = \"fault\"",
            "surface = \"right\"",
            "s.toml:13:11: m.msh: quadrilateral 42 of physical surface \"right\" at (2.000000, 0.500000, 0.500000) m lies on the boundary of the body",
        ),
        (
            "inside",
            "surface = \"left\"",
            "surface = \"fault\"",
            "s.toml:16:11: m.msh: quadrilateral 41 of physical surface \"fault\" at (1.000000, 0.500000, 0.500000) m lies inside the body, between hexahedra 43 and 44",
        ),
        (
            "typo",
            "surface = \"fault\"",
            "surface = \"falt\"",
            "s.toml:13:11: m.msh: has no physical surface \"falt\", did you mean \"fault\"?; there are: \"left\", \"fault\", \"right\"\n",
        ),
        (
            "number",
            "surface = \"fault\"",
            "surface = 9",
            "s.toml:13:11: m.msh: has no physical surface 9; there are: \"left\", \"fault\", \"right\"\n",
        ),
        (
            "volume",
            "surface = \"fault\"",
            "surface = \"rock\"",
            "s.toml:13:11: m.msh: \"rock\" is a physical volume, but a physical surface is needed here\n",
        ),
        (
            "surface",
            "name = \"rock\"",
            "name = \"rock\"\nvolume = \"fault\"",
            "s.toml:8:10: m.msh: \"fault\" is a physical surface, but a physical volume is needed here\n",
        ),
        (
            "two",
            "[[boundary]]",
            "[[fracture]]\nname = \"G\"\nsurface = [\"fault\"]\n\n[[boundary]]",
            "s.toml:17:11: fractures \"F\" and \"G\" share the face at (1.000000, 0.500000, 0.500000) m",
        ),
        (
            "gone",
            "m.msh",
            "n.msh",
            "s.toml:4:8: n.msh: cannot be read: entity not found\n",
        ),
        ("folder", "m.msh", ".", "s.toml:4:8: .: cannot be read: "),
        (
            "x",
            "file = \"m.msh\"",
            "file = \"m.msh\"\nx = { from = \"0 m\", to = \"1 m\", cells = 2 }",
            "s.toml:5:1: [mesh] has `x`, which belongs to a grid; leave it out",
        ),
        (
            "map",
            "[[material]]",
            "[mesh.map.rotate]\naxis = \"z\"\nangle = \"9 deg\"\n[[material]]",
            "s.toml:6:7: [mesh] has `map`, which belongs to a grid",
        ),
        (
            "plane",
            "surface = \"fault\"",
            "plane = \"x\"\nat = \"1 m\"",
            "s.toml:13:9: fracture \"F\" has `plane`, which belongs to a grid; use `surface`",
        ),
        (
            "side",
            "surface = \"left\"",
            "side = \"x-\"",
            "s.toml:16:8: [[boundary]] of side x- has `side`, which belongs to a grid; use `surface`",
        ),
        (
            "nothing",
            "surface = \"fault\"\n",
            "",
            "s.toml:11:1: fracture \"F\" needs `surface`\n",
        ),
        (
            "nowhere",
            "surface = \"left\"\n",
            "",
            "s.toml:15:1: [[boundary]] needs `surface`\n",
        ),
        (
            "unit",
            "file = \"m.msh\"",
            "file = \"m.msh\"\nunit = \"-1 m\"",
            "s.toml:5:8: the unit of a mesh is \"-1 m\", but it must be positive\n",
        ),
        (
            "list",
            "surface = \"fault\"",
            "surface = []",
            "s.toml:13:11: invalid length 0, expected the name or the number of a physical group, or a list of them\n",
        ),
        (
            "real",
            "surface = \"fault\"",
            "surface = 1.5",
            "s.toml:13:11: invalid type: floating point `1.5`, expected the name or the number",
        ),
        (
            "boxes",
            "name = \"rock\"",
            "name = \"rock\"\nboxes = [{ x = [\"0 m\", \"1 m\"] }]",
            "s.toml:6:1: m.msh: hexahedron 44 at (1.500000, 0.500000, 0.500000) m, in the physical volumes: \"rock\", has no material",
        ),
        (
            "unused",
            "[[fracture]]",
            "[[material]]\nname = \"B\"\nyoung = \"1 Pa\"\npoisson = 0\nlayers = [[\"5 m\", \"6 m\"]]\n[[fracture]]",
            "s.toml:11:1: material \"B\" selects no element",
        ),
        (
            "roller",
            "hold = \"fixed\"",
            "hold = \"roller\"\npressure = \"1 Pa\"",
            "s.toml:15:1: [[boundary]] of surface \"left\" needs exactly one of",
        ),
        (
            "held",
            "hold = \"fixed\"",
            "hold = \"roller\"",
            "body 0 (1 elements around",
        ),
    ] {
        refused_scene(&format!("scene_{name}"), from, to, expected);
    }
    let unnamed = |m: &mut Msh| m.names.push((3, 8, "empty".into()));
    let mut msh = cubes();
    unnamed(&mut msh);
    let scene = SCENE.replace(
        "name = \"rock\"",
        "name = \"rock\"\nvolume = [\"rock\", \"empty\"]",
    );
    let text = build("volume_empty", &msh.write(FORMS[1]), &scene).unwrap_err();
    assert!(
        text.starts_with("s.toml:8:10: m.msh: physical volume \"empty\" has no hexahedron"),
        "{text}"
    );
    // a grid has no surfaces
    let grid = "x = { from = \"0 m\", to = \"2 m\", cells = 2 }\ny = { from = \"0 m\", to = \"1 m\", cells = 1 }\nz = { from = \"0 m\", to = \"1 m\", cells = 1 }";
    let scene = SCENE.replace("file = \"m.msh\"", grid);
    let text = build("grid", &[], &scene).unwrap_err();
    assert!(text.starts_with("s.toml:15:11: fracture \"F\" has `surface`, which belongs to a mesh from a `file`; use `plane` and `at`"), "{text}");
    let scene = scene
        .replace("surface = \"fault\"", "at = \"1 m\"")
        .replace("surface", "side")
        .replace("left", "x-")
        .replace("right", "x+");
    let text = build("grid", &[], &scene).unwrap_err();
    assert!(
        text.starts_with("s.toml:13:1: fracture \"F\" needs `plane`"),
        "{text}"
    );
    let scene = scene
        .replace("at = \"1 m\"", "at = \"1 m\"\nplane = \"x\"")
        .replace("side = \"x-\"\n", "");
    let text = build("grid", &[], &scene).unwrap_err();
    assert!(
        text.starts_with("s.toml:18:1: [[boundary]] needs `side`"),
        "{text}"
    );
}

#[test]
fn files_that_cannot_be_read_are_refused_with_their_line() {
    for (name, from, to, expected) in [
        (
            "nan",
            "1.0 0.0 1.0",
            "1.0 nan 1.0",
            "m.msh: line 20: a coordinate of node 8 is NaN",
        ),
        (
            "infinite",
            "1.0 0.0 1.0",
            "1.0 0.0 inf",
            "m.msh: line 20: a coordinate of node 8 is inf",
        ),
        (
            "word",
            "1.0 0.0 1.0",
            "1.0 zero 1.0",
            "m.msh: line 20: expected a coordinate, found `zero`",
        ),
        (
            "short",
            "1.0 0.0 1.0 ",
            "1.0 0.0 ",
            "m.msh: line 21: expected the number of a node, found `2.0`",
        ),
        (
            "version",
            "2.2 0 8",
            "4 0 8",
            "m.msh: format 4 is not read; save the mesh in format 4.1 or 2.2",
        ),
        (
            "type",
            "2.2 0 8",
            "2.2 7 8",
            "m.msh: file type 7 is neither 0 (ASCII) nor 1 (binary)",
        ),
        ("size", "2.2 0 8", "2.2 0 4", "m.msh: data size 4 is not 8"),
        (
            "other",
            "$MeshFormat",
            "solid",
            "m.msh: does not start with $MeshFormat",
        ),
        (
            "partitioned",
            "$Nodes",
            "$PartitionedEntities\n$Nodes",
            "m.msh: is partitioned",
        ),
        (
            "parametric",
            "$Nodes",
            "$ParametricNodes\n$Nodes",
            "m.msh: has $ParametricNodes",
        ),
        (
            "unknown",
            "43 5 2 1 1 1 2",
            "43 5 2 1 1 1 99",
            "m.msh: line 31: element 43 has node 99, which $Nodes does not list",
        ),
        (
            "negative",
            "43 5 2 1 1 1 2",
            "43 5 2 1 1 1 -2",
            "m.msh: line 31: expected a node of an element, found `-2`",
        ),
        (
            "kind",
            "43 5 2",
            "43 55 2",
            "m.msh: line 31: element type 55 is not known",
        ),
        (
            "repeated",
            "3 2.0 0.0 0.0",
            "2 2.0 0.0 0.0",
            "m.msh: node 2 is listed twice",
        ),
        (
            "name",
            "\"fault\"",
            "fault",
            "m.msh: line 8: expected a name between double quotes, found `fault`",
        ),
        (
            "dimension",
            "2 2 \"fault\"",
            "5 2 \"fault\"",
            "m.msh: line 8: expected a dimension from 0 to 3, found `5`",
        ),
        (
            "many",
            "$Nodes\n12",
            "$Nodes\n18446744073709551615",
            "m.msh: line 25: expected the number of a node, found `$EndNodes`",
        ),
        (
            "few",
            "$Nodes\n12",
            "$Nodes\n11",
            "m.msh: line 24: expected the end of the section, found `12`",
        ),
        (
            "second",
            "$Elements",
            "$Nodes\n0\n$EndNodes\n$Elements",
            "m.msh: has two $Nodes sections",
        ),
        (
            "blocks",
            "2 12 1 12 ",
            "2 13 1 12 ",
            "announces 13 nodes in all blocks and lists 12",
        ),
    ] {
        refused_text(&format!("text_{name}"), from, to, expected);
    }
    let big = |first: [u8; 4]| {
        let mut bytes = b"$MeshFormat\n4.1 1 8\n".to_vec();
        bytes.extend(first);
        bytes.extend(b"\n$EndMeshFormat\n");
        build("order", &bytes, SCENE).unwrap_err()
    };
    assert!(
        big([0, 0, 0, 1])
            .contains("m.msh: its binary numbers are big-endian; save the mesh as ASCII")
    );
    assert!(big([1, 0, 13, 10]).contains("is [1, 0, 13, 10] in bytes; the file is damaged"));
    assert!(big([1, 0, 0, 0]).contains("m.msh: has no $Nodes section"));
}

#[test]
fn a_file_that_stops_anywhere_is_refused() {
    for form in FORMS {
        let bytes = cubes().write(form);
        let whole = bytes.len();
        for length in 0..whole {
            let read = GmshFile::parse(&bytes[..length], "m.msh");
            // the last line break may be missing
            assert_eq!(read.is_ok(), length == whole - 1, "{form:?} {length}");
        }
    }
    let bytes = cubes().write(FORMS[0]);
    let cut = |length: usize| {
        GmshFile::parse(&bytes[..length], "m.msh")
            .unwrap_err()
            .to_string()
    };
    let text = String::from_utf8(bytes.clone()).unwrap();
    let elements = text.find("$Elements").unwrap();
    assert_eq!(
        cut(elements),
        "m.msh: has no $Elements section before it is needed; save the mesh again"
    );
    assert_eq!(
        cut(elements + 14),
        "m.msh: line 28 is its end, where an element type was expected: the file is truncated"
    );
}

proptest! {
    #[test]
    fn no_damage_panics(form in 0..4usize, at in 0.0..1.0f64, junk in prop::collection::vec(any::<u8>(), 1..5), drop in 0..5usize) {
        let mut bytes = cubes().write(FORMS[form]);
        let at = (at * bytes.len() as f64) as usize;
        let end = (at + drop).min(bytes.len());
        bytes.splice(at..end, junk);
        let read = GmshFile::parse(&bytes, "m.msh").and_then(|file| GmshMesh::new(file, 1.0));
        if let Err(error) = read {
            prop_assert!(error.to_string().starts_with("m.msh: "));
        }
    }
}
