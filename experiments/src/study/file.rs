//! A study file: what is varied, what is measured, what is drawn.

use super::{Axes, FigureSection, Name};
use crate::scenes;
use anyhow::{Context, ensure};
use fracas::scene::read_toml;
use fracas_solvers::saddle::Measure;
use serde::{Deserialize, Serialize};
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
    /// What a tolerance is for, as `solve --measure`.
    #[serde(default)]
    pub tolerance_of: Measure,
    /// Columns of the table on the page; those of a spectrum are computed only where they are named here or drawn.
    #[serde(default = "shown")]
    pub measures: Vec<Name>,
    /// Errors against the solution of a direct solver, in the norms of energy; without it they are the estimates of `solve`.
    #[serde(default)]
    pub reference: bool,
    /// What is varied.
    pub axes: Axes,
    /// Rows that are left out: those that have all of these values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub skip: Vec<Table>,
    /// What bounds a row.
    #[serde(default)]
    pub limit: Limit,
    /// What is drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figure: Vec<FigureSection>,
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
            tolerance_of: Measure::default(),
            measures: shown(),
            reference,
            axes,
            skip: Vec::new(),
            limit: Limit::default(),
            figure: Vec::new(),
        }
    }

    /// Reads a study file; paths in it start at its folder.
    ///
    /// # Errors
    /// What is wrong with it, and in which line.
    pub fn load(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Self::from_toml(&text, &name, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads a study from text; `name` is for messages, paths in it start at `folder`.
    ///
    /// # Errors
    /// What is wrong with it, and in which line.
    pub fn from_toml(text: &str, name: &str, folder: &Path) -> anyhow::Result<Self> {
        let study: Self = read_toml(text, name)?;
        study.resolved(folder).with_context(|| name.to_owned())
    }

    /// The same with absolute paths, checked as far as nothing needs to be meshed.
    pub(crate) fn resolved(mut self, folder: &Path) -> anyhow::Result<Self> {
        let absolute = |path: &str| -> anyhow::Result<String> {
            let path = std::path::absolute(folder.join(path))?;
            Ok(path.display().to_string())
        };
        let file = |scene: &str| -> anyhow::Result<String> {
            match absolute(scene)? {
                path if scenes::is_file(&path) => Ok(path),
                _ => Ok(scene.to_owned()),
            }
        };
        for scene in &mut self.axes.scene {
            *scene = file(scene)?;
            scenes::load(scene)?;
        }
        for system in &mut self.axes.system {
            *system = absolute(system)?;
            ensure!(Path::new(system).is_dir(), "{system} is not a folder");
        }
        for skip in &mut self.skip {
            for (key, resolve) in [
                ("scene", &file as &dyn Fn(&str) -> _),
                ("system", &absolute),
            ] {
                let values = match skip.get_mut(key) {
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
        }
        self.check()?;
        Ok(self)
    }

    fn check(&self) -> anyhow::Result<()> {
        let axes = &self.axes;
        ensure!(
            !(axes.scene.is_empty() && axes.system.is_empty()),
            "a study needs a scene or a system: [axes] scene = [\"crossing\"]"
        );
        let idle = axes.scene.is_empty()
            && !(axes.set.is_empty() && axes.refine.iter().all(|f| f.get() == 1));
        ensure!(!idle, "`set` and `refine` have no effect without `scene`");
        let limit = self.limit;
        ensure!(
            limit.products > 0.0 && limit.seconds.is_none_or(|s| s > 0.0),
            "a limit is a positive number"
        );
        self.check_figures()?;
        self.product().map(|_| ())
    }

    /// True where eigenvalues are asked for.
    pub(super) fn is_spectral(&self) -> bool {
        let drawn = |figure: &FigureSection| {
            Name::ALL
                .iter()
                .any(|m| m.is_spectral() && [&figure.x, &figure.y].contains(&&m.text().to_owned()))
        };
        self.measures.iter().any(|m| m.is_spectral()) || self.figure.iter().any(drawn)
    }

    /// Measures of a row, in the order of `rows.csv`.
    pub(super) fn measured(&self) -> Vec<Name> {
        let spectral = self.is_spectral();
        let all = Name::ALL.iter().copied();
        all.filter(|m| spectral || !m.is_spectral()).collect()
    }
}
