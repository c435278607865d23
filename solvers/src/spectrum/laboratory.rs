//! One call: C, S_u, conditions, eigenvalues, bounds, verdicts.

use super::condition::StiffnessEnds;
use super::coupling::Coupling;
use super::dense_spectrum::dense_eigenvalues;
use super::modes::{self, Judge, ModeTarget};
use super::non_normal::NonNormalRequest;
use super::product::{Preconditioned, energy_scales};
use super::report::{Eigenvalues, Method, Parts, SpectrumReport};
use super::stated::state_bounds;
use super::{Hypothesis, certify, condition, hypotheses, iterative};
use crate::direct::DirectSolver;
use crate::eigen::dense;
use crate::saddle::{
    AugmentationChoice, AugmentationMatrix, InnerChoice, Racp, RacpInverse, SaddleBlocks,
    SaddleMethod,
};
use crate::{Observer, SetupError, Step};
use faer::c64;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::{Csr, SparseMatrix};
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
    /// γ of the relaxation of H; 0 = as published. Without effect on a dense C.
    #[serde(deserialize_with = "crate::saddle::relaxation::factor")]
    pub relaxation: f64,
    /// S̃_u⁻¹, multigrid in f64.
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
    /// Largest dense eigenvalue problem; above it only outer eigenvalues are found.
    pub dense_limit: usize,
    /// κ₂(A) and κ₂(S_u) too: a sparse factorization of each, which costs more than the rest of a large problem.
    pub conditions: bool,
    /// Eigenvectors wanted.
    pub modes: Vec<ModeTarget>,
    /// Pseudospectra, field of values and what they say of GMRES.
    pub non_normal: Option<NonNormalRequest>,
    /// Proofs, rounding included, of where the ends of the spectrum lie; exact S_u only.
    pub certify: bool,
}

impl Default for SpectrumRequest {
    fn default() -> Self {
        Self {
            augmentation: AugmentationChoice::default(),
            relaxation: 0.0,
            inner: InnerChoice::default(),
            dense_limit: 5000,
            conditions: true,
            modes: Vec::new(),
            non_normal: None,
            certify: false,
        }
    }
}

/// Which statements may be made of the blocks.
pub(super) struct Structure {
    /// B2 = B1ᵀ, A and H symmetric.
    pub(super) symmetric: bool,
    pub(super) h_is_zero: bool,
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
    let inner = request.inner.in_double().unwrap_or(request.inner);
    let request = SpectrumRequest {
        inner,
        ..request.clone()
    };
    let build =
        |blocks: &SaddleBlocks, c: &AugmentationMatrix| Ok(inner.prepare(blocks, c)?.inverse);
    analyse_around(blocks, &request, &build, observer)
}

/// S̃_u⁻¹ for these blocks and this C.
pub type BuildInner<'a> = dyn Fn(&SaddleBlocks, &AugmentationMatrix) -> Result<Box<dyn Preconditioner<f64>>, SetupError>
    + 'a;

/// The same with an S̃_u⁻¹ that blocks alone do not give, such as geometric multigrid; `request.inner` is its name.
///
/// # Errors
/// Those of [`analyse`] and of `build`.
pub fn analyse_around(
    blocks: &SaddleBlocks,
    request: &SpectrumRequest,
    build: &BuildInner<'_>,
    observer: &mut dyn Observer,
) -> Result<SpectrumReport, SetupError> {
    let direct = request.inner.backend().solver()?;
    let mut stages = Stages { observer, done: 0 };
    let augmentation = request.augmentation.compute(blocks, direct.as_ref())?;
    stages.next("augmentation");
    let given = blocks;
    let (mut blocks, structure, mut notes) = simplified(blocks);
    if blocks.flow.take().is_some() {
        notes.push(
            "the pressure field is left out: this is the spectrum of the (u, t) block".to_owned(),
        );
    }
    if !augmentation.empty_columns.is_empty() {
        notes.push(format!(
            "{} columns of B have no entries (first: column {}); |H_kk| is taken for the columns of C_local and BᵀA⁻¹B there, 1 where it is 0",
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
    let inner = build(&blocks, &c).map_err(|error| for_indefinite(error, &semi_definite))?;
    hypotheses.push(semi_definite);
    stages.next("inner solver");
    let method = Racp {
        augmentation: request.augmentation,
        relaxation: request.relaxation,
        inner: request.inner,
        ..Racp::default()
    };
    let parts = Parts {
        preconditioner: SaddleMethod::Racp(method).to_string(),
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
    let mut racp = RacpInverse::new(blocks.b1.clone(), c.clone(), inner.as_ref());
    let is_dense = matches!(c, AugmentationMatrix::Dense { .. });
    if let Some(h) = blocks.h.as_ref().filter(|_| !is_dense) {
        racp = racp.relaxed(Box::new(Csr::new(h.clone())), request.relaxation);
    }
    let relaxation = racp.relaxation();
    let p = |h: f64| racp.relaxation_at(h);
    let operator = Preconditioned::new(&blocks, &racp);
    let scales = energy_scales(&blocks, &c.diagonal_entries());
    let judge = Judge {
        operator: &operator,
        scales: &scales,
        layout: blocks.layout(),
    };
    let is_relaxed = relaxation.degree > 0;
    report.relaxation = is_relaxed.then_some(relaxation);
    if request.certify {
        certify::refuse(&blocks, request, is_relaxed)?;
    }
    // unrelaxed, the n_t eigenvalues beside 1; relaxed, 2 n_t, of which there are modes only through all of T
    let reduced = match is_relaxed {
        false => blocks.n_t(),
        true if request.modes.is_empty() && blocks.n_u() >= blocks.n_t() => 2 * blocks.n_t(),
        true => n,
    };
    let mut statements = None;
    let mut unsettled = Vec::new();
    let eigenvalues = if exact
        && structure.symmetric
        && reduced <= request.dense_limit
        && reduced < n.max(1)
    {
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
        let form = coupling.form(&p)?;
        statements = Some(form.statements()?);
        let (ones, others) = match is_relaxed {
            false => (blocks.n_u(), coupling.eigenvalues()?),
            true => (
                form.ones(),
                dense::general_eigenvalues(form.matrix().as_ref())?,
            ),
        };
        let ones = vec![c64::new(1.0, 0.0); ones];
        ones.into_iter().chain(others).collect()
    } else if n <= request.dense_limit {
        dense_eigenvalues(
            &mut report,
            &blocks,
            &c,
            request,
            inner.as_ref(),
            &structure,
            &judge,
            (&p, &mut statements),
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
            let (found, error) = iterative::statements(&blocks, &c, inner.as_ref(), &racp, exact)?;
            statements = Some(found);
            report.error_bar = Some(error);
        }
        let outer = iterative::outer_eigenvalues(&operator, &scales)?;
        report.notes.push(format!(
            "{} Ritz values with residuals below {:.1e}",
            outer.values.len(),
            outer.residual
        ));
        unsettled = outer.unsettled;
        outer.values
    };
    stages.next("eigenvalues");
    let is_real = exact && !is_relaxed;
    state_bounds(&mut report, &structure, statements, relaxation, is_real);
    report.judge(Eigenvalues::sorted(eigenvalues), &unsettled);
    report.non_normal(request, &operator, &racp, &blocks)?;
    if request.certify {
        let enclosures = certify::enclosures(given, &c, &report);
        report.certified = enclosures.is_complete();
        report.enclosures = Some(enclosures);
    }
    Ok(report)
}

/// The name of the approximation in hypotheses.
pub(super) const S_U: &str = "S̃_u ≻ 0";

/// What an exact inner solver has found.
pub(super) fn by_cholesky() -> Hypothesis {
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

/// The blocks without a B2 that equals B1ᵀ and without an H of zeros, and what holds for them.
pub(super) fn simplified(blocks: &SaddleBlocks) -> (SaddleBlocks, Structure, Vec<String>) {
    let mut blocks = blocks.clone();
    let mut notes = Vec::new();
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
