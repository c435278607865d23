//! Rows of a study, in order: the product of its axes without what it skips.

use super::findings::number as number_of;
use super::measure::number;
use super::{Axes, Choice, Load, Name, Setting, Study, Together};
use anyhow::{bail, ensure};
use fracas::solve::RightHandSide;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Rows that one study may have.
const MOST: usize = 100_000;

/// Columns that every study has, after those of scenes and variants.
const FIXED: [&str; 7] = [
    "refine",
    "rhs",
    "method",
    "augmentation",
    "inner",
    "krylov",
    "tolerance",
];

/// A row that is to be solved.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// From 1.
    pub(super) number: usize,
    pub(super) setting: Setting,
    /// A field per axis.
    pub(super) fields: Vec<String>,
    /// What is measured of it, where that is less than of others.
    pub(super) only: Vec<Name>,
}

impl Case {
    /// What its matrices depend on: equal for rows that differ in the method alone.
    pub(super) fn same_matrices(&self, other: &Self) -> bool {
        let of = |case: &Self| {
            let Setting {
                scene,
                system,
                set,
                refine,
                state,
                stabilization,
                ..
            } = case.setting.clone();
            (scene, system, set, refine, state, stabilization)
        };
        of(self) == of(other)
    }

    /// True where the right-hand side is that of the scene or system.
    pub(super) fn has_own_load(&self) -> bool {
        let load = self.setting.rhs.as_ref().and_then(|rhs| rhs.value);
        load.is_none_or(|load| load == Load::Known(RightHandSide::System))
    }

    /// The same with the right-hand side.
    pub(super) fn same_system(&self, other: &Self) -> bool {
        self.same_matrices(other) && self.setting.rhs == other.setting.rhs
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

/// Values of an axis.
struct Axis {
    /// Empty but for variants.
    name: String,
    values: Vec<Setting>,
}

fn axis<V: Clone>(values: &[V], put: impl Fn(&mut Setting, V)) -> Axis {
    let setting = |value: &V| {
        let mut setting = Setting::default();
        put(&mut setting, value.clone());
        setting
    };
    Axis {
        name: String::new(),
        values: values.iter().map(setting).collect(),
    }
}

impl Axes {
    /// Scenes, then everything that may differ for one of them, last running fastest; then systems.
    fn lists(&self) -> Vec<Vec<Axis>> {
        let scenes = axis(&self.scene, |s, v| s.scene = Some(v));
        let systems = axis(&self.system, |s, v| s.system = Some(v));
        let of_scenes = || {
            let sets = self.set.iter().map(|(key, values)| {
                axis(values, |s, v| {
                    s.set.insert(key.clone(), v);
                })
            });
            sets.chain([axis(&self.refine, |s, v| s.refine = Some(v))])
                .collect::<Vec<_>>()
        };
        let rest = || {
            let together = self.together.iter().map(|t| Axis {
                name: t.name.clone(),
                values: t.values.clone(),
            });
            let fixed = [
                axis(&self.rhs, |s, v| s.rhs = Some(v)),
                axis(&self.method, |s, v| s.method = Some(v)),
                axis(&self.augmentation, |s, v| s.augmentation = Some(v)),
                axis(&self.inner, |s, v| s.inner = Some(v)),
                axis(&self.krylov, |s, v| s.krylov = Some(v)),
                axis(&self.tolerance, |s, v| s.tolerance = Some(v)),
            ];
            let (state, factor) = (
                axis(&self.state, |s, v| s.state = Some(v)),
                axis(&self.stabilization, |s, v| s.stabilization = Some(v)),
            );
            let threads = axis(&self.threads, |s, v| s.threads = Some(v));
            let said = |axis: &Axis| !axis.values.is_empty();
            let optional = [state, factor].into_iter().filter(said);
            // what changes the matrices runs slowly
            optional
                .chain(together)
                .chain(fixed)
                .chain(Some(threads).filter(said))
                .collect::<Vec<_>>()
        };
        let mut lists = Vec::new();
        if self.system.is_empty() || !self.scene.is_empty() {
            let mut list = Vec::new();
            list.extend((!self.scene.is_empty()).then_some(scenes));
            list.extend(of_scenes());
            list.extend(rest());
            lists.push(list);
        }
        if !self.system.is_empty() {
            let mut list = vec![systems];
            list.extend(rest());
            lists.push(list);
        }
        lists
    }

    /// True for an axis with values of its own, not for one that variants or defaults give.
    fn varies(&self, name: &str) -> bool {
        match name {
            "scene" | "system" => !(self.scene.is_empty() && self.system.is_empty()),
            "refine" => self.refine.len() > 1,
            "rhs" => self.rhs.len() > 1,
            "method" => self.method.len() > 1,
            "augmentation" => self.augmentation.len() > 1,
            "inner" => self.inner.len() > 1,
            "krylov" => self.krylov.len() > 1,
            "tolerance" => self.tolerance.len() > 1,
            _ => true,
        }
    }

    /// What no row could mean, in a sentence.
    pub(super) fn objection(&self) -> Option<String> {
        let variants = || self.variants();
        let of_threads = self.threads.iter().copied();
        if (of_threads.chain(variants().filter_map(|v| v.threads))).any(|n| n == 0) {
            return Some("a row has at least one of `threads`".into());
        }
        let factors = self.stabilization.iter().copied();
        let mut factors = factors.chain(variants().filter_map(|v| v.stabilization));
        if let Some(factor) = factors.find(|f| !(*f >= 0.0 && f.is_finite())) {
            return Some(format!(
                "`stabilization` is {factor}, and factors of H are numbers from 0"
            ));
        }
        let is_taken = |name: &str| FIXED.contains(&name) || Name::find(name).is_some();
        if let Some(Together { name, .. }) = self.together.iter().find(|t| is_taken(&t.name)) {
            return Some(format!(
                "variants cannot be called `{name}`: that is an axis or a measure"
            ));
        }
        let key = variants().flat_map(Setting::said).find(|key| {
            let own = match *key {
                "state" => self.state.len(),
                "stabilization" => self.stabilization.len(),
                "threads" => self.threads.len(),
                "scene" => self.scene.len(),
                key => usize::from(FIXED.contains(&key) && self.varies(key)) * 2,
            };
            own > 1
        });
        key.map(|key| format!("`{key}` is an axis, and a variant says it, too"))
    }

    fn variants(&self) -> impl Iterator<Item = &Setting> {
        self.together.iter().flat_map(|t| &t.values)
    }
}

impl Study {
    /// True for an axis that has values of its own in any product.
    pub(super) fn varies(&self, name: &str) -> bool {
        self.axes.0.iter().any(|axes| axes.varies(name))
    }

    /// Names of the axes, in the order of the columns of `rows.csv`.
    pub(super) fn axis_names(&self) -> Vec<String> {
        let products = &self.axes.0;
        let mut names: Vec<String> = Vec::new();
        let mut add = |name: &str, used: bool| {
            if used && names.iter().all(|known| known != name) {
                names.push(name.to_owned());
            }
        };
        let said = |key: &str| {
            let mut variants = products.iter().flat_map(Axes::variants);
            variants.any(|variant| variant.said().contains(&key))
        };
        add("part", products.len() > 1);
        let any = |of: &dyn Fn(&Axes) -> bool| products.iter().any(of);
        add("scene", any(&|a| !a.scene.is_empty()) || said("scene"));
        add("system", any(&|a| !a.system.is_empty()) || said("system"));
        for axes in products {
            axes.set.keys().for_each(|key| add(key, true));
            axes.together.iter().for_each(|t| add(&t.name, true));
        }
        add("state", any(&|a| !a.state.is_empty()) || said("state"));
        let factor = any(&|a| !a.stabilization.is_empty());
        add("stabilization", factor || said("stabilization"));
        FIXED.iter().for_each(|name| add(name, true));
        let threads = any(&|a| !a.threads.is_empty());
        add("threads", threads || said("threads"));
        names
    }

    /// The rows; numbers count those that are left out, too.
    pub(super) fn product(&self) -> anyhow::Result<Vec<Case>> {
        let names = self.axis_names();
        let mut cases = Vec::new();
        for axes in &self.axes.0 {
            for list in axes.lists() {
                let sizes: Vec<usize> = list.iter().map(|axis| axis.values.len()).collect();
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
                    let places = places(row, &sizes);
                    cases.push(Case {
                        only: axes.measures.clone(),
                        ..case(number, &axes.part, &list, &places, &names)
                    });
                }
            }
        }
        let unsourced = cases
            .iter()
            .find(|case| case.setting.scene.is_some() == case.setting.system.is_some());
        ensure!(
            unsourced.is_none(),
            "every row needs a scene or a system: [axes] scene = [\"crossing\"]"
        );
        self.without_skipped(cases)
    }

    fn without_skipped(&self, mut cases: Vec<Case>) -> anyhow::Result<Vec<Case>> {
        let names = self.axis_names();
        for (k, skip) in self.skip.iter().enumerate() {
            let wanted = Wanted::new(skip);
            if let Some(key) = wanted.0.iter().find(|(key, _)| !names.contains(key)) {
                let (key, names) = (&key.0, names.join(", "));
                bail!(
                    "[[skip]] {}: no axis is called `{key}`; there are: {names}",
                    k + 1
                );
            }
            let before = cases.len();
            let field = |case: &Case, name: &str| {
                let column = names.iter().position(|known| known == name);
                column.map_or(String::new(), |column| case.fields[column].clone())
            };
            cases.retain(|case| !wanted.is_met(|name| field(case, name)));
            ensure!(cases.len() < before, "[[skip]] {} matches no row", k + 1);
        }
        ensure!(!cases.is_empty(), "every row is skipped");
        Ok(cases)
    }
}

/// What the fields of a row have to be: one of these values each; `"<5"`, `"<=5"`, `">5"` and `">=5"` bound a number, `">2 GPa"` one with
/// a unit, of which a plain bound takes the value in SI.
pub(super) struct Wanted(pub(super) Vec<(String, Vec<String>)>);

impl Wanted {
    pub(super) fn new(of: &Table) -> Self {
        let mut wanted = Vec::new();
        super::axes::flatten(of, "", &mut |key, value| {
            let values = match value {
                Value::Array(values) => values.iter().map(text).collect(),
                single => vec![text(single)],
            };
            wanted.push((key, values));
        });
        Self(wanted)
    }

    pub(super) fn is_met(&self, field: impl Fn(&str) -> String) -> bool {
        let meets = |field: &str, value: &String| match (bound(value), number_of(field)) {
            (Some((holds, bound)), Some(found)) => holds(&found, &bound),
            _ => field == value,
        };
        self.0.iter().all(|(name, values)| {
            let field = field(name);
            values.iter().any(|value| meets(&field, value))
        })
    }
}

type Compare = fn(&f64, &f64) -> bool;

/// Comparisons by their signs.
const SIGNS: [(&str, Compare); 4] = [
    ("<=", f64::le),
    (">=", f64::ge),
    ("<", f64::lt),
    (">", f64::gt),
];

/// The comparison that a value asks for, and with what.
fn bound(value: &str) -> Option<(Compare, f64)> {
    SIGNS.into_iter().find_map(|(sign, holds)| {
        let with = number_of(value.strip_prefix(sign)?.trim())?;
        Some((holds, with))
    })
}

fn case(place: usize, part: &str, list: &[Axis], places: &[usize], names: &[String]) -> Case {
    let mut setting = Setting::default();
    let mut variants = BTreeMap::new();
    let chosen = || list.iter().zip(places);
    for (axis, place) in chosen().filter(|(axis, _)| axis.name.is_empty()) {
        setting.take(&axis.values[*place]);
    }
    // a variant knows better
    for (axis, place) in chosen().filter(|(axis, _)| !axis.name.is_empty()) {
        let variant = &axis.values[*place];
        setting.take(variant);
        variants.insert(axis.name.as_str(), variant.name.clone());
    }
    let s = &setting;
    let field = |name: &String| -> String {
        fn said<V: ToString>(value: &Option<V>) -> String {
            value.as_ref().map_or(String::new(), V::to_string)
        }
        fn chosen<V: Clone>(value: &Option<Choice<V>>) -> String {
            value.clone().unwrap_or_default().to_string()
        }
        if let Some(variant) = variants.get(name.as_str()) {
            return variant.clone();
        }
        match name.as_str() {
            "part" => part.to_owned(),
            "scene" => said(&s.scene),
            "system" => said(&s.system),
            "refine" => said(&s.refine),
            "state" => said(&s.state),
            "stabilization" => s.stabilization.map_or(String::new(), number),
            "rhs" => chosen(&s.rhs),
            "method" => chosen(&s.method),
            "augmentation" => chosen(&s.augmentation),
            "inner" => chosen(&s.inner),
            "krylov" => chosen(&s.krylov),
            "tolerance" => s.tolerance.map_or(String::new(), |t| number(t.0)),
            "threads" => said(&s.threads),
            key => s.set.get(key).map_or(String::new(), text),
        }
    };
    let fields = names.iter().map(field).collect();
    Case {
        number: place,
        setting,
        fields,
        only: Vec::new(),
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
