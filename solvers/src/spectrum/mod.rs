//! The spectrum of M⁻¹𝒜 and what is proved about it.
//!
//! With `S̃_u⁻¹ = E Eᵀ`, `C⁻¹ = F Fᵀ` and `Z = [I 0; C⁻¹Bᵀ I]·diag(E, F)` the preconditioner is `M⁻¹ = Z J Zᵀ`,
//! `J = diag(I, −I)`, so M⁻¹𝒜 is similar to
//! ```text
//! T = J Zᵀ𝒜Z = [ K₀ + G R    G(I − Ĥ) ]     K₀ = Eᵀ S_u E    G = Eᵀ B1 F
//!              [   −R            Ĥ     ]     R = Fᵀ B2 E − Ĥ Gᵀ   Ĥ = Fᵀ H F
//! ```
//! a matrix without units and without the contrast of the materials.

mod any_method;
mod arnoldi;
pub mod bounds;
pub mod certificate;
pub mod certify;
pub mod condition;
mod coupling;
mod dense_spectrum;
mod discs;
pub mod explain;
pub mod field_of_values;
mod form;
mod hypotheses;
mod iterative;
mod laboratory;
pub mod modes;
pub mod non_normal;
mod positivity;
mod product;
pub mod real_ends;
pub mod region;
pub mod report;
mod similarity;
mod stated;

pub use any_method::analyse_method;
pub use bounds::{Bounds, Theorem};
pub use certificate::{AroundFractures, Certificate, certificate};
pub use certify::Enclosures;
pub use explain::{Explanation, Solved};
pub use field_of_values::FieldOfValues;
pub use hypotheses::Hypothesis;
pub use laboratory::{BuildInner, SpectrumRequest, analyse, analyse_around};
pub use modes::{Mode, ModeTarget, UnknownModeTarget};
pub use non_normal::{InnerProduct, NonNormal, NonNormalRequest};
pub use region::{Part, Region, Verdict};
pub use report::{Eigenvalues, Method, SpectrumReport};
