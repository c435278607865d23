//! Layers and the faults in them: `[geology]` becomes grid lines, boxes of materials, depth ranges and a shear, all of which a scene could
//! have written itself.
//!
//! | file | what it decides |
//! |---|---|
//! | `layers` | the list: names, order, what a list of layers spans |
//! | `faults` | what a fracture cuts and offsets, where it leans |
//! | `blocks` | boxes of materials between faults that offset layers |
//! | `lines` | where grid lines have to be, and what moves to the nearest |
//! | `leans` | the shear of the grid between faults, and which faults it cannot follow |

mod blocks;
mod faults;
mod layers;
mod leans;
mod lines;
mod problem;
mod sections;

use std::fmt;

pub use blocks::Piece;
pub use lines::Moved;
pub use problem::GeologyProblem;
pub use sections::{CompartmentSection, GeologySection, LayerSection};

use super::Problem;
use super::geometry::axis;
use super::located::{Located, at};
use super::mesh_sections::{AxisName, AxisSection, FractureSection, MapSection};
use super::one_or_many::OneOrMany;
use super::sections::{BoxSection, MaterialSection, SceneSections};
use crate::mesh::MAX_NODES;
use crate::units::{Length, Measure};
use blocks::{Blocks, Compartment};
use faults::Fault;
use layers::Layers;
use lines::{CLOSE, Lines, follows};

/// Size of a cell over that of its finer neighbour where lines follow from a geology and none is given: that of the scene `storage`. Unit: 1.
const GROWTH: f64 = 1.35;

/// What a `[geology]` has become.
#[derive(Clone, Debug, PartialEq)]
pub struct Geology {
    /// Boxes of the materials, before any map.
    pub pieces: Vec<Piece>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// What lies on a grid line beside the place where it is written.
    pub moved: Vec<Moved>,
}

impl fmt::Display for Geology {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for piece in &self.pieces {
            let [x, y, z] = piece.ends.map(|[from, to]| format!("{from} to {to}"));
            let name = &self.materials[piece.material];
            writeln!(f, "geology     \"{name}\": x {x} m, y {y} m, z {z} m")?;
        }
        (self.moved.iter()).try_for_each(|moved| writeln!(f, "geology     {moved}"))
    }
}

/// Puts grid lines, boxes, depth ranges and a shear in the place of `[geology]`.
pub(super) fn expand(sections: &mut SceneSections) -> Result<Option<Geology>, Located> {
    let Some(geology) = sections.geology.take() else {
        return Ok(None);
    };
    if sections.mesh.file.is_some() {
        let stray = Problem::StrayKey {
            what: "the scene".into(),
            key: "geology",
            belongs: "a grid",
            instead: "leave it out, the mesh comes from `file`",
        };
        return Err(at(&["geology"], stray));
    }
    let layers = Layers::new(&geology, &sections.material)?;
    let extents = extents(sections, &layers)?;
    let mut faults = Vec::new();
    for (i, fracture) in sections.fracture.iter().enumerate() {
        faults.extend(Fault::new(i, fracture, &layers, &extents)?);
    }
    faults::reach_layers(&mut faults, &sections.fracture, &layers, &extents);
    let mut compartments = Vec::new();
    for (i, section) in geology.compartments.iter().enumerate() {
        let materials = &sections.material;
        let compartment = Compartment::new(i, section, &faults, &layers, materials, &extents)?;
        compartments.push(compartment);
    }
    let mut moved = Vec::new();
    for d in 0..2 {
        across(
            d,
            sections,
            &faults,
            &mut compartments,
            extents[d],
            &mut moved,
        );
    }
    let mut z = Lines::new("z", &sections.mesh.z, extents[2], &mut moved);
    layers.levels.iter().for_each(|level| z.keep(*level));
    let blocks = Blocks::new(&layers, &faults, &compartments, &extents, &mut z)?;
    let follow = follows(&sections.mesh.z);
    upwards(sections, &mut faults, z, extents[2])?;
    // more nodes are refused when the mesh is made
    if follow || sections.mesh.nodes() <= MAX_NODES {
        require_throws(&sections.mesh.z, follow, (&layers, &faults, &blocks))?;
    }
    let pieces = blocks.pieces(&layers, &compartments);
    fill(sections, &pieces, &extents)?;
    lean(sections, &faults, &extents)?;
    for fracture in &mut sections.fracture {
        (fracture.dip, fracture.level) = (None, None);
        (fracture.throw, fracture.cuts) = (None, None);
    }
    let materials = sections.material.iter().map(|m| m.name.clone()).collect();
    Ok(Some(Geology {
        pieces,
        materials,
        moved,
    }))
}

/// Ends of the box: of x and y as [mesh] says, of z as layers do.
fn extents(sections: &SceneSections, layers: &Layers) -> Result<[[f64; 2]; 3], Located> {
    let mesh = &sections.mesh;
    let ends = |section: &AxisSection, name: &'static str| {
        let given = [&section.from, &section.to].map(|end| end.as_ref().map(Measure::si));
        match (given, &section.lines) {
            ([Some(from), Some(to)], _) if to > from => Ok([from, to]),
            (_, Some(lines)) if lines.len() > 1 => Ok([lines[0].si(), lines[lines.len() - 1].si()]),
            _ => {
                // the axis says better what it lacks
                axis(section, name)?;
                Err(at(&["mesh", name], Problem::AxisKeys { axis: name }))
            }
        }
    };
    let (top, bottom) = (layers.levels[0], layers.levels[layers.levels.len() - 1]);
    for (key, given, level) in [("from", &mesh.z.from, bottom), ("to", &mesh.z.to, top)] {
        if let Some(value) = given.as_ref().map(Measure::si)
            && value != level
        {
            let extent = GeologyProblem::Extent { key, value, level };
            return Err(at(&["mesh", "z", key], extent));
        }
    }
    Ok([ends(&mesh.x, "x")?, ends(&mesh.y, "y")?, [bottom, top]])
}

/// Lines of x or y: positions of faults, which stay, ends of fractures and compartments.
fn across(
    d: usize,
    sections: &mut SceneSections,
    faults: &[Fault],
    compartments: &mut [Compartment],
    ends: [f64; 2],
    moved: &mut Vec<Moved>,
) {
    let name = ["x", "y"][d];
    let mesh = &mut sections.mesh;
    let axis = [&mut mesh.x, &mut mesh.y].into_iter().nth(d);
    let Some(axis) = axis else { return };
    let mut lines = Lines::new(name, axis, ends, moved);
    let positions = faults.iter().filter(|f| f.axis == d).flat_map(|f| &f.at);
    positions.for_each(|at| lines.keep(*at));
    lines.settle(compartments.iter().flat_map(|c| c.ends[d]));
    for compartment in compartments {
        for end in &mut compartment.ends[d] {
            *end = lines.place(*end, || {
                format!("a side of a compartment of \"{}\"", compartment.layer)
            });
        }
    }
    let spans = (sections.fracture.iter()).filter_map(|f| [&f.x, &f.y][d].as_ref());
    lines.settle(spans.flatten().map(Measure::si));
    for fracture in &mut sections.fracture {
        place_span(d, fracture, &mut lines);
    }
    if !follows(axis) {
        return;
    }
    axis.growth.get_or_insert_with(|| Measure::ratio(GROWTH));
    let inside = |x: &f64| ends[0] < *x && *x < ends[1];
    let mut near: Vec<f64> = lines.points().into_iter().filter(inside).collect();
    near.sort_by(f64::total_cmp);
    match near.is_empty() {
        true => axis.fine = Some(ends.map(Measure::metres)),
        false => axis.near = Some(many(near)),
    }
}

/// The span of a fracture in x or y, its ends on lines.
fn place_span(d: usize, fracture: &mut FractureSection, lines: &mut Lines) {
    let what = end_of(&fracture.name);
    let span = [&mut fracture.x, &mut fracture.y]
        .into_iter()
        .nth(d)
        .and_then(Option::as_mut);
    for end in span.into_iter().flatten() {
        put(end, lines, &what);
    }
}

/// What moves, for [`Moved`].
fn end_of(fracture: &str) -> String {
    format!("an end of fracture \"{fracture}\"")
}

/// A length on the line that is close; as it was written where it lies on one.
fn put(end: &mut Measure<Length>, lines: &mut Lines, what: &str) {
    let line = lines.place(end.si(), || what.to_owned());
    if line != end.si() {
        *end = Measure::metres(line);
    }
}

/// Lines of z: tops, level fractures, ends of faults; cells are fine where faults across x and y reach.
fn upwards(
    sections: &mut SceneSections,
    faults: &mut [Fault],
    mut lines: Lines,
    [bottom, top]: [f64; 2],
) -> Result<(), Located> {
    let mut level = Vec::new();
    let flat = (sections.fracture.iter()).filter(|f| f.plane == Some(AxisName::Z));
    lines.settle(flat.flat_map(|f| f.at.iter().flat_map(OneOrMany::si)));
    let has_ends = |fault: &&Fault| {
        let fracture = &sections.fracture[fault.section];
        fracture.z.is_some() || fracture.cuts.is_some()
    };
    let ends: Vec<f64> = (faults.iter().filter(has_ends))
        .flat_map(|f| f.reach)
        .collect();
    for fracture in &mut sections.fracture {
        if fracture.plane == Some(AxisName::Z)
            && let Some(positions) = &mut fracture.at
        {
            let what = format!("fracture \"{}\"", fracture.name);
            let all = match positions {
                OneOrMany::One(one) => std::slice::from_mut(one),
                OneOrMany::Many(many) => &mut many[..],
            };
            for position in all {
                put(position, &mut lines, &what);
                level.push(position.si());
            }
        }
    }
    lines.settle(ends);
    for fault in faults.iter_mut() {
        let fracture = &mut sections.fracture[fault.section];
        if fracture.z.is_none() && fracture.cuts.is_none() {
            continue;
        }
        let what = end_of(&fault.name);
        let [from, to] = fault.reach;
        fault.reach = fault.reach.map(|end| lines.place(end, || what.clone()));
        if fault.reach[0] >= fault.reach[1] {
            let what = format!("fracture \"{}\"", fault.name);
            let key = if fracture.z.is_some() { "z" } else { "cuts" };
            let thin = GeologyProblem::Thin { what, from, to };
            return Err(at(&["fracture", &fault.section.to_string(), key], thin));
        }
        let unchanged = |z: &[Measure<Length>; 2]| [z[0].si(), z[1].si()] == fault.reach;
        if !fracture.z.as_ref().is_some_and(unchanged) {
            fracture.z = Some(fault.reach.map(Measure::metres));
        }
    }
    let axis = &mut sections.mesh.z;
    let follow = follows(axis);
    if axis.lines.is_none() {
        axis.from.get_or_insert_with(|| Measure::metres(bottom));
        axis.to.get_or_insert_with(|| Measure::metres(top));
    }
    if !follow {
        return Ok(());
    }
    axis.growth.get_or_insert_with(|| Measure::ratio(GROWTH));
    let hull = faults
        .iter()
        .map(|f| f.reach)
        .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let hull = match (hull, level.is_empty()) {
        (None, true) => Some([bottom, top]),
        (hull, _) => hull,
    };
    let is_in = |z: &f64| hull.is_some_and(|[from, to]| (from..=to).contains(z));
    let mut near: Vec<f64> = level.into_iter().filter(|z| !is_in(z)).collect();
    near.sort_by(f64::total_cmp);
    near.dedup();
    let through = lines.points().into_iter();
    let mut through: Vec<f64> = through
        .filter(|z| bottom < *z && *z < top && !near.contains(z))
        .filter(|z| hull.is_none_or(|ends| !ends.contains(z)))
        .collect();
    through.sort_by(f64::total_cmp);
    axis.fine = hull.map(|ends| ends.map(Measure::metres));
    axis.near = (!near.is_empty()).then(|| many(near));
    axis.through = (!through.is_empty()).then(|| many(through));
    Ok(())
}

/// Refuses a throw of which no cell takes a share; the lines of z follow tops, or have them between centres of cells.
fn require_throws(
    z: &AxisSection,
    follow: bool,
    (layers, faults, blocks): (&Layers, &[Fault], &Blocks),
) -> Result<(), Located> {
    let lines = match follow {
        true => None,
        false => {
            let lines = axis(z, "z")?.lines(2);
            Some(lines.map_err(|problem| at(&["mesh", "z"], problem))?)
        }
    };
    let Some(fault) = blocks.lost(layers, faults, lines.as_deref()) else {
        return Ok(());
    };
    // two lines that each moved by as much as they may
    let cells = if follow { 0.5 / CLOSE } else { 1.0 };
    let lost = GeologyProblem::LostThrow {
        name: fault.name.clone(),
        throw: fault.throw,
        size: cells * fault.throw.abs(),
    };
    Err(at(&["fracture", &fault.section.to_string(), "throw"], lost))
}

/// Gives each material its boxes.
fn fill(
    sections: &mut SceneSections,
    pieces: &[Piece],
    extents: &[[f64; 2]; 3],
) -> Result<(), Located> {
    for (number, material) in sections.material.iter_mut().enumerate() {
        let own = pieces.iter().filter(|piece| piece.material == number);
        material.boxes.extend(own.map(|piece| {
            let span = |d: usize| {
                (piece.ends[d] != extents[d]).then(|| piece.ends[d].map(Measure::metres))
            };
            BoxSection {
                x: span(0),
                y: span(1),
                z: Some(piece.ends[2].map(Measure::metres)),
            }
        }));
        let MaterialSection {
            name,
            boxes,
            layers,
            volume,
            ..
        } = &*material;
        if boxes.is_empty() && layers.is_empty() && volume.is_none() {
            let name = name.clone();
            let path = ["material", &number.to_string()];
            return Err(at(&path, GeologyProblem::Unplaced { name }));
        }
    }
    Ok(())
}

/// Leans the faults.
fn lean(
    sections: &mut SceneSections,
    faults: &[Fault],
    extents: &[[f64; 2]; 3],
) -> Result<(), Located> {
    let mut shear = Vec::new();
    for axis in [AxisName::X, AxisName::Y] {
        let ends = extents[axis.index()];
        shear.extend(leans::shear(faults, &sections.fracture, axis, ends)?);
    }
    if !shear.is_empty() {
        sections
            .mesh
            .map
            .get_or_insert_with(MapSection::default)
            .shear
            .extend(shear);
    }
    Ok(())
}

/// A list of lengths.
fn many(values: Vec<f64>) -> OneOrMany<Length> {
    OneOrMany::Many(values.into_iter().map(Measure::metres).collect())
}
