//! What is proved about the eigenvalues of M⁻¹𝒜, as regions of the complex plane.

use super::region::Region;
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

/// Extreme values that the statements need. With `K = Eᵀ(S_u + BC⁻¹Bᵀ)E`, `G = EᵀBF`, `Ĥ = FᵀHF`; where W = p(C⁻¹H) relaxes H,
/// `h_hat`, `k_h` and `coupling` are those of the relaxed matrix ([`Form`](super::form)):
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
    /// δ and Δ: extreme eigenvalues of S̃_u⁻¹S_u.
    pub sigma: (f64, f64),
    /// Extreme eigenvalues of C⁻¹H; the largest is η.
    pub h: (f64, f64),
}

impl Ingredients {
    /// True where S̃_u is S_u up to rounding.
    pub(super) fn is_exact(&self) -> bool {
        const ROUNDING: f64 = 1e-9;
        (self.sigma.0 - 1.0).abs() < ROUNDING && (self.sigma.1 - 1.0).abs() < ROUNDING
    }
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

    /// The same statement with the ends of a sharper region.
    #[must_use]
    pub fn sharpened(self, region: &Region) -> Self {
        Self {
            real_low: region.real.map(|r| r.0),
            real_high: region.real.map(|r| r.1),
            re_low: region.re.map(|r| r.0),
            re_high: region.re.map(|r| r.1),
            im_max: region.im_max,
            ..self
        }
    }

    /// The region that the bounds describe.
    pub fn region(&self) -> Region {
        Region {
            real: self.real_low.zip(self.real_high),
            re: self.re_low.zip(self.re_high),
            im_max: self.im_max,
            circles: Vec::new(),
        }
    }
}
