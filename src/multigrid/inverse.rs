//! The ready preconditioner.

use super::faces;
use super::hierarchy::hierarchy;
use super::{Geometric, GeometricError, Lost};
use crate::elasticity::Elastic;
use crate::system::StickSystem;
use fracas_operators::{Preconditioner, Properties, Real};
use fracas_solvers::multigrid::{
    Hierarchy, MultigridInverse, Places, Precision, SomeHierarchy, Summary,
};
use fracas_solvers::saddle::AugmentationMatrix;
use fracas_solvers::steering::Steering;

/// What rounding to f32 may leave of a uniform force as a residual before f64 is taken, in a body of unlike rocks. On
/// `layered_crossing` with contrasts from 10 to 10⁴ and 16 to 48 cells across, up to 8e-3 cost no iteration, 1.6e-2 cost 19 beside
/// 57 on 48 cells, 1.8 cost 2 beside 67 on 16. Unit: 1.
const ROUNDING: f64 = 1e-2;

/// Stiffest over softest rock up to which rounding does less harm. Unit: 1.
const ALIKE: f64 = 10.0;

/// What it may leave there: bars of one rock, 100 to 400 cubes long and held at one end, are at 0.2 to 40 of a uniform force, columns 500 m
/// high and 12 m wide at 89, and lose no iteration in f32; columns of 507 take 212 iterations for 26. Unit: 1.
const ROUNDING_ALIKE: f64 = 1e2;

/// The rounding from which f64 is taken.
fn limit(materials: &[Elastic]) -> f64 {
    let young = materials.iter().map(|m| m.young);
    let (soft, stiff) = young.fold((f64::INFINITY, 0.0_f64), |(a, b), e| (a.min(e), b.max(e)));
    if stiff <= ALIKE * soft {
        ROUNDING_ALIKE
    } else {
        ROUNDING
    }
}

/// Power of the unit roundoff ε up to which a stiffness relative to that of single nodes is rounding: 1e-11 in f64, 1e-5 in f32. Unit: 1.
const ROUNDED: f64 = 0.7;

/// What a motion costs that the coarsest level leaves out and the finest has lost, too.
fn soft<R: Real>(hierarchy: &Hierarchy<R>) -> Option<f64> {
    let cost = hierarchy.left_out()?;
    (cost <= R::epsilon().to_f64_exact().powf(ROUNDED)).then_some(cost)
}

/// One multigrid cycle per solve: `z ≈ S_u⁻¹ r` over the free displacements.
pub struct GeometricInverse {
    cycle: MultigridInverse,
    lost: Option<Lost>,
}

impl GeometricInverse {
    /// The hierarchy of `S_u = A + B C⁻¹Bᵀ` for `system`; C belongs to B in m² (tractions in Pa), diagonal or one block per
    /// face.
    ///
    /// # Cost
    /// Time and memory proportional to the unknowns; A is never assembled. Where f32 overflows or loses too many digits the hierarchy is
    /// built a second time, in f64, and [`GeometricInverse::lost`] says why.
    ///
    /// # Errors
    /// [`GeometricError`].
    pub fn new(
        settings: &Geometric,
        system: &StickSystem<'_>,
        c: &AugmentationMatrix,
    ) -> Result<Self, GeometricError> {
        settings.checked()?;
        settings.lines.checked()?;
        let expected = 3 * system.fractures.faces.len();
        if c.size() != expected {
            return Err(GeometricError::SizeOfC {
                expected,
                found: c.size(),
            });
        }
        // S_u / scale has entries around 1
        let stiffest = system.materials.iter().map(Elastic::constrained);
        let volume = system.mesh.grid.as_ref().map_or(1.0, |grid| {
            let length = |d: usize| grid.lines[d][grid.cells[d]] - grid.lines[d][0];
            let cells: usize = grid.cells.iter().product();
            length(0) * length(1) * length(2) / cells as f64
        });
        let largest = stiffest.fold(0.0, f64::max) * volume.cbrt();
        let scale = largest.log2().round().exp2();
        let materials: Vec<Elastic> = system
            .materials
            .iter()
            .map(|m| Elastic {
                young: m.young / scale,
                ..*m
            })
            .collect();
        let c_inverse = faces::inverse_blocks(c, scale).ok_or(GeometricError::DenseC)?;
        Self::in_unit(settings, system, scale, &materials, &c_inverse)
            .map_err(|error| error.judged(system))
    }

    /// The hierarchy of `S_u / scale`.
    fn in_unit(
        settings: &Geometric,
        system: &StickSystem<'_>,
        scale: f64,
        materials: &[Elastic],
        c_inverse: &[[[f64; 3]; 3]],
    ) -> Result<Self, GeometricError> {
        let mut lost = None;
        let mut single = None;
        if settings.precision == Precision::F32 {
            match hierarchy(settings, system, materials, c_inverse) {
                Ok(h) => match h.rounding() {
                    r if r <= limit(materials) && soft(&h).is_none() => single = Some(h),
                    rounding => lost = Some(Lost::Digits { rounding }),
                },
                Err(GeometricError::Overflow { level, .. }) => lost = Some(Lost::Range { level }),
                Err(other) => return Err(other),
            }
        }
        let hierarchy = match single {
            Some(h) => SomeHierarchy::Single(h),
            None => {
                let h = hierarchy(settings, system, materials, c_inverse)?;
                if let Some(cost) = soft(&h) {
                    return Err(GeometricError::Soft { cost });
                }
                SomeHierarchy::Double(h)
            }
        };
        let f = settings.over_correction;
        Ok(Self {
            cycle: MultigridInverse::new(hierarchy, Places::Free, scale, f),
            lost,
        })
    }
}

impl GeometricInverse {
    /// Why the hierarchy is in f64 although f32 was asked for.
    pub fn lost(&self) -> Option<Lost> {
        self.lost
    }

    /// Levels, complexities, bytes.
    pub fn summary(&self) -> Summary {
        self.cycle.summary()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.summary().levels.iter().map(|level| level.bytes).sum()
    }
}

impl Preconditioner<f64> for GeometricInverse {
    fn size(&self) -> usize {
        self.cycle.size()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.cycle.solve(r, z, work);
    }

    fn work_len(&self) -> usize {
        self.cycle.work_len()
    }

    fn flops(&self) -> u64 {
        self.cycle.flops()
    }

    fn properties(&self) -> Properties {
        self.cycle.properties()
    }
}
