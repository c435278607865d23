//! `z ← M⁻¹ r` by PETSc, in the slots of nodes.

use super::Multigrid;
use super::library::{Handle, Refusal, Rows};
use super::nodes::Nodes;
use crate::{DofCoordinate, SetupError};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use fracas_petsc_sys as sys;

/// Sweeps of the finest level in one V-cycle of BoomerAMG: down and up, each forward and backward, and a residual. Unit: products
/// with A.
pub(crate) const PRODUCTS_OF_FINEST_LEVEL: u64 = 5;

/// A cycle of a hierarchy that PETSc keeps.
pub(super) struct PetscInverse {
    handle: Handle,
    slots: Vec<u32>,
    flops: u64,
}

impl PetscInverse {
    /// Copies the matrix into PETSc and sets up.
    ///
    /// # Errors
    /// As [`Gamg`](super::Gamg).
    pub(super) fn new(
        of: Multigrid,
        a: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
        options: &str,
    ) -> Result<Self, SetupError> {
        let nodes = Nodes::new(a, coordinates, of.name())?;
        let kind = match of {
            Multigrid::Gamg => sys::GAMG,
            Multigrid::Boomeramg => sys::BOOMERAMG,
        };
        let rows = Rows {
            block: nodes.block,
            offsets: &nodes.offsets,
            columns: &nodes.columns,
            values: &nodes.values,
            positions: &nodes.positions,
        };
        let handle = Handle::new(kind, of.name(), &rows, options)
            .map_err(|refusal| refused(of.name(), nodes.size(), refusal))?;
        let flops = match of {
            Multigrid::Gamg => handle.flops(),
            Multigrid::Boomeramg => 2 * PRODUCTS_OF_FINEST_LEVEL * nodes.values.len() as u64,
        };
        Ok(Self {
            handle,
            slots: nodes.slots,
            flops,
        })
    }
}

/// The typed error of a refusal.
pub(crate) fn refused(method: &'static str, n: usize, refusal: Refusal) -> SetupError {
    let not = |reason| SetupError::NotApplicable { method, reason };
    match refusal {
        Refusal::Option(name) => not(format!(
            "PETSc has no use for the option {name:?} here; correct `options`, where the method itself is no option"
        )),
        Refusal::Memory => SetupError::OutOfMemory {
            method,
            n,
            bytes: None,
            advice: "use an iterative method, or a coarser mesh".to_owned(),
        },
        Refusal::Mumps(_, said) => not(format!("MUMPS stopped with {said}")),
        Refusal::Said(said) => not(format!("PETSc says: {said}")),
        Refusal::NotBegun(error) => error,
    }
}

impl Preconditioner<f64> for PetscInverse {
    fn size(&self) -> usize {
        self.slots.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let (from, to) = work[..2 * self.handle.size()].split_at_mut(self.handle.size());
        from.fill(0.0);
        for (r, slot) in r.iter().zip(&self.slots) {
            from[*slot as usize] = *r;
        }
        self.handle.apply(false, from, to);
        for (z, slot) in z.iter_mut().zip(&self.slots) {
            *z = to[*slot as usize];
        }
    }

    fn work_len(&self) -> usize {
        2 * self.handle.size()
    }

    fn flops(&self) -> u64 {
        self.flops
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}
