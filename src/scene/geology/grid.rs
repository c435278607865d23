//! Grid lines of a geology, and what lies on them.

use super::GeologyProblem;
use super::blocks::Compartment;
use super::faults::Fault;
use super::layers::stops;
use super::lines::{Lines, Moved, follows};
use crate::mesh::Relief;
use crate::scene::located::{Located, at};
use crate::scene::mesh_sections::{AxisName, FractureSection};
use crate::scene::one_or_many::OneOrMany;
use crate::scene::sections::SceneSections;
use crate::units::{Length, Measure};

/// Size of a cell over that of its finer neighbour where lines follow from a geology and none is given: that of the scene `storage`. Unit: 1.
const GROWTH: f64 = 1.35;

/// Lines of x or y: positions of faults, which stay, ends of fractures and compartments.
pub(super) fn across(
    d: usize,
    sections: &mut SceneSections,
    tops: &[Relief],
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
    let bends = stops(tops, d, ends);
    let bends = &bends[1..bends.len() - 1];
    let finest = lines.count();
    let inside = |x: &f64| ends[0] < *x && *x < ends[1];
    let boundary = &mut sections.boundary;
    let parts = (boundary.iter()).flat_map(|b| [&b.x, &b.y][d].iter().flatten());
    let parts: Vec<f64> = parts.map(Measure::si).filter(|x| inside(x)).collect();
    lines.settle(bends.iter().copied().chain(parts));
    for bend in bends {
        lines.place(*bend, || "a point of a top".into());
    }
    for b in boundary {
        let what = format!("an end of the part of {}", b.place());
        let span = [&mut b.x, &mut b.y].into_iter().nth(d);
        let Some(span) = span.and_then(Option::as_mut) else {
            continue;
        };
        // a part narrower than cells are told apart is refused where faces are chosen, as it is written
        let [from, to] = span.each_ref().map(|end| lines.nearest_to(end.si()));
        if from != to {
            span.iter_mut().for_each(|end| put(end, &mut lines, &what));
        }
    }
    axis.growth.get_or_insert_with(|| Measure::ratio(GROWTH));
    let mut near: Vec<f64> = lines.points();
    let mut through = near.split_off(finest);
    through.sort_by(f64::total_cmp);
    near.retain(inside);
    near.sort_by(f64::total_cmp);
    match near.is_empty() {
        true => axis.fine = Some(ends.map(Measure::metres)),
        false => axis.near = Some(many(near)),
    }
    axis.through = (!through.is_empty()).then(|| many(through));
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
pub(super) fn end_of(fracture: &str) -> String {
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
pub(super) fn upwards(
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
            for position in positions.as_mut_slice() {
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

/// A list of lengths.
fn many(values: Vec<f64>) -> OneOrMany<Length> {
    OneOrMany::Many(values.into_iter().map(Measure::metres).collect())
}
