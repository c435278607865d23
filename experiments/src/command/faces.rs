//! Fractures at the end of a run, as maps, or as profiles where they are narrow.

use crate::plot::{Axis, Cells, Figure, Mark, Series};
use crate::report::format_real;
use fracas::contact::ContactState;
use fracas::mesh::{FractureFace, HexMesh};
use fracas::nonlinear::FaceFields;
use fracas::run::Running;

/// Fractures that are shown.
const FRACTURES: usize = 8;

/// Faces of a fracture up to which they are drawn: some megabytes of figures.
const FACES: usize = 20_000;

/// Differences over the largest value that are none. Unit: 1.
const EVEN: f64 = 1e-9;

/// Sides of a fracture, short over long, below which a profile shows more than a map. Unit: 1.
const NARROW: f64 = 0.1;

/// Normal traction, opening, slip and criticality of every fracture, and what is left out.
pub(super) fn figures(run: &Running<'_>) -> (Vec<Figure>, Vec<String>) {
    let body = run.simulation().problem().body();
    let fields = run.simulation().face_fields(run.state());
    let states = &run.state().states;
    let (mut figures, mut notes) = (Vec::new(), Vec::new());
    for (fracture, name) in body.fractures.names.iter().enumerate() {
        let faces = body.fractures.faces.iter().enumerate();
        let own: Vec<(usize, &FractureFace)> = faces
            .filter(|(_, face)| usize::from(face.fracture) == fracture)
            .collect();
        if fracture >= FRACTURES || own.len() > FACES {
            notes.push(format!(
                "Fracture \"{name}\" with {} faces is not drawn; scene.pvd shows it.",
                own.len()
            ));
            continue;
        }
        let plane = Plane::new(&body.mesh, &own);
        for quantity in quantities(&fields, states) {
            let values: Vec<f64> = own.iter().map(|(f, _)| (quantity.of)(*f)).collect();
            let ends = [f64::INFINITY, f64::NEG_INFINITY];
            let [low, high] = values
                .iter()
                .fold(ends, |[low, high], v| [low.min(*v), high.max(*v)]);
            if low == 0.0 && high == 0.0 || own.is_empty() {
                continue;
            }
            if high - low <= EVEN * low.abs().max(high.abs()) {
                let (value, unit) = (format_real(0.5 * (low + high)), quantity.unit);
                notes.push(format!(
                    "{} of fracture \"{name}\" is {value} {unit} everywhere at the end.",
                    quantity.name
                ));
                continue;
            }
            let id = format!("fracture_{fracture}_{}", quantity.id);
            let caption = format!(
                "{} of fracture \"{name}\" at {} s.",
                quantity.name,
                format_real(run.state().time)
            );
            let what = (
                id,
                caption,
                format!("{} [{}]", quantity.name, quantity.unit),
            );
            figures.push(plane.figure(what, values, [low, high]));
        }
    }
    (figures, notes)
}

/// A value per face.
struct Quantity<'a> {
    id: &'static str,
    name: &'static str,
    unit: &'static str,
    of: Box<dyn Fn(usize) -> f64 + 'a>,
}

fn quantities<'a>(fields: &'a FaceFields, states: &'a [ContactState]) -> [Quantity<'a>; 5] {
    [
        Quantity {
            id: "state",
            name: "State (0 stick, 2 slip, 3 open)",
            unit: "1",
            of: Box::new(|f| f64::from(states[f].code())),
        },
        Quantity {
            id: "normal",
            name: "Normal traction",
            unit: "MPa",
            of: Box::new(|f| 1e-6 * fields.traction[3 * f]),
        },
        Quantity {
            id: "opening",
            name: "Opening",
            unit: "mm",
            of: Box::new(|f| 1e3 * fields.aperture[f]),
        },
        Quantity {
            id: "slip",
            name: "Slip",
            unit: "mm",
            of: Box::new(|f| 1e3 * fields.slip[f]),
        },
        Quantity {
            id: "criticality",
            name: "Shear over its limit",
            unit: "1",
            of: Box::new(|f| fields.criticality[f]),
        },
    ]
}

/// A direction in the plane of a fracture.
struct Direction {
    along: [f64; 3],
    name: String,
}

impl Direction {
    /// Along this unit vector or against it, so that it points up, or north, or east.
    fn new(along: [f64; 3], otherwise: &str) -> Self {
        let largest = along.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let leading = along.iter().rev().find(|x| x.abs() > 0.9 * largest);
        let sign = leading.map_or(1.0, |x| x.signum());
        let along = along.map(|x| sign * x);
        let axis = (0..3).find(|k| along[*k] > 1.0 - 1e-9);
        let name = axis.map_or(otherwise, |k| ["x", "y", "z"][k]).to_owned();
        Self { along, name }
    }

    /// m.
    fn at(&self, x: [f64; 3]) -> f64 {
        (0..3).map(|k| self.along[k] * x[k]).sum()
    }
}

/// The faces of a fracture, laid flat.
struct Plane {
    directions: [Direction; 2],
    quads: Vec<[[f64; 2]; 4]>,
    sides: [f64; 2],
}

impl Plane {
    fn new(mesh: &HexMesh, faces: &[(usize, &FractureFace)]) -> Self {
        let mut normal = [0.0; 3];
        for (_, face) in faces {
            (0..3).for_each(|k| normal[k] += face.area * face.frame[0][k]);
        }
        let directions = plane(normal);
        let place = |a: u32| [0, 1].map(|d: usize| directions[d].at(mesh.nodes[a as usize]));
        let quads: Vec<_> = (faces.iter())
            .map(|(_, face)| face.minus.nodes.map(place))
            .collect();
        let sides = [0, 1].map(|d: usize| {
            let at = || quads.iter().flatten().map(|p| p[d]);
            at().fold(f64::NEG_INFINITY, f64::max) - at().fold(f64::INFINITY, f64::min)
        });
        Self {
            directions,
            quads,
            sides,
        }
    }

    fn axis(&self, d: usize) -> Axis {
        Axis::linear(&format!("{} [m]", self.directions[d].name))
    }

    /// A map, or a profile along the longer side.
    fn figure(
        &self,
        (id, caption, label): (String, String, String),
        values: Vec<f64>,
        [low, high]: [f64; 2],
    ) -> Figure {
        let [a, b] = self.sides;
        if a.min(b) > NARROW * a.max(b) {
            let mut figure = Figure::new(&id, "", &caption, self.axis(0), self.axis(1));
            figure.cells = Some(Cells {
                label,
                quads: self.quads.clone(),
                values,
                range: [low, high],
            });
            figure.equal_aspect = true;
            return figure;
        }
        let long = usize::from(b > a);
        let middle = |quad: &[[f64; 2]; 4]| 0.25 * quad.iter().map(|p| p[long]).sum::<f64>();
        let mut points: Vec<[f64; 2]> = (self.quads.iter().zip(values))
            .map(|(quad, value)| [middle(quad), value])
            .collect();
        points.sort_by(|p, q| p[0].total_cmp(&q[0]));
        Figure::new(&id, "", &caption, self.axis(long), Axis::linear(&label)).with(Series::new(
            "",
            Mark::Points,
            points,
        ))
    }
}

/// Along strike and up dip of a plane with this normal, of any length; x and y of a level one.
fn plane(normal: [f64; 3]) -> [Direction; 2] {
    let unit = |v: [f64; 3]| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    };
    let n = unit(normal);
    // z × n
    let strike = match n[0].hypot(n[1]) {
        level if level < 1e-9 => [1.0, 0.0, 0.0],
        _ => unit([-n[1], n[0], 0.0]),
    };
    let dip = [
        n[1] * strike[2] - n[2] * strike[1],
        n[2] * strike[0] - n[0] * strike[2],
        n[0] * strike[1] - n[1] * strike[0],
    ];
    [
        Direction::new(strike, "along strike"),
        Direction::new(dip, "up dip"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_of_the_axes_are_named_by_them_and_dipping_ones_by_strike_and_dip() {
        for (normal, names) in [
            ([2.0, 0.0, 0.0], ["y", "z"]),
            ([0.0, -3.0, 0.0], ["x", "z"]),
            ([0.0, 0.0, 1.0], ["x", "y"]),
            ([1.0, 0.0, -1.0], ["y", "up dip"]),
            ([1.0, 1.0, 0.0], ["along strike", "z"]),
        ] {
            let found = plane(normal);
            assert_eq!(found.each_ref().map(|d| &*d.name), names);
            for direction in &found {
                assert!(direction.at(normal).abs() < 1e-12);
                assert!((direction.at(direction.along) - 1.0).abs() < 1e-12);
            }
            assert!(found[1].along[2] >= 0.0);
        }
    }
}
