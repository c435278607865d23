//! What of a fault is uncertain.

use anyhow::ensure;
use fracas::analytic::FaultStrength;
use fracas::units::{BiotCoefficient, Distance, Kind, Measure, Ratio, Stiffness};
use serde::{Deserialize, Serialize};

/// `[sampling]`: independent, uniform between two values.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SamplingSection {
    /// How many.
    pub samples: usize,
    /// Of the random numbers.
    #[serde(default)]
    pub seed: u64,
    /// Elements of the fault, for a sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elements: Option<usize>,
    #[serde(rename = "static", default, skip_serializing_if = "Option::is_none")]
    at_rest: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    dynamic: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    critical_slip: Option<[Measure<Distance>; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    horizontal_ratio: Option<[Measure<Ratio>; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    biot: Option<[Measure<BiotCoefficient>; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    young: Option<[Measure<Stiffness>; 2]>,
}

/// Values of one sample.
#[derive(Clone, Debug)]
pub(super) struct Given {
    pub(super) young: f64,
    pub(super) biot: f64,
    pub(super) horizontal_ratio: f64,
    pub(super) strength: FaultStrength,
    pub(super) elements: usize,
}

impl SamplingSection {
    pub(super) fn check(&self, weakens: bool) -> anyhow::Result<()> {
        ensure!(self.samples > 0, "sampling.samples = 0: take one or more");
        let pairs = [
            ("static", self.at_rest),
            ("dynamic", self.dynamic),
            ("critical_slip", si(&self.critical_slip)),
            ("horizontal_ratio", si(&self.horizontal_ratio)),
            ("biot", si(&self.biot)),
            ("young", si(&self.young)),
        ];
        for (key, pair) in pairs {
            if let Some([low, high]) = pair {
                ensure!(
                    low.is_finite() && low >= 0.0 && low <= high,
                    "sampling.{key} = [{low}, {high}]: the first value is at least 0 and not above the second"
                );
            }
        }
        ensure!(
            weakens || (self.dynamic.is_none() && self.critical_slip.is_none()),
            "[sampling] varies how friction weakens, and [friction] has no dynamic and critical_slip"
        );
        ensure!(
            si(&self.critical_slip).is_none_or(|[low, _]| low > 0.0),
            "sampling.critical_slip begins at 0: friction would fall at once; begin above 0"
        );
        Ok(())
    }

    /// The given values with those that are uncertain drawn; `draw` is uniform in [0, 1). Dynamic friction is never above static.
    pub(super) fn drawn(&self, given: &Given, mut draw: impl FnMut() -> f64) -> Given {
        // every key takes its number, so that one more uncertain value leaves the others as they are
        let mut between = |pair: Option<[f64; 2]>, value: f64| {
            let share = draw();
            pair.map_or(value, |[low, high]| low + share * (high - low))
        };
        let s = given.strength;
        let static_friction = between(self.at_rest, s.static_friction);
        let dynamic_friction = between(self.dynamic, s.dynamic_friction).min(static_friction);
        Given {
            strength: FaultStrength {
                static_friction,
                dynamic_friction,
                critical_slip: between(si(&self.critical_slip), s.critical_slip),
                ..s
            },
            horizontal_ratio: between(si(&self.horizontal_ratio), given.horizontal_ratio),
            biot: between(si(&self.biot), given.biot),
            young: between(si(&self.young), given.young),
            elements: self.elements.unwrap_or(given.elements),
        }
    }
}

fn si<K: Kind>(pair: &Option<[Measure<K>; 2]>) -> Option<[f64; 2]> {
    pair.as_ref().map(|[low, high]| [low.si(), high.si()])
}
