//! A displacement and tractions on the mesh of a body, as two VTK grids.

use super::grids::{field, write_body, write_fractures};
use crate::scene::Body;
use std::io::{self, Write};

/// Fields of an eigenvector or of a correction of a body.
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
        write_body(self.body, &self.displacement, Vec::new(), out)
    }

    /// Writes the minus sides of the fracture faces: cell fields `traction` (n, t1, t2), `normal`, `t1`, `t2`, `fracture`.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_fracture(&self, out: &mut impl Write) -> io::Result<()> {
        write_fractures(self.body, vec![field("traction", 3, self.traction)], out)
    }
}
