//! A displacement and tractions on the mesh of a body, as two VTK grids.

use super::vtu::{Cells, Field, Grid};
use crate::scene::Body;
use std::collections::HashMap;
use std::io::{self, Write};

/// Fields of one state of a body.
#[derive(Clone, Debug)]
pub struct Snapshot<'a> {
    body: &'a Body,
    displacement: Vec<f64>,
    traction: &'a [f64],
}

impl<'a> Snapshot<'a> {
    /// From the unknowns `u` (free displacements) and `t` (tractions n, t1, t2 per face); prescribed displacements
    /// are shown as 0, which is what they are in an eigenvector or in a correction.
    pub fn homogeneous(body: &'a Body, u: &[f64], t: &'a [f64]) -> Self {
        let constraints = &body.constraints;
        let (n_u, n_t) = (constraints.free_len(), 3 * body.fractures.faces.len());
        assert_eq!(
            (u.len(), t.len()),
            (n_u, n_t),
            "the body has n_u = {n_u}, n_t = {n_t}"
        );
        let mut displacement = vec![0.0; constraints.full_len()];
        for (dof, value) in constraints.free().iter().zip(u) {
            displacement[*dof as usize] = *value;
        }
        Self {
            body,
            displacement,
            traction: t,
        }
    }

    /// Displacements of all nodes, `3·node + component`.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// Writes the hexahedra: point vectors `displacement`, cell field `material`.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_body(&self, out: &mut impl Write) -> io::Result<()> {
        let mesh = &self.body.mesh;
        let material: Vec<f64> = mesh.regions.iter().map(|r| f64::from(*r)).collect();
        let grid = Grid {
            points: &mesh.nodes,
            cells: Cells::Hexahedra(&mesh.elements),
            point_fields: vec![field("displacement", 3, &self.displacement)],
            cell_fields: vec![field("material", 1, &material)],
        };
        grid.write(out)
    }

    /// Writes the minus sides of the fracture faces: cell fields `traction` (n, t1, t2), `normal`, `fracture`.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_fracture(&self, out: &mut impl Write) -> io::Result<()> {
        let faces = &self.body.fractures.faces;
        let mut number: HashMap<u32, u32> = HashMap::new();
        let mut points = Vec::new();
        let quads: Vec<[u32; 4]> = faces
            .iter()
            .map(|face| {
                face.minus.nodes.map(|node| {
                    *number.entry(node).or_insert_with(|| {
                        points.push(self.body.mesh.nodes[node as usize]);
                        points.len() as u32 - 1
                    })
                })
            })
            .collect();
        let normal: Vec<f64> = faces.iter().flat_map(|f| f.frame[0]).collect();
        let fracture: Vec<f64> = faces.iter().map(|f| f64::from(f.fracture)).collect();
        let grid = Grid {
            points: &points,
            cells: Cells::Quadrilaterals(&quads),
            point_fields: Vec::new(),
            cell_fields: vec![
                field("traction", 3, self.traction),
                field("normal", 3, &normal),
                field("fracture", 1, &fracture),
            ],
        };
        grid.write(out)
    }
}

fn field<'a>(name: &'a str, components: usize, values: &'a [f64]) -> Field<'a> {
    Field {
        name,
        components,
        values,
    }
}
