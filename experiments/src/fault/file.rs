//! A fault file: rock, fault, reservoir, stress, friction, pressure.

use super::blocks::{BlockSection, polygons};
use super::uncertain::{Given, SamplingSection};
use anyhow::{Context, ensure};
use fracas::analytic::{
    Depletion, DisplacedFault, FarStress, FaultLine, FaultPressure, FaultStrength, LinearWeakening,
    Rock, displaced_blocks,
};
use fracas::scene::read_toml;
use fracas::units::{
    Angle, BiotCoefficient, Distance, Kind, Length, Measure, Poisson, Ratio, Stiffness, Strength,
    Stress, StressGradient,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A straight fault between depleting blocks, in plane strain; heights are counted from its middle, upwards.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FaultFile {
    /// Heading.
    pub title: String,
    rock: RockSection,
    fault: FaultSection,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reservoir: Option<ReservoirSection>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    block: Vec<BlockSection>,
    stress: StressSection,
    friction: FrictionSection,
    /// How the pressure changes.
    pub pressure: PressureSection,
    /// What is uncertain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampling: Option<SamplingSection>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct RockSection {
    young: Measure<Stiffness>,
    poisson: Measure<Poisson>,
    biot: Measure<BiotCoefficient>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct FaultSection {
    dip: Measure<Angle>,
    from: Measure<Length>,
    to: Measure<Length>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    elements: Option<usize>,
}

/// Elements of a fault that does not weaken, and the fewest of one that does.
const ELEMENTS: usize = 400;

/// Elements within the half-length at which slip runs away.
const RESOLVED: f64 = 10.0;

/// Elements within what slides in the end: n of them know sums to 4/n, mostly better. Unit: 1; measured on 150 random faults.
const SLIDING: f64 = 50.0;

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct ReservoirSection {
    thickness: Measure<Length>,
    throw: Measure<Length>,
    #[serde(default = "width")]
    width: Measure<Length>,
}

/// Wide enough to have no end: 20 km.
fn width() -> Measure<Length> {
    measure("20 km")
}

/// A quantity that stands in this file.
fn measure<K: Kind>(text: &str) -> Measure<K> {
    match text.parse() {
        Ok(value) => value,
        Err(_) => unreachable!("{text} is a quantity"),
    }
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct StressSection {
    depth: Measure<Length>,
    vertical: Measure<StressGradient>,
    horizontal_ratio: Measure<Ratio>,
    pore_pressure: Measure<StressGradient>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct FrictionSection {
    #[serde(rename = "static")]
    at_rest: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    dynamic: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    critical_slip: Option<Measure<Distance>>,
    #[serde(default = "none")]
    cohesion: Measure<Strength>,
}

fn none<K: Kind>() -> Measure<K> {
    measure("0")
}

/// `[pressure]`
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PressureSection {
    change: Measure<Stress>,
    /// Equal steps of the curve.
    #[serde(default = "steps")]
    pub steps: usize,
    #[serde(default)]
    in_fault: InFault,
}

fn steps() -> usize {
    60
}

/// Where the pressure of a block acts in the fault.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
enum InFault {
    #[default]
    Either,
    Mean,
    Both,
    Nowhere,
}

/// Most elements of a fault: the cost of a state grows with their third power.
pub const MOST_ELEMENTS: usize = 5_000;

impl FaultFile {
    /// Reads a file.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn load(path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Self::from_toml(&text, &name)
    }

    /// Reads a text; `name` is for messages.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn from_toml(text: &str, name: &str) -> anyhow::Result<Self> {
        let file: Self = read_toml(text, name)?;
        file.check().with_context(|| name.to_owned())?;
        Ok(file)
    }

    fn check(&self) -> anyhow::Result<()> {
        let dip = self.fault.dip.si();
        ensure!(
            dip > 0.0 && dip < std::f64::consts::PI,
            "fault.dip = {}: the dip lies between 0 and 180 deg, both excluded",
            self.fault.dip
        );
        ensure!(
            self.fault.from.si() < self.fault.to.si(),
            "fault.from = {} is not below fault.to = {}",
            self.fault.from,
            self.fault.to
        );
        let depth = self.stress.depth.si();
        ensure!(
            depth > self.fault.to.si(),
            "stress.depth = {}: the fault reaches {} above it, out of the ground",
            self.stress.depth,
            self.fault.to
        );
        for (key, elements) in [
            ("fault.elements", self.fault.elements),
            (
                "sampling.elements",
                self.sampling.as_ref().and_then(|s| s.elements),
            ),
        ] {
            let Some(elements) = elements else { continue };
            ensure!(
                (2..=MOST_ELEMENTS).contains(&elements),
                "{key} = {elements}: take from 2 to {MOST_ELEMENTS}"
            );
        }
        ensure!(
            self.pressure.steps > 0,
            "pressure.steps = 0: take one or more"
        );
        ensure!(
            self.pressure.change.si() != 0.0,
            "pressure.change = 0: nothing happens"
        );
        let p = &self.stress;
        ensure!(
            p.pore_pressure.si() >= 0.0 && p.vertical.si() > 0.0,
            "[stress]: vertical and pore_pressure grow with depth, so that vertical is positive and pore_pressure not negative"
        );
        self.blocks()?;
        let f = &self.friction;
        let weakest = f.dynamic.unwrap_or(f.at_rest);
        ensure!(
            f.at_rest.is_finite() && (0.0..=f.at_rest).contains(&weakest),
            "[friction]: static = {} and dynamic = {weakest}: coefficients are at least 0, and the dynamic one is not above the static one",
            f.at_rest
        );
        ensure!(
            f.dynamic.is_none() == f.critical_slip.is_none(),
            "[friction]: dynamic and critical_slip go together; give both, or neither for friction that does not weaken"
        );
        if f.critical_slip.as_ref().is_some_and(|d| d.si() == 0.0) {
            anyhow::bail!(
                "friction.critical_slip = 0: friction would fall at once; give a length above 0"
            );
        }
        if let Some(sampling) = &self.sampling {
            sampling.check(f.dynamic.is_some())?;
        }
        Ok(())
    }

    /// That the fault is in equilibrium before the pressure changes.
    ///
    /// # Errors
    /// Where it is not, and by how much.
    pub(super) fn rest(
        &self,
        fault: &DisplacedFault,
        strength: FaultStrength,
    ) -> anyhow::Result<()> {
        let Some(loose) = fault.loose(strength) else {
            return Ok(());
        };
        anyhow::bail!(
            "the fault is not in equilibrium before the pressure changes: at a height of {:.1} m it carries a shear traction of {:.3} MPa and can carry {:.3} MPa; raise friction.static or friction.cohesion, or bring stress.horizontal_ratio = {} nearer to 1",
            fault.along[loose.element] * fault.dip.sin(),
            loose.shear / 1e6,
            loose.limit / 1e6,
            self.stress.horizontal_ratio
        )
    }

    /// Polygons of the blocks, counter-clockwise [m].
    fn blocks(&self) -> anyhow::Result<Vec<Vec<[f64; 2]>>> {
        let dip = self.fault.dip.si();
        match (&self.reservoir, self.block.as_slice()) {
            (Some(r), []) => {
                let [thickness, throw, width] = [&r.thickness, &r.throw, &r.width].map(Measure::si);
                ensure!(
                    thickness > 0.0 && width > 0.0,
                    "[reservoir]: thickness and width are positive"
                );
                let reach = 0.5 * (thickness + throw.abs()) * (dip.cos() / dip.sin()).abs();
                ensure!(
                    width > reach,
                    "reservoir.width = {}: the fault leans over {reach:.1} m beside its middle, out of the block; take a greater width",
                    r.width
                );
                Ok(displaced_blocks(dip, thickness, throw, width))
            }
            (None, []) => anyhow::bail!("no [reservoir] and no [[block]]: give one of them"),
            (Some(_), _) => anyhow::bail!("[reservoir] and [[block]] exclude each other"),
            (None, blocks) => polygons(blocks),
        }
    }

    /// Δp at the end [Pa].
    pub fn change(&self) -> f64 {
        self.pressure.change.si()
    }

    /// What is asked, without uncertainty; elements that resolve the half-length at which slip runs away, and what slides in the end, unless
    /// the file has them.
    ///
    /// # Errors
    /// None once the file was read.
    pub(super) fn given(&self) -> anyhow::Result<Given> {
        let mut given = self.written();
        if self.fault.elements.is_some() {
            return Ok(given);
        }
        let length = (self.fault.to.si() - self.fault.from.si()) / self.fault.dip.si().sin();
        let half = nucleation(&self.build(&given)?, given.strength);
        let number = |piece: f64, within: f64| (within * length / piece).ceil() as usize;
        given.elements = number(half, RESOLVED).clamp(ELEMENTS, MOST_ELEMENTS);
        while given.elements < MOST_ELEMENTS {
            let fault = self.build(&given)?;
            let mut path = fault.path(given.strength);
            // where it runs away the last state before counts
            let _ = path.advance(1.0);
            let slides = path.state().slipping_length(fault.h);
            if slides == 0.0 || slides >= SLIDING * fault.h {
                break;
            }
            given.elements = number(slides, SLIDING)
                .max(2 * given.elements)
                .min(MOST_ELEMENTS);
        }
        Ok(given)
    }

    fn written(&self) -> Given {
        let f = &self.friction;
        Given {
            young: self.rock.young.si(),
            biot: self.rock.biot.si(),
            horizontal_ratio: self.stress.horizontal_ratio.si(),
            strength: FaultStrength {
                cohesion: f.cohesion.si(),
                static_friction: f.at_rest,
                dynamic_friction: f.dynamic.unwrap_or(f.at_rest),
                critical_slip: f.critical_slip.as_ref().map_or(0.0, Measure::si),
            },
            elements: self.fault.elements.unwrap_or(ELEMENTS),
        }
    }

    /// The fault under these.
    ///
    /// # Errors
    /// None once the file was read.
    pub(super) fn build(&self, given: &Given) -> anyhow::Result<DisplacedFault> {
        let rock = Rock {
            young: given.young,
            poisson: self.rock.poisson.si(),
        };
        let line = FaultLine {
            dip: self.fault.dip.si(),
            heights: [self.fault.from.si(), self.fault.to.si()],
            elements: given.elements,
        };
        let s = &self.stress;
        // σ_v = −γ (depth − z), tension positive
        let (depth, weight, fluid) = (s.depth.si(), s.vertical.si(), s.pore_pressure.si());
        let vertical = [-weight * depth, weight];
        let far = FarStress {
            vertical,
            horizontal: vertical.map(|v| v * given.horizontal_ratio),
            pressure: [fluid * depth, -fluid],
        };
        let depletion = Depletion {
            poisson: rock.poisson,
            biot: given.biot,
            pressure_change: self.change(),
        };
        let acting = match self.pressure.in_fault {
            InFault::Either => FaultPressure::Either,
            InFault::Mean => FaultPressure::Mean,
            InFault::Both => FaultPressure::Both,
            InFault::Nowhere => FaultPressure::Nowhere,
        };
        let blocks = self.blocks()?;
        Ok(DisplacedFault::new(
            rock,
            line,
            far,
            (&blocks, depletion),
            acting,
        ))
    }
}

/// Half-length at which slip runs away where the fault is pressed most before production [m]; infinite without weakening.
pub(super) fn nucleation(fault: &DisplacedFault, strength: FaultStrength) -> f64 {
    if strength.critical_slip == 0.0 {
        return f64::INFINITY;
    }
    let pressed = fault.tractions(0.0).fold(0.0f64, |m, t| m.max(-t[0]));
    let weakening = LinearWeakening {
        static_friction: strength.static_friction,
        dynamic_friction: strength.dynamic_friction,
        critical_slip: strength.critical_slip,
        normal_traction: -pressed,
    };
    weakening.nucleation_half_length(fault.rock)
}
