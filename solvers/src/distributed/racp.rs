//! RACP over ranks: C and W of all faces on every rank, their own part of each applied, S_u⁻¹ over all.

use super::parts::{Coupled, Parts, Stabilized};
use super::schur::{NodeRows, SpreadInverse, kind_of};
use super::{Nodes, Numbering, OnRank, SpreadSaddle};
use crate::SetupError;
use crate::saddle::augmentation::AugmentationMatrix;
use crate::saddle::relaxation::Relaxation;
use crate::saddle::{ContactRows, InnerChoice, PartCost, Racp, RacpInverse, Ready};
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{Preconditioner, Properties};
use std::sync::Arc;
use std::time::Instant;

/// What there is of the fractures, on every rank: small beside A, as faces are beside cells.
#[derive(Clone, Debug)]
pub struct Contact {
    /// B, n_u × n_t.
    pub b: SparseMatrix<f64>,
    /// H, where it is not 0.
    pub h: Option<SparseMatrix<f64>>,
    /// C, which couples no more than the tractions of a face.
    pub c: AugmentationMatrix,
    /// Diagonal of `C_0 = Bᵀ diag(A)⁻¹ B`; 0 for an empty column gives way to `|H_ii|`.
    pub compliance: Vec<f64>,
    /// Wall time that C took [s].
    pub c_s: f64,
}

/// True for an S̃_u⁻¹ that there is over ranks.
pub fn takes(inner: InnerChoice) -> bool {
    kind_of(inner).is_some()
}

/// The saddle point by rows, and RACP around it; by all ranks together, each with its own rows of A and the columns of all.
///
/// # Errors
/// [`OnRank`] with the sentence of what cannot be set up: a C that couples faces, an inner solver without ranks, what PETSc says.
pub fn prepare(
    settings: &Racp,
    nodes: &Nodes,
    numbering: Numbering,
    a: SparseMatrix<f64>,
    contact: Contact,
) -> Result<(SpreadSaddle, Ready), OnRank> {
    let ranks = numbering.ranks();
    let Contact {
        b,
        h,
        c,
        compliance,
        c_s,
    } = contact;
    let inner = settings.inner;
    let begun = || {
        let kind = kind_of(inner).ok_or_else(|| not_over_ranks(inner))?;
        let own_c = rows_of_faces(&c, numbering.own_t())?;
        let f = &b * &c.inverse_root()?;
        let rows = NodeRows::new(nodes, &numbering, &a, &f, kind.0)?;
        Ok::<_, SetupError>((kind, own_c, rows))
    };
    let start = Instant::now();
    let ((method, kind, options), own_c, rows) = ranks.agree(begun())?;
    let entries = rows.entries();
    let matrix = ranks.agree(rows.into_matrix(method))?;
    let n = numbering.n_u();
    let s_u = ranks.agree(SpreadInverse::new(matrix, (method, kind, &options), n))?;
    let mut flops = [s_u.flops_here(inner, entries, ranks.is_first())];
    ranks.sum(&mut flops);
    let inner_s = start.elapsed().as_secs_f64();
    // W as one memory has it, of all faces
    let relaxation = (h.as_ref())
        .and_then(|h| Relaxation::new(Box::new(Csr::new(h.clone())), settings.relaxation, &c));
    let parts = Arc::new(ranks.agree(Parts::new(&numbering, a, &b, h.as_ref()))?);
    let of_c = Preconditioner::flops(&c);
    let own_c = OwnRows {
        c: own_c,
        flops: of_c,
    };
    let coupled = Coupled(parts.clone());
    let of_h = Box::new(Stabilized(parts.clone()));
    let relaxation = relaxation.map(|w| w.over(of_h));
    let inverse = RacpInverse::with_parts(coupled, own_c, s_u.counting(flops[0]));
    let inverse = inverse.relaxed_by(relaxation);
    let ready = Ready {
        relaxation: inverse.relaxation(),
        inverse: Box::new(inverse),
        hierarchy: None,
        parts: Some(PartCost {
            c_s,
            inner_s,
            inner_flops: flops[0] as u64,
        }),
    };
    Ok((SpreadSaddle::new(numbering, parts, &compliance), ready))
}

fn not_over_ranks(inner: InnerChoice) -> SetupError {
    SetupError::NotApplicable {
        method: "racp over ranks",
        reason: format!(
            "inner = \"{inner}\" works in one memory; take gamg, boomeramg or mumps of PETSc"
        ),
    }
}

/// C of some faces.
fn rows_of_faces(c: &AugmentationMatrix, own: &[u32]) -> Result<AugmentationMatrix, SetupError> {
    match c {
        AugmentationMatrix::Diagonal { c } => Ok(AugmentationMatrix::Diagonal {
            c: own.iter().map(|k| c[*k as usize]).collect(),
        }),
        AugmentationMatrix::FaceBlocks { c, inverse } => {
            let faces = own.iter().step_by(3).map(|k| *k as usize / 3);
            Ok(AugmentationMatrix::FaceBlocks {
                c: faces.clone().map(|f| c[f]).collect(),
                inverse: faces.map(|f| inverse[f]).collect(),
            })
        }
        _ => Err(SetupError::NotApplicable {
            method: "racp over ranks",
            reason: "its C couples faces that live on different ranks; take augmentation = \"fitted_h\", \"local_h\" or another one that is local to a face".to_owned(),
        }),
    }
}

/// C of the own faces; its flops are those of all.
struct OwnRows {
    c: AugmentationMatrix,
    flops: u64,
}

impl Preconditioner<f64> for OwnRows {
    fn size(&self) -> usize {
        Preconditioner::size(&self.c)
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.c.solve(r, z, work);
    }

    fn flops(&self) -> u64 {
        self.flops
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

impl ContactRows for OwnRows {}
