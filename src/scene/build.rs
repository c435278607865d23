//! From sections to a body.

use std::collections::HashSet;
use std::path::Path;

use super::flow::fluid;
use super::from_file::{mesh_from_file, require_grid_keys};
use super::geometry::{axis, expand, regions, warps};
use super::history::Histories;
use super::hold::hold;
use super::located::{Located, at};
use super::mesh_sections::AxisName;
use super::onset::onset;
use super::pores;
use super::profile;
use super::rocks::{elastic, viscosities};
use super::sections::SceneSections;
use super::sides::require_change;
use super::source::Source;
use super::used::require_used;
use super::{
    Body, InitialStress, Method, PoreChange, Problem, SceneError, SolverSection, TimeTable,
    WeightStress,
};
use crate::contact::Rocks;
use crate::elasticity::{Constraints, Elastic};
use crate::mesh::{BoxGrid, BuiltMesh, Hold, MAX_NODES, MeshError, bodies};
use crate::units::Measure;

/// Builds the body; problems get their place in the file.
pub(super) fn build(
    sections: &SceneSections,
    source: &Source,
    folder: &Path,
) -> Result<Body, SceneError> {
    let body = assemble(sections, folder).map_err(|located| placed(located, source))?;
    let parts = bodies(&body.mesh, &body.fractures, &body.prescribed());
    for (number, part) in parts.iter().enumerate() {
        if let Hold::Nothing { free } = part.hold {
            return Err(SceneError::NotHeld {
                body: number,
                elements: part.elements,
                center: part.center,
                free,
                free_axes: part.free_axes,
            });
        }
    }
    Ok(body)
}

/// A problem with its place in the file.
pub(super) fn placed(located: Located, source: &Source) -> SceneError {
    let path: Vec<&str> = located.path.iter().map(String::as_str).collect();
    SceneError::Section {
        place: Box::new(source.locate(&path)),
        problem: located.problem,
    }
}

fn assemble(sections: &SceneSections, folder: &Path) -> Result<Body, Located> {
    if sections.material.is_empty() {
        return Err(at(&["material"], Problem::NoMaterial));
    }
    unique(
        "material",
        "materials",
        sections.material.iter().map(|m| &m.name),
    )?;
    unique(
        "fracture",
        "fractures",
        sections.fracture.iter().map(|f| &f.name),
    )?;

    let (built, section_of) = match &sections.mesh.file {
        Some(file) => (
            mesh_from_file(sections, &folder.join(file))?,
            (0..sections.fracture.len()).collect(),
        ),
        None => mesh_of_grid(sections)?,
    };

    require_used(sections)?;
    let mut histories = Histories::new();
    let (time, of_time) = time_table(sections, &mut histories)?;
    let onset = onset(sections, &built.fractures)?;
    let (prescribed, tractions) = hold(&sections.boundary, &built, |i, boundary| {
        let path = ["boundary", &i.to_string(), "history"];
        histories.number(boundary.history.as_ref(), &path, of_time)
    })?;
    let (constraints, prescribed_histories) = constraints(3 * built.mesh.nodes.len(), prescribed);
    let mut pressures = Vec::with_capacity(section_of.len());
    for i in &section_of {
        let fracture = &sections.fracture[*i];
        let path = ["fracture", &i.to_string(), "pressure_history"];
        let history = histories.number(fracture.pressure_history.as_ref(), &path, of_time)?;
        pressures.push((profile::pressure(*i, fracture)?, history));
    }
    let pore_changes = pore_changes(sections, &mut histories, of_time)?;
    let friction = section_of
        .iter()
        .map(|i| profile::friction(*i, &sections.fracture[*i]))
        .collect::<Result<_, _>>()?;
    let gravity = sections.gravity.as_ref().map_or([0.0; 3], |g| g.si());
    let of_fluid = (&mut histories, of_time);
    let fluid = fluid(sections, &built, &section_of, gravity, of_fluid)?;
    let extra = sections.body_force.as_ref().map_or([0.0; 3], |f| f.si());
    let densities: Vec<f64> = sections
        .material
        .iter()
        .map(|m| m.density.as_ref().map_or(0.0, Measure::si))
        .collect();
    let weight = sections
        .initial_stress
        .as_ref()
        .and_then(|s| s.weight.as_ref());
    let weight_stress = weight
        .map(|section| WeightStress::new(section, sections, &built.mesh, &densities))
        .transpose()?;
    let afloat = weight
        .and_then(|w| w.fluid.as_ref())
        .map_or(0.0, Measure::si);
    let materials: Vec<Elastic> = sections.material.iter().map(elastic).collect();
    let viscosities = viscosities(sections, time)?;
    let isotropic: Vec<bool> = (sections.material.iter())
        .map(|m| m.isotropic_stress)
        .collect();
    let pressed = |i: usize| {
        let pores = &pore_changes[i];
        Some((pores.drained(), pores.history)).filter(|(drained, _)| *drained != 0.0)
    };
    let alike = |i: usize, j: usize| {
        materials[i] == materials[j]
            && viscosities[i] == viscosities[j]
            && isotropic[i] == isotropic[j]
            && pressed(i) == pressed(j)
            && pores::alike(&sections.material[i], &sections.material[j])
    };
    let body = Body {
        first_alike: Rocks::first_alike(materials.len(), alike),
        pore_fields: pores::fields(sections, &built.mesh, folder)?,
        weight_stress,
        mesh: built.mesh,
        fractures: built.fractures,
        friction,
        material_names: sections.material.iter().map(|m| m.name.clone()).collect(),
        materials,
        body_force: densities
            .iter()
            .map(|rho| [0, 1, 2].map(|d: usize| (rho - afloat) * gravity[d] + extra[d]))
            .collect(),
        densities,
        viscosities,
        isotropic,
        constraints,
        prescribed_histories,
        tractions,
        pressures,
        pressures_from: (section_of.iter())
            .map(|i| sections.fracture[*i].pressure_from)
            .collect(),
        pore_changes,
        fluid,
        gaps: section_of
            .iter()
            .map(|i| sections.fracture[*i].gap.as_ref().map_or(0.0, Measure::si))
            .collect(),
        histories: histories.0,
        time,
        onset,
        solver: solver(sections)?,
        initial_stress: sections.initial_stress.as_ref().map(|s| InitialStress {
            constant: s.constant.as_ref().map_or([0.0; 6], |c| c.si()),
            gradient: s.gradient.as_ref().map_or([0.0; 6], |g| g.si()),
            reference: s.reference.as_ref().map_or(0.0, Measure::si),
        }),
    };
    require_change(&body, &sections.fracture, &section_of)?;
    Ok(body)
}

/// Changes of pore pressure of materials, as far as they are the same all over each.
fn pore_changes(
    sections: &SceneSections,
    histories: &mut Histories,
    of_time: usize,
) -> Result<Vec<PoreChange>, Located> {
    let mut all = Vec::with_capacity(sections.material.len());
    for (i, material) in sections.material.iter().enumerate() {
        let number = i.to_string();
        let path = ["material", &number, "pressure_history"];
        let history = histories.number(material.pressure_history.as_ref(), &path, of_time)?;
        let mut own = PoreChange {
            change: material.pressure_change.as_ref().map_or(0.0, Measure::si),
            biot: material.biot.as_ref().map_or(1.0, Measure::si),
            history,
        };
        if let Some(table) = &material.pore_pressure {
            let path = ["material", &number, "pore_pressure"];
            let change = table.history(&material.name).map_err(|e| at(&path, e))?;
            // the history is in Pa
            (own.change, own.history) = match change {
                Some(change) => (1.0, histories.number_of(change)),
                None => (0.0, Body::ALWAYS),
            };
        }
        all.push(own);
    }
    Ok(all)
}

/// The mesh of a grid, and the section of every fracture in it.
fn mesh_of_grid(sections: &SceneSections) -> Result<(BuiltMesh, Vec<usize>), Located> {
    require_grid_keys(sections)?;
    let mesh = &sections.mesh;
    // before the lines of an axis take memory
    let nodes = mesh.nodes();
    if nodes > MAX_NODES {
        return Err(at(&["mesh"], MeshError::TooManyNodes { nodes }));
    }
    let axes = [
        axis(&mesh.x, "x")?,
        axis(&mesh.y, "y")?,
        axis(&mesh.z, "z")?,
    ];
    let mut lines: [Vec<f64>; 3] = Default::default();
    for d in 0..3 {
        lines[d] = axes[d]
            .lines(d)
            .map_err(|e| at(&["mesh", ["x", "y", "z"][d]], e))?;
    }
    let center = [0, 1, 2].map(|d: usize| 0.5 * (lines[d][0] + lines[d][lines[d].len() - 1]));

    // every expanded plane remembers its section
    let (mut planes, mut section_of) = (Vec::new(), Vec::new());
    for (i, fracture) in sections.fracture.iter().enumerate() {
        let expanded = expand(fracture, i, &lines)?;
        section_of.resize(section_of.len() + expanded.len(), i);
        planes.extend(expanded);
    }
    let grid = BoxGrid {
        axes,
        regions: regions(sections)?,
        fractures: planes,
        warps: match &mesh.map {
            Some(map) => warps(map, center)?,
            None => Vec::new(),
        },
    };
    let built = grid
        .build()
        .map_err(|e| locate(e, &grid, &section_of, sections))?;
    Ok((built, section_of))
}

/// All names of a list differ.
fn unique<'a>(
    key: &str,
    what: &'static str,
    names: impl Iterator<Item = &'a String>,
) -> Result<(), Located> {
    let mut seen = HashSet::new();
    for (i, name) in names.enumerate() {
        if !seen.insert(name) {
            let name = name.clone();
            return Err(at(
                &[key, &i.to_string(), "name"],
                Problem::DuplicateName { what, name },
            ));
        }
    }
    Ok(())
}

/// Of several values for one displacement the last one counts, with its history.
pub(super) fn constraints(
    n: usize,
    mut prescribed: Vec<(u32, f64, usize)>,
) -> (Constraints, Vec<usize>) {
    prescribed.reverse();
    prescribed.sort_by_key(|(dof, ..)| *dof);
    prescribed.dedup_by_key(|(dof, ..)| *dof);
    let histories = prescribed.iter().map(|(.., history)| *history).collect();
    let values = prescribed.into_iter().map(|(dof, u, _)| (dof, u)).collect();
    (Constraints::of_list(n, values), histories)
}

/// Steps in time and the number of the history of loads without their own.
fn time_table(
    sections: &SceneSections,
    histories: &mut Histories,
) -> Result<(Option<TimeTable>, usize), Located> {
    let Some(time) = &sections.time else {
        return Ok((None, Body::ALWAYS));
    };
    if time.end.si() <= 0.0 {
        return Err(at(&["time", "end"], Problem::NoTime));
    }
    let table = TimeTable {
        end: time.end.si(),
        steps: time.steps.get(),
    };
    let path = ["time", "history"];
    Ok((
        Some(table),
        histories.number(time.history.as_ref(), &path, Body::ALWAYS)?,
    ))
}

/// Settings of the solver, checked.
fn solver(sections: &SceneSections) -> Result<SolverSection, Located> {
    let solver = sections.solver.unwrap_or_default();
    let share = |v: f64| v > 0.0 && v < 1.0;
    let (factor, updates) = match solver.method {
        Method::Lagrange => (1.0, 1),
        Method::Penalty(penalty) => (penalty.factor, 1),
        Method::AugmentedLagrangian(method) => (method.factor, method.max_updates),
    };
    for (key, value, admitted, requirement) in [
        (
            "tolerance",
            solver.tolerance,
            share(solver.tolerance),
            "more than 0 and less than 1",
        ),
        (
            "state_tolerance",
            solver.state_tolerance,
            share(solver.state_tolerance),
            "more than 0 and less than 1",
        ),
        (
            "max_active",
            solver.max_active as f64,
            solver.max_active > 0,
            "at least 1",
        ),
        (
            "max_newton",
            solver.max_newton as f64,
            solver.max_newton > 0,
            "at least 1",
        ),
        (
            "max_krylov",
            solver.max_krylov as f64,
            solver.max_krylov > 0,
            "at least 1",
        ),
        (
            "factor",
            factor,
            factor > 0.0 && factor.is_finite(),
            "more than 0",
        ),
        ("max_updates", updates as f64, updates > 0, "at least 1"),
    ] {
        if !admitted {
            let problem = Problem::SolverValue {
                key,
                value,
                requirement,
            };
            let place = match key {
                "factor" | "max_updates" => "method",
                key => key,
            };
            return Err(at(&["solver", place], problem));
        }
    }
    Ok(solver)
}

/// Letters of the axes in order.
const AXES: &str = "xyz";

/// Where a mesh error is written.
fn locate(
    error: MeshError,
    grid: &BoxGrid,
    section_of: &[usize],
    sections: &SceneSections,
) -> Located {
    let fracture = |name: &str, key: Option<char>| {
        let Some(index) = grid.fractures.iter().position(|f| f.name == name) else {
            return vec!["fracture".to_string()];
        };
        let section = section_of[index];
        let mut path = vec!["fracture".to_string(), section.to_string()];
        match key {
            Some(axis)
                if sections.fracture[section].plane.map(AxisName::index) != AXES.find(axis) =>
            {
                path.push(axis.into())
            }
            Some(_) => path.push("at".into()),
            None => {}
        }
        path
    };
    let path = match &error {
        MeshError::OffGrid {
            fracture: f, axis, ..
        }
        | MeshError::OutsideBox {
            fracture: f, axis, ..
        }
        | MeshError::OnBoundary {
            fracture: f, axis, ..
        }
        | MeshError::SelectsNothing {
            fracture: f, axis, ..
        } => fracture(f, Some(*axis)),
        MeshError::Overlap { second, .. } => fracture(second, None),
        MeshError::EmptyRegion { region } => {
            let index = sections.material.iter().position(|m| m.name == *region);
            vec!["material".into(), index.unwrap_or(0).to_string()]
        }
        MeshError::NoRegion { .. } => vec!["material".into(), "0".into()],
        MeshError::Inverted { .. } => vec!["mesh".into(), "map".into()],
        MeshError::SurfacesMeet { .. } => vec!["mesh".into(), "map".into(), "lift".into()],
        MeshError::BadWarp { map, .. } => vec!["mesh".into(), "map".into(), (*map).into()],
        _ => vec!["mesh".into()],
    };
    Located {
        path,
        problem: Box::new(error.into()),
    }
}
