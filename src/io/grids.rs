//! The body and its fractures as VTK grids with any fields.

use super::vtu::{Cells, Field, Grid};
use crate::scene::Body;
use std::collections::HashMap;
use std::io::{self, Write};

/// A field by name, components per entity, and values.
pub(super) fn field<'a>(name: &'a str, components: usize, values: &'a [f64]) -> Field<'a> {
    Field {
        name,
        components,
        values,
    }
}

/// Writes the hexahedra with `displacement` (full numbering [m]) at the nodes, the cell field `material` and more.
///
/// # Errors
/// What the writer says.
pub(super) fn write_body(
    body: &Body,
    displacement: &[f64],
    cell_fields: Vec<Field<'_>>,
    out: &mut impl Write,
) -> io::Result<()> {
    let mesh = &body.mesh;
    let material: Vec<f64> = mesh.regions.iter().map(|r| f64::from(*r)).collect();
    let mut cell_fields = cell_fields;
    cell_fields.push(field("material", 1, &material));
    let grid = Grid {
        points: &mesh.nodes,
        cells: Cells::Hexahedra(&mesh.elements),
        point_fields: vec![field("displacement", 3, displacement)],
        cell_fields,
    };
    grid.write(out)
}

/// Writes the minus sides of the fracture faces with the cell fields `normal`, `t1`, `t2`, `fracture` and more.
///
/// # Errors
/// What the writer says.
pub(super) fn write_fractures(
    body: &Body,
    cell_fields: Vec<Field<'_>>,
    out: &mut impl Write,
) -> io::Result<()> {
    let faces = &body.fractures.faces;
    let mut number: HashMap<u32, u32> = HashMap::new();
    let mut points = Vec::new();
    let quads: Vec<[u32; 4]> = faces
        .iter()
        .map(|face| {
            face.minus.nodes.map(|node| {
                *number.entry(node).or_insert_with(|| {
                    points.push(body.mesh.nodes[node as usize]);
                    points.len() as u32 - 1
                })
            })
        })
        .collect();
    let frame = [0, 1, 2].map(|k: usize| -> Vec<f64> {
        let along = faces.iter().flat_map(|f| f.frame[k]);
        along.collect()
    });
    let fracture: Vec<f64> = faces.iter().map(|f| f64::from(f.fracture)).collect();
    let mut cell_fields = cell_fields;
    for (name, along) in ["normal", "t1", "t2"].iter().zip(&frame) {
        cell_fields.push(field(name, 3, along));
    }
    cell_fields.push(field("fracture", 1, &fracture));
    let grid = Grid {
        points: &points,
        cells: Cells::Quadrilaterals(&quads),
        point_fields: Vec::new(),
        cell_fields,
    };
    grid.write(out)
}
