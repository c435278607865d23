//! Tops that are not level: what they do not go with, and the levels of the grid that become surfaces.

use super::blocks::{Blocks, ThinCell};
use super::columns::{Columns, Held, between, touches};
use super::faults::Fault;
use super::grid::{end_of, upwards};
use super::layers::{Layers, stops};
use super::lines::{Lines, follows};
use super::remarks::{self, Remark};
use super::{CompartmentSection, GeologyProblem, leans, thin};
use crate::mesh::{MAX_NODES, Relief};
use crate::scene::SurfaceSection;
use crate::scene::geometry::{axis, leaning};
use crate::scene::located::{Located, at};
use crate::scene::mesh_sections::{AxisName, FractureSection, MapSection};
use crate::scene::one_or_many::OneOrMany;
use crate::scene::sections::SceneSections;
use crate::scene::surface_section::LiftSection;
use crate::units::Measure;

/// Share of a cell within which a fracture lies on a line of the grid. Unit: 1.
const SAME: f64 = 1e-6;

/// Refuses what needs level tops; `filled` tells whether a material fills a layer that is not level, or a part of it.
pub(super) fn require_composable(
    sections: &SceneSections,
    filled: impl Fn(&str) -> bool,
) -> Result<(), Located> {
    let refuse =
        |path: &[&str], what: String, why| Err(at(path, GeologyProblem::NeedsLevel { what, why }));
    if !follows(&sections.mesh.z) {
        let why = "levels of the grid follow them; give [mesh.z] `size`, perhaps `growth` and `largest`, and no other key";
        return refuse(
            &["mesh", "z"],
            "a list of lines or cells in [mesh.z]".into(),
            why,
        );
    }
    if sections
        .mesh
        .map
        .as_ref()
        .is_some_and(|map| !map.lift.is_empty())
    {
        let why = "they make a `lift` of their own; write the surface as `top`, or the boxes of materials without [geology]";
        return refuse(&["mesh", "map", "lift"], "[[mesh.map.lift]]".into(), why);
    }
    for (i, fracture) in sections.fracture.iter().enumerate() {
        let has_heights = fracture.z.is_some() || fracture.plane == Some(AxisName::Z);
        if fracture.every.is_some() && has_heights {
            let what = format!("`every` of fracture \"{}\"", fracture.name);
            let why = "its lines have other heights then; give positions by `at`";
            return refuse(&["fracture", &i.to_string(), "every"], what, why);
        }
    }
    for (i, material) in sections.material.iter().enumerate() {
        let drawdown = material
            .pore_pressure
            .as_ref()
            .map(|p| p.drawdown.is_some());
        if drawdown == Some(true) && filled(&material.name) {
            let what = format!("`drawdown` of material \"{}\"", material.name);
            let why = "it diffuses across a level layer, and this one is not; give its pressures as `points`, `grid` or `fields`";
            let path = ["material", &i.to_string(), "pore_pressure", "drawdown"];
            return refuse(&path, what, why);
        }
    }
    Ok(())
}

/// Depth ranges of faults in the rock: as written, or from the highest to the lowest of the tops that they cut, on both of their sides.
pub(super) fn reach_rock(
    faults: &mut [Fault],
    fractures: &[FractureSection],
    layers: &Layers,
    blocks: &Blocks,
    ends: [[f64; 2]; 2],
) {
    for fault in faults {
        if let Some(written) = fault.written {
            fault.rock = Some(written);
            continue;
        }
        fault.rock = Some(along_fault(fault, 0.0, layers, blocks, ends));
        fault.lies_at(fault.level());
        if let Some(dip) = &fractures[fault.section].dip {
            let slope = (std::f64::consts::FRAC_PI_2 - dip.si()).tan();
            fault.rock = Some(along_fault(fault, slope, layers, blocks, ends));
        }
    }
}

/// Lowest and highest of what a fault of this slope cuts, along its plane [m].
fn along_fault(
    fault: &Fault,
    slope: f64,
    layers: &Layers,
    blocks: &Blocks,
    ends: [[f64; 2]; 2],
) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let level = if slope == 0.0 { 0.0 } else { fault.level() };
    for position in &fault.at {
        let mut trace = ends;
        trace[fault.axis] = [*position; 2];
        let beside = (0..blocks.count()).filter(|b| touches(&blocks.rectangle(*b), &trace));
        for block in beside {
            for k in fault.levels().into_iter().flatten() {
                let top = &layers.tops[k];
                let shift = blocks.levels(block)[k] - layers.levels[k];
                for point in top.points(trace) {
                    let mut z = top.at(point) + shift;
                    // a plane as steep as the top is refused where columns are made
                    for _ in 0..100 {
                        let mut there = point;
                        there[fault.axis] = position + (z - level) * slope;
                        z = top.at(there) + shift;
                    }
                    range = [range[0].min(z), range[1].max(z)];
                }
            }
        }
    }
    range
}

/// Puts the levels of the grid at which written heights lie in the place of these.
pub(super) fn to_levels(
    sections: &mut SceneSections,
    faults: &mut [Fault],
    columns: &Columns,
) -> Result<(), Located> {
    let middle = columns.ends.map(|[from, to]| 0.5 * (from + to));
    for fault in faults {
        let Some(written) = fault.written else {
            continue;
        };
        let mut levels = [0.0; 2];
        for position in &fault.at {
            let mut point = middle;
            point[fault.axis] = *position;
            for (level, height) in levels.iter_mut().zip(written) {
                *level += columns.line(point, height)? / fault.at.len() as f64;
            }
        }
        fault.reach = levels;
    }
    for fracture in sections.fracture.iter_mut() {
        if fracture.plane != Some(AxisName::Z) {
            continue;
        }
        let rectangle = spans(fracture, columns.ends);
        let point = rectangle.map(|[from, to]| 0.5 * (from + to));
        for position in fracture.at.iter_mut().flat_map(OneOrMany::as_mut_slice) {
            *position = Measure::metres(columns.line(point, position.si())?);
        }
    }
    Ok(())
}

/// The rectangle that a fracture spans, the box where it does not say.
fn spans(fracture: &FractureSection, ends: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let given = [&fracture.x, &fracture.y];
    [0, 1].map(|d: usize| match given[d] {
        Some([from, to]) => [from.si(), to.si()],
        None => ends[d],
    })
}

/// Levels of the grid with heights of their own: level fractures, and ends of faults that are written and lie on no top beside them.
/// `levels` are the heights of level fractures as written.
pub(super) fn held(
    sections: &SceneSections,
    faults: &[Fault],
    heights: &[Vec<f64>],
    columns: &Columns,
    remarks: &mut Vec<Remark>,
) -> Vec<Held> {
    let mut all = Vec::new();
    for fault in faults {
        let (Some(written), fracture) = (fault.written, &sections.fracture[fault.section]) else {
            continue;
        };
        for (line, height) in fault.reach.into_iter().zip(written) {
            for position in &fault.at {
                let mut rectangle = spans(fracture, columns.ends);
                rectangle[fault.axis] = [*position; 2];
                let mut beside = (0..columns.blocks.count())
                    .filter(|b| touches(&columns.blocks.rectangle(*b), &rectangle));
                let lies_on = beside.find_map(|block| {
                    let levels = columns.blocks.levels(block);
                    let k = levels.iter().position(|level| *level == line)?;
                    let range = columns.layers.tops[k].range(rectangle);
                    let shift = line - columns.layers.levels[k];
                    Some((k, range.map(|z| z + shift)))
                });
                match lies_on {
                    Some((k, [low, high])) => {
                        let far = (low - height).abs().max((high - height).abs());
                        if far > columns.layers.rounding() {
                            remarks.push(Remark::Follows {
                                what: end_of(&fault.name),
                                top: columns.layers.name(k),
                                heights: [low, high],
                                written: height,
                            });
                        }
                    }
                    None => all.push(Held {
                        line,
                        rectangle,
                        height,
                        what: end_of(&fault.name),
                        path: ["fracture".into(), fault.section.to_string(), "z".into()],
                    }),
                }
            }
        }
    }
    for (i, fracture) in sections.fracture.iter().enumerate() {
        let lines = fracture.at.iter().flat_map(OneOrMany::si);
        all.extend(lines.zip(&heights[i]).map(|(line, height)| Held {
            line,
            rectangle: spans(fracture, columns.ends),
            height: *height,
            what: format!("fracture \"{}\"", fracture.name),
            path: ["fracture".into(), i.to_string(), "at".into()],
        }));
    }
    all
}

/// Lines of x and y in which columns are told apart, and whether they are all those of the grid.
pub(super) struct Stations {
    pub(super) lines: [Vec<f64>; 2],
    pub(super) all: [bool; 2],
}

impl Stations {
    /// Where tops may bend, blocks and fractures end and levels have heights of their own; all lines of the grid across axes along which
    /// tops climb, where they climb between lines that lean or come too close for their cells.
    pub(super) fn new(sections: &SceneSections, columns: &Columns) -> Result<Self, Located> {
        let tops = &columns.layers.tops;
        let of_fractures = |d: usize| {
            let rectangles = columns.held.iter().map(move |held| held.rectangle[d]);
            rectangles.flatten()
        };
        let bends = |d: usize| {
            let mut all = stops(tops, d, columns.ends[d]);
            all.extend(columns.blocks.breaks(d));
            all.extend(of_fractures(d));
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let mut stations = Self {
            lines: [bends(0), bends(1)],
            all: [false; 2],
        };
        let climb = |d: usize| tops.iter().any(|top| top.varies(d));
        let leans = (0..2).any(|d| !columns.leaning[d].is_empty() && climb(d));
        let mut all = [0, 1].map(|d: usize| leans && climb(d));
        for k in thin::layers(columns, &stations.lines)? {
            for (d, all) in all.iter_mut().enumerate() {
                *all |= tops[k].varies(d) || tops[k + 1].varies(d);
            }
        }
        let mesh = &sections.mesh;
        for (d, (section, name)) in [(&mesh.x, "x"), (&mesh.y, "y")].into_iter().enumerate() {
            if all[d] {
                let lines = axis(section, name)?.lines(d);
                let mut lines = lines.map_err(|e| at(&["mesh", name], e))?;
                snap(&mut lines, &stations.lines[d]);
                stations.lines[d] = lines;
            }
        }
        stations.all = all;
        Ok(stations)
    }

    /// All of them.
    fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let [x, y] = &self.lines;
        y.iter().flat_map(move |y| x.iter().map(move |x| [*x, *y]))
    }
}

/// Lines of the grid that are one with stations but for rounding become these.
fn snap(lines: &mut [f64], stations: &[f64]) {
    for station in stations {
        let above = lines
            .partition_point(|line| line <= station)
            .clamp(1, lines.len() - 1);
        let close = SAME * (lines[above] - lines[above - 1]);
        for line in &mut lines[above - 1..=above] {
            if (*line - station).abs() <= close {
                *line = *station;
            }
        }
    }
}

/// The levels of the grid that something lies on become surfaces.
pub(super) fn lift(
    sections: &mut SceneSections,
    columns: &Columns,
    stations: &Stations,
) -> Result<(), Located> {
    let all: Vec<Vec<(f64, f64)>> = (stations.points())
        .map(|point| columns.column(point))
        .collect::<Result<_, _>>()?;
    let mut lines: Vec<f64> = all.iter().flatten().map(|(line, _)| *line).collect();
    lines.sort_by(f64::total_cmp);
    lines.dedup();
    let lift = lines.into_iter().map(|line| {
        let heights = all.iter().map(|column| between(column, line)).collect();
        let relief = Relief::new(stations.lines.clone(), heights);
        LiftSection {
            level: Measure::metres(line),
            to: SurfaceSection::of(&relief),
        }
    });
    let lift: Vec<LiftSection> = lift.collect();
    (sections.mesh.map.get_or_insert_with(MapSection::default)).lift = lift;
    Ok(())
}

/// Tells whether a material fills a layer that is not level, or a part of one.
pub(super) fn filled(layers: &Layers, parts: &[CompartmentSection]) -> impl Fn(&str) -> bool {
    let tilted = |k: usize| {
        layers.tops[k]
            .is_level()
            .and(layers.tops[k + 1].is_level())
            .is_none()
    };
    let names: Vec<&String> = (layers.names.iter().enumerate())
        .filter(|(k, _)| tilted(*k))
        .map(|(_, name)| name)
        .collect();
    let of_parts = parts.iter().filter(|part| names.contains(&&part.layer));
    let mut all: Vec<String> = of_parts.map(|part| part.material.clone()).collect();
    all.extend(names.into_iter().cloned());
    move |name| all.iter().any(|other| other == name)
}

/// Puts heights of faults and level fractures on levels of the grid, and makes surfaces of all levels that something lies on; columns of cells
/// in which layers are thin.
pub(super) fn follow(
    sections: &mut SceneSections,
    faults: &mut [Fault],
    (layers, blocks): (&Layers, &Blocks),
    z: Lines,
    extents: [[f64; 2]; 3],
    remarks: &mut Vec<Remark>,
) -> Result<Vec<Vec<ThinCell>>, Located> {
    let ends = [extents[0], extents[1]];
    reach_rock(faults, &sections.fracture, layers, blocks, ends);
    let mut columns = Columns {
        layers,
        blocks,
        leaning: Default::default(),
        ends,
        held: Vec::new(),
    };
    for (d, axis) in [AxisName::X, AxisName::Y].into_iter().enumerate() {
        let planes = leans::shear(faults, &sections.fracture, axis, ends[d])?;
        columns.leaning[d] = planes.iter().map(leaning).collect();
    }
    let heights: Vec<Vec<f64>> = (sections.fracture.iter())
        .map(|fracture| match fracture.plane {
            Some(AxisName::Z) => fracture.at.iter().flat_map(OneOrMany::si).collect(),
            _ => Vec::new(),
        })
        .collect();
    to_levels(sections, faults, &columns)?;
    upwards(sections, faults, z, extents[2])?;
    // more nodes are refused when the mesh is made
    if sections.mesh.nodes() > MAX_NODES {
        return Ok(Vec::new());
    }
    remarks.extend(remarks::heights(&columns));
    columns.held = held(sections, faults, &heights, &columns, remarks);
    let stations = Stations::new(sections, &columns)?;
    remarks.extend(remarks::off(sections, &columns)?);
    let thin = match stations.all {
        [false, false] => Vec::new(),
        _ => thin::cells(&columns, &stations, remarks)?,
    };
    lift(sections, &columns, &stations)?;
    Ok(thin)
}
