//! The rows of `S_u = A + (BF)(BF)ᵀ`, `C⁻¹ = F Fᵀ`, in full 3×3 blocks of nodes, and PETSc's inverse of it over all ranks.

use super::parts::rows_of;
use super::{Nodes, Numbering};
use crate::SetupError;
use crate::direct::{DirectChoice, mumps};
use crate::petsc::library::{Handle, Rows};
use crate::petsc::{PRODUCTS_OF_FINEST_LEVEL, index, refused};
use crate::saddle::InnerChoice;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use fracas_petsc_sys as sys;
use std::ffi::c_int;

/// No row in this slot: the component is held.
const NONE: u32 = u32::MAX;

/// PETSc's name for an inner solver, as messages call it, its kind, and its options; `None` for one that has no ranks.
pub(super) fn kind_of(inner: InnerChoice) -> Option<(&'static str, c_int, String)> {
    match inner {
        InnerChoice::Gamg(gamg) => Some(("GAMG", sys::GAMG, gamg.text())),
        InnerChoice::Boomeramg(boomeramg) => Some(("BoomerAMG", sys::BOOMERAMG, boomeramg.text())),
        InnerChoice::Exact {
            backend: DirectChoice::Mumps,
        } => Some(("MUMPS", sys::MUMPS_SPD, String::new())),
        _ => None,
    }
}

/// The rows of this rank before PETSc has them: held components are rows of the identity, in the scale of their node.
pub(super) struct NodeRows {
    offsets: Vec<i32>,
    columns: Vec<i32>,
    values: Vec<f64>,
    positions: Vec<f64>,
    /// Row here of every own displacement.
    slots: Vec<u32>,
}

impl NodeRows {
    /// From this rank's rows of A, with the columns of all, and all of `f = B F`.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] where rows of a rank have more entries than 31 bits count.
    pub(super) fn new(
        nodes: &Nodes,
        numbering: &Numbering,
        a: &SparseMatrix<f64>,
        f: &SparseMatrix<f64>,
        method: &'static str,
    ) -> Result<Self, SetupError> {
        let augmentation = {
            let transpose = f.transpose_view().to_csr();
            &rows_of(f, numbering.own_u()) * &transpose
        };
        let all = numbering.slots();
        index(3 * numbering.node_count(), method)?;
        let (own, first) = (numbering.own_nodes(), numbering.first_slot());
        let own_u = numbering.own_u();
        let slots = own_u.iter().map(|i| all[*i as usize] - first);
        let slots: Vec<u32> = slots.collect();
        let mut row_in = vec![NONE; 3 * own.len()];
        (slots.iter().enumerate()).for_each(|(k, slot)| row_in[*slot as usize] = k as u32);
        let mut out = Self {
            offsets: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
            positions: match nodes.positions.is_empty() {
                true => Vec::new(),
                false => (own.iter())
                    .flat_map(|n| nodes.positions[*n as usize])
                    .collect(),
            },
            slots,
        };
        let mut place = vec![NONE; numbering.node_count()];
        let mut around: Vec<u32> = Vec::new();
        for (k, rows) in row_in.as_chunks::<3>().0.iter().enumerate() {
            let node = first / 3 + k as u32;
            let free = |c: usize| (rows[c] != NONE).then_some(rows[c] as usize);
            around.clear();
            around.push(node);
            place[node as usize] = 0;
            for row in (0..3).filter_map(free) {
                for m in [a, &augmentation] {
                    for j in m
                        .outer_view(row)
                        .iter()
                        .flat_map(|row| row.indices().iter())
                    {
                        let other = all[*j as usize] / 3;
                        if place[other as usize] == NONE {
                            place[other as usize] = 0;
                            around.push(other);
                        }
                    }
                }
            }
            around.sort_unstable();
            (around.iter().enumerate()).for_each(|(k, n)| place[*n as usize] = k as u32);
            let (begin, width) = (out.values.len(), 3 * around.len());
            let (mut sum, mut count) = (0.0, 0.0);
            for c in 0..3 {
                let start = out.values.len();
                for n in &around {
                    out.columns.extend((0..3).map(|d| (3 * n + d) as i32));
                }
                out.values.resize(start + width, 0.0);
                out.offsets.push(index(out.values.len(), method)?);
                let Some(row) = free(c) else { continue };
                for m in [a, &augmentation] {
                    for (j, v) in m.outer_view(row).iter().flat_map(|row| row.iter()) {
                        let slot = all[j];
                        let column = 3 * place[slot as usize / 3] + slot % 3;
                        out.values[start + column as usize] += *v;
                    }
                }
                sum += out.values[start + 3 * place[node as usize] as usize + c];
                count += 1.0;
            }
            for c in (0..3).filter(|c| free(*c).is_none()) {
                let diagonal = begin + c * width + 3 * place[node as usize] as usize + c;
                // the scale of the node; 1 where it is held altogether
                out.values[diagonal] = if count > 0.0 { sum / count } else { 1.0 };
            }
            around.iter().for_each(|n| place[*n as usize] = NONE);
        }
        Ok(out)
    }

    /// Entries of these rows.
    pub(super) fn entries(&self) -> usize {
        self.values.len()
    }

    /// A copy of them in PETSc; by all ranks together.
    pub(super) fn into_matrix(
        self,
        method: &'static str,
    ) -> Result<(Handle, Vec<u32>), SetupError> {
        let rows = Rows {
            block: 3,
            offsets: &self.offsets,
            columns: &self.columns,
            values: &self.values,
            positions: &self.positions,
        };
        let n = self.offsets.len() - 1;
        let handle = Handle::of_ranks(&rows).map_err(|refusal| refused(method, n, refusal))?;
        Ok((handle, self.slots))
    }
}

/// `z ← S̃_u⁻¹ r` over all ranks.
pub(super) struct SpreadInverse {
    handle: Handle,
    slots: Vec<u32>,
    flops: u64,
}

impl SpreadInverse {
    /// Sets PETSc up; by all ranks together.
    pub(super) fn new(
        (handle, slots): (Handle, Vec<u32>),
        (method, kind, options): (&'static str, c_int, &str),
        n: usize,
    ) -> Result<Self, SetupError> {
        let is_mumps = kind == sys::MUMPS_SPD;
        let why = |refusal| match is_mumps {
            true => mumps::why(n, refusal),
            false => refused(method, n, refusal),
        };
        let done = handle.set_up(kind, options).map_err(why);
        let done = done.and_then(|()| match is_mumps {
            true => mumps::positive(&handle, None),
            false => Ok(()),
        });
        done.map_err(|error| error.in_block("S_u"))?;
        Ok(Self {
            handle,
            slots,
            flops: 0,
        })
    }

    /// What the ranks' flops in one application add up of, counted as by [`Gamg`](crate::petsc::Gamg) and the others; this one has rows with so
    /// many entries.
    pub(super) fn flops_here(&self, inner: InnerChoice, entries: usize, is_first: bool) -> f64 {
        match inner {
            InnerChoice::Gamg(_) => self.handle.flops() as f64,
            InnerChoice::Boomeramg(_) => (2 * PRODUCTS_OF_FINEST_LEVEL) as f64 * entries as f64,
            // MUMPS tells the entries of all of a half
            _ if is_first => 4.0 * self.handle.infog(mumps::ENTRIES),
            _ => 0.0,
        }
    }

    /// With the flops of all ranks.
    pub(super) fn counting(mut self, flops: f64) -> Self {
        self.flops = flops as u64;
        self
    }
}

impl Preconditioner<f64> for SpreadInverse {
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
