//! The list of layers, checked.

use super::faults::Fault;
use super::{GeologyProblem, GeologySection};
use crate::nearest::nearest;
use crate::scene::located::{Located, at};
use crate::scene::sections::MaterialSection;

/// Layers before faults offset them.
pub(super) struct Layers {
    /// Material of each, by number.
    pub(super) materials: Vec<usize>,
    /// Its name.
    pub(super) names: Vec<String>,
    /// Tops, and the base of the last one, decreasing [m].
    pub(super) levels: Vec<f64>,
}

impl Layers {
    /// Names are known and tops decrease.
    pub(super) fn new(
        section: &GeologySection,
        materials: &[MaterialSection],
    ) -> Result<Self, Located> {
        let (mut levels, mut names, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
        for (k, layer) in section.layers.iter().enumerate() {
            let here =
                |key: &str, problem| at(&["geology", "layers", &k.to_string(), key], problem);
            let top = layer.top.si();
            let number = material(&layer.material, materials);
            numbers.push(number.map_err(|problem| here("material", problem))?);
            if let (Some(limit), Some(above)) = (levels.last().copied(), names.last())
                && top >= limit
            {
                let (name, above): (String, String) =
                    (layer.material.clone(), String::clone(above));
                return Err(here(
                    "top",
                    GeologyProblem::Order {
                        name,
                        top,
                        above,
                        limit,
                    },
                ));
            }
            levels.push(top);
            names.push(layer.material.clone());
        }
        let Some(top) = levels.last().copied() else {
            return Err(at(&["geology", "layers"], GeologyProblem::NoLayer));
        };
        let bottom = section.bottom.si();
        if bottom >= top {
            return Err(at(
                &["geology", "bottom"],
                GeologyProblem::Bottom { bottom, top },
            ));
        }
        levels.push(bottom);
        Ok(Self {
            materials: numbers,
            names,
            levels,
        })
    }

    /// Levels between the highest top and the lowest base of the layers of these materials.
    pub(super) fn span(&self, names: &[String]) -> Result<[f64; 2], GeologyProblem> {
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        for name in names {
            self.require(name)?;
            for k in (0..self.names.len()).filter(|k| self.names[*k] == *name) {
                high = high.max(self.levels[k]);
                low = low.min(self.levels[k + 1]);
            }
        }
        Ok([low, high])
    }

    /// How much lower level k lies at a point because of faults; the top and the bottom of the box stay [m].
    pub(super) fn offset(&self, k: usize, faults: &[Fault], point: [f64; 2]) -> f64 {
        let level = self.levels[k];
        match k == 0 || k == self.levels.len() - 1 {
            true => 0.0,
            false => faults.iter().map(|f| f.offset(level, point)).sum(),
        }
    }

    /// Levels at a point of those that are written within a range [m].
    pub(super) fn lying(
        &self,
        faults: &[Fault],
        point: [f64; 2],
        [low, high]: [f64; 2],
    ) -> impl Iterator<Item = f64> {
        let within = move |k: &usize| (low..=high).contains(&self.levels[*k]);
        let levels = (0..self.levels.len()).filter(within);
        levels.map(move |k| self.levels[k] - self.offset(k, faults, point))
    }

    /// A layer has this material.
    pub(super) fn require(&self, name: &String) -> Result<(), GeologyProblem> {
        match self.names.contains(name) {
            true => Ok(()),
            false => Err(unknown("layer", name, &self.names)),
        }
    }
}

/// Number of a material.
pub(super) fn material(name: &str, materials: &[MaterialSection]) -> Result<usize, GeologyProblem> {
    let number = materials.iter().position(|m| m.name == name);
    number.ok_or_else(|| {
        let known: Vec<String> = materials.iter().map(|m| m.name.clone()).collect();
        unknown("material", name, &known)
    })
}

/// A name that is not there.
pub(super) fn unknown(kind: &'static str, name: &str, known: &[String]) -> GeologyProblem {
    GeologyProblem::Unknown {
        kind,
        name: name.into(),
        nearest: nearest(name, known),
        known: known.to_vec(),
    }
}
