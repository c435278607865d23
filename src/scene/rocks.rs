//! Elastic constants and viscosities of the materials of a scene.

use super::located::{Located, at};
use super::sections::{MaterialSection, SceneSections};
use super::{Problem, TimeTable};
use crate::creep::LONGEST;
use crate::elasticity::Elastic;
use crate::units::Measure;

/// Those of a material.
pub(super) fn elastic(material: &MaterialSection) -> Elastic {
    Elastic {
        young: material.young.si(),
        poisson: material.poisson.si(),
    }
}

/// Viscosities of the materials, checked against the steps.
pub(super) fn viscosities(
    sections: &SceneSections,
    time: Option<TimeTable>,
) -> Result<Vec<Option<f64>>, Located> {
    let step = time.map_or(0.0, |t| t.end / f64::from(t.steps));
    let checked = |(i, m): (usize, &MaterialSection)| {
        let Some(viscosity) = m.viscosity.as_ref().map(Measure::si) else {
            return Ok(None);
        };
        let rock = elastic(m);
        let relaxation = viscosity / rock.shear();
        if step <= LONGEST * relaxation {
            return Ok(Some(viscosity));
        }
        let problem = Problem::Flows {
            name: m.name.clone(),
            relaxation,
            step,
            least: step * rock.shear() / LONGEST,
        };
        Err(at(&["material", &i.to_string(), "viscosity"], problem))
    };
    sections.material.iter().enumerate().map(checked).collect()
}
