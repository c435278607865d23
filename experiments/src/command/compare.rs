//! `fracas compare`: a study from the command line.

use super::Status;
use super::study::Place;
use crate::study::{Axes, Choice, Inner, Load, Study, Tolerance};
use anyhow::Context;
use clap::Args;
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{AugmentationChoice, SaddleMethod};
use std::collections::BTreeMap;
use std::io::Write;
use std::num::NonZeroU32;
use std::path::Path;
use toml::{Table, Value};

#[derive(Args, Debug)]
pub(super) struct Compare {
    /// Scene files, or names of scenes of the gallery.
    #[arg(value_name = "SCENE", required_unless_present = "system")]
    scene: Vec<String>,
    /// System folders (A.mtx, B1.mtx, …).
    #[arg(long, value_name = "DIR,…", value_delimiter = ',')]
    system: Vec<String>,
    /// Values of a key of the scenes, for example mesh.x.cells=8,16; may be repeated.
    #[arg(long = "set", value_name = "KEY=V,…")]
    set: Vec<String>,
    /// Factors on every cell count of the grid.
    #[arg(long, value_name = "N,…", value_delimiter = ',')]
    refine: Vec<NonZeroU32>,
    /// Right-hand sides: system, sin, ones, random:SEED.
    #[arg(long, value_name = "B,…", value_delimiter = ',')]
    rhs: Vec<Choice<Load>>,
    /// Preconditioners of the whole system, as --method of `solve`.
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    method: Vec<Choice<SaddleMethod>>,
    /// C, as --augmentation of `solve`.
    #[arg(long, value_name = "C,…", value_delimiter = ',')]
    augmentation: Vec<Choice<AugmentationChoice>>,
    /// Solvers of the displacement block, as --inner of `solve`.
    #[arg(long, value_name = "M,…", value_delimiter = ',')]
    inner: Vec<Choice<Inner>>,
    /// Iterations, as --krylov of `solve`.
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    krylov: Vec<Choice<KrylovChoice>>,
    /// Tolerances of the errors of u and t.
    #[arg(long, value_name = "TOL,…", value_delimiter = ',', value_parser = tolerance)]
    tolerance: Vec<Tolerance>,
    /// Errors against the solution of a direct solver.
    #[arg(long)]
    reference: bool,
    #[command(flatten)]
    place: Place,
}

fn tolerance(text: &str) -> Result<Tolerance, String> {
    let value = text.parse::<f64>().unwrap_or(f64::NAN);
    value.try_into().map_err(str::to_owned)
}

/// A list, or what stands for an option that is not given.
fn or<V: Clone>(given: &[V], otherwise: Vec<V>) -> Vec<V> {
    match given.is_empty() {
        true => otherwise,
        false => given.to_vec(),
    }
}

/// Values between commas, those in brackets or quotes left whole; what is no TOML is a string.
fn values(text: &str) -> Vec<Value> {
    let listed = toml::from_str::<Table>(&format!("v = [{text}]")).ok();
    match listed.as_ref().and_then(|table| table.get("v")) {
        Some(Value::Array(values)) => values.clone(),
        _ => (text.split(','))
            .map(|part| {
                let read = toml::from_str::<Table>(&format!("v = {part}")).ok();
                let read = read.and_then(|mut table| table.remove("v"));
                read.unwrap_or_else(|| Value::String(part.trim().into()))
            })
            .collect(),
    }
}

impl Compare {
    fn study(&self) -> anyhow::Result<Study> {
        let mut set = BTreeMap::new();
        for text in &self.set {
            let (key, list) = text.split_once('=').with_context(|| {
                format!("--set {text}: write key=value,…, e.g. --set mesh.x.cells=8,16")
            })?;
            set.insert(key.trim().to_owned(), values(list));
        }
        let none = Axes::default();
        let axes = Axes {
            scene: self.scene.clone(),
            system: self.system.clone(),
            set,
            refine: or(&self.refine, none.refine),
            rhs: or(&self.rhs, none.rhs),
            method: or(&self.method, none.method),
            augmentation: or(&self.augmentation, none.augmentation),
            inner: or(&self.inner, none.inner),
            krylov: or(&self.krylov, none.krylov),
            tolerance: or(&self.tolerance, none.tolerance),
            ..Axes::default()
        };
        let names = [self.scene.as_slice(), &self.system].concat();
        let title = format!("Comparison on {}", names.join(", "));
        Study::of_axes(title, axes, self.reference).resolved(Path::new(""))
    }

    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        self.place.run(&self.study()?, out)
    }
}
