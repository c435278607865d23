//! Which Schur complement of the pressures.

use super::near::{NearSchur, coupled, entries};
use super::{fixed_stress, half_order};
use crate::SetupError;
use crate::saddle::FlowBlocks;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Which `S_p ≈ T − Q2 S_u⁻¹ Q1`. Where Q2 = 0 all of them are T, and nothing else is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PressureSchur {
    /// `T + M`, `M_ii = −r(q2_i) (S_u|_i)⁻¹ r(q1_i)` on the displacements at which the pressure of face i acts.
    FixedStress,
    /// `T + α M` with the α that brings M to the middle of what the rock gives.
    ScaledFixedStress,
    /// `T + M`, `M_ij = −r(q2_i) (S_u|_i)⁻¹ r(q1_j)` on the displacements of face i and its neighbours in T, which j is one of.
    PatchFixedStress,
    /// `T + K M`, `M = W D^½ L^(−½) D^½ Wᵀ` with a Laplacian L on the nodes of open faces: each wave of pressures counts as much as it
    /// opens. Where Q1 is not that of a surface, so that its L is not positive definite, it is [`FixedStress`](Self::FixedStress).
    #[default]
    HalfOrder,
    /// `T`.
    Transmissibility,
    /// `T − Q2 diag(S_u)⁻¹ Q1` on the pattern of T.
    Diagonal,
    /// `T − Q2 S̃_u⁻¹ Q1` itself, dense in the open faces: an oracle for small systems.
    Exact,
}

impl PressureSchur {
    /// Every choice.
    pub const ALL: [Self; 7] = [
        Self::FixedStress,
        Self::ScaledFixedStress,
        Self::PatchFixedStress,
        Self::HalfOrder,
        Self::Transmissibility,
        Self::Diagonal,
        Self::Exact,
    ];

    /// Plain name.
    pub fn name(self) -> &'static str {
        match self {
            Self::FixedStress => "fixed_stress",
            Self::ScaledFixedStress => "scaled_fixed_stress",
            Self::PatchFixedStress => "patch_fixed_stress",
            Self::HalfOrder => "half_order",
            Self::Transmissibility => "transmissibility",
            Self::Diagonal => "diagonal",
            Self::Exact => "exact",
        }
    }

    /// S_p; `near` is asked for S_u near the rows that are given to it where this choice needs it, and `s_u_inverse` is `S̃_u⁻¹`.
    ///
    /// # Cost
    /// A small dense problem per open face, in parallel; nothing where Q2 = 0. The scaled one takes some products with S̃_u⁻¹, the one
    /// of half order one, the exact one a product per pressure.
    ///
    /// # Errors
    /// Those of `near`; [`SetupError::BadDiagonal`] naming the row of S_u that has no positive diagonal entry.
    pub fn system(
        self,
        flow: &FlowBlocks,
        near: impl FnOnce(Vec<usize>) -> Result<NearSchur, SetupError>,
        s_u_inverse: &dyn Preconditioner<f64>,
    ) -> Result<PressureSystem, SetupError> {
        let faces = coupled(flow);
        if faces.is_empty() || self == Self::Transmissibility {
            return Ok(flow.t.clone().into());
        }
        if self == Self::Exact {
            return Ok(exact(flow, s_u_inverse).into());
        }
        let near = near(NearSchur::rows(flow))?;
        if self == Self::HalfOrder {
            match half_order::system(flow, &near, &faces, s_u_inverse) {
                Err(SetupError::NotPositiveDefinite { .. }) => {}
                system => return system,
            }
        }
        let m = match self {
            Self::Diagonal => fixed_stress::by_diagonal(flow, &near, &faces)?,
            Self::PatchFixedStress => fixed_stress::by_patch(flow, &near, &faces)?,
            _ => fixed_stress::by_face(flow, &near, &faces)?,
        };
        let alpha = match self {
            Self::ScaledFixedStress => fixed_stress::middle(flow, &m, s_u_inverse),
            _ => 1.0,
        };
        let m = m.map(|v| alpha * v);
        Ok((&flow.t + &m).into())
    }
}

/// `T − Q2 S̃_u⁻¹ Q1`.
fn exact(flow: &FlowBlocks, s_u_inverse: &dyn Preconditioner<f64>) -> SparseMatrix<f64> {
    let (n_u, n_p) = (flow.q1.rows(), flow.t.rows());
    let columns: SparseMatrix<f64> = flow.q1.transpose_view().to_csr();
    let (mut q, mut v) = (vec![0.0; n_u], vec![0.0; n_u]);
    let mut work = vec![0.0; s_u_inverse.work_len()];
    let mut s_p = Triplets::new((n_p, n_p));
    for (value, (i, j)) in &flow.t {
        s_p.add_triplet(i as usize, j as usize, *value);
    }
    for j in 0..n_p {
        q.fill(0.0);
        entries(&columns, j).for_each(|(row, value)| q[row] = value);
        s_u_inverse.solve(&q, &mut v, &mut work);
        for i in coupled(flow) {
            let volume: f64 = entries(&flow.q2, i).map(|(row, q2)| q2 * v[row]).sum();
            s_p.add_triplet(i, j, -volume);
        }
    }
    s_p.to_csr()
}

/// A matrix whose inverse begins with `S_p⁻¹`: S_p, or S_p with unknowns behind the pressures that make it sparse.
#[derive(Clone, Debug)]
pub struct PressureSystem {
    matrix: SparseMatrix<f64>,
    n_p: usize,
}

impl From<SparseMatrix<f64>> for PressureSystem {
    fn from(s_p: SparseMatrix<f64>) -> Self {
        Self {
            n_p: s_p.rows(),
            matrix: s_p,
        }
    }
}

impl PressureSystem {
    /// With the pressures in its first n_p rows and columns.
    pub(super) fn with_auxiliary(matrix: SparseMatrix<f64>, n_p: usize) -> Self {
        Self { matrix, n_p }
    }

    /// n_p.
    pub fn size(&self) -> usize {
        self.n_p
    }

    /// Unknowns behind the pressures.
    pub fn auxiliary(&self) -> usize {
        self.matrix.rows() - self.n_p
    }

    /// All of it.
    pub fn matrix(&self) -> &SparseMatrix<f64> {
        &self.matrix
    }
}

impl fmt::Display for PressureSchur {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`PressureSchur`]'s.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown Schur complement of the pressures {found:?}: expected {}", PressureSchur::ALL.map(PressureSchur::name).join(", "))]
pub struct UnknownPressureSchur {
    /// What was given.
    pub found: String,
}

impl FromStr for PressureSchur {
    type Err = UnknownPressureSchur;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|choice| choice.name() == name);
        found.ok_or_else(|| UnknownPressureSchur {
            found: name.to_owned(),
        })
    }
}
