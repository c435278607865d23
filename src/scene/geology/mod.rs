//! Layers and the faults in them: `[geology]` becomes grid lines, boxes of materials, depth ranges and a shear, all of which a scene could
//! have written itself.
//!
//! | file | what it decides |
//! |---|---|
//! | `layers` | the list: names, order, what a list of layers spans |
//! | `faults` | what a fracture cuts and offsets, where it leans |
//! | `blocks` | boxes of materials between faults that offset layers |
//! | `grid` | lines of x, y and z, and what lies on them |
//! | `lines` | where grid lines have to be, and what moves to the nearest |
//! | `leans` | the shear of the grid between faults, and which faults it cannot follow |
//! | `lifts` | tops that are not level: levels of the grid that become surfaces, what does not go with them |
//! | `columns` | heights of these levels over a point, and what crosses |
//! | `thin` | layers that end: columns of cells in which they are too thin |
//! | `remarks` | what a reader should know of all that |

mod blocks;
mod columns;
mod faults;
mod grid;
mod layers;
mod leans;
mod lifts;
mod lines;
mod problem;
mod remarks;
mod sections;
mod thin;

use std::fmt;

pub use blocks::Piece;
pub use lines::Moved;
pub use problem::GeologyProblem;
pub use remarks::Remark;
pub use sections::{CompartmentSection, GeologySection, LayerSection};

use super::Problem;
use super::geometry::axis;
use super::located::{Located, at};
use super::mesh_sections::{AxisName, AxisSection, MapSection};
use super::sections::{BoxSection, MaterialSection, SceneSections};
use crate::mesh::MAX_NODES;
use crate::units::Measure;
use blocks::{Blocks, Compartment};
use faults::Fault;
use grid::{across, upwards};
use layers::Layers;
use lines::{CLOSE, Lines, follows};

/// Boxes that are shown in full.
const SHOWN: usize = 60;

/// What a `[geology]` has become.
#[derive(Clone, Debug, PartialEq)]
pub struct Geology {
    /// Boxes of the materials, before any map.
    pub pieces: Vec<Piece>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// What lies on a grid line beside the place where it is written.
    pub moved: Vec<Moved>,
    /// What tops that are not level have become; none where all are.
    pub remarks: Vec<Remark>,
}

impl Geology {
    /// What the grid has otherwise than it is written.
    pub fn warnings(&self) -> impl Iterator<Item = String> + '_ {
        let remarks = self.remarks.iter().filter(|remark| remark.is_warning());
        (self.moved.iter().map(ToString::to_string)).chain(remarks.map(ToString::to_string))
    }
}

impl fmt::Display for Geology {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for remark in &self.remarks {
            writeln!(f, "geology     {remark}")?;
        }
        if !self.remarks.is_empty() {
            let text = "levels below are those of the grid before they move to the tops";
            writeln!(f, "geology     {text}")?;
        }
        for piece in self.pieces.iter().take(SHOWN) {
            let [x, y, z] = piece.ends.map(|[from, to]| format!("{from} to {to}"));
            let name = &self.materials[piece.material];
            writeln!(f, "geology     \"{name}\": x {x} m, y {y} m, z {z} m")?;
        }
        if let Some(more) = self.pieces.len().checked_sub(SHOWN + 1) {
            let text = "boxes more; `fracas scene --expand` prints them";
            writeln!(f, "geology     {} {text}", more + 1)?;
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
    let ends = [across_ends(sections, 0)?, across_ends(sections, 1)?];
    let layers = Layers::new(&geology, &sections.material, &sections.fracture, ends)?;
    let [bottom, top] = heights(sections, &layers)?;
    let extents = [ends[0], ends[1], [bottom, top]];
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
        let compartments = &mut compartments;
        across(
            d,
            sections,
            &layers.tops,
            &faults,
            compartments,
            ends[d],
            &mut moved,
        );
    }
    let mut z = Lines::new("z", &sections.mesh.z, extents[2], &mut moved);
    layers.levels.iter().for_each(|level| z.keep(*level));
    let blocks = Blocks::new(&layers, &faults, &compartments, &extents, &mut z)?;
    let follow = follows(&sections.mesh.z);
    let mut remarks = Vec::new();
    let thin = match layers.are_level() {
        true => {
            upwards(sections, &mut faults, z, extents[2])?;
            Vec::new()
        }
        false => {
            lifts::require_composable(sections, lifts::filled(&layers, &geology.compartments))?;
            let told = z.told();
            let of_layers = (&layers, &blocks);
            let thin = lifts::follow(sections, &mut faults, of_layers, z, extents, &mut remarks)?;
            // ends and level fractures keep their heights, whatever lines they are on
            moved.truncate(told);
            thin
        }
    };
    // more nodes are refused when the mesh is made
    if follow || sections.mesh.nodes() <= MAX_NODES {
        require_throws(&sections.mesh.z, follow, (&layers, &faults, &blocks))?;
    }
    let pieces = blocks.pieces(&layers, &compartments, &thin);
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
        remarks,
    }))
}

/// Ends of the box along x or y, as [mesh] says.
fn across_ends(sections: &SceneSections, d: usize) -> Result<[f64; 2], Located> {
    let (section, name) = [(&sections.mesh.x, "x"), (&sections.mesh.y, "y")][d];
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
}

/// Bottom and top of the box, as layers say.
fn heights(sections: &SceneSections, layers: &Layers) -> Result<[f64; 2], Located> {
    let mesh = &sections.mesh;
    let (top, bottom) = (layers.levels[0], layers.levels[layers.levels.len() - 1]);
    for (key, given, level) in [("from", &mesh.z.from, bottom), ("to", &mesh.z.to, top)] {
        if let Some(value) = given.as_ref().map(Measure::si)
            && value != level
        {
            let extent = GeologyProblem::Extent { key, value, level };
            return Err(at(&["mesh", "z", key], extent));
        }
    }
    Ok([bottom, top])
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
