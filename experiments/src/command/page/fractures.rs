//! Fractures: traction, slip and state on each.

use super::ground::{Ground, Moment, Quantity, Scale};
use super::unit::Kind;
use crate::report::Panels;
use fracas::run::Stored;
use fracas::scene::Body;
use fracas_figures::section::{Patches, in_plane};

/// Fractures that are shown.
const FRACTURES: usize = 6;

/// Sides of a fracture, short over long, below which a profile shows more than a map. Unit: 1.
const NARROW: f64 = 0.1;

/// Rows of figures of a fracture.
const ROWS: usize = 7;

/// Names of states in the order of their codes.
const STATES: [&str; 4] = ["stick", "new-slip", "slip", "open"];

/// Fractures with their quantities, filled step by step.
pub(super) struct Fractures {
    shown: Vec<Shown>,
    /// Those that are not drawn.
    left: usize,
}

struct Shown {
    ground: Ground,
    name: String,
    quantities: Vec<Quantity>,
    states: Vec<Vec<f64>>,
}

/// Number of figures that the fractures of a body may take per step.
pub(super) fn figures(body: &Body) -> usize {
    ROWS * body.fractures.names.len().min(FRACTURES)
}

impl Fractures {
    /// Of a body, each of at most about `most` pieces: the largest ones.
    pub(super) fn new(body: &Body, most: usize) -> Self {
        let mut areas = vec![0.0; body.fractures.names.len()];
        for face in &body.fractures.faces {
            areas[usize::from(face.fracture)] += face.area;
        }
        let mut order: Vec<usize> = (0..areas.len()).filter(|k| areas[*k] > 0.0).collect();
        order.sort_by(|a, b| areas[*b].total_cmp(&areas[*a]));
        let left = order.len().saturating_sub(FRACTURES);
        order.truncate(FRACTURES);
        order.sort_unstable();
        let shown = order.into_iter().map(|k| Shown::new(body, k, most));
        Self {
            shown: shown.collect(),
            left,
        }
    }

    /// Takes what is shown of a step.
    pub(super) fn add(&mut self, stored: &Stored) {
        for shown in &mut self.shown {
            let of = &shown.ground.patches.of;
            for quantity in &mut shown.quantities {
                let row = of.iter().map(|f| value(quantity.id, stored, *f));
                quantity.values.push(row.collect());
            }
            let states = of.iter().map(|f| stored.states[*f]);
            shown.states.push(states.collect());
        }
    }

    /// The figures, and what is the same everywhere.
    pub(super) fn panels(self, moments: &[Moment], scale: Scale) -> (Vec<Panels>, Vec<String>) {
        let (mut all, mut notes) = (Vec::new(), Vec::new());
        for shown in self.shown {
            let first = all.len();
            let name = &shown.name;
            let changes = shown.states.iter().flatten().any(|s| *s != 0.0);
            let map_of = |(moment, of): (&Moment, &Vec<f64>)| {
                let id = format!("state_{}", moment.step);
                let names = STATES.map(str::to_owned).to_vec();
                let mut map = shown.ground.classes(&id, &moment.title, names, of.clone());
                map.caption.clone_from(&moment.why);
                map
            };
            if changes {
                all.push(Panels {
                    title: String::new(),
                    caption: format!("Contact state {}.", shown.ground.place),
                    figures: moments.iter().zip(&shown.states).map(map_of).collect(),
                });
            } else {
                notes.push(format!(
                    "Every face of fracture \"{name}\" sticks at these steps."
                ));
            }
            let (panels, same) = shown.ground.panels(shown.quantities, moments, scale);
            all.extend(panels);
            notes.extend(same);
            if let Some(panels) = all.get_mut(first) {
                panels.title = format!("Fracture \"{name}\"");
            }
        }
        if self.left > 0 {
            notes.push(format!(
                "The {FRACTURES} largest fractures are drawn; scene.pvd shows the {} others, and fault.csv sums them up.",
                self.left
            ));
        }
        (all, notes)
    }
}

impl Shown {
    fn new(body: &Body, fracture: usize, most: usize) -> Self {
        let faces = body.fractures.faces.iter().enumerate();
        let own: Vec<_> = faces
            .filter(|(_, face)| usize::from(face.fracture) == fracture)
            .collect();
        let mut normal = [0.0; 3];
        for (_, face) in &own {
            (0..3).for_each(|k| normal[k] += face.area * face.frame[0][k]);
        }
        if normal == [0.0; 3] {
            // of a closed surface, seen from above
            normal = [0.0, 0.0, 1.0];
        }
        let nodes = own.iter().flat_map(|(_, face)| face.minus.nodes);
        let points = nodes.map(|a| body.mesh.nodes[a as usize]);
        let directions = in_plane(normal, points);
        let mut patches = Patches::default();
        for (f, face) in own {
            let place = |a: u32| {
                let x = body.mesh.nodes[a as usize];
                [0, 1].map(|d: usize| directions[d].at(x))
            };
            patches.add(&face.minus.nodes.map(place), f);
        }
        let name = body.fractures.names[fracture].clone();
        let all = [
            ("normal", "Normal traction t_N", Kind::Stress),
            ("shear", "Shear traction ‖t_T‖", Kind::Stress),
            ("slip", "Slip", Kind::Length),
            ("opening", "Opening", Kind::Length),
            ("criticality", "Shear over its limit", Kind::Share),
            ("pressure", "Pressure of the fluid", Kind::Stress),
        ];
        Self {
            ground: Ground {
                id: format!("fracture_{fracture}"),
                place: format!("on fracture \"{name}\""),
                directions,
                patches: patches.thinned(most),
                outlines: Vec::new(),
                narrow: NARROW,
            },
            name,
            quantities: all
                .map(|(id, name, kind)| Quantity {
                    id,
                    name: name.into(),
                    kind,
                    values: Vec::new(),
                })
                .into(),
            states: Vec::new(),
        }
    }
}

fn value(id: &str, stored: &Stored, f: usize) -> f64 {
    match id {
        "normal" => stored.traction[3 * f],
        "shear" => stored.traction[3 * f + 1].hypot(stored.traction[3 * f + 2]),
        "slip" => stored.slip[f],
        "opening" => stored.aperture[f],
        "criticality" => stored.criticality[f],
        _ => stored.pressure[f],
    }
}
