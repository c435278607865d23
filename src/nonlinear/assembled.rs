//! S̃_u⁻¹ of assembled blocks.

use fracas_operators::Preconditioner;
use fracas_solvers::SetupError;
use fracas_solvers::amg::{Amg, AmgPlan};
use fracas_solvers::saddle::{AugmentationMatrix, InnerChoice, SaddleBlocks};

/// A and the pattern of B stay while faces stick, slip and open, so multigrid plans once: later hierarchies are made of new
/// values on the coarse unknowns of the first, that of all faces in stick.
#[derive(Debug, Default)]
pub(super) struct Assembled {
    plan: Option<AmgPlan>,
}

/// `S̃_u⁻¹`, and why it is in f64 where f32 was asked for and failed just now.
pub(super) struct Built {
    pub(super) inverse: Box<dyn Preconditioner<f64>>,
    pub(super) lost: Option<SetupError>,
}

impl Assembled {
    /// For this C.
    pub(super) fn build(
        &mut self,
        inner: InnerChoice,
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
    ) -> Result<Built, SetupError> {
        let InnerChoice::Amg(asked) = inner else {
            let inverse = inner.prepare(blocks, c)?.inverse;
            return Ok(Built {
                inverse,
                lost: None,
            });
        };
        let f = &blocks.b1 * &c.inverse_root()?;
        let coordinates = blocks.coordinates.as_deref();
        let mut lost = None;
        let inverse = match &self.plan {
            // aggregates of the stuck body may leave nothing to hold an open one; the plan stays that of the stuck body,
            // so that a restart finds the same
            Some(plan) => plan.refresh(&blocks.a, Some(&f)).or_else(|_| {
                let settings = plan.settings();
                settings.build_augmented(&blocks.a, &f, coordinates)
            }),
            None => {
                let plan = |settings: Amg| settings.plan(&blocks.a, Some(&f), coordinates);
                let first = plan(asked).or_else(|error| {
                    let double = asked.in_double().ok_or(error.clone())?;
                    let planned = plan(double).map_err(|_| error.clone())?;
                    lost = Some(error.in_block("S_u"));
                    Ok(planned)
                });
                first.map(|(inverse, plan)| {
                    self.plan = Some(plan);
                    inverse
                })
            }
        };
        let inverse = inverse.map_err(|error: SetupError| error.in_block("S_u"))?;
        Ok(Built {
            inverse: Box::new(inverse),
            lost,
        })
    }
}
