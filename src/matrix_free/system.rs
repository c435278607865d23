//! The saddle point of a body without an assembled A, and its size.

use super::{Magnitude, MatrixFreeSaddle};
use crate::elasticity::ElasticityError;
use crate::system::StickSystem;
use fracas_operators::{Layout, LinearOperator};
use fracas_solvers::saddle::{EnergyNorms, SaddleSystem, StrainNorm};

/// Nothing is assembled but H.
pub struct MatrixFreeSystem {
    /// 𝒜.
    pub saddle: MatrixFreeSaddle<f64>,
    /// Sizes of A and B.
    pub magnitude: Magnitude,
}

impl MatrixFreeSystem {
    /// Of `system`, tractions in this unit [Pa]; `None`: in the one that balances both rows.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn new(system: &StickSystem<'_>, unit: Option<f64>) -> Result<Self, ElasticityError> {
        let magnitude = system.magnitude()?;
        let unit = unit.unwrap_or(magnitude.unit);
        let saddle = MatrixFreeSaddle::in_traction_unit(system, unit)?;
        Ok(Self { saddle, magnitude })
    }
}

impl SaddleSystem for MatrixFreeSystem {
    fn operator(&self) -> &dyn LinearOperator<f64> {
        &self.saddle
    }

    fn layout(&self) -> Layout {
        self.saddle.layout()
    }

    fn has_short_recurrences(&self) -> bool {
        true
    }

    fn norm_inf(&self) -> f64 {
        self.saddle.norm_inf_from_below(self.magnitude.stiffest)
    }

    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        self.saddle.contact_scale(x, b)
    }

    fn norms(&self, own: bool) -> EnergyNorms<'_> {
        let a = self.saddle.stiffness();
        let strain = || -> StrainNorm<'_> { Box::new(|u| a.strain_norm(u)) };
        let displaced = own && a.is_displaced();
        self.saddle
            .energy_norms(&self.magnitude, displaced.then(strain))
    }
}
