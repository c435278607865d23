//! Pieces of the saddle point around some faces: all that C of these faces depends on.

use super::MatrixFreeSaddle;
use crate::contact::Coupling;
use crate::elasticity::{Constraints, ElasticityError, reduced, stiffness_of_rows};
use crate::mesh::{FractureFace, FractureMesh, HexMesh, Incidence, Places};
use crate::system::StickSystem;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::SetupError;
use fracas_solvers::saddle::{Augmentation, AugmentationChoice, SaddleBlocks};
use rayon::prelude::*;

/// Faces of one piece: about 30 MB of A per thread in the worst case.
const FACES: usize = 2048;

/// A body or a choice without a C.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PiecesError {
    /// A choice that needs all of A, or a C that is not positive definite.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A mesh without a stiffness.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
}

impl MatrixFreeSaddle<f64> {
    /// C of this saddle point, from A on the elements around the fractures alone.
    ///
    /// # Errors
    /// Of a choice that needs all of A, with the reason; as those of the assembled computation.
    pub fn augmentation(
        &self,
        system: &StickSystem<'_>,
        choice: AugmentationChoice,
    ) -> Result<Augmentation, PiecesError> {
        let h = self.stabilization().map(|h| h.matrix());
        system.augmentation(choice, self.unit(), h)
    }
}

impl StickSystem<'_> {
    /// C for tractions counted in this unit and H in it, from A on the elements around the fractures alone.
    ///
    /// # Errors
    /// As [`MatrixFreeSaddle::augmentation`].
    pub fn augmentation(
        &self,
        choice: AugmentationChoice,
        unit: f64,
        h: Option<&SparseMatrix<f64>>,
    ) -> Result<Augmentation, PiecesError> {
        choice.require_local()?;
        let around = Around::new(self.mesh, self.fractures);
        let faces = &self.fractures.faces;
        let pieces = faces.par_chunks(FACES).enumerate().map(|(i, chunk)| {
            let piece = around.piece(self, chunk)?;
            let mut piece = piece.into_traction_unit(unit);
            piece.h = h.map(|h| diagonal_blocks(h, FACES * i, chunk.len()));
            Ok(piece)
        });
        choice.compute_in_parts(pieces, h)
    }
}

/// The 3×3 diagonal blocks of H for `count` faces from `first`.
fn diagonal_blocks(h: &SparseMatrix<f64>, first: usize, count: usize) -> SparseMatrix<f64> {
    let mut blocks = Triplets::new((3 * count, 3 * count));
    for row in 0..3 * count {
        let Some(entries) = h.outer_view(3 * first + row) else {
            continue;
        };
        for (column, value) in entries.iter() {
            if column / 3 == first + row / 3 {
                blocks.add_triplet(row, column - 3 * first, *value);
            }
        }
    }
    blocks.to_csr()
}

/// Elements around the nodes of fractures.
struct Around {
    nodes: Places,
    elements: Incidence,
}

/// Nodes of both sides of some faces.
pub(super) fn nodes_of(faces: &[FractureFace]) -> impl Iterator<Item = u32> {
    let sides = faces.iter().flat_map(|f| [f.minus.nodes, f.plus.nodes]);
    sides.flatten()
}

/// In increasing order, each once.
fn sorted(numbers: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut list: Vec<u32> = numbers.collect();
    list.sort_unstable();
    list.dedup();
    list
}

/// Place of `node` in an increasing list that has it.
fn place(nodes: &[u32], node: u32) -> u32 {
    nodes.partition_point(|n| *n < node) as u32
}

impl Around {
    fn new(mesh: &HexMesh, fractures: &FractureMesh) -> Self {
        let nodes = Places::new(mesh.nodes.len(), nodes_of(&fractures.faces));
        let elements = nodes.elements(&mesh.elements);
        Self { nodes, elements }
    }

    /// Elements around a node of a fracture.
    fn elements(&self, node: u32) -> &[u32] {
        self.nodes.of(node).map_or(&[], |k| self.elements.row(k))
    }

    /// A and B on the free displacements of the nodes of `faces`, the columns of B those of `faces`; elements and nodes
    /// keep their order, so the sums have the bits of the assembled matrices.
    fn piece(
        &self,
        system: &StickSystem<'_>,
        faces: &[FractureFace],
    ) -> Result<SaddleBlocks, ElasticityError> {
        let mesh = system.mesh;
        let touched = sorted(nodes_of(faces));
        let around = touched.iter().flat_map(|node| self.elements(*node));
        let elements = sorted(around.copied());
        let corners = |e: &u32| mesh.elements[*e as usize];
        let nodes = sorted(elements.iter().flat_map(corners));
        let local = HexMesh {
            nodes: nodes.iter().map(|n| mesh.nodes[*n as usize]).collect(),
            elements: elements
                .iter()
                .map(|e| corners(e).map(|n| place(&nodes, n)))
                .collect(),
            regions: elements.iter().map(|e| mesh.regions[*e as usize]).collect(),
            origin: (0..nodes.len() as u32).collect(),
            grid: None,
        };
        let is_touched: Vec<bool> = nodes
            .iter()
            .map(|n| touched.binary_search(n).is_ok())
            .collect();
        let a = stiffness_of_rows(&local, system.materials, |node| is_touched[node])?;
        let is_held = |dof: &u32| {
            let (node, i) = (*dof as usize / 3, *dof as usize % 3);
            let dof = 3 * nodes[node] as usize + i;
            !is_touched[node] || system.constraints.free_index(dof).is_none()
        };
        let held = (0..3 * nodes.len() as u32).filter(is_held);
        let constraints =
            Constraints::of_list(3 * nodes.len(), held.map(|dof| (dof, 0.0)).collect());
        let mut fractures = FractureMesh {
            faces: faces.to_vec(),
            ..FractureMesh::default()
        };
        for face in &mut fractures.faces {
            for side in [&mut face.minus, &mut face.plus] {
                side.nodes = side.nodes.map(|n| place(&nodes, n));
            }
        }
        let b1 = Coupling::new(&fractures, &constraints).assemble();
        Ok(SaddleBlocks {
            a: reduced(&a, &constraints),
            rhs_u: vec![0.0; b1.rows()],
            rhs_t: vec![0.0; b1.cols()],
            b1,
            b2: None,
            h: None,
            coordinates: None,
            flow: None,
        })
    }
}
