//! S̃_u⁻¹ of assembled blocks.

use super::fallback::Fallbacks;
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

impl Assembled {
    /// True where the next build plans.
    pub(super) fn plans(&self, inner: InnerChoice) -> bool {
        self.plan.is_none() && matches!(inner, InnerChoice::Amg(_))
    }

    /// S̃_u⁻¹ for this C; where f32 was asked for and fails it is in f64, and that is told.
    pub(super) fn build(
        &mut self,
        inner: InnerChoice,
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
        fallbacks: &mut Fallbacks,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let InnerChoice::Amg(asked) = inner else {
            return Ok(inner.prepare(blocks, c)?.inverse);
        };
        let f = &blocks.b1 * &c.by_faces()?.inverse_root()?;
        let coordinates = blocks.coordinates.as_deref();
        let inverse = match &self.plan {
            // aggregates of the stuck body may leave nothing to hold an open one; the plan stays that of the stuck body,
            // so that a restart finds the same
            Some(plan) => plan.refresh(&blocks.a, Some(&f)).or_else(|_| {
                let settings = plan.settings();
                settings.build_augmented(&blocks.a, &f, coordinates)
            }),
            None => {
                let stiffness = blocks.stiffness();
                let double = asked.in_double().filter(|_| stiffness.exceeds_single());
                let asked = double.unwrap_or(asked);
                if double.is_some() {
                    let spread = stiffness.spread();
                    let reason =
                        format!("entries of A spread over {spread:.0e}, the digits of f32");
                    fallbacks.note(reason);
                }
                let plan = |settings: Amg| settings.plan(&blocks.a, Some(&f), coordinates);
                let first = plan(asked).or_else(|error| {
                    let double = asked.in_double().ok_or(error.clone())?;
                    let planned = plan(double).map_err(|_| error.clone())?;
                    fallbacks.note(format!("with f32 {}", error.in_block("S_u")));
                    Ok(planned)
                });
                first.map(|(inverse, plan)| {
                    self.plan = Some(plan);
                    inverse
                })
            }
        };
        let inverse = inverse.map_err(|error: SetupError| error.in_block("S_u"))?;
        Ok(Box::new(inverse))
    }
}
