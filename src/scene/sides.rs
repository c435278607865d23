//! Pressures of fractures that follow the rock on their two sides.

use super::Body;
use super::located::{Located, at};
use super::sections::SceneSections;
use super::{FractureSection, PoreField, Problem, Profile};
use crate::mesh::{FractureFace, FractureMesh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// What the pressure in a face is made of: the changes of pore pressure in the elements on its two sides. Rock without one does not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PressureFrom {
    /// Their mean.
    Mean,
    /// The larger one: the smaller drawdown, or the larger rise.
    Larger,
}

impl PressureFrom {
    /// Of what changes on both sides [Pa].
    fn of(self, [minus, plus]: [f64; 2]) -> f64 {
        match self {
            Self::Mean => 0.5 * (minus + plus),
            Self::Larger => minus.max(plus),
        }
    }
}

impl fmt::Display for PressureFrom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean => "the mean",
            Self::Larger => "the larger one",
        })
    }
}

/// Refuses a pressure of its own, or one of a fluid that flows, beside one that follows the rock.
pub(super) fn require_alone(sections: &SceneSections) -> Result<(), Located> {
    let following = (sections.fracture.iter().enumerate())
        .filter(|(_, fracture)| fracture.pressure_from.is_some());
    for (i, fracture) in following {
        let other = match (fracture.has_pressure(), &sections.fluid) {
            (true, _) => "`pressure`",
            (false, Some(_)) => "the pressure of [fluid]",
            (false, None) => continue,
        };
        let name = fracture.name.clone();
        let path = ["fracture", &i.to_string(), "pressure_from"];
        return Err(at(&path, Problem::TwoFluids { name, other }));
    }
    Ok(())
}

/// Refuses a fracture beside which no pore pressure changes.
pub(super) fn require_change(
    body: &Body,
    sections: &[FractureSection],
    section_of: &[usize],
) -> Result<(), Located> {
    for (i, fracture) in sections.iter().enumerate() {
        let own = |face: &&FractureFace| section_of[usize::from(face.fracture)] == i;
        let changes = |face: &FractureFace| {
            let sides = [face.minus.element, face.plus.element];
            sides.iter().any(|e| body.has_change(*e))
        };
        let mut faces = body.fractures.faces.iter().filter(own);
        if fracture.pressure_from.is_some() && !faces.any(changes) {
            let name = fracture.name.clone();
            let path = ["fracture", &i.to_string(), "pressure_from"];
            return Err(at(&path, Problem::NoChangeBeside { name }));
        }
    }
    Ok(())
}

impl Body {
    /// Whether the pore pressure of an element may change.
    fn has_change(&self, element: u32) -> bool {
        let region = usize::from(self.mesh.regions[element as usize]);
        let in_space = self.pore_fields.iter().any(|field| field.region == region);
        in_space || self.pore_changes[region].change != 0.0
    }

    /// Changes of pore pressure in elements at a time [s].
    pub(crate) fn pore_changes_at(&self, time: f64) -> PoreChanges<'_> {
        PoreChanges {
            body: self,
            fields: self
                .pore_fields
                .iter()
                .map(|field| field.at(time))
                .collect(),
            factors: self
                .histories
                .iter()
                .map(|history| history.at(time))
                .collect(),
        }
    }

    /// Pressures of the faces whose fractures follow the rock on their two sides [Pa], 0 of others, at a time [s]; `None` where no fracture
    /// does.
    pub fn pressures_of_sides(&self, time: f64) -> Option<Vec<f64>> {
        self.follows_sides()
            .then(|| self.of_sides(&self.pore_changes_at(time)))
    }

    /// Given pressures of fractures in which they may differ from face to face [Pa], 0 of others, at a time [s]; `None` where there is none.
    pub(crate) fn uneven_pressures(&self, time: f64) -> Option<Vec<f64>> {
        let mut all = self.pressures_of_sides(time);
        let is_uneven = |profile: &Profile<f64>| profile.range()[0] < profile.range()[1];
        if self.pressures.iter().any(|(profile, _)| is_uneven(profile)) {
            let all = all.get_or_insert_with(|| vec![0.0; self.fractures.faces.len()]);
            for (p, face) in all.iter_mut().zip(&self.fractures.faces) {
                let (profile, history) = &self.pressures[usize::from(face.fracture)];
                if is_uneven(profile) {
                    *p += self.pressure_of(face) * self.histories[*history].at(time);
                }
            }
        }
        all
    }

    /// [`pressures_of_sides`](Self::pressures_of_sides) with every uniform change at the factor 1 of its history, and no others.
    pub(crate) fn pressures_of_sides_at_once(&self) -> Option<Vec<f64>> {
        let none = |field: &PoreField| vec![0.0; field.elements.len()].into();
        let at_once = || PoreChanges {
            body: self,
            fields: self.pore_fields.iter().map(none).collect(),
            factors: vec![1.0; self.histories.len()],
        };
        self.follows_sides().then(|| self.of_sides(&at_once()))
    }

    /// True where some fracture's pressure follows the rock on its two sides.
    fn follows_sides(&self) -> bool {
        self.pressures_from.iter().any(Option::is_some)
    }

    fn of_sides(&self, changes: &PoreChanges<'_>) -> Vec<f64> {
        let of = |face: &FractureFace| {
            let sides = [face.minus.element, face.plus.element];
            let rule = self.pressures_from[usize::from(face.fracture)];
            rule.map_or(0.0, |rule| rule.of(sides.map(|e| changes.of(e))))
        };
        self.fractures.faces.iter().map(of).collect()
    }
}

/// Changes of pore pressure in elements at a time.
pub(crate) struct PoreChanges<'b> {
    body: &'b Body,
    /// Per field and element of it [Pa].
    fields: Vec<Arc<[f64]>>,
    /// Of the histories. Unit: 1.
    factors: Vec<f64>,
}

impl PoreChanges<'_> {
    /// Δp in an element [Pa].
    ///
    /// # Cost
    /// A search among the fields, and among the elements of one.
    pub(crate) fn of(&self, element: u32) -> f64 {
        let region = self.region(element);
        let mut fields = self.body.pore_fields.iter().zip(&self.fields);
        match fields.find(|(field, _)| field.region == region) {
            Some((field, changes)) => {
                let place = field.elements.binary_search(&element);
                place.map_or(0.0, |place| changes[place])
            }
            None => {
                let pores = &self.body.pore_changes[region];
                pores.change * self.factors[pores.history]
            }
        }
    }

    /// α Δp in an element [Pa].
    pub(crate) fn drained(&self, element: u32) -> f64 {
        self.body.pore_changes[self.region(element)].biot * self.of(element)
    }

    fn region(&self, element: u32) -> usize {
        usize::from(self.body.mesh.regions[element as usize])
    }
}

/// The least and the largest of such numbers on the faces of each fracture; `None` where it has no face.
pub(super) fn ranges(fractures: &FractureMesh, numbers: &[f64]) -> Vec<Option<[f64; 2]>> {
    let mut all: Vec<Option<[f64; 2]>> = vec![None; fractures.names.len()];
    for (face, p) in fractures.faces.iter().zip(numbers) {
        let own = &mut all[usize::from(face.fracture)];
        let [low, high] = own.unwrap_or([*p; 2]);
        *own = Some([low.min(*p), high.max(*p)]);
    }
    all
}
