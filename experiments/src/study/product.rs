//! Rows of a study, in order: the product of its axes without what it skips.

use super::axes::flatten;
use super::measure::number;
use super::{Choice, Inner, Load, Study};
use anyhow::{bail, ensure};
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{AugmentationChoice, SaddleMethod};
use std::num::NonZeroU32;
use toml::Value;

/// Rows that one study may have.
const MOST: usize = 100_000;

/// Where a system comes from.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Origin {
    Scene(String),
    System(String),
}

/// A row that is to be solved.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// From 1.
    pub(super) number: usize,
    pub(super) origin: Origin,
    /// `key=value`.
    pub(super) set: Vec<String>,
    pub(super) refine: NonZeroU32,
    pub(super) rhs: Choice<Load>,
    pub(super) method: Choice<SaddleMethod>,
    pub(super) augmentation: Choice<AugmentationChoice>,
    pub(super) inner: Choice<Inner>,
    pub(super) krylov: Choice<KrylovChoice>,
    pub(super) tolerance: f64,
    /// A field per axis.
    pub(super) fields: Vec<String>,
}

impl Case {
    /// What its right-hand side and its matrices depend on: equal for rows that differ in the method alone.
    pub(super) fn same_system(&self, other: &Self) -> bool {
        let of = |case: &Self| {
            let rhs = case.rhs.to_string();
            (case.origin.clone(), case.set.clone(), case.refine, rhs)
        };
        of(self) == of(other)
    }
}

/// A value as it stands in `rows.csv`.
pub(super) fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Float(value) => number(*value),
        other => other.to_string(),
    }
}

impl Study {
    /// Names of the axes, in the order of the columns of `rows.csv`.
    pub(super) fn axis_names(&self) -> Vec<String> {
        let axes = &self.axes;
        let sources = [("scene", &axes.scene), ("system", &axes.system)];
        let sources = sources.into_iter().filter(|(_, list)| !list.is_empty());
        let fixed = [
            "refine",
            "rhs",
            "method",
            "augmentation",
            "inner",
            "krylov",
            "tolerance",
        ];
        (sources.map(|(name, _)| name.to_owned()))
            .chain(axes.set.keys().cloned())
            .chain(fixed.map(String::from))
            .collect()
    }

    /// The rows; numbers count those that are left out, too.
    pub(super) fn product(&self) -> anyhow::Result<Vec<Case>> {
        let axes = &self.axes;
        let scenes = axes.scene.iter().cloned().map(Origin::Scene);
        let systems = axes.system.iter().cloned().map(Origin::System);
        let mut cases = Vec::new();
        for origin in scenes.chain(systems) {
            let is_scene = matches!(origin, Origin::Scene(_));
            let mut sizes: Vec<usize> = axes.set.values().map(Vec::len).collect();
            sizes.push(axes.refine.len());
            if !is_scene {
                sizes.fill(1);
            }
            sizes.extend([
                axes.rhs.len(),
                axes.method.len(),
                axes.augmentation.len(),
                axes.inner.len(),
                axes.krylov.len(),
                axes.tolerance.len(),
            ]);
            let rows = sizes
                .iter()
                .try_fold(1_usize, |n, size| n.checked_mul(*size));
            let rows = rows.filter(|n| n.saturating_add(cases.len()) <= MOST);
            let Some(rows) = rows else {
                bail!("the product of the axes has more than {MOST} rows");
            };
            ensure!(rows > 0, "an axis without a value leaves no row");
            for row in 0..rows {
                let number = cases.len() + 1;
                cases.push(self.case(number, &origin, &places(row, &sizes)));
            }
        }
        self.without_skipped(cases)
    }

    fn case(&self, number: usize, origin: &Origin, places: &[usize]) -> Case {
        let axes = &self.axes;
        let (of_set, rest) = places.split_at(axes.set.len());
        let chosen: Vec<(&String, &Value)> = (axes.set.iter())
            .zip(of_set)
            .map(|((key, values), place)| (key, &values[*place]))
            .collect();
        let is_scene = matches!(origin, Origin::Scene(_));
        let (refine, rhs) = (axes.refine[rest[0]], axes.rhs[rest[1]].clone());
        let method = axes.method[rest[2]].clone();
        let augmentation = axes.augmentation[rest[3]].clone();
        let inner = axes.inner[rest[4]].clone();
        let krylov = axes.krylov[rest[5]].clone();
        let tolerance = axes.tolerance[rest[6]].0;
        let of_scenes = |text: String| if is_scene { text } else { String::new() };
        let mut fields = Vec::new();
        let (scene, system) = match origin {
            Origin::Scene(name) => (name.as_str(), ""),
            Origin::System(name) => ("", name.as_str()),
        };
        fields.extend((!axes.scene.is_empty()).then(|| scene.to_owned()));
        fields.extend((!axes.system.is_empty()).then(|| system.to_owned()));
        fields.extend(chosen.iter().map(|(_, value)| of_scenes(text(value))));
        fields.extend([
            of_scenes(refine.to_string()),
            rhs.to_string(),
            method.to_string(),
            augmentation.to_string(),
            inner.to_string(),
            krylov.to_string(),
            text(&Value::Float(tolerance)),
        ]);
        let set = chosen.iter().filter(|_| is_scene);
        Case {
            number,
            origin: origin.clone(),
            set: set.map(|(key, value)| format!("{key}={value}")).collect(),
            refine: if is_scene { refine } else { NonZeroU32::MIN },
            rhs,
            method,
            augmentation,
            inner,
            krylov,
            tolerance,
            fields,
        }
    }

    fn without_skipped(&self, mut cases: Vec<Case>) -> anyhow::Result<Vec<Case>> {
        let names = self.axis_names();
        for (k, skip) in self.skip.iter().enumerate() {
            let mut wanted: Vec<(usize, Vec<String>)> = Vec::new();
            let mut unknown = None;
            flatten(skip, "", &mut |key, value| {
                let values = match value {
                    Value::Array(values) => values.iter().map(text).collect(),
                    single => vec![text(single)],
                };
                match names.iter().position(|name| *name == key) {
                    Some(column) => wanted.push((column, values)),
                    None => unknown = Some(key),
                }
            });
            if let Some(key) = unknown {
                let names = names.join(", ");
                bail!(
                    "[[skip]] {}: no axis is called `{key}`; there are: {names}",
                    k + 1
                );
            }
            let before = cases.len();
            let is_meant = |case: &Case| {
                (wanted.iter()).all(|(column, values)| values.contains(&case.fields[*column]))
            };
            cases.retain(|case| !is_meant(case));
            ensure!(cases.len() < before, "[[skip]] {} matches no row", k + 1);
        }
        ensure!(!cases.is_empty(), "every row is skipped");
        Ok(cases)
    }
}

/// The place of a row on every axis, the last one running fastest.
fn places(mut row: usize, sizes: &[usize]) -> Vec<usize> {
    let mut places = vec![0; sizes.len()];
    for (place, size) in places.iter_mut().zip(sizes).rev() {
        (*place, row) = (row % size, row / size);
    }
    places
}
