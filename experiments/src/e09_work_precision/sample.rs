//! Displacements of a mesh at the nodes that coarser ones share with it.

use fracas::scene::Body;
use fracas_operators::vector::norm2;

/// The displacements of the finest mesh at its grid nodes.
pub(super) struct Sample {
    cells: usize,
    u: Vec<f64>,
}

/// Grid nodes that a fracture splits: both sides have their own displacement there.
fn split(body: &Body, vertices: usize) -> Vec<bool> {
    let mesh = &body.mesh;
    let mut split = vec![false; vertices];
    for copy in vertices..mesh.nodes.len() {
        let mut root = copy;
        while mesh.origin[root] as usize != root {
            root = mesh.origin[root] as usize;
        }
        split[root] = true;
    }
    split
}

impl Sample {
    /// From the free displacements of a body with this many cells along every axis.
    pub(super) fn new(body: &Body, cells: usize, u: &[f64]) -> Self {
        Self {
            cells,
            u: body.constraints.expand(u),
        }
    }

    /// `‖u − u_fine‖ / ‖u_fine‖` in ℓ² of the grid nodes of `body` off its fractures; its mesh divides the finest one.
    pub(super) fn error(&self, body: &Body, u: &[f64]) -> f64 {
        let u = body.constraints.expand(u);
        let lines = body.mesh.grid.as_ref().map_or(1, |grid| grid.cells[0] + 1);
        let (fine, step) = (self.cells + 1, self.cells / (lines - 1).max(1));
        let split = split(body, lines.pow(3));
        let (mut difference, mut size) = (Vec::new(), Vec::new());
        for node in (0..lines.pow(3)).filter(|n| !split[*n]) {
            let at = [node % lines, node / lines % lines, node / (lines * lines)];
            let there = step * (at[0] + fine * (at[1] + fine * at[2]));
            for i in 0..3 {
                difference.push(u[3 * node + i] - self.u[3 * there + i]);
                size.push(self.u[3 * there + i]);
            }
        }
        norm2(&difference) / norm2(&size)
    }
}
