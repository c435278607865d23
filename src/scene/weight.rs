//! The initial stress of rock under its own weight.

use super::Problem;
use super::located::{Located, at};
use super::sections::SceneSections;
use super::weight_above::WeightAbove;
use crate::mesh::HexMesh;
use crate::units::{Density, Measure, Ratio};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// σ_v from the densities above, σ_xx and σ_yy as shares of it; needs `[gravity]` along z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeightSection {
    /// `[σ_xx/σ_v, σ_yy/σ_v]`.
    pub horizontal: [Measure<Ratio>; 2],
    /// Density of the fluid in the pores, hydrostatic from the top: stress is then the effective one, and rock weighs less by it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<Measure<Density>>,
}

/// σ_v of the rock above, and the shares of the horizontal stresses.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightStress {
    vertical: Vertical,
    horizontal: [f64; 2],
}

/// σ_v of the rock above.
#[derive(Clone, Debug, PartialEq)]
enum Vertical {
    /// (z [m], σ_v [Pa]), z increasing, straight between the levels of the mesh.
    Levels(Vec<(f64, f64)>),
    /// Point by point.
    Above(WeightAbove),
}

impl WeightStress {
    /// σ0 at a point [Pa].
    pub fn at(&self, point: [f64; 3]) -> [f64; 6] {
        let vertical = match &self.vertical {
            Vertical::Levels(levels) => {
                let z = point[2];
                let last = levels.len() - 1;
                let above = levels
                    .partition_point(|(level, _)| *level <= z)
                    .clamp(1, last);
                let ((z0, s0), (z1, s1)) = (levels[above - 1], levels[above]);
                s0 + (s1 - s0) * (z - z0) / (z1 - z0)
            }
            Vertical::Above(rock) => rock.at(point),
        };
        let [x, y] = self.horizontal.map(|share| share * vertical);
        [x, y, vertical, 0.0, 0.0, 0.0]
    }

    /// True where it may jump at a side of an element, so that a point on it has two values.
    pub(super) fn jumps(&self) -> bool {
        matches!(self.vertical, Vertical::Above(_))
    }

    /// Integrates densities [kg/m³] from the top down, where elements are level each the mean over a level of the mesh, elsewhere point by
    /// point: rock is in equilibrium where layers are level; where they are not, the equilibrium at time 0 makes up for the difference.
    pub(super) fn new(
        section: &WeightSection,
        sections: &SceneSections,
        mesh: &HexMesh,
        densities: &[f64],
    ) -> Result<Self, Located> {
        let place = ["initial_stress", "weight"];
        let gravity = sections.gravity.as_ref().map_or([0.0; 3], |g| g.si());
        let is_vertical = gravity[2] != 0.0 && gravity[..2] == [0.0; 2];
        let fluid = section.fluid.as_ref().map_or(0.0, Measure::si);
        let horizontal = [0, 1].map(|k: usize| section.horizontal[k].si());
        if !is_vertical {
            return Err(at(&place, Problem::NoWeight));
        }
        let Some(lines) = levels(mesh) else {
            let weights: Vec<f64> = densities
                .iter()
                .map(|rho| (rho - fluid) * gravity[2])
                .collect();
            let regions = mesh
                .regions
                .iter()
                .map(|region| densities[usize::from(*region)]);
            let mut elements = regions.enumerate();
            if let Some((e, rock)) = elements.find(|(_, rho)| *rho < fluid * (1.0 - CLOSE)) {
                let [from, to] = reach(mesh, e).map(|z| (1e3 * z).round() / 1e3);
                let lifted = Problem::Lifted {
                    from,
                    to,
                    rock,
                    fluid,
                };
                return Err(at(&["initial_stress", "weight", "fluid"], lifted));
            }
            return Ok(Self {
                vertical: Vertical::Above(WeightAbove::new(mesh, &weights)),
                horizontal,
            });
        };
        let mut sums = vec![[0.0; 2]; lines.len() - 1];
        for (e, region) in mesh.regions.iter().enumerate() {
            let [low, high] = reach(mesh, e);
            let first = lines.partition_point(|line| *line <= low - CLOSE * (high - low));
            let area = mesh.element_volume(e) / (high - low);
            let layers = lines[first..].windows(2).zip(&mut sums[first..]);
            for (line, sum) in layers.take_while(|(line, _)| 0.5 * (line[0] + line[1]) < high) {
                let volume = area * (line[1] - line[0]);
                sum[0] += volume * densities[usize::from(*region)];
                sum[1] += volume;
            }
        }
        let mut levels = vec![(lines[lines.len() - 1], 0.0)];
        let mut stress = 0.0;
        for (k, [mass, volume]) in sums.iter().enumerate().rev() {
            let rock = mass / volume;
            if rock < fluid * (1.0 - CLOSE) {
                let [from, to] = [k, k + 1].map(|k| (1e3 * lines[k]).round() / 1e3);
                let lifted = Problem::Lifted {
                    from,
                    to,
                    rock,
                    fluid,
                };
                return Err(at(&["initial_stress", "weight", "fluid"], lifted));
            }
            stress += (rock - fluid) * gravity[2] * (lines[k + 1] - lines[k]);
            levels.push((lines[k], stress));
        }
        levels.reverse();
        let vertical = Vertical::Levels(levels);
        Ok(Self {
            vertical,
            horizontal,
        })
    }
}

/// Share of the height of an element within which two heights are one, and of a density within which two are. Unit: 1.
const CLOSE: f64 = 1e-6;

/// Lowest and highest z of an element [m].
fn reach(mesh: &HexMesh, e: usize) -> [f64; 2] {
    let z = mesh.elements[e].map(|a| mesh.nodes[a as usize][2]);
    let of = |f: fn(f64, f64) -> f64| z.into_iter().reduce(f).unwrap_or(0.0);
    [of(f64::min), of(f64::max)]
}

/// Heights of the tops and bottoms of elements, increasing; `None` where one of these is not level.
fn levels(mesh: &HexMesh) -> Option<Vec<f64>> {
    let mut all = Vec::with_capacity(2 * mesh.elements.len());
    let mut thinnest = f64::INFINITY;
    for (e, nodes) in mesh.elements.iter().enumerate() {
        let [low, high] = reach(mesh, e);
        let close =
            |a: &u32, b: f64| (mesh.nodes[*a as usize][2] - b).abs() <= CLOSE * (high - low);
        let tops = nodes.iter().filter(|a| close(a, high)).count();
        let bottoms = nodes.iter().filter(|a| close(a, low)).count();
        if (tops, bottoms) != (4, 4) {
            return None;
        }
        thinnest = thinnest.min(high - low);
        all.extend([low, high]);
    }
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() <= CLOSE * thinnest);
    Some(all)
}
