//! A study file: what is varied, what is measured, what is drawn.

use super::measure::Group;
use super::names::SectionError;
use super::{Axes, CheckSection, FigureSection, Finest, Name, Products, Published, TableSection};
use crate::scenes;
use anyhow::{Context, bail, ensure};
use fracas::scene::read_toml;
use fracas_solvers::saddle::Measure;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use toml::{Table, Value};

/// A study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Heading.
    pub title: String,
    /// What is asked, in a sentence.
    #[serde(default)]
    pub question: String,
    /// How it is asked: scenes, sizes, methods, tolerances.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub setup: String,
    /// The expected answer, with its source.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub expect: String,
    /// Remarks for the reader.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub note: Vec<String>,
    /// How solves are counted.
    #[serde(default)]
    pub counts: Counts,
    /// False leaves out what the clock and the memory of the machine say, so that equal runs give equal bytes.
    #[serde(default = "yes")]
    pub clock: bool,
    /// Level of this study, where it has several.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub at: String,
    /// What a tolerance is for, as `solve --measure`.
    #[serde(default)]
    pub tolerance_of: Measure,
    /// Columns of the table on the page; those of a spectrum are computed only where they are named here or drawn.
    #[serde(default = "shown")]
    pub measures: Vec<Name>,
    /// Errors against the solution of a direct solver, in the norms of energy; without it they are the estimates of `solve`.
    #[serde(default)]
    pub reference: bool,
    /// The mesh that `mesh_error` is against.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finest: Option<Finest>,
    /// What is varied.
    pub axes: Products,
    /// Rows that are left out: those that have all of these values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub skip: Vec<Table>,
    /// What bounds a row.
    #[serde(default)]
    pub limit: Limit,
    /// What is drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figure: Vec<FigureSection>,
    /// What is listed beside all rows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub table: Vec<TableSection>,
    /// What others have published.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub published: Vec<Published>,
    /// What is claimed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub check: Vec<CheckSection>,
    /// By name, what is another one at this level.
    #[serde(default, skip_serializing)]
    pub level: BTreeMap<String, Table>,
}

/// How solves are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Counts {
    /// As `solve` does: with what fits the system, and with what takes the place of parts that fail.
    #[default]
    Solve,
    /// As published tables do: products with the assembled 𝒜 to a true residual, and nothing takes the place of what fails.
    Published,
}

fn yes() -> bool {
    true
}

fn shown() -> Vec<Name> {
    use Name::{Application, Cost, ErrorT, ErrorU, Iterations, Memory, N, SetUp, Solve};
    vec![
        N,
        Iterations,
        Application,
        Cost,
        SetUp,
        Solve,
        Memory,
        ErrorU,
        ErrorT,
    ]
}

/// What bounds a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limit {
    /// Iterations over all restarts.
    pub iterations: usize,
    /// C_s at which an iteration is given up: products with 𝒜, those that M⁻¹ is worth included.
    pub products: f64,
    /// Wall time after which the iteration stops [s].
    pub seconds: Option<f64>,
}

impl Default for Limit {
    fn default() -> Self {
        Self {
            iterations: 1000,
            products: 20_000.0,
            seconds: None,
        }
    }
}

impl Study {
    /// A product of axes with everything else as it is by default.
    pub(crate) fn of_axes(title: String, axes: Axes, reference: bool) -> Self {
        Self {
            title,
            question: String::new(),
            setup: String::new(),
            expect: String::new(),
            note: Vec::new(),
            counts: Counts::default(),
            clock: true,
            at: String::new(),
            finest: None,
            tolerance_of: Measure::default(),
            measures: shown(),
            reference,
            axes: Products(vec![axes]),
            skip: Vec::new(),
            limit: Limit::default(),
            figure: Vec::new(),
            table: Vec::new(),
            published: Vec::new(),
            check: Vec::new(),
            level: BTreeMap::new(),
        }
    }

    /// Reads a study file; paths in it start at its folder.
    ///
    /// # Errors
    /// What is wrong with it, and in which line; a level that it does not have.
    pub fn load(path: &Path, level: Option<&str>) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_toml(&text, &name, folder, level)
    }

    /// Reads a study from text; `name` is for messages, paths in it start at `folder`.
    ///
    /// # Errors
    /// What is wrong with it, and in which line; a level that it does not have.
    pub fn from_toml(
        text: &str,
        name: &str,
        folder: &Path,
        level: Option<&str>,
    ) -> anyhow::Result<Self> {
        let mut study: Self = read_toml(text, name)?;
        let whole: Table = text.parse()?;
        let at_level = |(level, other): (&String, &Table)| -> anyhow::Result<(String, Self)> {
            let mut whole = whole.clone();
            whole.remove("level");
            merge(&mut whole, other);
            whole.insert("at".into(), level.as_str().into());
            let study = (whole.try_into()).with_context(|| format!("{name}: [level.{level}]"))?;
            Ok((level.clone(), study))
        };
        // a word that no level knows is said at any level
        let levels = study.level.iter().map(at_level);
        let mut levels = levels.collect::<anyhow::Result<BTreeMap<_, _>>>()?;
        if let Some(level) = level {
            let Some(other) = levels.remove(level) else {
                let known: Vec<&str> = levels.keys().map(String::as_str).collect();
                bail!(
                    "{name} has no level `{level}`; there are: {}",
                    known.join(", ")
                );
            };
            study = other;
        }
        study.level.clear();
        let resolved = study.resolved(folder);
        resolved.map_err(|error| match error.downcast_ref() {
            Some(at @ SectionError { section, place, .. }) => {
                match line_of(text, section, *place) {
                    Some(line) => anyhow::anyhow!("{name}:{line}: {at}"),
                    None => error.context(name.to_owned()),
                }
            }
            None => error.context(name.to_owned()),
        })
    }

    /// The same with absolute paths, checked as far as nothing needs to be meshed.
    pub(crate) fn resolved(mut self, folder: &Path) -> anyhow::Result<Self> {
        let absolute = |path: &str| -> anyhow::Result<String> {
            let path = std::path::absolute(folder.join(path))?;
            // without `..`; a link keeps its name
            let place = path.parent().and_then(|parent| parent.canonicalize().ok());
            let path = match (place, path.file_name()) {
                (Some(place), Some(name)) => place.join(name),
                _ => path,
            };
            Ok(path.display().to_string())
        };
        let file = |scene: &str| -> anyhow::Result<String> {
            match absolute(scene)? {
                path if scenes::is_file(&path) => Ok(path),
                _ => Ok(scene.to_owned()),
            }
        };
        for axes in &mut self.axes.0 {
            let (scenes_of, systems_of) = axes.sources();
            for scene in scenes_of {
                *scene = file(scene)?;
                scenes::load(scene)?;
            }
            for system in systems_of {
                *system = absolute(system)?;
                ensure!(Path::new(system).is_dir(), "{system} is not a folder");
            }
        }
        // rows are chosen as they are written in the axes
        let mut of_rows = |rows: &mut Table| -> anyhow::Result<()> {
            for (key, resolve) in [
                ("scene", &file as &dyn Fn(&str) -> _),
                ("system", &absolute),
            ] {
                let values = match rows.get_mut(key) {
                    Some(Value::Array(values)) => values.as_mut_slice(),
                    Some(value) => std::slice::from_mut(value),
                    None => &mut [],
                };
                for value in values {
                    if let Value::String(text) = value {
                        *text = resolve(text)?;
                    }
                }
            }
            Ok(())
        };
        self.skip.iter_mut().try_for_each(&mut of_rows)?;
        let mut whole = Value::try_from(&self)?;
        each_where(&mut whole, &mut of_rows)?;
        self = whole.try_into()?;
        self.check()?;
        Ok(self)
    }

    fn check(&self) -> anyhow::Result<()> {
        for axes in &self.axes.0 {
            let (sets, refines) = (
                !axes.set.is_empty(),
                axes.refine.iter().any(|f| f.get() > 1),
            );
            ensure!(
                axes.has_scenes() || !(sets || refines),
                "`set` and `refine` have no effect without `scene`"
            );
            if let Some((axis, value)) = axes.repeated() {
                bail!("{value} stands twice in the axis `{axis}`: its rows would be the same");
            }
            if let (true, Some(key)) = (axes.has_systems(), axes.of_scenes()) {
                bail!(
                    "`{key}` has no effect on a system folder, whose H is in H.mtx; give scenes [[axes]] of their own"
                );
            }
        }
        let nested = self
            .measured()
            .iter()
            .any(|name| name.group() == Group::Nested);
        ensure!(
            !nested || self.counts == Counts::Published,
            "algebraic_u, algebraic_t and mesh_error need counts = \"published\""
        );
        ensure!(
            !self.measured().contains(&Name::MeshError) || self.finest.is_some(),
            "mesh_error needs [finest], the mesh that it is against"
        );
        self.check_runs()?;
        if let Some(why) = self.axes.0.iter().find_map(Axes::objection) {
            bail!(why);
        }
        let limit = self.limit;
        ensure!(
            limit.products > 0.0 && limit.seconds.is_none_or(|s| s > 0.0),
            "a limit is a positive number"
        );
        self.product()?;
        Ok(self.check_names()?)
    }
}

impl Study {
    /// Refuses methods beside a run: those of a run are keys of the scene.
    fn check_runs(&self) -> anyhow::Result<()> {
        let measured = self.measured();
        for axes in &self.axes.0 {
            let names = match axes.measures.as_slice() {
                [] => &measured,
                own => own,
            };
            let any = |groups: &[Group]| names.iter().any(|name| groups.contains(&name.group()));
            let solves = any(&[
                Group::Solve,
                Group::Count,
                Group::Clock,
                Group::Spectrum,
                Group::NonNormal,
            ]);
            let idle = axes.of_solves();
            ensure!(
                !any(&[Group::Run]) || solves || idle.is_none(),
                "`{}` has no effect on a run, whose method is a key of the scene: set.\"solver.racp.inner\" = [\"exact\", \"amg\"]",
                idle.unwrap_or_default()
            );
        }
        Ok(())
    }
}

/// Puts what a level says in the place of what is there. Tables are merged, products by their `part`, variants by their `name`; other
/// lists are not.
fn merge(whole: &mut Table, level: &Table) {
    for (key, value) in level {
        let known_by = match key.as_str() {
            "axes" => "part",
            "together" => "name",
            _ => "",
        };
        match (whole.get_mut(key), value) {
            (Some(Value::Table(own)), Value::Table(other)) => merge(own, other),
            (Some(Value::Array(own)), Value::Array(others)) if !known_by.is_empty() => {
                for other in others {
                    let same = |one: &&mut Value| one.get(known_by) == other.get(known_by);
                    match (own.iter_mut().find(same), other) {
                        (Some(Value::Table(one)), Value::Table(other)) => merge(one, other),
                        _ => own.push(other.clone()),
                    }
                }
            }
            _ => {
                whole.insert(key.clone(), value.clone());
            }
        }
    }
}

/// Line of the k-th `[[section]]`, or of the k-th `{` of `section = [`, from 1.
fn line_of(text: &str, section: &str, place: usize) -> Option<usize> {
    let (head, list) = (format!("[[{section}]]"), format!("{section} = ["));
    let mut is_in_list = false;
    let mut found = text.lines().enumerate().filter(|(_, line)| {
        let line = line.trim();
        is_in_list = line.starts_with(&list) || (is_in_list && !line.starts_with(']'));
        line.starts_with(&head) || (is_in_list && line.starts_with('{'))
    });
    found.nth(place).map(|(line, _)| line + 1)
}

/// Every `where` in a value.
fn each_where(
    value: &mut Value,
    visit: &mut dyn FnMut(&mut Table) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    match value {
        Value::Array(values) => values.iter_mut().try_for_each(|v| each_where(v, visit)),
        Value::Table(table) => {
            table
                .iter_mut()
                .try_for_each(|(key, value)| match (key.as_str(), value) {
                    ("where", Value::Table(rows)) => visit(rows),
                    (_, value) => each_where(value, visit),
                })
        }
        _ => Ok(()),
    }
}
