//! What an iteration costs, independent of the machine.

use crate::krylov::KrylovChoice;
use fracas_operators::{LinearOperator, Preconditioner};
use serde::Serialize;

/// `c_app = flops(M⁻¹) / flops(𝒜)` and `C_s = n_it (1 + c_app)`, n_it in products: an iteration of BiCGStab counts
/// twice. The unit of both is one product with 𝒜.
///
/// # Source
/// M. Ferronato, SNA'25 lecture, slide on the cost of an application.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Flops of one product with 𝒜.
    pub product_flops: u64,
    /// Flops of one application of M⁻¹.
    pub application_flops: u64,
}

impl Cost {
    /// The convention in one sentence.
    pub const CONVENTION: &'static str = "c_app = flops(M⁻¹) / flops(𝒜); C_s = products·(1 + c_app), one product per iteration, two for BiCGStab; null when not converged";

    /// As both count themselves.
    pub fn new(saddle: &dyn LinearOperator<f64>, m: &dyn Preconditioner<f64>) -> Self {
        Self {
            product_flops: saddle.flops(),
            application_flops: m.flops(),
        }
    }

    /// `flops(M⁻¹) / flops(𝒜)`; an empty 𝒜 counts as one flop.
    pub fn c_app(self) -> f64 {
        self.application_flops as f64 / self.product_flops.max(1) as f64
    }

    /// `n_it (1 + c_app)`.
    pub fn c_s(self, iterations: usize, krylov: &KrylovChoice) -> f64 {
        let products = iterations * krylov.products_per_iteration();
        products as f64 * (1.0 + self.c_app())
    }
}
