//! Rows of a body: of A from the elements around the nodes of a rank, B, H and C of all faces.

use super::super::{Solve, SolveError, StuckBody};
use super::Replicated;
use super::strain::strain_of;
use crate::contact::{Coupling, prescribed_jump};
use crate::elasticity::{Constraints, lift, reduced, stiffness_of_rows};
use crate::matrix_free::MatrixFreeError;
use crate::memory;
use crate::mesh::node_graph;
use crate::scene::Body;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::Observer;
use fracas_solvers::direct::partition;
use fracas_solvers::distributed::{Contact, Nodes, Numbering, PartStrain, Ranks, SpreadSaddle};
use fracas_solvers::saddle::Racp;
use std::sync::Arc;
use std::time::Instant;

/// A mesh that every rank has.
pub(super) struct BodyRows {
    name: String,
    body: Arc<Body>,
    /// Number of every node of the mesh among those with a free displacement.
    numbers: Vec<u32>,
    count: usize,
}

impl BodyRows {
    /// Meshes on every rank, with B, H and C of all faces.
    pub(super) fn new(
        settings: &Solve,
        racp: &Racp,
        stuck: &StuckBody,
        ranks: Ranks,
        observer: &mut dyn Observer,
    ) -> Result<(Self, Replicated), SolveError> {
        let work = memory::over_ranks(ranks.size(), ranks.beside());
        let body = stuck.mesh(work, observer)?;
        let failed = |source| SolveError::Assembly {
            name: stuck.name.clone(),
            source,
        };
        let system = body.stick_system(stuck.stabilization(&body));
        let magnitude = system.magnitude().map_err(failed)?;
        let unit = settings.traction_unit.unwrap_or(magnitude.unit);
        let square = unit * unit;
        let b = Coupling::new(&body.fractures, &body.constraints).in_traction_unit(unit);
        let h = system.stabilization().map(|h| h.map(|v| v * square));
        let start = Instant::now();
        let c = system
            .augmentation(racp.augmentation, unit, h.as_ref())
            .map_err(MatrixFreeError::from)?;
        let c_s = start.elapsed().as_secs_f64();
        let (numbers, count) = body.constraints.free_nodes();
        let free = body.constraints.free();
        let numbered = body.mesh.nodes.iter().zip(&numbers);
        let numbered = numbered.filter(|(_, number)| **number != Constraints::NO_NUMBER);
        let positions = numbered.map(|(x, _)| *x).collect();
        let slot = |dof: &u32| 3 * numbers[*dof as usize / 3] + dof % 3;
        let jump = prescribed_jump(&body.fractures, &body.constraints);
        let replicated = Replicated {
            nodes: Nodes {
                slots: free.iter().map(slot).collect(),
                count,
                positions,
            },
            contact: Contact {
                b: b.assemble(),
                h,
                c: c.matrix,
                compliance: magnitude.compliance.iter().map(|c| c * square).collect(),
                c_s,
            },
            rhs_t: jump.into_iter().map(|jump| -unit * jump).collect(),
            unit,
            findings: Vec::new(),
        };
        let rows = Self {
            name: stuck.name.clone(),
            count: replicated.nodes.count,
            numbers,
            body,
        };
        Ok((rows, replicated))
    }

    fn number(&self, node: u32) -> Option<u32> {
        Some(self.numbers[node as usize]).filter(|number| *number != Constraints::NO_NUMBER)
    }

    /// Part of every node with a free displacement.
    pub(super) fn divided(&self, parts: usize) -> Result<Vec<u32>, SolveError> {
        let Body {
            mesh, fractures, ..
        } = &*self.body;
        let (offsets, around) = node_graph(mesh, fractures, self.count, |n| self.number(n));
        Ok(partition(&offsets, &around, parts)?)
    }

    /// True for the nodes of this rank, by their numbers.
    fn own(&self, numbering: &Numbering) -> Vec<bool> {
        let mut own = vec![false; self.count];
        let nodes = numbering.own_nodes().iter();
        nodes.for_each(|node| own[*node as usize] = true);
        own
    }

    /// The own rows of A, from the elements around their nodes, and of its right-hand side.
    pub(super) fn rows(
        &self,
        numbering: &Numbering,
    ) -> Result<(SparseMatrix<f64>, Vec<f64>), SolveError> {
        let failed = |source| SolveError::Assembly {
            name: self.name.clone(),
            source,
        };
        let Body {
            mesh,
            materials,
            constraints,
            ..
        } = &*self.body;
        let own = self.own(numbering);
        let is_own = |node: usize| {
            let number = self.number(node as u32);
            number.is_some_and(|number| own[number as usize])
        };
        let full = stiffness_of_rows(mesh, materials, is_own).map_err(failed)?;
        let force = self.body.forces().map_err(failed)?;
        let mut rhs: Vec<f64> = (constraints.free().iter())
            .map(|dof| force[*dof as usize])
            .collect();
        drop(force);
        if constraints.is_displaced() {
            lift(&full, constraints, &mut rhs);
        }
        let a = reduced(&full, constraints);
        drop(full);
        let own_u = numbering.own_u();
        let rhs = own_u.iter().map(|i| rhs[*i as usize]).collect();
        // the rows of other ranks are empty, so that the own ones follow each other
        let shape = (own_u.len(), a.cols());
        let (offsets, columns, values) = a.into_raw_storage();
        let mut own_offsets: Vec<usize> = own_u.iter().map(|i| offsets[*i as usize]).collect();
        own_offsets.push(values.len());
        let a = SparseMatrix::new(shape, own_offsets, columns, values);
        Ok((a, rhs))
    }

    /// The strain of the elements of this rank, where displacements are prescribed.
    pub(super) fn strain(&self, saddle: &SpreadSaddle) -> Result<Option<PartStrain>, SolveError> {
        if !self.body.constraints.is_displaced() {
            return Ok(None);
        }
        let own = self.own(saddle.numbering());
        let is_first = saddle.numbering().ranks().is_first();
        // an element is where its first free node is; those without one are on the first rank
        let is_here = |nodes: &[u32; 8]| {
            let first = nodes.iter().find_map(|node| self.number(*node));
            first.map_or(is_first, |number| own[number as usize])
        };
        let strain = strain_of(&self.body, saddle, is_here);
        strain.map(Some).map_err(|source| SolveError::Body {
            name: self.name.clone(),
            source,
        })
    }
}
