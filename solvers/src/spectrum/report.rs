//! What `analyse` says, as the JSON that other tools read.

use super::bounds::{Bounds, Ingredients, Theorem};
use super::region::{Region, Verdict, is_non_real};
use super::{Enclosures, FieldOfValues, Hypothesis, Mode, NonNormal, SpectrumRequest};
use crate::SetupError;
use crate::saddle::{RelaxationSummary, SaddleBlocks};
use crate::words::by_number;
use faer::c64;
use fracas_operators::{LinearOperator, Preconditioner};
use serde::{Serialize, Serializer};

/// An eigenvalue counts as 1 (or ½) when it is this close.
pub const AT_TOLERANCE: f64 = 1e-9;

/// Tolerance of the verdicts, relative to max(1, |λ|): the eigenvalue solver finds a double eigenvalue without two eigenvectors, as 1
/// is one with exact S_u, to √ε.
pub const CONTAINED_TOLERANCE: f64 = 1e-7;

/// The same for a triple eigenvalue with one eigenvector: ∛ε, and room for the size of the matrix.
pub const AT_CHAIN: f64 = 5e-5;

/// Begins the note of a report that lacks them.
const WITHOUT: &str = "no departure from normality, pseudospectra and field of values";

/// Eigenvalues as two lists.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Eigenvalues {
    /// Real parts.
    pub re: Vec<f64>,
    /// Imaginary parts.
    pub im: Vec<f64>,
}

impl Eigenvalues {
    /// Sorted by real, then imaginary part.
    pub fn sorted(mut values: Vec<c64>) -> Self {
        values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        Self {
            re: values.iter().map(|v| v.re).collect(),
            im: values.iter().map(|v| v.im).collect(),
        }
    }

    /// Pairs (Re λ, Im λ).
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.re.iter().copied().zip(self.im.iter().copied())
    }
}

/// An eigenvalue outside what is claimed of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outside {
    /// Re λ.
    pub re: f64,
    /// Im λ.
    pub im: f64,
    /// Which limit it breaks.
    pub verdict: Verdict,
}

/// Theorem 2 as printed, judged also where it does not apply.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Printed {
    /// The printed limits.
    pub bounds: Bounds,
    /// True when its hypotheses hold.
    pub applies: bool,
    /// Eigenvalues outside.
    pub outside: Vec<Outside>,
}

/// How the eigenvalues were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// All of them.
    Dense,
    /// The outer ones by Arnoldi, the bounds by Lanczos.
    Iterative,
}

/// The spectrum of M⁻¹𝒜, its bounds and what else is known. Infinite or undefined numbers are `None` (JSON null).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(
    non_snake_case,
    reason = "the symbols of the method are the keys of the JSON"
)]
pub struct SpectrumReport {
    /// Displacement unknowns.
    pub n_u: usize,
    /// Traction unknowns.
    pub n_t: usize,
    /// Pressure unknowns; none without flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub n_p: Option<usize>,
    /// Name of M.
    pub preconditioner: String,
    /// Name of C; `none` in a method without one.
    pub augmentation: String,
    /// Name of the approximate inverse of the displacement block; `none` in a method without one.
    pub inner: String,
    /// How H is relaxed; absent where it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxation: Option<RelaxationSummary>,
    /// λ_min(C); NaN (null) without C.
    pub c_min: f64,
    /// λ_max(C); NaN (null) without C.
    pub c_max: f64,
    /// κ₂(A); null when A is singular.
    pub cond_A: Option<f64>,
    /// κ₂(S_u).
    pub cond_S_u: Option<f64>,
    /// All eigenvalues (dense), or the outer ones (iterative).
    pub eigenvalues: Eigenvalues,
    /// Smallest real eigenvalue; null where it is not known.
    pub real_min: Option<f64>,
    /// Largest real eigenvalue, as the smallest.
    pub real_max: Option<f64>,
    /// Smallest real part of all, as above.
    pub re_min: Option<f64>,
    /// Largest real part of all, as above.
    pub re_max: Option<f64>,
    /// Largest |Im λ|, as above.
    pub im_max: Option<f64>,
    /// Non-real eigenvalues among those that were found: |Im λ| > 1e-7 max(1, |λ|).
    pub n_complex: usize,
    /// Eigenvalues with |λ − 1| ≤ 1e-9.
    pub n_at_one: usize,
    /// Eigenvalues with |λ − ½| ≤ 1e-9.
    pub n_at_half: usize,
    /// δ = λ_min(S̃_u⁻¹S_u).
    pub delta: Option<f64>,
    /// Δ = λ_max(S̃_u⁻¹S_u).
    pub Delta: Option<f64>,
    /// η = λ_max(C⁻¹H).
    pub eta: Option<f64>,
    /// What is proved, in numbers: the ends of `region`.
    pub bounds: Bounds,
    /// What is proved, statement by statement.
    #[serde(serialize_with = "by_parts")]
    pub region: Region,
    /// True: `enclosures` are proved, rounding included, and where there are bounds the verdict with them. False: eigenvalues and ends are had
    /// in f64 and judged with a tolerance.
    pub certified: bool,
    /// Where a proof is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub enclosures: Option<Enclosures>,
    /// All eigenvalues lie inside; null when nothing is proved.
    pub contained: Option<bool>,
    /// What the bounds rest on; empty where none is stated.
    pub hypotheses: Vec<Hypothesis>,
    /// In a sentence: inside, outside, or the hypothesis that fails.
    pub verdict: String,
    /// How.
    pub method: Method,
    /// Eigenvalues outside the region.
    pub outside: Vec<Outside>,
    /// Theorem 2 as printed; null where its extreme values are not defined.
    pub printed: Option<Printed>,
    /// Interval of the whole spectrum when S_u is exact, B2 = B1ᵀ and H is SPSD.
    pub exact_S_u_interval: Option<(f64, f64)>,
    /// Extreme values behind the bounds.
    pub ingredients: Option<Ingredients>,
    /// Largest relative error bar of the extreme values found iteratively; null when all are dense.
    pub error_bar: Option<f64>,
    /// Relative error bar of cond_A.
    pub cond_A_error: Option<f64>,
    /// Relative error bar of cond_S_u.
    pub cond_S_u_error: Option<f64>,
    /// dim ker A, when A is singular.
    pub kernel_A: Option<usize>,
    /// Smallest non-zero eigenvalue of A, when A is singular.
    pub smallest_nonzero_A: Option<f64>,
    /// Field of values, where no theorem speaks.
    pub field_of_values: Option<FieldOfValues>,
    /// Pseudospectra and what they say of GMRES, where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub non_normal: Option<NonNormal>,
    /// Eigenvectors asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<Mode>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

/// What the preconditioner is made of.
pub(super) struct Parts {
    pub(super) preconditioner: String,
    pub(super) augmentation: String,
    pub(super) inner: String,
    /// λ_min(C), λ_max(C).
    pub(super) c_extremes: (f64, f64),
}

impl SpectrumReport {
    /// Nothing found yet.
    pub(super) fn empty(blocks: &SaddleBlocks, parts: Parts, notes: Vec<String>) -> Self {
        let (c_min, c_max) = parts.c_extremes;
        Self {
            n_u: blocks.n_u(),
            n_t: blocks.n_t(),
            n_p: blocks.flow.as_ref().map(|flow| flow.t.rows()),
            preconditioner: parts.preconditioner,
            augmentation: parts.augmentation,
            inner: parts.inner,
            relaxation: None,
            c_min,
            c_max,
            cond_A: None,
            cond_S_u: None,
            eigenvalues: Eigenvalues::default(),
            real_min: None,
            real_max: None,
            re_min: None,
            re_max: None,
            im_max: None,
            n_complex: 0,
            n_at_one: 0,
            n_at_half: 0,
            delta: None,
            Delta: None,
            eta: None,
            bounds: Bounds::none(None),
            region: Region::default(),
            certified: false,
            enclosures: None,
            contained: None,
            hypotheses: Vec::new(),
            verdict: String::new(),
            method: Method::Dense,
            outside: Vec::new(),
            printed: None,
            exact_S_u_interval: None,
            ingredients: None,
            error_bar: None,
            cond_A_error: None,
            cond_S_u_error: None,
            kernel_A: None,
            smallest_nonzero_A: None,
            field_of_values: None,
            non_normal: None,
            modes: Vec::new(),
            notes,
        }
    }

    /// The first hypothesis that does not hold.
    pub(super) fn objection(&self) -> Option<String> {
        self.hypotheses.iter().find_map(Hypothesis::objection)
    }

    /// The departure from normality, where the request asks for it; a note where it cannot be told.
    pub(super) fn non_normal(
        &mut self,
        request: &SpectrumRequest,
        operator: &dyn LinearOperator<f64>,
        m: &dyn Preconditioner<f64>,
        blocks: &SaddleBlocks,
    ) -> Result<(), SetupError> {
        if let Some(request) = &request.non_normal {
            match NonNormal::new(operator, m, blocks, &self.eigenvalues, request) {
                Ok(found) => self.non_normal = Some(found),
                Err(SetupError::NotApplicable { reason, .. }) => {
                    self.notes.push(format!("{WITHOUT}: {reason}"));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Fills in the statistics and verdicts of the eigenvalues. Where `unsettled` Ritz values lie beyond an end of those that were found, this
    /// end is not known.
    pub(super) fn judge(&mut self, eigenvalues: Eigenvalues, unsettled: &[c64]) {
        let extreme = |values: &mut dyn Iterator<Item = f64>, larger: bool| {
            values.reduce(|a, b| if larger { a.max(b) } else { a.min(b) })
        };
        let real = || {
            eigenvalues
                .iter()
                .filter(|(re, im)| !is_non_real(*re, *im))
                .map(|(re, _)| re)
        };
        self.real_min = extreme(&mut real(), false);
        self.real_max = extreme(&mut real(), true);
        self.re_min = extreme(&mut eigenvalues.re.iter().copied(), false);
        self.re_max = extreme(&mut eigenvalues.re.iter().copied(), true);
        self.im_max = extreme(&mut eigenvalues.im.iter().map(|v| v.abs()), true);
        self.require_settled(unsettled);
        self.n_complex = eigenvalues
            .iter()
            .filter(|(re, im)| is_non_real(*re, *im))
            .count();
        let near = |target: f64| {
            eigenvalues
                .iter()
                .filter(|(re, im)| (re - target).hypot(*im) <= AT_TOLERANCE)
                .count()
        };
        self.n_at_one = near(1.0);
        self.n_at_half = near(0.5);
        let proved = self.bounds.theorem != Theorem::None;
        // exact S_u: 1 is an eigenvalue with chains of up to three vectors, found to the cube root of rounding
        let is_exact = self.ingredients.is_some_and(|i| i.is_exact());
        self.outside = outside(&eigenvalues, &self.region);
        self.outside
            .retain(|o| !is_exact || (o.re - 1.0).hypot(o.im) > AT_CHAIN);
        self.contained = proved.then_some(self.outside.is_empty());
        self.verdict = match (self.contained, self.objection()) {
            (Some(true), _) if self.method == Method::Iterative => format!(
                "every one of the {} found lies inside",
                eigenvalues.re.len()
            ),
            (Some(true), _) => "every eigenvalue lies inside".to_owned(),
            (Some(false), _) => {
                let n = self.outside.len();
                let lie = by_number(n, "eigenvalue lies", "eigenvalues lie");
                format!("{n} {lie} OUTSIDE")
            }
            (None, Some(objection)) => objection,
            (None, None) => "nothing to hold against".to_owned(),
        };
        self.printed = self.ingredients.as_ref().map(|ingredients| {
            let bounds = Bounds::printed(ingredients);
            Printed {
                applies: self.bounds.theorem == Theorem::WithoutH,
                outside: outside(&eigenvalues, &bounds.region()),
                bounds,
            }
        });
        self.eigenvalues = eigenvalues;
    }
}

impl SpectrumReport {
    /// Takes back ends beyond which eigenvalues were seen that have not settled.
    fn require_settled(&mut self, unsettled: &[c64]) {
        // chains of vectors at 1 converge to a root of rounding
        let apart = |v: &&c64| (v.re - 1.0).hypot(v.im) > AT_CHAIN;
        let unsettled = || unsettled.iter().filter(apart);
        let lowest = unsettled().map(|v| v.re).reduce(f64::min);
        let highest = unsettled().map(|v| v.re).reduce(f64::max);
        let farthest = unsettled().map(|v| v.im.abs()).reduce(f64::max);
        let mut lost = Vec::new();
        let mut require = |end: &mut Option<f64>, beyond: Option<f64>, sign: f64, name| {
            let passed = |end: &mut f64| {
                let slack = CONTAINED_TOLERANCE * end.abs().max(1.0);
                beyond.is_some_and(|beyond| sign * (beyond - *end) > slack)
            };
            if end.take_if(passed).is_some() {
                lost.push(name);
            }
        };
        require(&mut self.real_min, lowest, -1.0, "smallest real eigenvalue");
        require(&mut self.real_max, highest, 1.0, "largest real eigenvalue");
        require(&mut self.re_min, lowest, -1.0, "smallest real part");
        require(&mut self.re_max, highest, 1.0, "largest real part");
        require(&mut self.im_max, farthest, 1.0, "largest imaginary part");
        if !lost.is_empty() {
            self.notes.push(format!(
                "not known: {}; Ritz values beyond those that were found have not converged",
                lost.join(", ")
            ));
        }
    }
}

fn by_parts<S: Serializer>(region: &Region, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(region.parts())
}

fn outside(eigenvalues: &Eigenvalues, region: &super::Region) -> Vec<Outside> {
    eigenvalues
        .iter()
        .filter_map(|(re, im)| {
            let verdict = region.verdict(re, im, CONTAINED_TOLERANCE);
            (verdict != Verdict::Inside).then_some(Outside { re, im, verdict })
        })
        .collect()
}
