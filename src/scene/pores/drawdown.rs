//! A layer into which the change of pressure of its neighbours diffuses.

use super::PoreProblem;
use crate::analytic::{Diffusion, FarSide};
use crate::mesh::HexMesh;
use crate::scene::History;
use crate::scene::located::{Located, at};
use crate::scene::pore_pressure::{Between, Points, Table, change};
use crate::scene::sections::MaterialSection;
use crate::scene::{Problem, TableProblem};
use crate::units::{Diffusivity, Length, Measure};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Diffusion across a level layer, `∂p/∂t = κ ∂²p/∂z²`, from the faces of an aquifer whose pressure is a table: give `points` or `file`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrawdownSection {
    /// κ, the hydraulic conductivity over the specific storage.
    pub diffusivity: Measure<Diffusivity>,
    /// The faces at which the pressure changes as in the table.
    pub from: FromFace,
    /// What holds at the other face; `"closed"` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<FarFace>,
    /// Bottom and top of the layer; those of the boxes of the material, where all have the same, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<[Measure<Length>; 2]>,
    /// `[[time, pressure], …]` of the aquifer, times increasing; constant outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Points>,
    /// A CSV file with the heading `time [day],aquifer [bar],…` and a row per time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Its column; the name of the material if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// What holds between two times.
    #[serde(default, skip_serializing_if = "Between::is_linear")]
    pub between: Between,
}

/// A face of a layer, or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FromFace {
    /// The lower one.
    Bottom,
    /// The upper one.
    Top,
    /// Both.
    Both,
}

/// What holds at the face away from the aquifer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FarFace {
    /// Nothing flows through it.
    Closed,
    /// Its pressure does not change.
    Held,
}

impl DrawdownSection {
    /// Takes the rows of its file into `points`, and checks which keys are there.
    pub(in crate::scene) fn read_file(
        &mut self,
        name: &str,
        folder: &Path,
        here: &[&str; 3],
    ) -> Result<(), Located> {
        let place = |key: &'static str| [here[0], here[1], here[2], "drawdown", key];
        let what = || format!("`drawdown` of material \"{name}\"");
        let found = usize::from(self.points.is_some()) + usize::from(self.file.is_some());
        if found != 1 {
            let (what, keys) = (what(), "`points`, `file`");
            let problem = Problem::ExactlyOne { what, keys, found };
            return Err(at(&place("drawdown")[..4], problem));
        }
        let idle = |key: &'static str, without: &'static str| {
            let what = what();
            at(&place(key), Problem::Idle { key, what, without })
        };
        if self.column.is_some() && self.file.is_none() {
            return Err(idle("column", "file"));
        }
        if self.far.is_some() && self.from == FromFace::Both {
            return Err(idle("far", "from = \"bottom\"` or `\"top\""));
        }
        let table = Table {
            points: &mut self.points,
            file: &mut self.file,
            column: &mut self.column,
        };
        (table.fill(name, folder)).map_err(|problem| at(&place("file"), problem))
    }

    /// Bottom and top of the layer [m].
    fn layer(&self, material: &MaterialSection) -> Result<[f64; 2], Problem> {
        if let Some(z) = &self.z {
            let [from, to] = [z[0].si(), z[1].si()];
            if to > from {
                return Ok([from, to]);
            }
            let what = format!("`z` of `drawdown` of material \"{}\"", material.name);
            return Err(Problem::EmptyInterval { what, from, to });
        }
        let of_boxes = material.boxes.iter().map(|own| own.z.as_ref());
        let all = of_boxes.chain(material.layers.iter().map(Some));
        let all: Option<Vec<[f64; 2]>> = all
            .map(|z| z.map(|[from, to]| [from.si(), to.si()]))
            .collect();
        let first = all.as_ref().and_then(|all| all.first()).copied();
        match (all, first) {
            (Some(all), Some(first)) if all.iter().all(|z| *z == first) => Ok(first),
            _ => Err(PoreProblem::NoLayer {
                name: material.name.clone(),
                found: first,
            }
            .into()),
        }
    }

    /// The change in the elements of a material.
    pub(super) fn drawdown(
        &self,
        material: &MaterialSection,
        mesh: &HexMesh,
        elements: &[u32],
    ) -> Result<Drawdown, Problem> {
        let layer = self.layer(material)?;
        let thickness = layer[1] - layer[0];
        let place = || format!("`drawdown` of material \"{}\"", material.name);
        let history = change(self.points.as_ref(), self.between, place);
        let history = history.map_err(|problem: TableProblem| Problem::from(problem))?;
        let mut number: HashMap<[u64; 2], u32> = HashMap::new();
        let (mut intervals, mut interval_of) = (Vec::new(), Vec::with_capacity(elements.len()));
        for e in elements {
            let nodes = mesh.elements[*e as usize].map(|a| mesh.nodes[a as usize]);
            let reach = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| {
                let z = nodes.iter().map(|x| x[2]);
                z.reduce(of).unwrap_or(0.0)
            });
            let slack = CLOSE * thickness;
            if reach[0] < layer[0] - slack || reach[1] > layer[1] + slack {
                return Err(PoreProblem::OutOfLayer {
                    element: *e as usize,
                    name: material.name.clone(),
                    center: [0, 1, 2].map(|i| nodes.iter().map(|x| x[i]).sum::<f64>() / 8.0),
                    reach,
                    layer,
                }
                .into());
            }
            let inside = reach.map(|z| (z - layer[0]).clamp(0.0, thickness));
            let interval = match self.from {
                FromFace::Top => [thickness - inside[1], thickness - inside[0]],
                FromFace::Bottom | FromFace::Both => inside,
            };
            let known = number.entry(interval.map(f64::to_bits));
            interval_of.push(*known.or_insert_with(|| {
                intervals.push(interval);
                intervals.len() as u32 - 1
            }));
        }
        Ok(Drawdown {
            diffusion: Diffusion {
                thickness,
                diffusivity: self.diffusivity.si(),
                far: match (self.from, self.far) {
                    (FromFace::Both, _) => FarSide::Driven,
                    (_, Some(FarFace::Held)) => FarSide::Held,
                    (_, Some(FarFace::Closed) | None) => FarSide::Closed,
                },
            },
            history,
            intervals,
            interval_of,
        })
    }
}

/// Share of the thickness by which an element may reach out of the layer: rounding, and levels with six digits. Unit: 1.
const CLOSE: f64 = 1e-6;

/// The change in elements, each its mean over the z that it fills.
#[derive(Clone, Debug)]
pub(super) struct Drawdown {
    diffusion: Diffusion,
    /// Change of the aquifer since time 0 [Pa].
    history: History,
    /// Distances from the driven face that elements fill [m], each once.
    intervals: Vec<[f64; 2]>,
    interval_of: Vec<u32>,
}

impl Drawdown {
    /// Δp per element at a time [s], in Pa.
    pub(super) fn at(&self, time: f64) -> Vec<f64> {
        let changes = self.history.changes();
        let stepped = self.history.is_stepped();
        let mean = |interval: &[f64; 2]| -> f64 {
            let since = changes.iter().filter(|(start, _)| *start < time);
            let each = since.map(|(start, change)| {
                change
                    * match stepped {
                        true => self.diffusion.step(*interval, time - start),
                        false => self.diffusion.ramp(*interval, time - start),
                    }
            });
            each.sum()
        };
        let means: Vec<f64> = self.intervals.par_iter().map(mean).collect();
        let of = |n: &u32| means[*n as usize];
        self.interval_of.iter().map(of).collect()
    }

    pub(super) fn corners(&self) -> Vec<f64> {
        self.history.corners().collect()
    }

    pub(super) fn jumps(&self) -> Vec<f64> {
        self.history.jumps().collect()
    }

    /// For a person.
    pub(super) fn origin(&self) -> String {
        let Diffusion {
            thickness,
            diffusivity,
            far,
        } = self.diffusion;
        let [faces, other] = match far {
            FarSide::Driven => ["both faces", ""],
            FarSide::Closed => ["one face", ", the other closed"],
            FarSide::Held => ["one face", ", the other held"],
        };
        let time = thickness * thickness / diffusivity;
        format!(
            "what diffuses from {faces} of a layer of {thickness} m{other}, L^2/kappa = {time:.4e} s"
        )
    }
}
