//! Settings that a run goes on with, beside those that its folder was begun with.

use super::tree::{self, RESOLVED};
use crate::scene::{Scene, SolverSection};
use serde_json::{Map, Value};
use std::path::Path;

/// A sentence per setting of `[solver]` that is another in the scene beside this checkpoint; none where there is no such scene.
pub(super) fn changed(checkpoint: &Path, now: &Scene) -> Vec<String> {
    let absolute = std::path::absolute(checkpoint);
    let folder = absolute.as_deref().ok().and_then(tree::run_of);
    let Some(before) = folder.and_then(|run| Scene::load(run.join(RESOLVED)).ok()) else {
        return Vec::new();
    };
    let [before, now] = [&before, now].map(|scene| solver(scene.sections().solver));
    let missing = |key: &&String| !now.contains_key(*key);
    now.keys()
        .chain(before.keys().filter(missing))
        .filter(|key| before.get(*key) != now.get(*key))
        .map(|key| {
            let said = |of: &Map<String, Value>| {
                of.get(key)
                    .map_or_else(|| "not given".to_owned(), Value::to_string)
            };
            format!(
                "solver.{key} is {} from here on, {RESOLVED} beside the checkpoint says {}",
                said(&now),
                said(&before)
            )
        })
        .collect()
}

/// Names and values, defaults included.
fn solver(section: Option<SolverSection>) -> Map<String, Value> {
    match serde_json::to_value(section.unwrap_or_default()) {
        Ok(Value::Object(values)) => values,
        _ => Map::new(),
    }
}
