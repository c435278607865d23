//! One call: C, S_u, conditions, eigenvalues, bounds, verdicts.

use super::bounds::{Bounds, Ingredients, Theorem};
use super::condition::StiffnessEnds;
use super::coupling::Coupling;
use super::modes::{self, Judge, ModeTarget};
use super::product::{Preconditioned, energy_scales};
use super::report::{Eigenvalues, Method, Parts, SpectrumReport};
use super::similarity::Similarity;
use super::{Hypothesis, condition, field_of_values, hypotheses, iterative};
use crate::direct::DirectSolver;
use crate::eigen::dense;
use crate::saddle::{
    AugmentationChoice, AugmentationMatrix, InnerChoice, RacpInverse, SaddleBlocks,
};
use crate::{Observer, SetupError, Step};
use faer::{Mat, c64};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Dense, Preconditioner};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Relative difference of two entries that counts as equal when symmetry is asked for.
const SYMMETRY: f64 = 1e-12;

/// What to analyse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SpectrumRequest {
    /// C.
    pub augmentation: AugmentationChoice,
    /// S̃_u⁻¹.
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
    /// Largest dense eigenvalue problem; above it only outer eigenvalues are found.
    pub dense_limit: usize,
    /// κ₂(A) and κ₂(S_u) too: a sparse factorization of each, which costs more than the rest of a large problem.
    pub conditions: bool,
    /// Eigenvectors wanted.
    pub modes: Vec<ModeTarget>,
}

impl Default for SpectrumRequest {
    fn default() -> Self {
        Self {
            augmentation: AugmentationChoice::default(),
            inner: InnerChoice::default(),
            dense_limit: 5000,
            conditions: true,
            modes: Vec::new(),
        }
    }
}

/// Which statements may be made of the blocks.
pub(super) struct Structure {
    /// B2 = B1ᵀ, A and H symmetric.
    pub(super) symmetric: bool,
    h_is_zero: bool,
    /// What it says, condition by condition.
    hypotheses: Vec<Hypothesis>,
}

/// Analyses M⁻¹𝒜: whatever can still be done is done, with notes.
///
/// With exact S_u and B2 = B1ᵀ the spectrum is 1 (n_u times) and that of an n_t × n_t matrix, symmetric where A is SPSD, so
/// n_u does not limit it. Everything else takes an unsymmetric eigenvalue problem of size n_u + n_t. Bounds are stated and
/// judged only where all hypotheses of the report hold.
///
/// # Errors
/// Those of the augmentation and of the factorizations: C = exact with singular A, singular S_u, NaN, shapes.
pub fn analyse(
    blocks: &SaddleBlocks,
    request: &SpectrumRequest,
    observer: &mut dyn Observer,
) -> Result<SpectrumReport, SetupError> {
    let direct = request.inner.backend().solver()?;
    let mut stages = Stages { observer, done: 0 };
    let augmentation = request.augmentation.compute(blocks, direct.as_ref())?;
    stages.next("augmentation");
    let (blocks, structure, mut notes) = simplified(blocks);
    if !augmentation.empty_columns.is_empty() {
        notes.push(format!(
            "{} columns of B have no entries (first: column {}); C_local and BᵀA⁻¹B count as 1 there",
            augmentation.empty_columns.len(),
            augmentation.empty_columns[0] + 1
        ));
    }
    let c = augmentation.matrix;
    let mut hypotheses = structure.hypotheses.clone();
    let semi_definite = if structure.symmetric {
        hypotheses::semi_definite(&blocks.a, direct.as_ref())
    } else {
        Hypothesis::not_needed("A ⪰ 0")
    };
    let a_holds = semi_definite.holds == Some(true);
    let inner = (request.inner.prepare(&blocks, &c))
        .map_err(|error| for_indefinite(error, &semi_definite))?
        .inverse;
    hypotheses.push(semi_definite);
    stages.next("inner solver");
    let parts = Parts {
        preconditioner: "racp".to_owned(),
        augmentation: request.augmentation.to_string(),
        inner: request.inner.to_string(),
        c_extremes: c.extremes()?,
    };
    let mut report = SpectrumReport::empty(&blocks, parts, notes);
    report.hypotheses = hypotheses;
    if request.conditions {
        conditions(
            &mut report,
            &blocks,
            &c,
            inner.as_ref(),
            request.inner,
            direct.as_ref(),
        );
    }
    stages.next("condition numbers");

    let n = blocks.n_u() + blocks.n_t();
    let exact = matches!(request.inner, InnerChoice::Exact { .. });
    let racp = RacpInverse::new(blocks.b1.clone(), c.clone(), inner.as_ref());
    let operator = Preconditioned::new(&blocks, &racp);
    let scales = energy_scales(&blocks, &c.diagonal_entries());
    let judge = Judge {
        operator: &operator,
        scales: &scales,
    };
    let eigenvalues = if exact && structure.symmetric && blocks.n_t() <= request.dense_limit {
        let coupling = if blocks.n_u() <= request.dense_limit {
            Coupling::dense(&blocks, &c, a_holds)?
        } else {
            Coupling::sparse(&blocks, &c, a_holds, inner.as_ref())?
        };
        report.hypotheses.push(by_cholesky());
        report.modes = modes::of_coupling(
            &request.modes,
            &coupling,
            &blocks,
            &c,
            inner.as_ref(),
            &judge,
        )?;
        report.ingredients = Some(coupling.ingredients()?);
        let ones = vec![c64::new(1.0, 0.0); blocks.n_u()];
        ones.into_iter().chain(coupling.eigenvalues()?).collect()
    } else if n <= request.dense_limit {
        dense_eigenvalues(
            &mut report,
            &blocks,
            &c,
            request,
            inner.as_ref(),
            &structure,
            &judge,
        )?
    } else {
        report.method = Method::Iterative;
        report.notes.push(format!(
            "n_u + n_t = {n} is above the dense limit {}: only outer eigenvalues, without multiplicities",
            request.dense_limit
        ));
        report.hypotheses.push(if exact {
            by_cholesky()
        } else {
            hypotheses::probed(inner.as_ref())
        });
        if structure.symmetric {
            let (ingredients, error) = iterative::ingredients(&blocks, &c, inner.as_ref())?;
            report.ingredients = Some(ingredients);
            report.error_bar = Some(error);
        }
        let (values, residual) = iterative::outer_eigenvalues(&operator, &scales)?;
        report.notes.push(format!(
            "{} Ritz values with residuals below {residual:.1e}",
            values.len()
        ));
        values
    };
    stages.next("eigenvalues");
    state_bounds(&mut report, &structure, exact);
    let disc = report.bounds.theorem == Theorem::WithoutH;
    report.judge(Eigenvalues::sorted(eigenvalues), disc);
    Ok(report)
}

/// The name of the approximation in hypotheses.
const S_U: &str = "S̃_u ≻ 0";

/// What an exact inner solver has found.
fn by_cholesky() -> Hypothesis {
    Hypothesis::new(S_U, true, "Cholesky factorization of S_u")
}

/// Says that it is A where an indefinite one leaves S_u without a factorization.
fn for_indefinite(error: SetupError, semi_definite: &Hypothesis) -> SetupError {
    match (&error, semi_definite.holds) {
        (
            SetupError::NotPositiveDefinite { .. }
            | SetupError::Singular { .. }
            | SetupError::BadDiagonal { .. },
            Some(false),
        ) => SetupError::NotApplicable {
            method: "this inner solver",
            reason: format!(
                "{}, and S_u = A + B C⁻¹Bᵀ with it: {error}; take a smaller C (augmentation = \"global_times=FACTOR\") or another inner solver",
                semi_definite.reason
            ),
        },
        _ => error,
    }
}

/// Tells the observer what is done.
pub(super) struct Stages<'a> {
    pub(super) observer: &'a mut dyn Observer,
    pub(super) done: usize,
}

impl Stages<'_> {
    /// Stopping between stages would leave nothing to report, so a wish to stop is not heard here.
    pub(super) fn next(&mut self, stage: &'static str) {
        self.done += 1;
        let _ = self.observer.observe(&Step::Progress {
            stage,
            done: self.done,
            total: 4,
        });
    }
}

/// The blocks without flow, without a B2 that equals B1ᵀ and without an H of zeros, and what holds for them.
pub(super) fn simplified(blocks: &SaddleBlocks) -> (SaddleBlocks, Structure, Vec<String>) {
    let mut blocks = blocks.clone();
    let mut notes = Vec::new();
    if blocks.flow.take().is_some() {
        notes.push(
            "the pressure field is left out: this is the spectrum of the (u, t) block".to_owned(),
        );
    }
    let transpose: SparseMatrix<f64> = blocks.b1.transpose_view().to_csr();
    if blocks.b2.as_ref().is_some_and(|b2| agree(b2, &transpose)) {
        blocks.b2 = None;
    }
    if blocks
        .h
        .as_ref()
        .is_some_and(|h| h.data().iter().all(|v| *v == 0.0))
    {
        blocks.h = None;
    }
    let is_symmetric = |m: &SparseMatrix<f64>| agree(m, &m.transpose_view().to_csr());
    let conditions = [
        ("B2 = B1ᵀ", blocks.b2.is_none(), "B2 differs from B1ᵀ"),
        ("A = Aᵀ", is_symmetric(&blocks.a), "A is not symmetric"),
        (
            "H = Hᵀ",
            blocks.h.as_ref().is_none_or(is_symmetric),
            "H is not symmetric",
        ),
    ];
    for (_, _, reason) in conditions.iter().filter(|(_, holds, _)| !holds) {
        notes.push(format!(
            "{reason}: no bound is proved; see the field of values"
        ));
    }
    let structure = Structure {
        symmetric: conditions.iter().all(|(_, holds, _)| *holds),
        h_is_zero: blocks.h.is_none(),
        hypotheses: conditions
            .map(|(statement, holds, reason)| {
                let found = if holds {
                    "compared entry by entry"
                } else {
                    reason
                };
                Hypothesis::new(statement, holds, found)
            })
            .into(),
    };
    (blocks, structure, notes)
}

/// Equal up to rounding, relative to the largest entry of the row.
fn agree(a: &SparseMatrix<f64>, b: &SparseMatrix<f64>) -> bool {
    let largest = |v: &mut dyn Iterator<Item = &f64>| v.fold(0.0f64, |m, x| m.max(x.abs()));
    let difference = a - b;
    difference
        .outer_iterator()
        .zip(a.outer_iterator())
        .all(|(d, row)| largest(&mut d.data().iter()) <= SYMMETRY * largest(&mut row.data().iter()))
}

/// κ₂(A), or the kernel of a singular A. What fails becomes a note.
pub(super) fn stiffness_condition(
    report: &mut SpectrumReport,
    blocks: &SaddleBlocks,
    direct: &dyn DirectSolver,
) {
    match condition::stiffness_ends(blocks, direct) {
        Ok(StiffnessEnds {
            kernel: 0,
            ends: Some(ends),
        }) => {
            report.cond_A = Some(ends.condition());
            report.cond_A_error = Some(ends.error());
            note_accuracy(&mut report.notes, "cond_A", ends.error());
        }
        Ok(StiffnessEnds {
            kernel: 0,
            ends: None,
        }) => {
            report
                .notes
                .push("A is singular to working precision, with no clear kernel".to_owned());
        }
        Ok(StiffnessEnds { kernel, ends }) => {
            report.notes.push(format!(
                "A is singular: its kernel has dimension {kernel} (rigid-body modes of blocks held by fractures only)"
            ));
            report.kernel_A = Some(kernel);
            report.smallest_nonzero_A = ends.map(|e| e.low.value);
        }
        Err(error) => report
            .notes
            .push(format!("A is not positive semi-definite: {error}")),
    }
}

/// κ₂(A), κ₂(S_u), and the kernel of a singular A. What fails becomes a note.
fn conditions(
    report: &mut SpectrumReport,
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    inner: &dyn Preconditioner<f64>,
    choice: InnerChoice,
    direct: &dyn DirectSolver,
) {
    stiffness_condition(report, blocks, direct);
    let exact = matches!(choice, InnerChoice::Exact { .. }).then_some(inner);
    match condition::schur_ends(blocks, c, exact, direct) {
        Ok(ends) => {
            report.cond_S_u = Some(ends.condition());
            report.cond_S_u_error = Some(ends.error());
            note_accuracy(&mut report.notes, "cond_S_u", ends.error());
        }
        Err(error) => report.notes.push(format!("cond_S_u is not known: {error}")),
    }
}

/// Says when Lanczos stopped short of eight digits.
fn note_accuracy(notes: &mut Vec<String>, what: &str, error: f64) {
    const EIGHT_DIGITS: f64 = 1e-8;
    if error.is_nan() || error > EIGHT_DIGITS {
        notes.push(format!("{what} is known to a relative {error:.1e} only"));
    }
}

/// All eigenvalues of T, or of M⁻¹𝒜 in energy scales when S̃_u is not SPD.
fn dense_eigenvalues(
    report: &mut SpectrumReport,
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    request: &SpectrumRequest,
    inner: &dyn Preconditioner<f64>,
    structure: &Structure,
    judge: &Judge<'_>,
) -> Result<Vec<c64>, SetupError> {
    let matrix = match Similarity::new(blocks, c, request.inner, inner) {
        Ok(similarity) => {
            report.hypotheses.push(match request.inner {
                InnerChoice::Exact { .. } => by_cholesky(),
                _ => Hypothesis::new(S_U, true, "Cholesky factorization of S̃_u⁻¹"),
            });
            report.ingredients = Some(similarity.ingredients()?);
            let matrix = similarity.matrix();
            report.modes = modes::of_similarity(&request.modes, &similarity, &matrix, judge)?;
            if !structure.symmetric {
                report.field_of_values = Some(field_of_values::of_matrix(matrix.as_ref())?);
            }
            matrix
        }
        Err(SetupError::NotApplicable { reason, .. }) if inner.properties().linear => {
            report.notes.push(format!(
                "{reason}: eigenvalues of M⁻¹𝒜 itself, no bounds, no modes"
            ));
            report.hypotheses.push(Hypothesis::new(S_U, false, reason));
            let product = Dense::of_operator(judge.operator);
            let (n, d) = (judge.scales.len(), judge.scales);
            Mat::from_fn(n, n, |i, j| d[i] * product.entry(i, j) / d[j])
        }
        Err(error) => return Err(error),
    };
    dense::general_eigenvalues(matrix.as_ref())
}

/// Chooses the statement that holds.
fn state_bounds(report: &mut SpectrumReport, structure: &Structure, exact: bool) {
    let holds = report.objection().is_none();
    report.bounds = match &report.ingredients {
        Some(i) if holds && structure.h_is_zero => Bounds::printed(i),
        Some(i) if holds => Bounds::with_h(i),
        other => Bounds::none(other.as_ref()),
    };
    let semi_definite = |i: &Ingredients| i.h_hat.0 >= -1e-12 * i.h_hat.1.abs().max(1.0);
    if let Some(i) = report
        .ingredients
        .as_ref()
        .filter(|i| exact && holds && semi_definite(i))
    {
        report.exact_S_u_interval = Some(Bounds::exact_s_u(i));
    }
}

#[cfg(test)]
mod tests;
