//! Values replaced from the command line.

use toml::{Table, Value};

use super::SceneError;
use super::source::Source;

/// The scene's text with `path=value` applied in order.
///
/// A path goes through tables by key and through lists by number (from 0) or by the entry's `name`; missing tables are
/// made. A value is TOML where it reads as TOML (`8`, `[1, 2]`, `true`), and else a string (`4 m`).
pub(super) fn apply<S: AsRef<str>>(source: &Source, overrides: &[S]) -> Result<String, SceneError> {
    let mut root = Value::Table(source.parse::<Table>()?);
    for text in overrides.iter().map(AsRef::as_ref) {
        let (path, value) = text
            .split_once('=')
            .filter(|(path, _)| !path.trim().is_empty())
            .ok_or_else(|| SceneError::OverrideForm { text: text.into() })?;
        set(&mut root, path.trim(), read(value.trim()), text)?;
    }
    Ok(toml::to_string(&root)?)
}

/// TOML, or a string.
fn read(text: &str) -> Value {
    toml::from_str::<Table>(&format!("v = {text}"))
        .ok()
        .filter(|table| table.len() == 1)
        .and_then(|mut table| table.remove("v"))
        .unwrap_or_else(|| Value::String(text.into()))
}

fn set(root: &mut Value, path: &str, value: Value, text: &str) -> Result<(), SceneError> {
    let mut here = root;
    let mut parent = String::from("scene");
    for segment in path.split('.') {
        let lost = |known: Vec<String>| SceneError::OverridePath {
            text: text.into(),
            segment: segment.into(),
            parent: parent.clone(),
            known,
        };
        here = match here {
            Value::Table(table) => table
                .entry(segment.to_string())
                .or_insert_with(|| Value::Table(Table::new())),
            Value::Array(list) => {
                let names: Vec<String> = list
                    .iter()
                    .enumerate()
                    .map(|(i, v)| match v.get("name").and_then(Value::as_str) {
                        Some(name) => name.to_string(),
                        None => i.to_string(),
                    })
                    .collect();
                let index = names
                    .iter()
                    .position(|n| n == segment)
                    .or(segment.parse().ok());
                match index.and_then(|i| list.get_mut(i)) {
                    Some(entry) => entry,
                    None => return Err(lost(names)),
                }
            }
            _ => return Err(lost(Vec::new())),
        };
        parent = segment.into();
    }
    *here = value;
    Ok(())
}
