//! The list of layers, checked.

use super::faults::Fault;
use super::{GeologyProblem, GeologySection};
use crate::mesh::Relief;
use crate::nearest::nearest;
use crate::scene::located::{Located, at};
use crate::scene::mesh_sections::{AxisName, FractureSection};
use crate::scene::sections::MaterialSection;

/// Layers before faults offset them.
pub(super) struct Layers {
    /// Material of each, by number.
    pub(super) materials: Vec<usize>,
    /// Its name.
    pub(super) names: Vec<String>,
    /// Levels of the grid at tops, and at the base of the last one, decreasing [m]: where they are written, where tops are level.
    pub(super) levels: Vec<f64>,
    /// Heights of tops, and of the base of the last one.
    pub(super) tops: Vec<Relief>,
}

/// Share of the height of all layers within which two heights are one. Unit: 1.
const SAME: f64 = 1e-9;

impl Layers {
    /// Names are known and tops decrease; those that are not level get their levels where faults that offset layers lie, or as their means.
    pub(super) fn new(
        section: &GeologySection,
        materials: &[MaterialSection],
        fractures: &[FractureSection],
        ends: [[f64; 2]; 2],
    ) -> Result<Self, Located> {
        let (mut tops, mut names, mut numbers) = (Vec::new(), Vec::<String>::new(), Vec::new());
        let here = |k: usize, key: &str, problem: GeologyProblem| {
            at(&["geology", "layers", &k.to_string(), key], problem)
        };
        for (k, layer) in section.layers.iter().enumerate() {
            let path = ["geology", "layers", &k.to_string(), "top"];
            let top = (layer.top).surface(&path, &format!("the top of \"{}\"", layer.material))?;
            let number = material(&layer.material, materials);
            numbers.push(number.map_err(|problem| here(k, "material", problem))?);
            let limit = tops.last().and_then(Relief::is_level);
            if let (Some(top), Some(limit), Some(above)) = (top.is_level(), limit, names.last())
                && top >= limit
            {
                let order = order(&layer.material, top, above, limit);
                return Err(here(k, "top", order));
            }
            tops.push(top);
            names.push(layer.material.clone());
        }
        let Some(last) = tops.last() else {
            return Err(at(&["geology", "layers"], GeologyProblem::NoLayer));
        };
        let bottom = section.bottom.si();
        if let Some(top) = last.is_level().filter(|top| bottom >= *top) {
            return Err(at(
                &["geology", "bottom"],
                GeologyProblem::Bottom { bottom, top },
            ));
        }
        tops.push(Relief::level(bottom));
        let mut layers = Self {
            materials: numbers,
            names,
            levels: Vec::new(),
            tops,
        };
        layers.require_order(ends)?;
        layers.levels = layers.references(fractures, ends);
        match layers.levels.windows(2).position(|pair| pair[1] >= pair[0]) {
            // bottom and top of the box apart, this is a layer that is nowhere
            Some(k) if k + 1 < layers.names.len() => {
                let (top, limit) = (layers.levels[k + 1], layers.levels[k]);
                let order = order(&layers.names[k + 1], top, &layers.names[k], limit);
                Err(here(k + 1, "top", order))
            }
            Some(k) => {
                let (bottom, top) = (bottom, layers.levels[k]);
                let path = ["geology", "bottom"];
                Err(at(&path, GeologyProblem::Bottom { bottom, top }))
            }
            None => Ok(layers),
        }
    }

    /// All tops are level.
    pub(super) fn are_level(&self) -> bool {
        self.tops.iter().all(|top| top.is_level().is_some())
    }

    /// Height within which two heights are one [m].
    pub(super) fn rounding(&self) -> f64 {
        let highest = |top: &Relief| top.range([[f64::NEG_INFINITY, f64::INFINITY]; 2])[1];
        let bottom = self.tops.last().and_then(Relief::is_level).unwrap_or(0.0);
        SAME * (highest(&self.tops[0]) - bottom).abs()
    }

    /// What a level is, for messages.
    pub(super) fn name(&self, k: usize) -> String {
        match self.names.get(k) {
            Some(name) => format!("the top of \"{name}\""),
            None => "`bottom`".into(),
        }
    }

    /// No top lies above the one before it anywhere in the box.
    fn require_order(&self, ends: [[f64; 2]; 2]) -> Result<(), Located> {
        let rounding = self.rounding();
        for (k, pair) in self.tops.windows(2).enumerate() {
            let [x, y] = [0, 1].map(|d| stops(pair, d, ends[d]));
            let points = y.iter().flat_map(|y| x.iter().map(|x| [*x, *y]));
            let thickness = |p: [f64; 2]| pair[0].at(p) - pair[1].at(p);
            let worst = points.min_by(|a, b| thickness(*a).total_cmp(&thickness(*b)));
            let Some(point) = worst.filter(|point| thickness(*point) < -rounding) else {
                continue;
            };
            let problem = GeologyProblem::TopsCross {
                upper: self.name(k),
                lower: self.name(k + 1),
                at: point,
                heights: [pair[0].at(point), pair[1].at(point)],
            };
            let number = (k + 1).to_string();
            let path: &[&str] = match k + 1 < self.names.len() {
                true => &["geology", "layers", &number, "top"],
                false => &["geology", "bottom"],
            };
            return Err(at(path, problem));
        }
        Ok(())
    }

    /// Levels of the grid at tops: those of level ones; the means of others along faults that offset layers, where these leave each layer half
    /// its mean thickness, else over the box.
    fn references(&self, fractures: &[FractureSection], ends: [[f64; 2]; 2]) -> Vec<f64> {
        let mut traces = Vec::new();
        for fracture in fractures {
            let axis = fracture.plane.map(AxisName::index).filter(|axis| *axis < 2);
            let moves = fracture.throw.as_ref().is_some_and(|t| t.si() != 0.0);
            let (Some(axis), Some(positions), true) = (axis, &fracture.at, moves) else {
                continue;
            };
            for position in positions.si() {
                let mut trace = ends;
                trace[axis] = [position; 2];
                traces.push(trace);
            }
        }
        let mean = |traces: &[[[f64; 2]; 2]]| -> Vec<f64> {
            let all = |top: &Relief| traces.iter().map(|trace| top.mean(*trace)).sum::<f64>();
            let of = |top: &Relief| top.is_level().unwrap_or(all(top) / traces.len() as f64);
            self.tops.iter().map(of).collect()
        };
        let whole = mean(&[ends]);
        let mut levels = whole.clone();
        if !traces.is_empty() {
            let along = mean(&traces);
            let thickness = |levels: &[f64], k: usize| levels[k] - levels[k + 1];
            let is_thick = |k: usize| thickness(&along, k) >= 0.5 * thickness(&whole, k);
            if (0..self.names.len()).all(is_thick) {
                levels = along;
            }
        }
        // a few digits will do
        let height = whole[0] - whole[whole.len() - 1];
        let step = 10f64.powf((height.log10() - 5.0).floor());
        let rounded = |z: f64| match step.is_normal() {
            true => (z / step).round() * step,
            false => z,
        };
        let known = self.tops.iter().map(Relief::is_level).zip(levels);
        known
            .map(|(level, mean)| level.unwrap_or(rounded(mean)))
            .collect()
    }

    /// Numbers of the highest top and the lowest base of the layers of these materials.
    pub(super) fn span(&self, names: &[String]) -> Result<[usize; 2], GeologyProblem> {
        let [mut first, mut last] = [usize::MAX, 0];
        for name in names {
            self.require(name)?;
            for k in (0..self.names.len()).filter(|k| self.names[*k] == *name) {
                first = first.min(k);
                last = last.max(k + 1);
            }
        }
        Ok([first, last])
    }

    /// How much lower level k lies at a point because of faults; the top and the bottom of the box stay [m].
    pub(super) fn offset(&self, k: usize, faults: &[Fault], point: [f64; 2]) -> f64 {
        match k == 0 || k == self.levels.len() - 1 {
            true => 0.0,
            false => faults.iter().map(|f| f.offset(k, point)).sum(),
        }
    }

    /// A layer has this material.
    pub(super) fn require(&self, name: &String) -> Result<(), GeologyProblem> {
        match self.names.contains(name) {
            true => Ok(()),
            false => Err(unknown("layer", name, &self.names)),
        }
    }
}

/// Layers out of order.
fn order(name: &str, top: f64, above: &str, limit: f64) -> GeologyProblem {
    GeologyProblem::Order {
        name: name.into(),
        top,
        above: above.into(),
        limit,
    }
}

/// Ends of an interval of x (0) or y (1), and where surfaces may bend in it, increasing [m].
pub(super) fn stops(tops: &[Relief], axis: usize, ends: [f64; 2]) -> Vec<f64> {
    let mut all: Vec<f64> = tops.iter().flat_map(|top| top.bends(axis, ends)).collect();
    all.extend(ends);
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
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
