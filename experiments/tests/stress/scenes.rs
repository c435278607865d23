//! Mutated scenes: what is taken is what the text says.

use crate::mutation::mutate;
use crate::room::{Verdict, count, trial};
use fracas::scene::{Scene, gallery};
use fracas::units::Quantity;
use fracas_operators::random::Random;
use toml::{Table, Value};

/// Nodes up to which a scene that is taken is also meshed.
const MESHED: u128 = 400;

/// A scene with most of what a scene can say.
pub(crate) const RICH: &str = include_str!("rich.toml");

#[test]
fn mutated_scenes_are_refused_or_taken_for_what_they_say() {
    let mut bases: Vec<String> = gallery().iter().map(|s| s.toml.to_owned()).collect();
    bases.push(RICH.to_owned());
    trial("scenes", count(0.5, 12_000), |g| {
        // the small rich one half of the time: it is meshed
        let base = match g.once_in(2) {
            true => RICH,
            false => &bases[g.below(bases.len())],
        };
        let (bytes, _) = mutate(base.as_bytes(), g);
        match String::from_utf8(bytes) {
            Ok(text) => judge(&text),
            Err(_) => Verdict::Refused,
        }
    });
}

/// What a scene in a text is taken for.
pub(crate) fn judge(text: &str) -> Verdict {
    let Ok(scene) = Scene::from_toml(text, "mutated.toml") else {
        return Verdict::Refused;
    };
    match lie(text, &scene) {
        Some(what) => Verdict::Finding(format!("{what}\n{text}")),
        None => {
            if scene.nodes() <= MESHED {
                let _ = scene.build().map(|body| body.audit().to_string());
            }
            Verdict::Taken
        }
    }
}

/// A value that became another one, or that nothing looked at.
fn lie(text: &str, scene: &Scene) -> Option<String> {
    let said: Table = match text.parse() {
        Ok(table) => table,
        Err(error) => return Some(format!("taken, but no TOML: {error}")),
    };
    let written = match scene.to_toml() {
        Ok(written) => written,
        Err(error) => return Some(format!("taken, but cannot be written: {error}")),
    };
    match Scene::from_toml(&written, "mutated.toml") {
        // a number that is none equals nothing, but is written as itself
        Ok(again)
            if same_file(again.sections() == scene.sections(), scene)
                || again.to_toml().is_ok_and(|text| text == written) => {}
        Ok(_) => return Some(format!("reads back as another scene:\n{written}")),
        Err(error) => return Some(format!("does not read back: {error}\n{written}")),
    }
    let kept: Table = match written.parse() {
        Ok(table) => table,
        Err(error) => return Some(format!("is written as no TOML: {error}")),
    };
    let mut leaves = Vec::new();
    collect(&Value::Table(said.clone()), &mut Vec::new(), &mut leaves);
    for (path, value) in leaves {
        let ends = path.join(".");
        if ends == "mesh.file" {
            continue;
        }
        match find(&Value::Table(kept.clone()), &path) {
            Some(other) if equal(&value, other) || value.to_string() == other.to_string() => {}
            Some(other) => return Some(format!("{ends} = {value} is taken for {other}")),
            // a default is left out: without it the scene is the same
            None => {
                let mut without = said.clone();
                remove(&mut without, &path);
                let same = toml::to_string(&without)
                    .ok()
                    .and_then(|text| Scene::from_toml(&text, "mutated.toml").ok())
                    .is_some_and(|other| other.sections() == scene.sections());
                if !same {
                    return Some(format!("{ends} = {value} is lost"));
                }
            }
        }
    }
    None
}

/// The path of a mesh file becomes absolute when it is written.
fn same_file(same: bool, scene: &Scene) -> bool {
    same || scene.sections().mesh.file.is_some()
}

fn collect(value: &Value, path: &mut Vec<String>, leaves: &mut Vec<(Vec<String>, Value)>) {
    let mut inner = |key: String, value: &Value, leaves: &mut Vec<(Vec<String>, Value)>| {
        path.push(key);
        collect(value, path, leaves);
        path.pop();
    };
    match value {
        Value::Table(table) => table
            .iter()
            .for_each(|(key, v)| inner(key.clone(), v, leaves)),
        Value::Array(array) => {
            let entries = array.iter().enumerate();
            entries.for_each(|(i, v)| inner(i.to_string(), v, leaves));
        }
        leaf => leaves.push((path.clone(), leaf.clone())),
    }
}

fn find<'a>(value: &'a Value, path: &[String]) -> Option<&'a Value> {
    path.iter().try_fold(value, |value, key| match value {
        Value::Table(table) => table.get(key),
        Value::Array(array) => array.get(key.parse::<usize>().ok()?),
        // a list of one may be written as its element
        leaf if key == "0" => Some(leaf),
        _ => None,
    })
}

fn remove(table: &mut Table, path: &[String]) {
    let Some((last, first)) = path.split_last() else {
        return;
    };
    let mut root = Value::Table(std::mem::take(table));
    let holder = first.iter().try_fold(&mut root, |value, key| match value {
        Value::Table(table) => table.get_mut(key),
        Value::Array(array) => array.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    });
    if let Some(Value::Table(holder)) = holder {
        holder.remove(last);
    }
    if let Value::Table(root) = root {
        *table = root;
    }
}

/// Equal numbers, quantities or texts.
fn equal(a: &Value, b: &Value) -> bool {
    let si = |v: &Value| match v {
        Value::Integer(n) => Some(*n as f64),
        Value::Float(x) => Some(*x),
        Value::String(text) => text.parse::<Quantity>().ok().map(|q| q.si()),
        _ => None,
    };
    a == b || matches!((si(a), si(b)), (Some(x), Some(y)) if x == y)
}

/// A random scene in text: a small box with up to four cuts.
pub(crate) fn random(g: &mut Random) -> String {
    let cells = [0; 3].map(|_| 2 + g.below(3));
    let mut text = String::from("title = \"random\"\n[mesh]\n");
    for (axis, n) in ["x", "y", "z"].iter().zip(cells) {
        text += &format!("{axis} = {{ from = \"0 m\", to = \"{n} m\", cells = {n} }}\n");
    }
    let young = 10f64.powf(8.0 + 3.0 * g.unit());
    let poisson = 0.49 * g.unit();
    text += &format!(
        "[[material]]\nname = \"rock\"\nyoung = \"{young:.3e} Pa\"\npoisson = {poisson:.3}\n"
    );
    for f in 0..g.below(5) {
        let axis = g.below(3);
        let at = 1 + g.below(cells[axis] - 1);
        let plane = ["x", "y", "z"][axis];
        text += &format!("[[fracture]]\nname = \"f{f}\"\nplane = \"{plane}\"\nat = \"{at} m\"\n");
        text += &format!("friction_angle = \"{} deg\"\n", 5 + g.below(50));
        let other = ["y", "z", "x"][axis];
        let most = cells[(axis + 1) % 3];
        if g.once_in(2) {
            text += &format!("{other} = [\"0 m\", \"{} m\"]\n", 1 + g.below(most));
        }
    }
    for side in ["x-", "x+", "y-", "y+", "z-", "z+"] {
        let what = match g.below(6) {
            0 => "hold = \"fixed\"",
            1 | 2 => "hold = \"roller\"",
            3 => "pressure = \"5 MPa\"",
            4 => "displacement = { x = \"-1 mm\" }",
            _ => continue,
        };
        text += &format!("[[boundary]]\nside = \"{side}\"\n{what}\n");
    }
    text + "[time]\nend = \"1 s\"\nsteps = 2\nhistory = [[\"0 s\", 0.5], [\"1 s\", 1.0]]\n"
}
