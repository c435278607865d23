//! A straight fault through reservoirs whose pressure changes: its tractions, its slip, where it runs away.

use super::fault_friction::{LARGEST_STEP, Sliding};
use super::polygons::{contains, crossings};
use super::sliding_factor::SlidingFactor;
use super::{Depletion, FaultFriction, NoState, Rock, Strength};

/// Where the pressure of a block acts in the fault that it touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaultPressure {
    /// Where either side lies in a block: the pressure of the block.
    #[default]
    Either,
    /// The mean of both sides.
    Mean,
    /// Where both sides lie in blocks.
    Both,
    /// Nowhere: the fault keeps its pressure.
    Nowhere,
}

impl FaultPressure {
    /// Share of the change of pressure in the fault, by whether its sides lie in a block.
    fn share(self, sides: [bool; 2]) -> f64 {
        let [either, both] = [sides[0] || sides[1], sides[0] && sides[1]].map(f64::from);
        match self {
            Self::Either => either,
            Self::Mean => 0.5 * (either + both),
            Self::Both => both,
            Self::Nowhere => 0.0,
        }
    }
}

/// Effective stress before production, linear in height, plane strain; tension positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarStress {
    /// Total vertical stress at height 0 [Pa] and its change per metre upwards [Pa/m].
    pub vertical: [f64; 2],
    /// Total horizontal stress across the strike, the same.
    pub horizontal: [f64; 2],
    /// Pressure of the fluid, the same; positive.
    pub pressure: [f64; 2],
}

/// Friction of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultStrength {
    /// Cohesion c, which slip leaves [Pa].
    pub cohesion: f64,
    /// Static friction coefficient [1].
    pub static_friction: f64,
    /// Dynamic friction coefficient [1].
    pub dynamic_friction: f64,
    /// Slip over which friction falls; 0 without weakening [m].
    pub critical_slip: f64,
}

/// Distance from the fault at which its sides are told, as a share of the element. Unit: 1.
const BESIDE: f64 = 1e-6;

/// A straight fault of equal elements through (0, 0) in the plane (x, z), z upwards, in a homogeneous full space.
///
/// Tangent t = (cos δ, sin δ) up the dip δ, normal n = (sin δ, −cos δ). Glide leaves the normal traction alone, so that
/// ```text
/// t(λ) = R (σ0 + λ Δσ) n        σ'_N = t_N + p_0 + λ Δp_f        L(γ) = c − min(σ'_N, 0) f(γ)
/// ```
/// with the share λ of the change of pressure; Δσ of [`Depletion`], slip of [`FaultFriction`]. Tractions are means over the elements:
/// at corners of blocks shear grows like ln r, and a value at one point of an element would depend on where that point lies.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplacedFault {
    /// The rock.
    pub rock: Rock,
    friction: FaultFriction,
    /// Dip [rad].
    pub dip: f64,
    /// Element length [m].
    pub h: f64,
    /// Distance of the middles of the elements from (0, 0), up the dip [m].
    pub along: Vec<f64>,
    /// Means of (σ'_N, τ) before production [Pa].
    initial: Vec<[f64; 2]>,
    /// Their change for λ = 1 [Pa].
    change: Vec<[f64; 2]>,
}

/// Ends of a fault and how finely it is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultLine {
    /// Dip, 90° = upright [rad].
    pub dip: f64,
    /// Heights of its ends [m].
    pub heights: [f64; 2],
    /// Elements.
    pub elements: usize,
}

/// An element that carries more than it can before production.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LooseElement {
    /// Its number.
    pub element: usize,
    /// |τ| [Pa].
    pub shear: f64,
    /// τ_L [Pa].
    pub limit: f64,
}

/// A state of the fault.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultState {
    /// δ per element, along t on the side that n points to [m].
    pub slip: Vec<f64>,
    /// τ per element [Pa].
    pub shear: Vec<f64>,
    /// σ'_N per element [Pa].
    pub normal: Vec<f64>,
    /// |τ|/L per element [1].
    pub criticality: Vec<f64>,
}

impl DisplacedFault {
    /// The fault between blocks (counter-clockwise polygons) with this change of pressure.
    pub fn new(
        rock: Rock,
        line: FaultLine,
        far: FarStress,
        (blocks, change): (&[Vec<[f64; 2]>], Depletion),
        acting: FaultPressure,
    ) -> Self {
        let (sin, cos) = line.dip.sin_cos();
        let (t, n) = ([cos, sin], [sin, -cos]);
        let [low, high] = line.heights.map(|z| z / sin);
        let h = (high - low) / line.elements as f64;
        let along: Vec<f64> = (0..line.elements)
            .map(|i| low + h * (i as f64 + 0.5))
            .collect();
        let at = |s: f64| [s * t[0], s * t[1]];
        let on_fault = |[xx, zz, xz]: [f64; 3]| {
            let pull = [xx * n[0] + xz * n[1], xz * n[0] + zz * n[1]];
            [
                pull[0] * n[0] + pull[1] * n[1],
                pull[0] * t[0] + pull[1] * t[1],
            ]
        };
        let initial = (along.iter())
            .map(|s| {
                let at = |[value, gradient]: [f64; 2]| value + gradient * s * sin;
                let [normal, shear] = on_fault([at(far.horizontal), at(far.vertical), 0.0]);
                [normal + at(far.pressure), shear]
            })
            .collect();
        let meets = crossings(blocks, t, BESIDE * h);
        let change = (along.iter())
            .map(|s| {
                let ends = [s - 0.5 * h, s + 0.5 * h];
                // the traction passes the fault: either side tells it
                let mean = change.mean_stress_change(blocks, ends.map(at));
                let [normal, shear] = on_fault(mean);
                let inner = meets
                    .iter()
                    .copied()
                    .filter(|m| ends[0] < *m && *m < ends[1]);
                let cuts: Vec<f64> = [ends[0]]
                    .into_iter()
                    .chain(inner)
                    .chain([ends[1]])
                    .collect();
                let shares = cuts.windows(2).map(|cut| {
                    let middle = at(0.5 * (cut[0] + cut[1]));
                    let sides = [-BESIDE * h, BESIDE * h].map(|e| {
                        let beside = [middle[0] + e * n[0], middle[1] + e * n[1]];
                        blocks.iter().any(|block| contains(block, beside))
                    });
                    (cut[1] - cut[0]) / h * acting.share(sides)
                });
                [normal + shares.sum::<f64>() * change.pressure_change, shear]
            })
            .collect();
        Self {
            rock,
            friction: FaultFriction::new(rock, line.elements, h),
            dip: line.dip,
            h,
            along,
            initial,
            change,
        }
    }

    /// (σ'_N, τ) per element without slip at a share λ of the change of pressure [Pa].
    pub fn tractions(&self, share: f64) -> impl Iterator<Item = [f64; 2]> + '_ {
        (self.initial.iter().zip(&self.change))
            .map(move |(a, b)| [0, 1].map(|k| a[k] + share * b[k]))
    }

    /// The element that is furthest beyond its limit before production: slip would not be due to pressure alone. A billionth of the
    /// tractions is rounding.
    pub fn loose(&self, strength: FaultStrength) -> Option<LooseElement> {
        let largest = self
            .initial
            .iter()
            .flatten()
            .fold(0.0f64, |m, t| m.max(t.abs()));
        let of = |(element, [normal, shear]): (usize, &[f64; 2])| LooseElement {
            element,
            shear: shear.abs(),
            limit: strength.under(*normal).peak,
        };
        let all = self.initial.iter().enumerate().map(of);
        all.filter(|e| e.shear - e.limit > 1e-9 * largest)
            .max_by(|a, b| (a.shear - a.limit).total_cmp(&(b.shear - b.limit)))
    }

    /// The fault before production, under this friction, on its way through growing shares of the change of pressure.
    pub fn path(&self, strength: FaultStrength) -> FaultPath<'_> {
        FaultPath {
            fault: self,
            strength,
            share: 0.0,
            sliding: Sliding::none(self.along.len()),
            factor: SlidingFactor::default(),
        }
    }

    /// σ'_N and τ without slip.
    fn loaded(&self, share: f64) -> [Vec<f64>; 2] {
        [0, 1].map(|k| self.tractions(share).map(|t| t[k]).collect())
    }
}

/// A fault on its way. Slip follows the pressure step by step, so that a state beyond one that ran away is not taken for its next.
#[derive(Clone, Debug)]
pub struct FaultPath<'a> {
    fault: &'a DisplacedFault,
    strength: FaultStrength,
    /// λ of the state.
    share: f64,
    sliding: Sliding,
    /// Of what slid in the step tried last.
    factor: SlidingFactor,
}

/// A step below this share of what was asked for is none: slip runs away. Unit: 1.
const SMALLEST_STEP: f64 = 1.0 / (1u64 << 16) as f64;

impl FaultPath<'_> {
    /// λ of the state at hand.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// On to a share λ.
    ///
    /// # Cost
    /// O(elements · m + m³) per step with m sliding elements, m² in the place of m³ without weakening; steps in which no element slips
    /// more than a fifth of its critical slip.
    ///
    /// # Errors
    /// [`NoState`]; then the state is the last one before.
    pub fn advance(&mut self, to: f64) -> Result<FaultState, NoState> {
        let allowed = LARGEST_STEP * self.strength.critical_slip;
        let most = if allowed > 0.0 {
            allowed
        } else {
            f64::INFINITY
        };
        let whole = to - self.share;
        let mut step = whole;
        let mut was_cut = false;
        while self.share != to {
            let next = if step.abs() < (to - self.share).abs() {
                self.share + step
            } else {
                to
            };
            let tried = self.at(next, most);
            match tried {
                Ok(sliding) => {
                    let (_, largest) = sliding.weakening_since(&self.sliding);
                    (self.sliding, self.share) = (sliding, next);
                    // where slip runs away every step is half of the one before
                    step *= match (was_cut, largest <= 0.5 * allowed) {
                        (true, _) => 0.5,
                        (false, true) => 2.0,
                        (false, false) => 1.0,
                    };
                    was_cut = false;
                }
                Err(NoState::Runaway { .. }) if step.abs() > SMALLEST_STEP * whole.abs() => {
                    step *= 0.5;
                    was_cut = true;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(self.state())
    }

    fn at(&mut self, share: f64, most: f64) -> Result<Sliding, NoState> {
        let [normal, shear] = self.fault.loaded(share);
        let limits = self.limits(&normal);
        let friction = &self.fault.friction;
        friction.next(&mut self.factor, &self.sliding, (&shear, &limits), most)
    }

    fn limits(&self, normal: &[f64]) -> Vec<Strength> {
        normal.iter().map(|n| self.strength.under(*n)).collect()
    }

    /// The state at hand.
    pub fn state(&self) -> FaultState {
        let [normal, shear] = self.fault.loaded(self.share);
        let limits = self.limits(&normal);
        let slip = self.sliding.slip.clone();
        let shear = self.fault.friction.shear_after(&shear, &slip);
        let criticality = (shear.iter().zip(&limits).zip(&slip))
            .map(|((tau, limit), d)| match (tau.abs(), limit.after(*d)) {
                (0.0, _) => 0.0,
                (tau, limit) => tau / limit,
            })
            .collect();
        FaultState {
            slip,
            shear,
            normal,
            criticality,
        }
    }
}

impl FaultStrength {
    /// Limits under an effective normal traction [Pa].
    fn under(self, normal: f64) -> Strength {
        let pressed = (-normal).max(0.0);
        Strength {
            peak: self.cohesion + pressed * self.static_friction,
            residual: self.cohesion + pressed * self.dynamic_friction,
            critical_slip: self.critical_slip,
        }
    }
}

impl FaultState {
    /// Length that slides [m], elements being h long.
    pub fn slipping_length(&self, h: f64) -> f64 {
        h * self.slip.iter().filter(|d| **d != 0.0).count() as f64
    }

    /// Longest piece that slides without a gap [m].
    pub fn longest_patch(&self, h: f64) -> f64 {
        let pieces = self.slip.split(|d| *d == 0.0);
        h * pieces.map(<[f64]>::len).max().unwrap_or(0) as f64
    }

    /// Largest |δ| [m].
    pub fn largest_slip(&self) -> f64 {
        self.slip.iter().fold(0.0, |m, d| m.max(d.abs()))
    }

    /// ∫ |δ| ds [m²]; times G it is the moment per length of strike.
    pub fn slip_integral(&self, h: f64) -> f64 {
        h * self.slip.iter().map(|d| d.abs()).sum::<f64>()
    }
}

#[cfg(test)]
mod tests;
