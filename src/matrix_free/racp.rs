//! RACP around geometric multigrid, without an assembled A.

use super::{MatrixFreeSaddle, PiecesError};
use crate::elasticity::ElasticityError;
use crate::multigrid::{GeometricError, GeometricInverse, Lost};
use crate::system::StickSystem;
use fracas_solvers::multigrid::Summary;
use fracas_solvers::saddle::{InnerChoice, PartCost, Racp, RacpInverse, Ready};
use fracas_solvers::{Observer, Step};
use std::time::Instant;

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
    /// An inner solver of assembled matrices.
    #[error("inner solver {inner}: it needs an assembled A; without one take geometric")]
    NotGeometric {
        /// Its name.
        inner: String,
    },
    /// The observer wants to stop.
    #[error("stopped on request")]
    Stopped,
}

/// RACP, ready, with what is known of its parts.
pub struct RacpParts {
    /// M⁻¹.
    pub inverse: RacpInverse<'static>,
    /// Levels of S̃_u.
    pub hierarchy: Summary,
    /// What C and S̃_u cost.
    pub cost: PartCost,
    /// Why the hierarchy is in f64 although f32 was asked for.
    pub lost: Option<Lost>,
}

/// What is known of a preconditioner, whatever it is made from.
impl From<RacpParts> for Ready {
    fn from(parts: RacpParts) -> Self {
        Self {
            relaxation: parts.inverse.relaxation(),
            inverse: Box::new(parts.inverse),
            hierarchy: Some(parts.hierarchy),
            parts: Some(parts.cost),
        }
    }
}

impl RacpParts {
    /// Everything that depends on the body but not on a right-hand side; `saddle` is that of `system`, which is not needed
    /// afterwards.
    ///
    /// # Errors
    /// [`MatrixFreeError`].
    pub fn new(
        racp: &Racp,
        saddle: &MatrixFreeSaddle<f64>,
        system: &StickSystem<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Self, MatrixFreeError> {
        let InnerChoice::Geometric(geometric) = racp.inner else {
            return Err(MatrixFreeError::NotGeometric {
                inner: racp.inner.to_string(),
            });
        };
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
        let c = saddle.augmentation(system, racp.augmentation)?.matrix;
        let c_s = start.elapsed().as_secs_f64();
        announce("hierarchy of S_u", 1)?;
        let start = Instant::now();
        let in_pascal = c.clone().scaled(1.0 / (saddle.unit() * saddle.unit()));
        let inner = GeometricInverse::new(&geometric, system, &in_pascal)?;
        let hierarchy = inner.summary();
        let lost = inner.lost();
        let cost = PartCost {
            c_s,
            inner_s: start.elapsed().as_secs_f64(),
            inner_flops: fracas_operators::Preconditioner::flops(&inner),
        };
        let mut inverse = RacpInverse::with_parts(saddle.coupling().clone(), c, inner);
        if let Some(h) = saddle.stabilization() {
            inverse = inverse.relaxed(Box::new(h.clone()), racp.relaxation);
        }
        Ok(Self {
            inverse,
            hierarchy,
            cost,
            lost,
        })
    }
}
