//! Keys that would be read and change nothing, or less than they say.

use super::Problem;
use super::acting::require_time;
use super::located::{Located, at};
use super::sections::{MaterialSection, SceneSections};
use super::sides::require_alone;

/// Refuses keys that change nothing where they stand.
pub(super) fn require_used(sections: &SceneSections) -> Result<(), Located> {
    let idle = |path: [&str; 2], key: &'static str, what: String, without: &'static str| {
        at(
            &[path[0], path[1], key],
            Problem::Idle { key, what, without },
        )
    };
    require_densities(sections)?;
    for (i, m) in sections.material.iter().enumerate() {
        let given = [
            ("biot", m.biot.is_some()),
            ("pressure_history", m.pressure_history.is_some()),
        ];
        if m.viscosity.is_some() && sections.time.is_none() {
            let (what, place) = (format!("material \"{}\"", m.name), i.to_string());
            return Err(idle(["material", &place], "viscosity", what, "[time]"));
        }
        let stray = given.into_iter().find(|(key, given)| {
            let table = m.pore_pressure.is_some() && *key == "biot";
            *given && m.pressure_change.is_none() && !table
        });
        if m.isotropic_stress && sections.initial_stress.is_none() {
            let (what, place) = (format!("material \"{}\"", m.name), i.to_string());
            return Err(idle(
                ["material", &place],
                "isotropic_stress",
                what,
                "[initial_stress]",
            ));
        }
        let other = [
            ("pressure_change", m.pressure_change.is_some()),
            ("pressure_history", m.pressure_history.is_some()),
        ];
        let other = other.into_iter().find(|(_, given)| *given);
        if let (Some(_), Some((key, _))) = (&m.pore_pressure, other) {
            let name = m.name.clone();
            let path = ["material", &i.to_string(), key];
            return Err(at(&path, Problem::TwoPressures { name, key }));
        }
        if let Some((key, _)) = stray {
            let what = format!("material \"{}\"", m.name);
            return Err(idle(
                ["material", &i.to_string()],
                key,
                what,
                "pressure_change",
            ));
        }
    }
    for (i, f) in sections.fracture.iter().enumerate() {
        let of_geology = [
            ("dip", f.dip.is_some()),
            ("level", f.level.is_some()),
            ("throw", f.throw.is_some()),
            ("cuts", f.cuts.is_some()),
        ];
        if let Some((key, _)) = of_geology.into_iter().find(|(_, given)| *given) {
            let what = format!("fracture \"{}\"", f.name);
            return Err(idle(["fracture", &i.to_string()], key, what, "[geology]"));
        }
        if f.pressure_history.is_some() && !f.has_pressure() {
            let what = format!("fracture \"{}\"", f.name);
            let path = ["fracture", &i.to_string()];
            return Err(idle(path, "pressure_history", what, "pressure"));
        }
    }
    require_alone(sections)?;
    require_flow(sections)?;
    for (i, b) in sections.boundary.iter().enumerate() {
        if b.hold.is_some() && b.history.is_some() {
            let side = b.place();
            let path = ["boundary", &i.to_string(), "history"];
            return Err(at(&path, Problem::HeldHistory { side }));
        }
    }
    require_time(sections)
}

/// Refuses rock whose weight nobody knows, where gravity acts.
fn require_densities(sections: &SceneSections) -> Result<(), Located> {
    if sections.gravity.as_ref().is_none_or(|g| g.si() == [0.0; 3]) {
        return Ok(());
    }
    let without = |m: &MaterialSection| m.density.is_none();
    match sections.material.iter().position(without) {
        None => Ok(()),
        Some(i) => {
            let name = sections.material[i].name.clone();
            Err(at(
                &["material", &i.to_string()],
                Problem::NoDensity { name },
            ))
        }
    }
}

/// Refuses keys of a fluid where there is none, and what drives it where no time passes.
fn require_flow(sections: &SceneSections) -> Result<(), Located> {
    let idle = |path: &[&str], key: &'static str, what: String, without: &'static str| {
        at(path, Problem::Idle { key, what, without })
    };
    match &sections.fluid {
        Some(fluid) => {
            let what = || "[fluid]".to_string();
            if fluid.reference.is_some() && fluid.density.is_none() {
                return Err(idle(
                    &["fluid", "reference"],
                    "reference",
                    what(),
                    "density",
                ));
            }
            if fluid.density.is_some() && sections.gravity.is_none() {
                return Err(idle(&["fluid", "density"], "density", what(), "[gravity]"));
            }
            for (i, source) in sections.source.iter().enumerate() {
                let without = match (&source.level, &source.pressure, &fluid.density) {
                    (Some(_), None, _) => "pressure",
                    (Some(_), _, None) => "density",
                    _ => continue,
                };
                let path = ["source", &i.to_string(), "level"];
                return Err(idle(&path, "level", source.name(), without));
            }
        }
        None => {
            for (i, f) in sections.fracture.iter().enumerate() {
                let given = [
                    ("conductivity", f.conductivity.is_some()),
                    ("conductivity_along", f.conductivity_along.is_some()),
                    ("storage", f.storage.is_some()),
                    ("initial_pressure", f.initial_pressure.is_some()),
                ];
                if let Some((key, _)) = given.into_iter().find(|(_, given)| *given) {
                    let what = format!("fracture \"{}\"", f.name);
                    return Err(idle(
                        &["fracture", &i.to_string(), key],
                        key,
                        what,
                        "[fluid]",
                    ));
                }
            }
        }
    }
    let without = match (&sections.fluid, &sections.time) {
        (None, _) => "[fluid]",
        (Some(_), None) => "[time]",
        (Some(_), Some(_)) => return Ok(()),
    };
    match sections.source.first() {
        Some(source) => {
            let what = source.name();
            let key = match source.rate {
                Some(_) => "rate",
                None => "pressure",
            };
            Err(idle(&["source", "0"], key, what, without))
        }
        None => match sections.well.first() {
            Some(well) => {
                let what = format!("[[well]] \"{}\"", well.name);
                let key = match well.rate {
                    Some(_) => "rate",
                    None => "pressure",
                };
                Err(idle(&["well", "0"], key, what, without))
            }
            None => Ok(()),
        },
    }
}
