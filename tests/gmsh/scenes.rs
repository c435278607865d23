//! Scenes on grids, written as Gmsh files and read back: the same body up to numbering.

use crate::writer::{Element, FORMS, Msh};
use fracas::contact::JumpStabilization;
use fracas::scene::{Body, Scene, gallery};
use fracas_operators::sparse::SparseMatrix;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A folder of its own for a test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("gmsh")
        .join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Number of the physical surface of a fracture, of a side.
pub(crate) const FRACTURE: i32 = 100;
const SIDE: i32 = 1;

/// All 48 numberings of a hexahedron, half of them left-handed: places in the standard one.
fn numberings() -> Vec<[usize; 8]> {
    const CORNERS: [[i32; 3]; 8] = [
        [-1, -1, -1],
        [1, -1, -1],
        [1, 1, -1],
        [-1, 1, -1],
        [-1, -1, 1],
        [1, -1, 1],
        [1, 1, 1],
        [-1, 1, 1],
    ];
    let axes = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [1, 0, 2],
        [0, 2, 1],
        [2, 1, 0],
    ];
    let mut all = Vec::new();
    for order in axes {
        for signs in 0..8 {
            all.push(CORNERS.map(|c| {
                let image = [0, 1, 2].map(|d: usize| match signs >> d & 1 {
                    1 => -c[order[d]],
                    _ => c[order[d]],
                });
                CORNERS.iter().position(|other| *other == image).unwrap()
            }));
        }
    }
    all
}

/// A permutation of 0..n that is far from the identity.
fn shuffled(n: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|i| (i + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15_usize));
    order
}

/// The mesh of a body on a grid as a file in disorder: node numbers with gaps, elements shuffled and numbered in all 48
/// ways, quadrilaterals turned, nodes without elements.
pub(crate) fn as_msh(body: &Body) -> Msh {
    let grid = body.mesh.grid.as_ref().unwrap();
    let tag = |node: u32| 3 * u64::from(body.mesh.origin[node as usize]) + 5;
    let mut msh = Msh::default();
    for node in shuffled(grid.node_count()) {
        msh.nodes.push((tag(node as u32), body.mesh.nodes[node]));
    }
    msh.nodes.push((4, [1e3, 2e3, 3e3]));
    for (r, name) in body.material_names.iter().enumerate() {
        msh.names.push((3, r as i32 + 1, name.clone()));
    }
    let sides = ["x-", "x+", "y-", "y+", "z-", "z+"];
    for (s, name) in (SIDE..).zip(sides) {
        msh.names.push((2, s, name.into()));
    }
    for (f, name) in (FRACTURE..).zip(&body.fractures.names) {
        msh.names.push((2, f, name.clone()));
    }
    let mut quads: Vec<(i32, [u64; 4])> = Vec::new();
    for face in &body.fractures.faces {
        quads.push((
            FRACTURE + i32::from(face.fracture),
            face.minus.nodes.map(tag),
        ));
    }
    for (e, nodes) in body.mesh.elements.iter().enumerate() {
        let n = grid.cells;
        let at = [e % n[0], e / n[0] % n[1], e / (n[0] * n[1])];
        for (side, face) in (SIDE..).zip(fracas::mesh::FACES) {
            let (axis, layer) = ((side - SIDE) as usize / 2, (side - SIDE) % 2);
            if at[axis] == layer as usize * (n[axis] - 1) {
                quads.push((side, face.map(|a| tag(nodes[a]))));
                if n[axis] == 1 && layer == 0 {
                    continue;
                }
            }
        }
    }
    let mut id = 10;
    let mut add = |kind, dimension, groups: Vec<i32>, nodes: Vec<u64>| {
        id += 1;
        msh.elements.push(Element {
            id,
            kind,
            dimension,
            groups,
            nodes,
        });
    };
    add(15, 0, Vec::new(), vec![5]);
    for i in shuffled(quads.len()) {
        let (group, quad) = quads[i];
        let turned = [0, 1, 2, 3].map(|a: usize| match i % 8 < 4 {
            true => quad[(a + i) % 4],
            false => quad[(8 - a - i % 4) % 4],
        });
        add(3, 2, vec![group], turned.into());
    }
    let ways = numberings();
    for e in shuffled(body.mesh.elements.len()) {
        let nodes = ways[e % 48].map(|a| tag(body.mesh.elements[e][a]));
        add(
            5,
            3,
            vec![i32::from(body.mesh.regions[e]) + 1],
            nodes.into(),
        );
    }
    msh
}

/// Whether the normal of a fracture disobeys the rule for surfaces in files.
fn is_flipped(body: &Body, fracture: usize) -> bool {
    let mut n = [0.0f64; 3];
    for face in body
        .fractures
        .faces
        .iter()
        .filter(|f| usize::from(f.fracture) == fracture)
    {
        (0..3).for_each(|d| n[d] += face.area * face.frame[0][d]);
    }
    let largest = n.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    *n.iter().find(|c| c.abs() >= 0.5 * largest).unwrap() < 0.0
}

/// The scene with its mesh in `file`.
pub(crate) fn as_file_scene(scene: &Scene, body: &Body, file: &str) -> String {
    let mut table: Table = toml::from_str(&scene.to_toml().unwrap()).unwrap();
    let text = |s: &str| Value::String(s.into());
    table.insert(
        "mesh".into(),
        Value::Table(Table::from_iter([("file".into(), text(file))])),
    );
    for material in table["material"].as_array_mut().unwrap() {
        let material = material.as_table_mut().unwrap();
        material.remove("boxes");
        material.remove("layers");
        material.insert("volume".into(), material["name"].clone());
    }
    let mut fractures = Vec::new();
    let sections = table.remove("fracture");
    for (f, name) in body.fractures.names.iter().enumerate() {
        let mut section = sections
            .iter()
            .flat_map(|s| s.as_array().unwrap())
            .find(|s| name.starts_with(s["name"].as_str().unwrap()))
            .and_then(|s| s.as_table().cloned())
            .unwrap();
        for key in ["plane", "at", "every", "x", "y", "z"] {
            section.remove(key);
        }
        section.insert("name".into(), text(name));
        // by number and by name
        section.insert(
            "surface".into(),
            match f % 2 {
                0 => text(name),
                _ => Value::Integer((FRACTURE + f as i32).into()),
            },
        );
        section.insert("flip".into(), Value::Boolean(is_flipped(body, f)));
        fractures.push(Value::Table(section));
    }
    table.insert("fracture".into(), Value::Array(fractures));
    if let Some(boundaries) = table.get_mut("boundary") {
        for boundary in boundaries.as_array_mut().unwrap() {
            let boundary = boundary.as_table_mut().unwrap();
            let side = boundary.remove("side").unwrap();
            boundary.insert("surface".into(), side);
        }
    }
    toml::to_string(&table).unwrap()
}

/// A place to a micrometre: text files have 16 digits.
fn rounded(x: [f64; 3]) -> [i64; 3] {
    x.map(|x| (1e6 * x).round() as i64)
}

/// Where the degrees of freedom of `b` are in `a`: nodes by their places and the elements that see them.
fn node_map(a: &Body, b: &Body) -> Vec<usize> {
    let place = |body: &Body, n: u32| rounded(body.mesh.nodes[n as usize]);
    let key = |body: &Body, e: usize| {
        let mut key = body.mesh.elements[e].map(|n| place(body, n));
        key.sort_unstable();
        key
    };
    let elements: HashMap<_, usize> = (0..a.mesh.elements.len()).map(|e| (key(a, e), e)).collect();
    let mut map = vec![usize::MAX; b.mesh.nodes.len()];
    for e in 0..b.mesh.elements.len() {
        let twin = elements[&key(b, e)];
        assert_eq!(a.mesh.regions[twin], b.mesh.regions[e]);
        for n in b.mesh.elements[e] {
            let mut corners = a.mesh.elements[twin].iter();
            let found = *corners.find(|m| place(a, **m) == place(b, n)).unwrap() as usize;
            assert!(
                [usize::MAX, found].contains(&map[n as usize]),
                "copies differ"
            );
            map[n as usize] = found;
        }
    }
    let mut seen = map.clone();
    seen.sort_unstable();
    assert!(seen.into_iter().eq(0..a.mesh.nodes.len()), "not one to one");
    map
}

fn face_map(a: &Body, b: &Body) -> Vec<usize> {
    let key = |body: &Body, f: &fracas::mesh::FractureFace| {
        let mut nodes = f.minus.nodes.map(|n| rounded(body.mesh.nodes[n as usize]));
        nodes.sort_unstable();
        (f.fracture, nodes)
    };
    let faces: HashMap<_, usize> = a
        .fractures
        .faces
        .iter()
        .enumerate()
        .map(|(i, f)| (key(a, f), i))
        .collect();
    b.fractures
        .faces
        .iter()
        .map(|f| faces[&key(b, f)])
        .collect()
}

/// `b` with its rows and columns where `a` has them.
fn difference(
    a: &SparseMatrix<f64>,
    b: &SparseMatrix<f64>,
    row: &dyn Fn(usize) -> usize,
    column: &dyn Fn(usize) -> usize,
) -> f64 {
    assert_eq!((a.rows(), a.cols()), (b.rows(), b.cols()));
    let mut entries: HashMap<(usize, usize), f64> = HashMap::new();
    for (value, (i, j)) in a.iter().map(|(v, (i, j))| (v, (i as usize, j as usize))) {
        *entries.entry((i, j)).or_default() += value;
    }
    let largest = entries.values().fold(0.0f64, |m, v| m.max(v.abs()));
    for (value, (i, j)) in b.iter().map(|(v, (i, j))| (v, (i as usize, j as usize))) {
        *entries.entry((row(i), column(j))).or_default() -= value;
    }
    entries.values().fold(0.0f64, |m, v| m.max(v.abs())) / largest.max(f64::MIN_POSITIVE)
}

#[track_caller]
pub(crate) fn assert_same(a: &Body, b: &Body) {
    let (nodes, faces) = (node_map(a, b), face_map(a, b));
    assert_eq!(a.fractures.names, b.fractures.names);
    assert_eq!(a.fractures.edges.len(), b.fractures.edges.len());
    for (face, twin) in b.fractures.faces.iter().zip(&faces) {
        let twin = &a.fractures.faces[*twin];
        for (n, m) in face.frame.iter().flatten().zip(twin.frame.iter().flatten()) {
            assert!((n - m).abs() < 1e-12, "{:?} {:?}", face.frame, twin.frame);
        }
    }
    let full = |dof: usize| 3 * nodes[dof / 3] + dof % 3;
    assert_eq!(a.constraints.free_len(), b.constraints.free_len());
    let u = |i: usize| {
        let dof = b.constraints.free()[i] as usize;
        a.constraints.free_index(full(dof)).unwrap()
    };
    let t = |i: usize| 3 * faces[i / 3] + i % 3;
    let h = Some(JumpStabilization::default());
    let [x, y] = [a, b].map(|body| body.saddle_blocks(h).unwrap());
    assert!(difference(&x.a, &y.a, &u, &u) < 1e-13);
    assert!(difference(&x.b1, &y.b1, &u, &t) < 1e-13);
    match (&x.h, &y.h) {
        (Some(x), Some(y)) => assert!(difference(x, y, &t, &t) < 1e-12),
        (x, y) => assert_eq!(x.is_none(), y.is_none()),
    }
    let scale = x
        .rhs_u
        .iter()
        .fold(f64::MIN_POSITIVE, |m: f64, v| m.max(v.abs()));
    for (i, v) in y.rhs_u.iter().enumerate() {
        assert!((v - x.rhs_u[u(i)]).abs() < 1e-11 * scale, "{i}");
    }
    for (i, v) in y.rhs_t.iter().enumerate() {
        assert!((v - x.rhs_t[t(i)]).abs() < 1e-15, "{i}");
    }
}

#[test]
fn every_scene_of_the_gallery_is_the_same_from_a_file_in_each_of_the_four_forms() {
    let folder = folder("gallery");
    for (i, entry) in gallery().iter().enumerate() {
        let scene = entry.small_scene().unwrap();
        let body = scene.build().unwrap();
        let msh = as_msh(&body);
        // every form sees crossings, maps and materials: all four of three scenes, one of the others
        let forms = FORMS.iter().enumerate();
        let all = ["crossing", "tee", "layered_crossing"].contains(&entry.name);
        for (f, form) in forms.filter(|(f, _)| all || i % 4 == *f) {
            let file = format!("{}_{f}.msh", entry.name);
            std::fs::write(folder.join(&file), msh.write(*form)).unwrap();
            let text = as_file_scene(&scene, &body, &file);
            let path = folder.join(format!("{}_{f}.toml", entry.name));
            std::fs::write(&path, text).unwrap();
            let read = Scene::load(&path).unwrap();
            assert_eq!(read.sections(), Scene::load(&path).unwrap().sections());
            let found = read
                .build()
                .unwrap_or_else(|e| panic!("{}: {e}", entry.name));
            assert!(found.mesh.grid.is_none());
            assert_same(&body, &found);
        }
    }
}

#[test]
fn bent_fractures_in_distorted_rock_are_the_same_from_a_file() {
    let folder = folder("distorted");
    let entry = fracas::scene::named("layered_crossing").unwrap();
    let bent = [
        "mesh.map.distort.amplitude=0.15",
        "mesh.map.distort.bend_fractures=true",
        "mesh.map.distort.seed=3",
        "mesh.map.rotate.axis=y",
        "mesh.map.rotate.angle=90 deg",
    ];
    let scene = entry.small_scene().unwrap().with_overrides(&bent).unwrap();
    let body = scene.build().unwrap();
    std::fs::write(folder.join("m.msh"), as_msh(&body).write(FORMS[3])).unwrap();
    let text = as_file_scene(&scene, &body, "m.msh");
    let name = folder.join("s.toml").display().to_string();
    assert_same(
        &body,
        &Scene::from_toml(&text, &name).unwrap().build().unwrap(),
    );
}

#[test]
fn groups_of_one_name_are_one_group() {
    let folder = folder("twice");
    let scene = fracas::scene::named("layered_crossing").unwrap();
    let scene = scene.small_scene().unwrap();
    let body = scene.build().unwrap();
    for (f, form) in FORMS.iter().enumerate() {
        let mut msh = as_msh(&body);
        // every second element of a group is in another one of its name, which may come first
        let again = |number: i32| number + 1000;
        let mut names = msh.names.clone();
        names.iter_mut().for_each(|name| name.1 = again(name.1));
        msh.names = match f % 2 {
            0 => [msh.names, names].concat(),
            _ => [names, msh.names].concat(),
        };
        for element in msh.elements.iter_mut().step_by(2) {
            // every second fracture is called by its number, which is that of one group
            let by_name = |g: &i32| *g < FRACTURE || (*g - FRACTURE) % 2 == 0;
            let groups = element.groups.iter_mut().filter(|g| by_name(g));
            groups.for_each(|g| *g = again(*g));
        }
        let file = format!("{f}.msh");
        std::fs::write(folder.join(&file), msh.write(*form)).unwrap();
        let text = as_file_scene(&scene, &body, &file);
        let name = folder.join("s.toml").display().to_string();
        assert_same(
            &body,
            &Scene::from_toml(&text, &name).unwrap().build().unwrap(),
        );
    }
}

#[test]
fn a_roller_on_a_list_of_sides_holds_each_along_its_own_axis() {
    let folder = folder("rollers");
    let scene = fracas::scene::named("patch").unwrap();
    let scene = scene.small_scene().unwrap();
    let body = scene.build().unwrap();
    std::fs::write(folder.join("m.msh"), as_msh(&body).write(FORMS[2])).unwrap();
    let text = as_file_scene(&scene, &body, "m.msh");
    let mut table: Table = toml::from_str(&text).unwrap();
    let name = folder.join("s.toml").display().to_string();
    let built = |table: &Table, boundaries: &str| {
        let own: Table = toml::from_str(boundaries).unwrap();
        let mut table = table.clone();
        table.insert("boundary".into(), own["boundary"].clone());
        let text = toml::to_string(&table).unwrap();
        Scene::from_toml(&text, &name).unwrap().build()
    };
    table.remove("boundary");
    let one = "[[boundary]]\nsurface = ['x-', 'y-', 'z-']\nhold = 'roller'\n";
    let each: String = (["x-", "y-", "z-"].iter())
        .map(|side| format!("[[boundary]]\nsurface = '{side}'\nhold = 'roller'\n"))
        .collect();
    let [one, each] = [one, &each].map(|text| built(&table, text).unwrap());
    assert_eq!(one.constraints.free(), each.constraints.free());
    assert!(one.constraints.free_len() < one.constraints.full_len());
}
