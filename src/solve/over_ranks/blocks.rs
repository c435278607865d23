//! Rows of matrices that every rank has read.

use super::super::{Problem, Solve, SolveError};
use super::Replicated;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::Observer;
use fracas_solvers::distributed::{Contact, Nodes, Numbering};
use fracas_solvers::saddle::{Racp, SaddleBlocks};
use std::sync::Arc;
use std::time::Instant;

/// Blocks of a folder, until each rank has its rows of them.
pub(super) struct BlockRows {
    blocks: SaddleBlocks,
}

impl BlockRows {
    /// Reads the matrices on every rank.
    pub(super) fn new(
        settings: &Solve,
        racp: &Racp,
        problem: &Problem,
        observer: &mut dyn Observer,
    ) -> Result<(Self, Replicated), SolveError> {
        let loaded = problem.load(observer)?;
        let refused = |what| SolveError::NotOverRanks {
            what,
            instead: "leave the engine out",
        };
        if loaded.blocks.flow.is_some() {
            return Err(refused("a system with flow"));
        }
        if loaded.blocks.b2.is_some() {
            return Err(refused("a B2 other than B1ᵀ"));
        }
        loaded.blocks.check()?;
        let unit = settings
            .traction_unit
            .unwrap_or_else(|| match loaded.is_ours {
                true => loaded.blocks.traction_unit(),
                false => 1.0,
            });
        let blocks = Arc::unwrap_or_clone(loaded.blocks).into_traction_unit(unit);
        let start = Instant::now();
        let direct = racp.inner.backend().solver()?;
        let c = racp.augmentation.compute(&blocks, direct.as_ref())?.matrix;
        let contact = Contact {
            c,
            c_s: start.elapsed().as_secs_f64(),
            compliance: blocks.contact_compliance(),
            b: blocks.b1.clone(),
            h: blocks.h.clone(),
        };
        let replicated = Replicated {
            nodes: Nodes::of_matrix(&blocks.a, blocks.coordinates.as_deref())?,
            contact,
            rhs_t: blocks.rhs_t.clone(),
            unit,
            findings: loaded.findings,
        };
        Ok((Self { blocks }, replicated))
    }

    pub(super) fn a(&self) -> &SparseMatrix<f64> {
        &self.blocks.a
    }

    /// The own rows of A and of its right-hand side.
    pub(super) fn rows(&self, numbering: &Numbering) -> (SparseMatrix<f64>, Vec<f64>) {
        let rows = || {
            let row = |i: &u32| self.blocks.a.outer_view(*i as usize);
            numbering.own_u().iter().filter_map(row)
        };
        let mut offsets = vec![0];
        for row in rows() {
            offsets.push(offsets[offsets.len() - 1] + row.nnz());
        }
        let mut columns = Vec::with_capacity(offsets[offsets.len() - 1]);
        let mut values = Vec::with_capacity(offsets[offsets.len() - 1]);
        for row in rows() {
            columns.extend_from_slice(row.indices());
            values.extend_from_slice(row.data());
        }
        let shape = (numbering.own_u().len(), self.blocks.n_u());
        let own = numbering.own_u().iter();
        let rhs = own.map(|i| self.blocks.rhs_u[*i as usize]).collect();
        (SparseMatrix::new(shape, offsets, columns, values), rhs)
    }
}
