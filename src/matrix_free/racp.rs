//! RACP around geometric multigrid, without an assembled A.

use super::{MatrixFreeSaddle, PiecesError};
use crate::contact::Coupling;
use crate::elasticity::ElasticityError;
use crate::multigrid::{Geometric, GeometricError, GeometricInverse, Lost};
use crate::system::StickSystem;
use fracas_solvers::amg::{Precision, Summary};
use fracas_solvers::saddle::{AugmentationChoice, PartCost, RELAXATION, RacpInverse};
use fracas_solvers::{Observer, Step};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;

/// Settings of RACP without an assembled A.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MatrixFreeRacp {
    /// C: local, local_h, half_h, fitted_h or face_block.
    pub augmentation: AugmentationChoice,
    /// γ of the [`Relaxation`](fracas_solvers::saddle::Relaxation) of H, from 0 (none; with C = local_h the published method) to 1.
    #[serde(deserialize_with = "fracas_solvers::saddle::relaxation::factor")]
    pub relaxation: f64,
    /// S̃_u⁻¹.
    pub inner: Geometric,
}

impl Default for MatrixFreeRacp {
    fn default() -> Self {
        Self {
            augmentation: AugmentationChoice::FittedH,
            relaxation: RELAXATION,
            inner: Geometric::default(),
        }
    }
}

/// Why a body has no solver without an assembled A.
#[derive(Debug, thiserror::Error)]
pub enum MatrixFreeError {
    /// C.
    #[error(transparent)]
    Augmentation(#[from] PiecesError),
    /// The hierarchy of S_u.
    #[error(transparent)]
    Geometric(#[from] GeometricError),
    /// A mesh without a stiffness.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// The observer wants to stop.
    #[error("stopped on request")]
    Stopped,
}

/// RACP, ready, with what is known of its parts.
pub struct RacpParts {
    /// M⁻¹.
    pub inverse: RacpInverse<GeometricInverse, Arc<Coupling<f64>>>,
    /// Levels of S̃_u.
    pub hierarchy: Summary,
    /// What C and S̃_u cost.
    pub cost: PartCost,
    /// Why the hierarchy is in f64 although f32 was asked for.
    pub lost: Option<Lost>,
}

impl MatrixFreeRacp {
    /// The same with the hierarchy in f64.
    #[must_use]
    pub fn in_double(self) -> Self {
        let precision = Precision::F64;
        Self {
            inner: Geometric {
                precision,
                ..self.inner
            },
            ..self
        }
    }

    /// Everything that depends on the body but not on a right-hand side; `saddle` is that of `system`, which is not needed
    /// afterwards.
    ///
    /// # Errors
    /// [`MatrixFreeError`].
    pub fn ready(
        &self,
        saddle: &MatrixFreeSaddle<f64>,
        system: &StickSystem<'_>,
        observer: &mut dyn Observer,
    ) -> Result<RacpParts, MatrixFreeError> {
        let mut announce = |stage, done| {
            let step = Step::Progress {
                stage,
                done,
                total: 2,
            };
            match observer.observe(&step).is_break() {
                true => Err(MatrixFreeError::Stopped),
                false => Ok(()),
            }
        };
        announce("C from the elements around the fractures", 0)?;
        let start = Instant::now();
        let c = saddle.augmentation(system, self.augmentation)?.matrix;
        let c_s = start.elapsed().as_secs_f64();
        announce("hierarchy of S_u", 1)?;
        let start = Instant::now();
        let in_pascal = c.clone().scaled(1.0 / (saddle.unit() * saddle.unit()));
        let inner = self.inner.build(system, &in_pascal)?;
        let hierarchy = inner.summary();
        let lost = inner.lost();
        let cost = PartCost {
            c_s,
            inner_s: start.elapsed().as_secs_f64(),
            inner_flops: fracas_operators::Preconditioner::flops(&inner),
        };
        let mut inverse = RacpInverse::with_operator(saddle.coupling().clone(), c, inner);
        if let Some(h) = saddle.stabilization() {
            inverse = inverse.relaxed(Box::new(h.clone()), self.relaxation);
        }
        Ok(RacpParts {
            inverse,
            hierarchy,
            cost,
            lost,
        })
    }
}
