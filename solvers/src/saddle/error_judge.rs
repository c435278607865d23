//! What M⁻¹r says of the error of an iterate.

use super::EnergyNorms;
use super::series::{FOLLOWS, Series};
use fracas_operators::Fields;

/// Ritz value of M⁻¹𝒜 above which M⁻¹r is taken for the error. Unit: 1.
pub const TRUSTED: f64 = 0.1;

/// Times that an error may be larger than what is said. Unit: 1.
const OPTIMISM: f64 = 10.0;

/// Share of the tolerance that the next pass aims at. Unit: 1.
const AIM: f64 = 0.5;

/// Bounds of what a pass lowers the residual by: less is not worth a start, of more nothing is known. Unit: 1.
const STEP: [f64; 2] = [1e-4, 0.1];

/// The upper one where a pass goes on with what it has: its next look has to tell whether the error falls. Unit: 1.
const ONWARD: f64 = 0.2;

/// Share by which a pass has to lower the error: else rounding is all that is left. Unit: 1.
const GAIN: f64 = 0.5;

/// Judges the errors of every field, pass by pass, by `e = 𝒜⁻¹r = (M⁻¹𝒜)⁻¹ M⁻¹r ≈ M⁻¹r`.
///
/// Where one field of M⁻¹r does not see the residuals of another ([`blind`](fracas_operators::Properties)), or M is poor, the sizes given are the
/// larger ones of M⁻¹r and of `M⁻¹r + M⁻¹(r − 𝒜M⁻¹r)`: tractions were wrong by 4e-2 where 8e-8 was said, by what errors of u of 8e-6 do to them.
///
/// Where M is poor, M⁻¹r may be too small by the eigenvalue θ of M⁻¹𝒜 nearest to zero: 1/|θ|, θ a Ritz value of the iteration, is
/// a bound, and what a further pass changes shows the error before it. Of matrices whose entries are known, and of a field of few unknowns, which
/// may have changed little by chance, the bound is taken: u was wrong by 1.3e-9 where 9e-11 was said, t by 1.2e-9 where 3e-11 was. Else the geometric
/// mean of both is, and no less than a tenth of the bound: a rule, not a theorem, tried over random systems (`tests/systems/accuracy.rs`); the
/// bound would cost runs of 300 networks 13 % more iterations.
///
/// The Ritz value of a first pass may itself be
/// too large: whether a second one has [`confirmed`](Judged::confirmed) an error is said beside it (tractions were wrong by 1.4e-3 where 6e-5 was said).
#[derive(Clone, Debug)]
pub struct ErrorJudge {
    tolerance: f64,
    last: Option<Pass>,
}

/// Errors of an iterate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// `‖e_u‖/‖u‖`, `‖e_t‖/‖t‖`, … in [`EnergyNorms`], larger than those of M⁻¹r where M is poor.
    pub error: Fields<f64>,
    /// The largest one of M⁻¹r itself.
    pub estimate: f64,
    /// True where the pass did not halve the error: rounding leaves of x what it leaves.
    pub stands: bool,
    /// True where M is not poor, or a further pass has shown by how much x changed.
    pub confirmed: bool,
    /// The Ritz value where M is poor, else 1: a pass that lowers the residual by less leaves errors along its vector as they are.
    pub hidden: f64,
}

impl Judged {
    /// Of an iterate that is not finite.
    pub fn unknown(norms: &EnergyNorms<'_>) -> Self {
        Self {
            error: norms.layout().values(f64::NAN),
            estimate: f64::NAN,
            stands: false,
            confirmed: false,
            hidden: 1.0,
        }
    }

    /// Of the solution itself.
    pub(super) fn exact(norms: &EnergyNorms<'_>) -> Self {
        Self {
            error: norms.layout().values(0.0),
            estimate: 0.0,
            stands: false,
            confirmed: true,
            hidden: 1.0,
        }
    }

    /// The same with errors of at least these, where some are known.
    pub(super) fn at_least(self, known: Option<Fields<f64>>) -> Self {
        let Some(known) = known.filter(|known| largest(known).is_finite()) else {
            return self;
        };
        Self {
            error: self.error.map(|field, error| error.max(known[field])),
            estimate: self.estimate.max(largest(&known)),
            ..self
        }
    }

    /// The largest error.
    pub fn worst(&self) -> f64 {
        largest(&self.error)
    }

    /// What has the largest error.
    pub fn part(&self) -> &'static str {
        let worst = self.error.largest();
        worst.map_or("unknowns", |(field, _)| field.name)
    }

    /// By how much the next pass is to lower the residual on the way to this tolerance.
    pub fn step(&self, tolerance: f64) -> f64 {
        self.lowered(tolerance, STEP[1])
    }

    /// The same where the pass goes on.
    pub(super) fn step_onward(&self, tolerance: f64) -> f64 {
        self.lowered(tolerance, ONWARD)
    }

    fn lowered(&self, tolerance: f64, most: f64) -> f64 {
        (AIM * tolerance / self.estimate)
            .min(self.hidden)
            .clamp(STEP[0], most)
    }
}

/// Where a pass ended.
#[derive(Clone, Debug)]
struct Pass {
    /// Norms of M⁻¹r, not relative to anything.
    error: Fields<f64>,
    estimate: f64,
    /// Kept where M is poor.
    x: Vec<f64>,
}

impl ErrorJudge {
    /// Of a first iterate, on the way to errors of at most this tolerance.
    pub fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            last: None,
        }
    }

    /// Whether the largest error is within the tolerance.
    pub(super) fn accepts(&self, judged: &Judged) -> bool {
        judged.worst() <= self.tolerance
    }

    /// Errors of these sizes relative to the norms `of`.
    pub(super) fn relative(&self, size: Fields<f64>, of: Fields<f64>) -> Fields<f64> {
        EnergyNorms::relative(size, of, self.tolerance)
    }

    /// Whether errors of these sizes, relative to the norms `of`, may be too large by what follows them ([`Series`](super::Series)): what is
    /// too large by itself need not be followed, and what is far below the tolerance is small with what follows.
    pub fn is_in_doubt(&self, size: Fields<f64>, of: Fields<f64>) -> bool {
        let worst = self.worst(size, of);
        worst <= self.tolerance && worst * FOLLOWS > self.tolerance
    }

    /// Whether the second term of this series is shorter than the first, in the field that is longest against the norms `of`: else nothing is
    /// known of the sum.
    pub(super) fn falls(&self, series: &Series, of: Fields<f64>) -> bool {
        self.worst(series.second(), of) <= (1.0 - FOLLOWS.recip()) * self.worst(series.first(), of)
    }

    /// The largest of these sizes, each relative to the norm `of` its field.
    fn worst(&self, size: Fields<f64>, of: Fields<f64>) -> f64 {
        largest(&self.relative(size, of))
    }

    /// Errors of x of these sizes for `e = M⁻¹r`, relative to the norms `of` ([`EnergyNorms::solution`] of x or more); `ritz` is the Ritz value
    /// of M⁻¹𝒜 nearest to zero, where one is known.
    ///
    /// # Cost
    /// One norm of a change of x where M is poor.
    pub fn judge(
        &mut self,
        norms: &EnergyNorms<'_>,
        (size, x): (Fields<f64>, &[f64]),
        of: Fields<f64>,
        ritz: Option<f64>,
    ) -> Judged {
        let relative = self.relative(size, of);
        let is_poor = ritz.is_none_or(|ritz| ritz < TRUSTED);
        let bound = ritz.map_or(f64::INFINITY, |ritz| TRUSTED / ritz);
        let factor = match (&self.last, is_poor) {
            (_, false) => size.map(|_, _| 1.0),
            (None, true) => size.map(|_, _| bound),
            (Some(before), true) => {
                let seen = before.effectivity(norms, x);
                let by_chance = norms.by_chance();
                let of_matrices = norms.entries().is_some();
                seen.map(|field, seen| match bound.is_finite() {
                    true if by_chance[field] || of_matrices => bound,
                    true => (seen.clamp(1.0, bound) * bound)
                        .sqrt()
                        .max(bound / OPTIMISM),
                    false => seen.max(1.0),
                })
            }
        };
        let estimate = largest(&relative);
        let confirmed = !is_poor || self.last.is_some();
        let stands = (self.last.as_ref()).is_some_and(|last| estimate > GAIN * last.estimate);
        self.last = Some(Pass {
            error: size,
            estimate,
            x: if is_poor { x.to_vec() } else { Vec::new() },
        });
        Judged {
            error: relative.map(|field, error| error * factor[field]),
            estimate,
            stands,
            confirmed,
            hidden: ritz.filter(|_| is_poor).unwrap_or(1.0),
        }
    }
}

impl Pass {
    /// Error over its estimate, field by field, the next iterate standing for the solution; infinite where that is not known.
    fn effectivity(&self, norms: &EnergyNorms<'_>, next: &[f64]) -> Fields<f64> {
        if self.x.is_empty() {
            return self.error.map(|_, _| f64::INFINITY);
        }
        let change: Vec<f64> = next.iter().zip(&self.x).map(|(y, x)| y - x).collect();
        norms.error(&change).map(|field, change| match change {
            0.0 => 1.0,
            change => change / self.error[field],
        })
    }
}

/// The largest value, NaN for none.
fn largest(values: &Fields<f64>) -> f64 {
    let values = values.iter().map(|(_, value)| value);
    values.fold(f64::NAN, f64::max)
}
