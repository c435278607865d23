//! S̃_u⁻¹ of assembled blocks.

use fracas_operators::Preconditioner;
use fracas_solvers::SetupError;
use fracas_solvers::amg::AmgPlan;
use fracas_solvers::saddle::{AugmentationMatrix, InnerChoice, SaddleBlocks};

/// A and the pattern of B stay while faces stick, slip and open, so multigrid plans once: later hierarchies are made of new
/// values on the coarse unknowns of the first, that of all faces in stick.
#[derive(Debug, Default)]
pub(super) struct Assembled {
    plan: Option<AmgPlan>,
}

impl Assembled {
    /// `S̃_u⁻¹` for this C.
    pub(super) fn build(
        &mut self,
        inner: InnerChoice,
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let InnerChoice::Amg(settings) = inner else {
            return Ok(inner.prepare(blocks, c)?.inverse);
        };
        let f = &blocks.b1 * &c.inverse_root()?;
        let coordinates = blocks.coordinates.as_deref();
        let inverse = match &self.plan {
            // aggregates of the stuck body may leave nothing to hold an open one; the plan stays that of the stuck body,
            // so that a restart finds the same
            Some(plan) => plan
                .refresh(&blocks.a, Some(&f))
                .or_else(|_| settings.build_augmented(&blocks.a, &f, coordinates)),
            None => {
                let planned = settings.plan(&blocks.a, Some(&f), coordinates);
                planned.map(|(inverse, plan)| {
                    self.plan = Some(plan);
                    inverse
                })
            }
        };
        Ok(Box::new(inverse.map_err(|error| error.in_block("S_u"))?))
    }
}
