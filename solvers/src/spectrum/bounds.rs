//! What is proved about the eigenvalues of M⁻¹𝒜, as regions of the complex plane.

use serde::{Deserialize, Serialize};

/// Which statement holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theorem {
    /// Theorem 2 of M. Ferronato, SNA'25 lecture: H = 0, B2 = B1ᵀ.
    #[serde(rename = "H=0")]
    WithoutH,
    /// Its extension to symmetric H ≠ 0, B2 = B1ᵀ.
    #[serde(rename = "H!=0")]
    WithH,
    /// None: B2 ≠ B1ᵀ, H or A unsymmetric, A indefinite, or S̃_u not SPD.
    #[serde(rename = "none")]
    None,
}

/// Extreme values that the statements need. With `K = Eᵀ(S_u + BC⁻¹Bᵀ)E`, `G = EᵀBF`, `Ĥ = FᵀHF`:
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ingredients {
    /// λ_min(K), λ_max(K).
    pub k: (f64, f64),
    /// Extreme singular values of G: the smallest over all of R^{n_t}, so 0 when n_t > n_u.
    pub g: (f64, f64),
    /// λ_min(Ĥ), λ_max(Ĥ).
    pub h_hat: (f64, f64),
    /// Extremes of `K_H = K − GĤGᵀ`.
    pub k_h: (f64, f64),
    /// `‖G(I − Ĥ)‖₂`.
    pub coupling: f64,
}

/// Bounds with the extreme values they come from; `None` is undefined.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// Which statement.
    pub theorem: Theorem,
    /// λ_min(K).
    pub alpha_u: Option<f64>,
    /// λ_max(K).
    pub beta_u: Option<f64>,
    /// σ_min(G).
    pub alpha_t: Option<f64>,
    /// σ_max(G).
    pub beta_t: Option<f64>,
    /// Real eigenvalues are not below this.
    pub real_low: Option<f64>,
    /// Real eigenvalues are not above this.
    pub real_high: Option<f64>,
    /// Real parts of non-real eigenvalues are not below this.
    pub re_low: Option<f64>,
    /// Real parts of non-real eigenvalues are not above this.
    pub re_high: Option<f64>,
    /// |Im λ| is not above this; 0 when no eigenvalue is non-real.
    pub im_max: Option<f64>,
}

impl Bounds {
    /// Nothing is proved; the extreme values are kept where they exist.
    pub fn none(ingredients: Option<&Ingredients>) -> Self {
        Self {
            theorem: Theorem::None,
            alpha_u: ingredients.map(|i| i.k.0),
            beta_u: ingredients.map(|i| i.k.1),
            alpha_t: ingredients.map(|i| i.g.0),
            beta_t: ingredients.map(|i| i.g.1),
            real_low: None,
            real_high: None,
            re_low: None,
            re_high: None,
            im_max: None,
        }
    }

    /// Theorem 2 as printed, for H = 0 and B2 = B1ᵀ:
    /// ```text
    /// real:     min{α_u, 2α_t²/(β_u + √(β_u² − 4α_t²))} ≤ λ ≤ β_u
    /// non-real: α_u/2 ≤ Re λ ≤ β_u/2,  |Im λ| ≤ √(β_t² − α_u²/4),  none if 2β_t < α_u
    /// ```
    /// When β_u < 2α_t the second term does not exist: with u eliminated, a real λ < α_u would have
    /// `λ(β_u − λ) ≥ α_t²`, whose largest left side is β_u²/4; so no real eigenvalue lies below α_u.
    ///
    /// # Source
    /// M. Ferronato, SNA'25 lecture, theorem 2.
    pub fn printed(i: &Ingredients) -> Self {
        let (alpha_u, beta_u, alpha_t, beta_t) = (i.k.0, i.k.1, i.g.0, i.g.1);
        let discriminant = beta_u * beta_u - 4.0 * alpha_t * alpha_t;
        let real_low = if discriminant < 0.0 {
            alpha_u
        } else {
            alpha_u.min(2.0 * alpha_t * alpha_t / (beta_u + discriminant.sqrt()))
        };
        Self {
            theorem: Theorem::WithoutH,
            real_low: Some(real_low),
            real_high: Some(beta_u),
            re_low: Some(alpha_u / 2.0),
            re_high: Some(beta_u / 2.0),
            im_max: Some((beta_t * beta_t - alpha_u * alpha_u / 4.0).max(0.0).sqrt()),
            ..Self::none(Some(i))
        }
    }

    /// The extension to any symmetric H, for B2 = B1ᵀ:
    /// ```text
    /// real:     min{λ_min(K_H), λ_min(Ĥ)} ≤ λ ≤ max{λ_max(K_H), λ_max(Ĥ)}
    /// non-real: ½(λ_min(K_H) + λ_min(Ĥ)) ≤ Re λ ≤ ½(λ_max(K_H) + λ_max(Ĥ)),  |Im λ| ≤ ‖G(I − Ĥ)‖
    /// ```
    /// Proof: the symmetric part of T is diag(K_H, Ĥ), so Re λ is a value of its Rayleigh quotient. JT is symmetric,
    /// so `v*Jv = 0` for a non-real λ: half of ‖v‖² sits in each field.
    pub fn with_h(i: &Ingredients) -> Self {
        Self {
            theorem: Theorem::WithH,
            real_low: Some(i.k_h.0.min(i.h_hat.0)),
            real_high: Some(i.k_h.1.max(i.h_hat.1)),
            re_low: Some(0.5 * (i.k_h.0 + i.h_hat.0)),
            re_high: Some(0.5 * (i.k_h.1 + i.h_hat.1)),
            im_max: Some(i.coupling),
            ..Self::none(Some(i))
        }
    }

    /// With exact S_u the whole spectrum is real, in `[λ_min(GᵀG), max(1, λ_max(Ĥ))]` for SPSD H: besides 1 it is
    /// `1 − W^{1/2}(I − Ĥ)W^{1/2}` with `W = I − GᵀG`, `0 ≤ W ≤ I` because A is SPSD.
    pub fn exact_s_u(i: &Ingredients) -> (f64, f64) {
        (i.g.0 * i.g.0, i.h_hat.1.max(1.0))
    }

    /// The region that the bounds describe.
    pub fn region(&self) -> Region {
        Region {
            real: self.real_low.zip(self.real_high),
            re: self.re_low.zip(self.re_high),
            im_max: self.im_max,
            disc: false,
        }
    }
}

/// A closed set of the complex plane, symmetric about the real axis; absent limits do not limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Region {
    /// Real eigenvalues.
    pub real: Option<(f64, f64)>,
    /// Real parts of non-real eigenvalues.
    pub re: Option<(f64, f64)>,
    /// |Im λ| of non-real eigenvalues.
    pub im_max: Option<f64>,
    /// Non-real eigenvalues lie in |λ − ½| ≤ ½ (H = 0, A SPSD, any SPD S̃_u).
    pub disc: bool,
}

/// Where an eigenvalue fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Inside.
    Inside,
    /// A real eigenvalue outside its interval.
    Real,
    /// The real part of a non-real eigenvalue outside its interval.
    RealPart,
    /// An imaginary part too large.
    ImaginaryPart,
    /// Outside |λ − ½| ≤ ½.
    Disc,
}

/// An imaginary part below this times max(1, |λ|) is rounding: a double real eigenvalue splits by √ε.
pub const REAL_TOLERANCE: f64 = 1e-7;

/// True for an eigenvalue that counts as non-real.
pub fn is_non_real(re: f64, im: f64) -> bool {
    im.abs() > REAL_TOLERANCE * re.hypot(im).max(1.0)
}

impl Region {
    /// The same with the disc |λ − ½| ≤ ½ for non-real eigenvalues.
    ///
    /// Proof: with |u| = 1, `λ² − kλ + g = 0`, k = u*Ku, g = |Gᵀu|²; for non-real λ, |λ|² = g and 2 Re λ = k ≥ 2g
    /// because `K = EᵀAE + 2GGᵀ`; so |λ|² ≤ Re λ.
    pub fn with_disc(self) -> Self {
        Self { disc: true, ..self }
    }

    /// Judges one eigenvalue; `tolerance` is relative to max(1, |λ|).
    pub fn verdict(&self, re: f64, im: f64, tolerance: f64) -> Verdict {
        let slack = tolerance * re.hypot(im).max(1.0);
        let within = |interval: Option<(f64, f64)>, value: f64| {
            interval.is_none_or(|(low, high)| value >= low - slack && value <= high + slack)
        };
        if !is_non_real(re, im) {
            return if within(self.real, re) {
                Verdict::Inside
            } else {
                Verdict::Real
            };
        }
        if !within(self.re, re) {
            Verdict::RealPart
        } else if self.im_max.is_some_and(|limit| im.abs() > limit + slack) {
            Verdict::ImaginaryPart
        } else if self.disc && (re - 0.5).hypot(im) > 0.5 + slack {
            Verdict::Disc
        } else {
            Verdict::Inside
        }
    }

    /// True when the region holds λ up to `tolerance`.
    pub fn contains(&self, re: f64, im: f64, tolerance: f64) -> bool {
        self.verdict(re, im, tolerance) == Verdict::Inside
    }
}
