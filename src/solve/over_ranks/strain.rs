//! `wᵀA w` of some elements, w with the prescribed displacements in their places.

use crate::elasticity::{ElasticityError, matrix_free};
use crate::mesh::HexMesh;
use crate::scene::Body;
use fracas_operators::vector::dot;
use fracas_operators::{AdjointOperator, LinearOperator};
use fracas_solvers::distributed::{PartStrain, SpreadSaddle};

/// Where a displacement comes from.
#[derive(Clone, Copy)]
enum Origin {
    /// Prescribed [m].
    Prescribed(f64),
    /// An entry of the own ones, or of the ghosts behind them.
    Entry(u32),
}

/// That of the elements `is_here`, all of whose free displacements this rank has or reads.
pub(super) fn strain_of(
    body: &Body,
    saddle: &SpreadSaddle,
    is_here: impl Fn(&[u32; 8]) -> bool,
) -> Result<PartStrain, ElasticityError> {
    let Body {
        mesh, constraints, ..
    } = body;
    let elements: Vec<usize> = (0..mesh.elements.len())
        .filter(|e| is_here(&mesh.elements[*e]))
        .collect();
    let corners = elements.iter().flat_map(|e| mesh.elements[*e]);
    let mut nodes: Vec<u32> = corners.collect();
    nodes.sort_unstable();
    nodes.dedup();
    let place = |node: u32| nodes.partition_point(|n| *n < node) as u32;
    let local = HexMesh {
        nodes: nodes.iter().map(|n| mesh.nodes[*n as usize]).collect(),
        elements: (elements.iter())
            .map(|e| mesh.elements[*e].map(place))
            .collect(),
        regions: elements.iter().map(|e| mesh.regions[*e]).collect(),
        origin: (0..nodes.len() as u32).collect(),
        grid: None,
    };
    let product: Box<dyn AdjointOperator<f64>> = matrix_free(&local, &body.materials)?;
    let own = saddle.numbering().own_u();
    let origin = |dof: usize| match constraints.free_index(dof) {
        None => Origin::Prescribed(constraints.value(dof).unwrap_or(0.0)),
        Some(free) => {
            let free = free as u32;
            let ghost = || own.len() + saddle.ghosts().partition_point(|g| *g < free);
            let entry = own.binary_search(&free).unwrap_or_else(|_| ghost());
            Origin::Entry(entry as u32)
        }
    };
    let dofs = nodes
        .iter()
        .flat_map(|n| [0, 1, 2].map(|c| 3 * *n as usize + c));
    let origins: Vec<Origin> = dofs.map(origin).collect();
    Ok(Box::new(move |u: &[f64]| {
        let of = |origin: &Origin| match origin {
            Origin::Prescribed(u) => *u,
            Origin::Entry(i) => u[*i as usize],
        };
        let w: Vec<f64> = origins.iter().map(of).collect();
        let mut image = vec![0.0; w.len()];
        product.apply(&w, &mut image, &mut vec![0.0; product.work_len()]);
        dot(&w, &image)
    }))
}
