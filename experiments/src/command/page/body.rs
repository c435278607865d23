//! The body in sections: displacement and stress.

use super::ground::{Ground, Moment, Quantity, Scale};
use super::unit::Kind;
use crate::report::Panels;
use fracas::run::Stored;
use fracas::scene::Body;
use fracas_figures::Outline;
use fracas_figures::section::{Section, planes};

/// Width of the edges of bodies and materials, and of fractures, in points.
const EDGE: f64 = 0.7;
const TRACE: f64 = 1.8;

/// Rows of figures of the first section, and of each further one.
const ROWS: [usize; 2] = [7, 4];

/// Sections with their quantities, filled step by step.
pub(super) struct Sections {
    sections: Vec<(Section, Vec<Quantity>)>,
}

/// Number of figures that sections of a body may take per step.
pub(super) fn figures(sections: usize) -> usize {
    match sections {
        0 => 0,
        n => ROWS[0] + (n - 1) * ROWS[1],
    }
}

impl Sections {
    /// Of a body, each of at most about `most(number of sections)` pieces.
    pub(super) fn new(body: &Body, most: impl Fn(usize) -> usize) -> Self {
        let planes = planes(body);
        let most = most(planes.len());
        let section = |(k, plane)| {
            let section = Section::new(body, plane, most);
            let quantities = quantities(&section, k == 0);
            (section, quantities)
        };
        Self {
            sections: planes.into_iter().enumerate().map(section).collect(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.sections.len()
    }

    /// Takes what is shown of a step.
    pub(super) fn add(&mut self, body: &Body, stored: &Stored) {
        for (section, quantities) in &mut self.sections {
            let of: Vec<usize> = section.patches.of.clone();
            let mut rows = vec![Vec::with_capacity(of.len()); quantities.len()];
            for e in of {
                let u = section.mean(&body.mesh, e, &stored.displacement);
                let sigma: [f64; 6] = std::array::from_fn(|k| stored.stress[6 * e + k]);
                for (row, quantity) in rows.iter_mut().zip(&*quantities) {
                    row.push(value(quantity.id, section, u, sigma));
                }
            }
            for (quantity, row) in quantities.iter_mut().zip(rows) {
                quantity.values.push(row);
            }
        }
    }

    /// The figures, and what is the same everywhere.
    pub(super) fn panels(
        self,
        body: &Body,
        moments: &[Moment],
        scale: Scale,
    ) -> (Vec<Panels>, Vec<String>) {
        let (mut all, mut notes) = (Vec::new(), Vec::new());
        for (k, (section, quantities)) in self.sections.into_iter().enumerate() {
            let words = section.plane.words();
            let outline = |points, width| Outline { points, width };
            let edges = section.edges.into_iter().map(|line| outline(line, EDGE));
            let traces = section.traces.into_iter().map(|line| outline(line, TRACE));
            let ground = Ground {
                id: format!("section_{}", k + 1),
                place: format!("in the section {words}"),
                directions: section.directions,
                outlines: edges.chain(traces).collect(),
                patches: section.patches,
                narrow: 0.0,
            };
            let region = |e: &usize| f64::from(body.mesh.regions[*e]);
            let of = ground.patches.of.iter().map(region).collect();
            let names = body.material_names.clone();
            let raster = match ground.patches.is_raster {
                true => " Squares stand for what lies at their centres.",
                false => "",
            };
            all.push(Panels {
                title: format!("The body in the section {words}"),
                caption: format!(
                    "Thick lines are fractures, thin ones edges of the body and of its materials. Displacements are means of an element's piece, \
                     stresses those of elements, initial stress included, tension positive. Colours are the same at all steps; the 0.5 % at either end \
                     of the values take the colour of the end.{raster}"
                ),
                figures: vec![ground.classes("materials", "materials", names, of)],
            });
            let (panels, same) = ground.panels(quantities, moments, scale);
            all.extend(panels);
            notes.extend(same);
        }
        (all, notes)
    }
}

fn quantities(section: &Section, is_first: bool) -> Vec<Quantity> {
    let [a, b] = section.directions.each_ref().map(|d| &*d.name);
    let across = |what: &str, d: &str| match d.len() {
        1 => format!("{what}_{d}"),
        _ => format!("{what} {d}"),
    };
    let both = match (a.len(), b.len()) {
        (1, 1) => format!("σ_{a}{b}"),
        _ => format!("σ {a}, {b}"),
    };
    let stress = |d: &str| match d.len() {
        1 => format!("σ_{d}{d}"),
        _ => format!("σ {d}"),
    };
    let all = [
        ("u", "Displacement ‖u‖".to_owned(), Kind::Length, true),
        (
            "u_1",
            format!("Displacement {}", across("u", a)),
            Kind::Length,
            false,
        ),
        (
            "u_2",
            format!("Displacement {}", across("u", b)),
            Kind::Length,
            false,
        ),
        (
            "sigma_1",
            format!("Normal stress {}", stress(a)),
            Kind::Stress,
            false,
        ),
        (
            "sigma_2",
            format!("Normal stress {}", stress(b)),
            Kind::Stress,
            true,
        ),
        ("tau", format!("Shear stress {both}"), Kind::Stress, true),
        (
            "mises",
            "Stress of von Mises".to_owned(),
            Kind::Stress,
            true,
        ),
    ];
    let shown = all.into_iter().filter(|(.., always)| is_first || *always);
    shown
        .map(|(id, name, kind, _)| Quantity {
            id,
            name,
            kind,
            values: Vec::new(),
        })
        .collect()
}

fn value(id: &str, section: &Section, u: [f64; 3], sigma: [f64; 6]) -> f64 {
    let [a, b] = section.directions.each_ref().map(|d| d.along);
    let dot = |x: [f64; 3], y: [f64; 3]| (0..3).map(|k| x[k] * y[k]).sum::<f64>();
    let [xx, yy, zz, xy, yz, xz] = sigma;
    let on = |n: [f64; 3]| {
        [
            xx * n[0] + xy * n[1] + xz * n[2],
            xy * n[0] + yy * n[1] + yz * n[2],
            xz * n[0] + yz * n[1] + zz * n[2],
        ]
    };
    match id {
        "u" => dot(u, u).sqrt(),
        "u_1" => dot(a, u),
        "u_2" => dot(b, u),
        "sigma_1" => dot(a, on(a)),
        "sigma_2" => dot(b, on(b)),
        "tau" => dot(a, on(b)),
        // √(3/2 s:s)
        _ => {
            let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
            let shear = xy * xy + yz * yz + xz * xz;
            (0.5 * normal + 3.0 * shear).sqrt()
        }
    }
}
