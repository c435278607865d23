//! Proofs in f64 of where the eigenvalues of M⁻¹𝒜 lie, with exact S_u.
//!
//! What is proved is a statement about the blocks as they are given, every entry an f64, and `M = [A B1; B1ᵀ −C]`, not about what an
//! iteration does with rounded factors. It holds in spite of rounding: every error of a product, a factorization or an inverse is bounded
//! from above after the fact (`rounding`).
//!
//! * Symmetric blocks, and A ≻ 0 or C ≻ H (proved, too): all eigenvalues are real, and the signs of `𝒜 − σM` count those beyond σ. With
//!   A ≻ 0 its Schur complement on tractions is `−((S + H) − σ(S + C))`, S = BᵀA⁻¹B; with C ≻ H they are those of the definite pencil
//!   `(diag(0, C − H), M)`.
//! * All others: discs of Gershgorin for `1 + eig(K)` (`discs`).

#[cfg(test)]
mod cases;
mod discs;
mod inertia;
mod pencil;
mod rounding;
#[cfg(test)]
mod tests;

use super::SpectrumRequest;
use super::report::{CONTAINED_TOLERANCE, SpectrumReport};
use crate::SetupError;
use crate::saddle::{AugmentationMatrix, InnerChoice, SaddleBlocks};
use discs::Disc;
use pencil::{Pencil, Route};
use serde::Serialize;

/// Most unknowns: dense matrices of n², and up to a dozen factorizations.
pub const LARGEST: usize = 2000;

/// Widths of enclosures that are tried, relative to max(1, |λ|).
const WIDTHS: [f64; 5] = [1e-11, 1e-9, 1e-7, 1e-5, 1e-3];

/// What is proved of the eigenvalues, rounding included.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Enclosures {
    /// Of what, and by which argument.
    pub statement: String,
    /// The smallest real eigenvalue lies in it.
    pub real_min: Option<(f64, f64)>,
    /// The largest real eigenvalue lies in it.
    pub real_max: Option<(f64, f64)>,
    /// Every Re λ lies in it.
    pub re: Option<(f64, f64)>,
    /// No |Im λ| is larger; 0 where all eigenvalues are proved to be real.
    pub im_max: Option<f64>,
    /// Every eigenvalue lies in the interval of `bounds` widened by 1e-7, the tolerance of the verdict; null without such bounds.
    pub contained: Option<bool>,
    /// Why something is missing.
    pub reason: Option<String>,
}

impl Enclosures {
    fn failed(reason: impl Into<String>) -> Self {
        Self {
            statement: "nothing is proved".to_owned(),
            real_min: None,
            real_max: None,
            re: None,
            im_max: None,
            contained: None,
            reason: Some(reason.into()),
        }
    }

    /// All that was asked for, and nothing that speaks against it.
    pub fn is_complete(&self) -> bool {
        self.real_min.is_some()
            && self.real_max.is_some()
            && self.contained != Some(false)
            && self.reason.is_none()
    }
}

/// Refuses what has no explicit blocks, before anything is computed.
pub(super) fn refuse(
    blocks: &SaddleBlocks,
    request: &SpectrumRequest,
    is_relaxed: bool,
) -> Result<(), SetupError> {
    let no = |reason: String| {
        Err(SetupError::NotApplicable {
            method: "certify",
            reason,
        })
    };
    let n = blocks.n_u() + blocks.n_t();
    match request.inner {
        InnerChoice::Exact { .. } if is_relaxed => no(
            "H is relaxed, so M has no explicit blocks; take method = \"racp:published\"".into(),
        ),
        InnerChoice::Exact { .. } if n > LARGEST => no(format!(
            "{n} unknowns are more than {LARGEST}; take a coarser mesh"
        )),
        InnerChoice::Exact { .. } => Ok(()),
        _ => no("only an exact S_u makes M explicit; take inner = \"exact\"".into()),
    }
}

/// Proves what can be proved of the eigenvalues that the report has found, in (u, t).
pub fn enclosures(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    report: &SpectrumReport,
) -> Enclosures {
    if blocks.n_u() == 0 {
        return Enclosures::failed("without displacements 1 need not be an eigenvalue");
    }
    let pencil = Pencil::new(blocks, c);
    let mut found = match pencil.is_symmetric().then(|| pencil.route()).flatten() {
        Some(route) => by_signs(&pencil, route, report),
        None => match discs::discs(&pencil) {
            Ok(discs) => by_discs(&discs, pencil.sizes().0),
            Err(reason) => Enclosures::failed(reason),
        },
    };
    let region = report.region.real.filter(|_| report.contained.is_some());
    found.contained = region.map(|(low, high)| {
        let room = |end: f64| CONTAINED_TOLERANCE * end.abs().max(1.0);
        let ends = found.re.zip(found.im_max);
        ends.is_some_and(|((re_low, re_high), im)| {
            re_low >= low - room(low) && re_high <= high + room(high) && im <= room(high)
        })
    });
    if found.contained == Some(false) && found.reason.is_none() {
        found.reason = Some("the enclosures reach beyond the bounds".to_owned());
    }
    if report.contained == Some(false) && found.contained == Some(true) {
        found.reason = Some(
            "eigenvalues found in f64 lie outside of the bounds, where none is proved to lie"
                .to_owned(),
        );
    }
    found
}

fn by_signs(pencil: &Pencil, route: Route, report: &SpectrumReport) -> Enclosures {
    let hypothesis = match route {
        Route::Stiff => "A ≻ 0, C ≻ 0",
        Route::Dominated => "C ≻ H, S_u ≻ 0",
    };
    let (found_low, found_high) = report.real_min.zip(report.real_max).unwrap_or((1.0, 1.0));
    // 1 is an eigenvalue n_u times, so that the smallest is not above it and the largest not below
    let width = |w: f64, at: f64| w * at.abs().max(1.0);
    let least = (WIDTHS.iter()).find_map(|w| {
        let low = found_low.min(1.0) - width(*w, found_low);
        pencil.none_below(low).then_some(low)
    });
    let below = WIDTHS.iter().find_map(|w| {
        let high = found_low + width(*w, found_low);
        (high < 1.0 && pencil.one_below(high)).then_some(high)
    });
    let most = match route {
        // S + H ≺ S + C, or C − H ≻ 0 with a semidefinite remainder
        Route::Stiff if found_high <= 1.0 + WIDTHS[0] && pencil.c_dominates() => Some(1.0),
        _ => WIDTHS.iter().find_map(|w| {
            let high = found_high.max(1.0) + width(*w, found_high);
            pencil.none_above(high, route).then_some(high)
        }),
    };
    let above = WIDTHS.iter().find_map(|w| {
        let low = found_high - width(*w, found_high);
        (low > 1.0 && pencil.one_above(low, route)).then_some(low)
    });
    let missing = least.is_none() || most.is_none();
    Enclosures {
        statement: format!(
            "all eigenvalues are real ({hypothesis} proved), and the signs of 𝒜 − σM count them, for the blocks as given in f64"
        ),
        real_min: least.map(|low| (low, below.unwrap_or(1.0))),
        real_max: most.map(|high| (above.unwrap_or(1.0), high)),
        re: least.zip(most),
        im_max: Some(0.0),
        contained: None,
        reason: missing.then(|| "rounding hides the signs next to an end".to_owned()),
    }
}

fn by_discs(discs: &[Disc], n_u: usize) -> Enclosures {
    let ends = |discs: &mut dyn Iterator<Item = &Disc>| {
        discs.fold((1.0_f64, 1.0_f64), |(low, high), disc| {
            let (center, radius) = (disc.center.re, disc.radius);
            (
                low.min((center - radius).next_down()),
                high.max((center + radius).next_up()),
            )
        })
    };
    let real = ends(&mut discs.iter().filter(|disc| disc.touches()));
    // a disc of its own with a real centre holds a real eigenvalue
    let alone = discs.iter().filter(|disc| disc.is_alone(discs));
    let (low, high) = alone.fold((1.0_f64, 1.0_f64), |(low, high), disc| {
        let (center, radius) = (disc.center.re, disc.radius);
        (
            low.min((center + radius).next_up()),
            high.max((center - radius).next_down()),
        )
    });
    let im = |disc: &Disc| (disc.center.im.abs() + disc.radius).next_up();
    // real where every disc is one of its own around a real centre
    let is_real = discs.iter().all(|disc| disc.is_alone(discs));
    Enclosures {
        statement: format!(
            "1 at least {n_u} times, the others in {} discs (Gershgorin), for the blocks as given in f64",
            discs.len()
        ),
        real_min: Some((real.0, low)),
        real_max: Some((high, real.1)),
        re: Some(ends(&mut discs.iter())),
        im_max: Some(match is_real {
            true => 0.0,
            false => discs.iter().map(im).fold(0.0, f64::max),
        }),
        contained: None,
        reason: None,
    }
}
