//! From sections to a fluid: channels, and the faces and edges of sources.

use super::flow_sections::{AlongSection, SourceSection};
use super::history::Histories;
use super::located::{Located, at};
use super::outline::Outline;
use super::sections::{SceneSections, SideName};
use super::wells::wells;
use super::{FlowProblem, Problem};
use crate::flow::{Channel, Directed, Fluid, Given, Place, Source, edge_ends};
use crate::mesh::{BuiltMesh, FractureFace, dot, minus};
use crate::nearest::nearest;
use crate::units::Measure;

/// Share of its length within which both ends of an edge are on one side of a fracture: a hundred times the rounding of coordinates in six
/// digits beside cells of a tenth of the fracture. Unit: 1.
const SAME_SIDE: f64 = 1e-3;

/// The fluid of a scene, if it has one; `section_of` tells the section of every fracture.
pub(super) fn fluid(
    sections: &SceneSections,
    built: &BuiltMesh,
    section_of: &[usize],
    gravity: [f64; 3],
    (histories, of_time): (&mut Histories, usize),
) -> Result<Option<Fluid>, Located> {
    let Some(section) = &sections.fluid else {
        return Ok(None);
    };
    if section_of.is_empty() {
        return Err(at(&["fluid"], FlowProblem::NoFracture));
    }
    let is_heavy = section.density.as_ref().is_some_and(|d| d.si() > 0.0);
    if is_heavy && gravity[..2] != [0.0; 2] {
        return Err(at(&["gravity"], FlowProblem::TiltedGravity));
    }
    let mut channels = Vec::with_capacity(section_of.len());
    for i in section_of {
        let fracture = &sections.fracture[*i];
        let path = ["fracture", &i.to_string()];
        if fracture.has_pressure() {
            let name = fracture.name.clone();
            let path = [path[0], path[1], "pressure"];
            return Err(at(&path, FlowProblem::FixedPressure { name }));
        }
        let Some(conductivity) = &fracture.conductivity else {
            let what = format!("fracture \"{}\", in which a fluid flows,", fracture.name);
            let key = "conductivity";
            return Err(at(&path, Problem::MissingKey { what, key }));
        };
        let directed = match &fracture.conductivity_along {
            Some(along) => Some(directed(
                (along, conductivity.si()),
                (&fracture.name, channels.len()),
                built,
                &path,
            )?),
            None => None,
        };
        channels.push(Channel {
            conductivity: conductivity.si() * directed.map_or(1.0, |d: Directed| d.ratio.sqrt()),
            directed,
            storage: fracture.storage.as_ref().map_or(0.0, Measure::si),
            initial_pressure: fracture.initial_pressure.as_ref().map_or(0.0, Measure::si),
        });
    }
    let mut sources = Vec::with_capacity(sections.source.len());
    for (i, source) in sections.source.iter().enumerate() {
        let number = i.to_string();
        let path = ["source", &number, "history"];
        let history = histories.number(source.history.as_ref(), &path, of_time)?;
        let place = place(source, &number, built)?;
        let given = match (&source.rate, &source.pressure) {
            (Some(_), None) if matches!(place, Place::Edges(_)) => {
                let name = source.name();
                return Err(at(
                    &["source", &number, "rate"],
                    FlowProblem::RateOnEdge { name },
                ));
            }
            (Some(rate), None) => Given::Rate(rate.si()),
            (None, Some(pressure)) => Given::Pressure(pressure.si()),
            (rate, pressure) => {
                return Err(at(
                    &["source", &number],
                    Problem::ExactlyOne {
                        what: source.name(),
                        keys: "`rate`, `pressure`",
                        found: usize::from(rate.is_some()) + usize::from(pressure.is_some()),
                    },
                ));
            }
        };
        sources.push(Source {
            place,
            given,
            level: source.level.as_ref().map(Measure::si),
            history,
        });
    }
    require_one_each(&sources, sections, built)?;
    let wells = wells(sections, built, (histories, of_time))?;
    Ok(Some(Fluid {
        viscosity: section.viscosity.si(),
        compressibility: section.compressibility.as_ref().map_or(0.0, Measure::si),
        density: section.density.as_ref().map_or(0.0, Measure::si),
        gravity,
        reference: section.reference.as_ref().map_or(0.0, Measure::si),
        channels,
        sources,
        wells,
    }))
}

/// Sine of the angle to the normal of a face below which a direction is none in its plane: half a degree. Unit: 1.
const IN_PLANE: f64 = 1e-2;

/// How the conductivity of a fracture, and of its faces by their number of a fracture, depends on the direction.
fn directed(
    (along, across): (&AlongSection, f64),
    (name, number): (&str, usize),
    built: &BuiltMesh,
    path: &[&str],
) -> Result<Directed, Located> {
    let name = || name.to_string();
    let path = [path[0], path[1], "conductivity_along", "direction"];
    let length = along.direction.iter().map(|a| a * a).sum::<f64>();
    if !(length > 0.0 && length.is_finite()) {
        return Err(at(&path, FlowProblem::ZeroDirection { name: name() }));
    }
    let directed = Directed {
        along: along.direction,
        ratio: along.conductivity.si() / across,
    };
    let own = |face: &&FractureFace| usize::from(face.fracture) == number;
    let mut faces = built.fractures.faces.iter().filter(own);
    match faces.find(|face| directed.lies_in(face) < IN_PLANE) {
        Some(face) => {
            let center = face.center;
            let name = name();
            Err(at(&path, FlowProblem::NoDirection { name, center }))
        }
        None => Ok(directed),
    }
}

/// Faces or edges of a source.
fn place(source: &SourceSection, number: &str, built: &BuiltMesh) -> Result<Place, Located> {
    let names = &built.fractures.names;
    let Some(fracture) = names.iter().position(|name| *name == source.fracture) else {
        let problem = FlowProblem::UnknownFracture {
            name: source.fracture.clone(),
            nearest: nearest(&source.fracture, names),
            known: names.clone(),
        };
        return Err(at(&["source", number, "fracture"], problem));
    };
    let faces = || {
        let faces = built.fractures.faces.iter().enumerate();
        faces.filter(move |(_, face)| usize::from(face.fracture) == fracture)
    };
    match (&source.at, source.edge) {
        (None, None) => Ok(Place::Faces(faces().map(|(f, _)| f as u32).collect())),
        (Some(point), None) => {
            let point = [&point[0], &point[1], &point[2]].map(Measure::si);
            // a point on the border of faces lies on each of them
            let on: Vec<u32> = faces()
                .filter(|(_, face)| Outline::new(face, built).holds(point))
                .map(|(f, _)| f as u32)
                .collect();
            if !on.is_empty() {
                return Ok(Place::Faces(on));
            }
            let distance = |face: &FractureFace| {
                let d = minus(face.center, point);
                dot(d, d)
            };
            let closest = faces().min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
            let problem = FlowProblem::NoFace {
                name: source.fracture.clone(),
                point,
                nearest: closest.map_or([f64::NAN; 3], |(_, face)| face.center),
            };
            Err(at(&["source", number, "at"], problem))
        }
        (None, Some(side)) => {
            let edges = side_edges(faces().map(|(_, face)| face), built, side);
            match edges.is_empty() {
                false => Ok(Place::Edges(edges)),
                true => {
                    let name = source.fracture.clone();
                    let side = side.name();
                    let problem = FlowProblem::NoEdge { name, side };
                    Err(at(&["source", number, "edge"], problem))
                }
            }
        }
        (Some(_), Some(_)) => {
            let name = source.name();
            Err(at(&["source", number], FlowProblem::FaceAndEdge { name }))
        }
    }
}

/// Edges of one face of a fracture alone that lie farthest to a side.
fn side_edges<'f>(
    faces: impl Iterator<Item = &'f FractureFace>,
    built: &BuiltMesh,
    side: SideName,
) -> Vec<[u32; 2]> {
    let mesh = &built.mesh;
    let mut edges: Vec<[u32; 2]> = faces
        .flat_map(|face| (0..4).map(|a| edge_ends(face, mesh, a)))
        .collect();
    edges.sort_unstable();
    let outer: Vec<[u32; 2]> = edges
        .chunk_by(|a, b| a == b)
        .filter(|same| same.len() == 1)
        .map(|same| same[0])
        .collect();
    let (axis, sign) = (side.index() / 2, [-1.0, 1.0][side.index() % 2]);
    let along = |node: u32| sign * mesh.nodes[node as usize][axis];
    let all = || outer.iter().flatten().map(|node| along(*node));
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    let length = |ends: &[u32; 2]| {
        let [a, b] = ends.map(|node| mesh.nodes[node as usize]);
        let d = minus(b, a);
        dot(d, d).sqrt()
    };
    // both ends on the side; a fracture across the axis has none
    let longest = outer.iter().map(length).fold(0.0, f64::max);
    if high - low <= SAME_SIDE * longest {
        return Vec::new();
    }
    let there = |ends: &&[u32; 2]| {
        let zone = SAME_SIDE * length(ends);
        ends.iter().all(|node| along(*node) >= high - zone)
    };
    outer.iter().filter(there).copied().collect()
}

/// Refuses faces that have two pressures, or a pressure and a rate.
fn require_one_each(
    sources: &[Source],
    sections: &SceneSections,
    built: &BuiltMesh,
) -> Result<(), Located> {
    let number = |i: usize| i.to_string();
    for (i, source) in sources.iter().enumerate() {
        if !matches!(source.given, Given::Pressure(_)) {
            continue;
        }
        let others = sources.iter().enumerate().filter(|(j, other)| {
            // each pair of pressures is seen once, as the later one
            *j < i || matches!(other.given, Given::Rate(_))
        });
        for (j, other) in others {
            let center = match (&source.place, &other.place) {
                (Place::Faces(a), Place::Faces(b)) => {
                    let both = a.iter().find(|f| b.contains(f));
                    both.map(|f| built.fractures.faces[*f as usize].center)
                }
                (Place::Edges(a), Place::Edges(b)) => {
                    let both = a.iter().find(|e| b.contains(e));
                    both.map(|[p, q]| {
                        let [p, q] = [p, q].map(|n| built.mesh.nodes[*n as usize]);
                        std::array::from_fn(|k| 0.5 * (p[k] + q[k]))
                    })
                }
                _ => None,
            };
            if let Some(center) = center {
                let problem = FlowProblem::TwoOnOne {
                    name: sections.source[i].fracture.clone(),
                    center,
                    other: match other.given {
                        Given::Rate(_) => "rate",
                        Given::Pressure(_) => "pressure",
                    },
                    number: j + 1,
                };
                return Err(at(&["source", &number(i)], problem));
            }
        }
    }
    Ok(())
}
