//! From sections to a body.

use std::collections::HashSet;

use super::hold::hold;
use super::sections::{
    AxisName, AxisSection, BoxSection, FractureSection, InclineSection, MapSection, SceneSections,
};
use super::source::Source;
use super::{Body, Friction, InitialStress, Problem, SceneError};
use crate::elasticity::{Constraints, Elastic};
use crate::mesh::{
    Axis, BoxGrid, BoxRegion, Distort, Grading, Hold, Incline, MeshError, PlaneFracture, Rotate,
    Warp, bodies,
};
use crate::units::{Length, Measure};

/// A problem and the path of keys to where it is written.
pub(super) struct Located {
    pub(super) path: Vec<String>,
    pub(super) problem: Problem,
}

/// `problem` at a path.
pub(super) fn at(path: &[&str], problem: impl Into<Problem>) -> Located {
    Located {
        path: path.iter().map(|s| (*s).to_string()).collect(),
        problem: problem.into(),
    }
}

/// Builds the body; problems get their place in the file.
pub(super) fn build(sections: &SceneSections, source: &Source) -> Result<Body, SceneError> {
    let body = assemble(sections).map_err(|located| {
        let path: Vec<&str> = located.path.iter().map(String::as_str).collect();
        SceneError::Section {
            place: source.locate(&path),
            problem: located.problem,
        }
    })?;
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

fn assemble(sections: &SceneSections) -> Result<Body, Located> {
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

    let mesh = &sections.mesh;
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

    let (prescribed, tractions) = hold(&sections.boundary, &built)?;
    let gravity = sections.gravity.as_ref().map_or([0.0; 3], |g| g.si());
    let extra = sections.body_force.as_ref().map_or([0.0; 3], |f| f.si());
    let densities: Vec<f64> = sections
        .material
        .iter()
        .map(|m| m.density.as_ref().map_or(0.0, Measure::si))
        .collect();
    Ok(Body {
        mesh: built.mesh,
        fractures: built.fractures,
        friction: section_of
            .iter()
            .map(|i| friction(&sections.fracture[*i]))
            .collect(),
        material_names: sections.material.iter().map(|m| m.name.clone()).collect(),
        materials: sections
            .material
            .iter()
            .map(|m| Elastic {
                young: m.young.si(),
                poisson: m.poisson.si(),
            })
            .collect(),
        body_force: densities
            .iter()
            .map(|rho| [0, 1, 2].map(|d: usize| rho * gravity[d] + extra[d]))
            .collect(),
        densities,
        constraints: Constraints::new(prescribed),
        tractions,
        initial_stress: sections.initial_stress.as_ref().map(|s| InitialStress {
            constant: s.constant.as_ref().map_or([0.0; 6], |c| c.si()),
            gradient: s.gradient.as_ref().map_or([0.0; 6], |g| g.si()),
            reference: s.reference.as_ref().map_or(0.0, Measure::si),
        }),
    })
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

fn axis(section: &AxisSection, name: &'static str) -> Result<Axis, Located> {
    let keys = || at(&["mesh", name], Problem::AxisKeys { axis: name });
    match (&section.from, &section.to, section.cells, &section.lines) {
        (None, None, None, Some(lines)) if section.ratio.is_none() && section.toward.is_none() => {
            Ok(Axis::Lines(lines.iter().map(Measure::si).collect()))
        }
        (Some(from), Some(to), Some(cells), None) => Ok(Axis::Cells {
            from: from.si(),
            to: to.si(),
            cells: cells.get() as usize,
            grading: match (&section.ratio, &section.toward) {
                (None, None) => Grading::Uniform,
                (Some(ratio), None) => Grading::Geometric { ratio: ratio.si() },
                (Some(ratio), Some(center)) => Grading::Toward {
                    center: center.si(),
                    ratio: ratio.si(),
                },
                (None, Some(_)) => {
                    return Err(at(
                        &["mesh", name, "toward"],
                        MeshError::Grading {
                            axis: ['x', 'y', 'z']
                                [["x", "y", "z"].iter().position(|a| *a == name).unwrap_or(0)],
                            ratio: 1.0,
                            cells: cells.get() as usize,
                            advice: "`toward` needs a `ratio` greater than 1",
                        },
                    ));
                }
            },
        }),
        _ => Err(keys()),
    }
}

/// `[from, to]` in metres, not empty.
fn interval(
    span: &[Measure<Length>; 2],
    what: impl FnOnce() -> String,
    path: &[&str],
) -> Result<[f64; 2], Located> {
    let [from, to] = [span[0].si(), span[1].si()];
    match to > from {
        true => Ok([from, to]),
        false => Err(at(
            path,
            Problem::EmptyInterval {
                what: what(),
                from,
                to,
            },
        )),
    }
}

fn regions(sections: &SceneSections) -> Result<Vec<BoxRegion>, Located> {
    let mut regions = Vec::new();
    for (i, material) in sections.material.iter().enumerate() {
        let number = i.to_string();
        let whole = [f64::NEG_INFINITY, f64::INFINITY];
        let mut boxes = Vec::new();
        for (b, BoxSection { x, y, z }) in material.boxes.iter().enumerate() {
            let mut bounds = [whole; 3];
            for (d, (name, span)) in [("x", x), ("y", y), ("z", z)].into_iter().enumerate() {
                if let Some(span) = span {
                    let what = || format!("the box of material \"{}\" in {name}", material.name);
                    bounds[d] = interval(
                        span,
                        what,
                        &["material", &number, "boxes", &b.to_string(), name],
                    )?;
                }
            }
            boxes.push(bounds);
        }
        for (l, layer) in material.layers.iter().enumerate() {
            let what = || format!("layer {} of material \"{}\"", l + 1, material.name);
            let z = interval(
                layer,
                what,
                &["material", &number, "layers", &l.to_string()],
            )?;
            boxes.push([whole, whole, z]);
        }
        regions.push(BoxRegion {
            name: material.name.clone(),
            boxes,
        });
    }
    Ok(regions)
}

/// One plane per position.
fn expand(
    fracture: &FractureSection,
    index: usize,
    lines: &[Vec<f64>; 3],
) -> Result<Vec<PlaneFracture>, Located> {
    let number = index.to_string();
    let here = ["fracture", number.as_str()];
    let axis = fracture.plane.index();
    let mut spans = [None; 3];
    for (d, span) in [&fracture.x, &fracture.y, &fracture.z]
        .into_iter()
        .enumerate()
    {
        let name = ["x", "y", "z"][d];
        match span {
            Some(_) if d == axis => {
                return Err(at(
                    &["fracture", &number, name],
                    Problem::SpanAlongNormal {
                        name: fracture.name.clone(),
                        axis: name,
                    },
                ));
            }
            Some(span) => spans[d] = Some([span[0].si(), span[1].si()]),
            None => {}
        }
    }
    let positions: Vec<f64> = match (&fracture.at, fracture.every) {
        (Some(at), None) => at.si(),
        (None, Some(every)) => {
            let last = lines[axis].len() - 1;
            (1..last)
                .filter(|i| i % every.get() as usize == 0)
                .map(|i| lines[axis][i])
                .collect()
        }
        (first, second) => {
            return Err(at(
                &here,
                Problem::ExactlyOne {
                    what: format!("fracture \"{}\"", fracture.name),
                    keys: "`at`, `every`",
                    found: usize::from(first.is_some()) + usize::from(second.is_some()),
                },
            ));
        }
    };
    if positions.is_empty() {
        return Err(at(
            &here,
            Problem::NoPlane {
                name: fracture.name.clone(),
                axis: fracture.plane.name(),
                every: fracture.every.map_or(0, |e| e.get()),
            },
        ));
    }
    let several = positions.len() > 1;
    Ok(positions
        .into_iter()
        .enumerate()
        .map(|(i, at)| PlaneFracture {
            name: match several {
                true => format!("{}_{}", fracture.name, i + 1),
                false => fracture.name.clone(),
            },
            axis,
            at,
            spans,
            flip: fracture.flip,
        })
        .collect())
}

fn friction(fracture: &FractureSection) -> Option<Friction> {
    match (&fracture.friction_angle, &fracture.cohesion) {
        (None, None) => None,
        (angle, cohesion) => Some(Friction {
            angle: angle.as_ref().map_or(0.0, Measure::si),
            cohesion: cohesion.as_ref().map_or(0.0, Measure::si),
        }),
    }
}

fn warps(map: &MapSection, center: [f64; 3]) -> Result<Vec<Box<dyn Warp>>, Located> {
    let mut warps: Vec<Box<dyn Warp>> = Vec::new();
    let point = |p: &Option<[Measure<Length>; 3]>| match p {
        Some([x, y, z]) => [x.si(), y.si(), z.si()],
        None => center,
    };
    if let Some(distort) = &map.distort {
        warps.push(Box::new(Distort {
            amplitude: distort.amplitude,
            seed: u64::from(distort.seed),
            smooth: distort.smooth,
            planar: !distort.bend_fractures,
        }));
    }
    if let Some(incline) = &map.incline {
        let along = incline.along.unwrap_or(match incline.plane {
            AxisName::Z => AxisName::X,
            _ => AxisName::Z,
        });
        warps.push(Box::new(Incline {
            plane: incline.plane.index(),
            along: along.index(),
            tilt: tilt(incline, along)?,
            pivot: point(&incline.pivot),
            fade: incline.fade,
        }));
    }
    if let Some(rotate) = &map.rotate {
        warps.push(Box::new(Rotate {
            axis: rotate.axis.index(),
            angle: rotate.angle.si(),
            center: point(&rotate.center),
        }));
    }
    Ok(warps)
}

/// Tilt of the planes: 90° − dip for vertical planes, the dip itself for horizontal ones.
fn tilt(incline: &InclineSection, along: AxisName) -> Result<f64, Located> {
    let here = ["mesh", "map", "incline"];
    match (&incline.dip, &incline.tilt) {
        (None, Some(tilt)) => Ok(tilt.si()),
        (Some(dip), None) => match (incline.plane, along) {
            (AxisName::Z, _) => Ok(dip.si()),
            (_, AxisName::Z) => Ok(std::f64::consts::FRAC_PI_2 - dip.si()),
            _ => Err(at(&["mesh", "map", "incline", "dip"], Problem::NoDip)),
        },
        (dip, tilt) => Err(at(
            &here,
            Problem::ExactlyOne {
                what: "[mesh.map.incline]".into(),
                keys: "`dip`, `tilt`",
                found: usize::from(dip.is_some()) + usize::from(tilt.is_some()),
            },
        )),
    }
}

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
            Some(axis) if sections.fracture[section].plane.name() != axis.to_string() => {
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
        MeshError::BadWarp { map, .. } => vec!["mesh".into(), "map".into(), (*map).into()],
        _ => vec!["mesh".into()],
    };
    Located {
        path,
        problem: error.into(),
    }
}
