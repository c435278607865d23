//! What a body is made of, what holds it and what loads it, with totals to hold against a sketch.

use super::sides::ranges;
use super::{Body, PoreField, PressureFrom, Pull};
use crate::mesh::face_geometry;
use std::fmt;

/// A material and how much of it there is.
#[derive(Clone, Debug, PartialEq)]
pub struct Stock {
    /// Its name.
    pub name: String,
    /// Elements.
    pub elements: usize,
    /// Volume [m³].
    pub volume: f64,
    /// Young's modulus [Pa].
    pub young: f64,
    /// Poisson's ratio [-].
    pub poisson: f64,
    /// Body force, gravity included [N].
    pub weight: [f64; 3],
}

/// A traction on a part of the surface at the factor 1 of its history.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// Faces of elements.
    pub faces: usize,
    /// Area [m²].
    pub area: f64,
    /// Force per area, its mean where it changes [Pa].
    pub traction: [f64; 3],
    /// Sum of the force [N].
    pub force: [f64; 3],
}

/// Materials, holds and loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Inventory {
    /// In the order of the scene.
    pub materials: Vec<Stock>,
    /// Displacements that are prescribed along x, y, z.
    pub held: [usize; 3],
    /// Those of them that are not 0, and the largest one [m].
    pub moved: [(usize, f64); 3],
    /// Loads on the surface.
    pub pushes: Vec<Push>,
    /// Pressure of the fluid in fractures that have one: name, least and largest pressure [Pa], ∫ p dA [N].
    pub pressures: Vec<(String, [f64; 2], f64)>,
    /// Fractures whose pressure follows the rock on their two sides: name, what it takes, least and largest pressure at the end [Pa].
    pub following: Vec<(String, PressureFrom, [f64; 2])>,
    /// Changes of pore pressure that differ from element to element: name of the material, what its elements take, and the lowest and
    /// highest change at the end [Pa].
    pub pores: Vec<(String, String, [f64; 2])>,
}

impl Body {
    /// Volumes, areas, counts and total loads.
    ///
    /// # Cost
    /// O(elements).
    pub fn inventory(&self) -> Inventory {
        let mut materials: Vec<Stock> = (self.material_names.iter().zip(&self.materials))
            .map(|(name, elastic)| Stock {
                name: name.clone(),
                elements: 0,
                volume: 0.0,
                young: elastic.young,
                poisson: elastic.poisson,
                weight: [0.0; 3],
            })
            .collect();
        for (e, region) in self.mesh.regions.iter().enumerate() {
            let stock = &mut materials[usize::from(*region)];
            stock.elements += 1;
            stock.volume += self.mesh.element_volume(e);
        }
        for (stock, force) in materials.iter_mut().zip(&self.body_force) {
            stock.weight = force.map(|f| f * stock.volume);
        }
        let (mut held, mut moved) = ([0; 3], [(0, 0.0f64); 3]);
        for (dof, value) in self.constraints.prescribed() {
            let i = *dof as usize % 3;
            held[i] += 1;
            if *value != 0.0 {
                moved[i].0 += 1;
                if value.abs() > moved[i].1.abs() {
                    moved[i].1 = *value;
                }
            }
        }
        Inventory {
            materials,
            held,
            moved,
            pushes: self.pushes(),
            pressures: self.fluid(),
            following: self.following(),
            pores: self.pores(),
        }
    }

    fn pushes(&self) -> Vec<Push> {
        let area =
            |nodes: &[u32; 4]| face_geometry(&nodes.map(|a| self.mesh.nodes[a as usize])).area;
        (self.tractions.iter())
            .map(|load| {
                let area: f64 = load.faces.iter().map(area).sum();
                let forces = load.forces(&self.mesh.nodes);
                let sum = |i: usize| forces.iter().skip(i).step_by(3).sum();
                let force: [f64; 3] = [0, 1, 2].map(sum);
                let (traction, force) = match load.pull {
                    Pull::Traction(t) => (t, t.map(|t| t * area)),
                    Pull::Pressure(_) => (force.map(|f| f / area), force),
                };
                Push {
                    faces: load.faces.len(),
                    area,
                    traction,
                    force,
                }
            })
            .collect()
    }

    fn fluid(&self) -> Vec<(String, [f64; 2], f64)> {
        let faces = self.fractures.faces.iter();
        let pressures: Vec<f64> = faces.map(|face| self.pressure_of(face)).collect();
        let mut forces = vec![0.0; self.fractures.names.len()];
        for (face, p) in self.fractures.faces.iter().zip(&pressures) {
            forces[usize::from(face.fracture)] += p * face.area;
        }
        let ranges = ranges(&self.fractures, &pressures).into_iter().zip(forces);
        let named = self.fractures.names.iter().zip(ranges);
        let of = |(name, (range, force)): (&String, (Option<[f64; 2]>, f64))| {
            let range = range.filter(|range| *range != [0.0; 2])?;
            Some((name.clone(), range, force))
        };
        named.filter_map(of).collect()
    }

    fn following(&self) -> Vec<(String, PressureFrom, [f64; 2])> {
        let end = self.time.map_or(0.0, |time| time.end);
        let Some(pressures) = self.pressures_of_sides(end) else {
            return Vec::new();
        };
        let ranges = ranges(&self.fractures, &pressures);
        let all = self.fractures.names.iter().zip(&self.pressures_from);
        all.zip(ranges)
            .filter_map(|((name, rule), range)| Some((name.clone(), (*rule)?, range?)))
            .collect()
    }
}

impl Body {
    fn pores(&self) -> Vec<(String, String, [f64; 2])> {
        let end = self.time.map_or(0.0, |time| time.end);
        let of = |field: &PoreField| {
            let change = field.at(end);
            let range = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| {
                let all = change.iter().copied();
                all.reduce(of).unwrap_or(0.0)
            });
            let name = self.material_names[field.region].clone();
            (name, field.to_string(), range)
        };
        self.pore_fields.iter().map(of).collect()
    }
}

impl fmt::Display for Inventory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triple = |v: [f64; 3]| format!("({:.4e}, {:.4e}, {:.4e})", v[0], v[1], v[2]);
        for m in &self.materials {
            write!(
                f,
                "material    \"{}\": {} elements, {:.6} m^3, E = {:.4e} Pa, nu = {}",
                m.name, m.elements, m.volume, m.young, m.poisson
            )?;
            match m.weight {
                [0.0, 0.0, 0.0] => writeln!(f)?,
                weight => writeln!(f, ", body force {} N", triple(weight))?,
            }
        }
        let [x, y, z] = self.held;
        writeln!(
            f,
            "held        {x} displacements along x, {y} along y, {z} along z"
        )?;
        for (axis, (count, largest)) in ["x", "y", "z"].iter().zip(self.moved) {
            if count > 0 {
                writeln!(
                    f,
                    "moved       {count} of them along {axis}, by up to {largest:.6e} m"
                )?;
            }
        }
        for push in &self.pushes {
            writeln!(
                f,
                "load        {} faces, {:.6} m^2, traction {} Pa, force {} N",
                push.faces,
                push.area,
                triple(push.traction),
                triple(push.force)
            )?;
        }
        for (name, pressure, force) in &self.pressures {
            let [least, most] = pressure;
            write!(f, "pressure    \"{name}\": {least:.4e}")?;
            if most > least {
                write!(f, " to {most:.4e}")?;
            }
            writeln!(f, " Pa, {force:.4e} N on either side")?;
        }
        for (name, rule, [low, high]) in &self.following {
            writeln!(
                f,
                "pressure    \"{name}\": {rule} of what changes on its two sides, {low:.4e} to {high:.4e} Pa at the end"
            )?;
        }
        for (name, origin, [low, high]) in &self.pores {
            writeln!(
                f,
                "pore        \"{name}\": {origin}; they change by {low:.4e} to {high:.4e} Pa until the end"
            )?;
        }
        Ok(())
    }
}
