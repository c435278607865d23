//! From sections to grid lines, regions, planes and maps.

use super::Problem;
use super::located::{Located, at};
use super::mesh_sections::{
    AxisName, AxisSection, FractureSection, InclineSection, MapSection, ShearSection,
};
use super::sections::{BoxSection, SceneSections};
use crate::mesh::{
    Axis, BoxRegion, Disc, Distort, Grading, Incline, Leaning, Lift, MeshError, PlaneFracture,
    Rotate, Shear, Warp,
};
use crate::units::{Length, Measure};

pub(super) fn axis(section: &AxisSection, name: &'static str) -> Result<Axis, Located> {
    let keys = || at(&["mesh", name], Problem::AxisKeys { axis: name });
    if section.asks_for_sizes() {
        return section.size_field().map(Axis::Sized).ok_or_else(keys);
    }
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

pub(super) fn regions(sections: &SceneSections) -> Result<Vec<BoxRegion>, Located> {
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
pub(super) fn expand(
    fracture: &FractureSection,
    index: usize,
    lines: &[Vec<f64>; 3],
) -> Result<Vec<PlaneFracture>, Located> {
    let number = index.to_string();
    let here = ["fracture", number.as_str()];
    let Some(plane) = fracture.plane else {
        let what = format!("fracture \"{}\"", fracture.name);
        return Err(at(&here, Problem::MissingKey { what, key: "plane" }));
    };
    let axis = plane.index();
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
        let name = fracture.name.clone();
        return Err(match fracture.every {
            None => at(&["fracture", &number, "at"], Problem::NoPosition { name }),
            Some(every) => at(
                &here,
                Problem::NoPlane {
                    name,
                    axis: plane.name(),
                    every: every.get(),
                },
            ),
        });
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

pub(super) fn warps(map: &MapSection, center: [f64; 3]) -> Result<Vec<Box<dyn Warp>>, Located> {
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
    if let Some(disc) = &map.disc {
        warps.push(Box::new(Disc {
            axis: disc.axis.index(),
            radius: disc.radius.si(),
            center: point(&disc.center),
        }));
    }
    let mut levels = Vec::with_capacity(map.lift.len());
    for (i, section) in map.lift.iter().enumerate() {
        let path = ["mesh", "map", "lift", &i.to_string(), "to"];
        let surface = section.to.surface(&path, "`to` of [[mesh.map.lift]]")?;
        levels.push((section.level.si(), surface));
    }
    levels.sort_by(|a, b| a.0.total_cmp(&b.0));
    if !levels.is_empty() {
        warps.push(Box::new(Lift { levels }));
    }
    for axis in [AxisName::X, AxisName::Y, AxisName::Z] {
        let of_axis = map.shear.iter().filter(|section| section.plane == axis);
        let mut leaning: Vec<Leaning> = of_axis.map(leaning).collect();
        leaning.sort_by(|a, b| a.at.total_cmp(&b.at));
        if !leaning.is_empty() {
            warps.push(Box::new(Shear {
                plane: axis.index(),
                along: AxisName::Z.index(),
                leaning,
            }));
        }
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

/// A plane of [mesh.map.shear].
pub(super) fn leaning(section: &ShearSection) -> Leaning {
    let tilt = std::f64::consts::FRAC_PI_2 - section.dip.si();
    Leaning {
        at: section.at.si(),
        level: section.level.si(),
        slope: tilt.tan(),
        reach: [section.z[0].si(), section.z[1].si()],
    }
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
