//! A straight fault through reservoirs whose pressure changes: its tractions, its slip, where it runs away.

use super::fault_friction::{LARGEST_STEP, Sliding};
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

/// A straight fault of equal elements through (0, 0) in the plane (x, z), z upwards, in a homogeneous full space.
///
/// Tangent t = (cos δ, sin δ) up the dip δ, normal n = (sin δ, −cos δ). Glide leaves the normal traction alone, so that
/// ```text
/// t(λ) = R (σ0 + λ Δσ) n        σ'_N = t_N + p_0 + λ Δp_f        L(γ) = c − min(σ'_N, 0) f(γ)
/// ```
/// with the share λ of the change of pressure; Δσ of [`Depletion`], slip of [`FaultFriction`].
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
    /// (σ'_N, τ) before production [Pa].
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
        let change = (along.iter())
            .map(|s| {
                let beside = |e: f64| [s * t[0] + e * n[0], s * t[1] + e * n[1]];
                // the traction passes the fault: either side tells it
                let e = 1e-6 * h;
                let [normal, shear] = on_fault(change.stress_change(blocks, beside(e)));
                let sides = [-e, e].map(|e| blocks.iter().any(|block| contains(block, beside(e))));
                let share = match (acting, sides) {
                    (FaultPressure::Nowhere, _) | (_, [false, false]) => 0.0,
                    (_, [true, true]) => 1.0,
                    (FaultPressure::Either, _) => 1.0,
                    (FaultPressure::Mean, _) => 0.5,
                    (FaultPressure::Both, _) => 0.0,
                };
                [normal + share * change.pressure_change, shear]
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
        let whole = to - self.share;
        let mut step = whole;
        let mut was_cut = false;
        while self.share != to {
            let next = if step.abs() < (to - self.share).abs() {
                self.share + step
            } else {
                to
            };
            let allowed = LARGEST_STEP * self.strength.critical_slip;
            let tried = self.at(next).and_then(|sliding| {
                let (moved, largest) = sliding.weakening_since(&self.sliding);
                match allowed > 0.0 && largest > allowed {
                    true => Err(NoState::Runaway { sliding: moved }),
                    false => Ok((sliding, largest)),
                }
            });
            match tried {
                Ok((sliding, largest)) => {
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

    fn at(&mut self, share: f64) -> Result<Sliding, NoState> {
        let [normal, shear] = self.fault.loaded(share);
        let limits = self.limits(&normal);
        let friction = &self.fault.friction;
        friction.next(&mut self.factor, &self.sliding, &shear, &limits)
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

/// True for points inside a polygon.
fn contains(polygon: &[[f64; 2]], x: [f64; 2]) -> bool {
    let mut inside = false;
    for (k, a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        if (a[1] > x[1]) != (b[1] > x[1]) {
            let crossing = a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            inside ^= x[0] < crossing;
        }
    }
    inside
}

/// Two blocks of one reservoir on both sides of a fault through (0, 0): each so thick and so wide [m], that on the side of n lower by
/// the throw, their middles at heights ± throw/2.
pub fn displaced_blocks(dip: f64, thickness: f64, throw: f64, width: f64) -> Vec<Vec<[f64; 2]>> {
    let slope = dip.cos() / dip.sin();
    let fault = |z: f64| [z * slope, z];
    let [low, high] = [-0.5 * thickness, 0.5 * thickness];
    let up = 0.5 * throw;
    vec![
        vec![
            [-width, low + up],
            fault(low + up),
            fault(high + up),
            [-width, high + up],
        ],
        vec![
            fault(low - up),
            [width, low - up],
            [width, high - up],
            fault(high - up),
        ],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::Random;

    /// Verification data of vertical displaced faults: b = 150 m, a = 75 m.
    fn vertical(elements: usize) -> DisplacedFault {
        let rock = Rock {
            young: 2.0 * 6.5e9 * 1.15,
            poisson: 0.15,
        };
        let right = std::f64::consts::FRAC_PI_2;
        let change = Depletion {
            poisson: 0.15,
            biot: 0.9,
            pressure_change: -25e6,
        };
        let line = FaultLine {
            dip: right,
            heights: [-600.0, 600.0],
            elements,
        };
        let far = FarStress {
            vertical: [-60e6, 0.0],
            horizontal: [-60e6, 0.0],
            pressure: [0.0; 2],
        };
        let blocks = displaced_blocks(right, 225.0, -75.0, 2e4);
        DisplacedFault::new(rock, line, far, (&blocks, change), FaultPressure::Nowhere)
    }

    const FRICTIONLESS: FaultStrength = FaultStrength {
        cohesion: 0.0,
        static_friction: 0.0,
        dynamic_friction: 0.0,
        critical_slip: 0.0,
    };

    #[test]
    fn slip_without_friction_is_the_known_trapezoid() {
        // |δ(z)| = ((1−2ν) α |Δp|/G) clamp(b − |z|, 0, b − a): 0.181731 m for |z| < 75 m
        let slope = 0.7 * 0.9 * 25e6 / 6.5e9;
        let (mut before, mut peak) = (f64::INFINITY, 0.0);
        for elements in [160, 320, 640] {
            let fault = vertical(elements);
            let state = fault.path(FRICTIONLESS).advance(1.0).unwrap();
            let (mut error, mut size) = (0.0f64, 0.0f64);
            for (z, d) in fault.along.iter().zip(&state.slip) {
                let exact = slope * (150.0 - z.abs()).clamp(0.0, 75.0);
                error += (d.abs() - exact).powi(2);
                size += exact * exact;
            }
            let relative = (error / size).sqrt();
            assert!(
                relative < 0.62 * before,
                "{elements}: {relative} after {before}"
            );
            before = relative;
            peak = state.largest_slip();
        }
        assert!(before < 1e-2, "{before}");
        assert!((peak - 0.181_731).abs() < 0.01 * 0.181_731, "{peak}");
    }

    #[test]
    fn states_keep_the_law_and_grow_with_the_load() {
        let fault = vertical(400);
        let strength = FaultStrength {
            static_friction: 0.03,
            dynamic_friction: 0.03,
            ..FRICTIONLESS
        };
        let mut before = 0.0;
        let mut path = fault.path(strength);
        for share in [0.2, 0.5, 1.0] {
            let state = path.advance(share).unwrap();
            let now = state.slip_integral(fault.h);
            assert!(now > before, "{now} after {before}");
            before = now;
            assert!(state.criticality.iter().all(|chi| *chi < 1.0 + 1e-9));
            assert!(state.longest_patch(fault.h) <= state.slipping_length(fault.h));
        }
    }

    #[test]
    fn a_fault_that_weakens_runs_away_sooner_the_faster_it_weakens() {
        let fault = vertical(400);
        let weak = |critical_slip| FaultStrength {
            static_friction: 0.05,
            dynamic_friction: 0.01,
            critical_slip,
            ..FRICTIONLESS
        };
        let at = |critical| {
            let mut path = fault.path(weak(critical));
            let ended = path.advance(2.0);
            (ended.is_ok(), path.share())
        };
        let [(fast_ends, fast), (slow_ends, slow)] = [0.002, 0.004].map(at);
        assert!(!fast_ends && !slow_ends && fast < slow, "{fast} {slow}");
        assert_eq!(at(1.0), (true, 2.0));
        // steps of one's own find the same
        let mut path = fault.path(weak(0.004));
        let found = (1..=200).find(|k| path.advance(0.01 * f64::from(*k)).is_err());
        assert!(found.is_some());
        assert!(
            (path.share() - slow).abs() < 1e-3,
            "{} {slow}",
            path.share()
        );
    }

    /// Whatever the strength, steps of one's own end where those of the path end: elements that begin to slide one at a time make no
    /// jump that depends on them.
    #[test]
    fn where_slip_runs_away_does_not_depend_on_the_steps() {
        let fault = vertical(300);
        let (mut gone, mut safe) = (0, 0);
        for seed in 0..24 {
            let r = &mut Random::new(seed);
            let static_friction = r.between(0.03, 0.09);
            let strength = FaultStrength {
                static_friction,
                dynamic_friction: r.between(0.3, 0.95) * static_friction,
                critical_slip: r.scale(3e-3, 0.2),
                ..FRICTIONLESS
            };
            let ends = |steps: u32| {
                let mut path = fault.path(strength);
                let ended = (1..=steps)
                    .try_for_each(|k| path.advance(f64::from(k) / f64::from(steps)).map(drop));
                assert_ne!(ended, Err(NoState::Unsettled), "seed {seed}, {strength:?}");
                let slip = path.state().slip_integral(fault.h);
                (ended.is_ok(), path.share(), slip)
            };
            let [one, many] = [1, 150].map(ends);
            assert_eq!(one.0, many.0, "seed {seed}: {one:?} {many:?}, {strength:?}");
            let of = if one.0 { one.2 } else { 1.0 };
            assert!(
                (one.1 - many.1).abs() < 2e-3,
                "seed {seed}: {one:?} {many:?}"
            );
            assert!(
                !one.0 || (one.2 - many.2).abs() <= 1e-8 * of,
                "seed {seed}: {one:?} {many:?}"
            );
            if one.0 { safe += 1 } else { gone += 1 }
        }
        assert!(gone >= 5 && safe >= 5, "{gone} run away, {safe} do not");
    }

    #[test]
    fn pressure_acts_where_it_is_said_to() {
        let right = std::f64::consts::FRAC_PI_2;
        let blocks = displaced_blocks(right, 200.0, 100.0, 1e3);
        let with = |acting| {
            let base = vertical(120);
            let change = Depletion {
                poisson: 0.15,
                biot: 0.9,
                pressure_change: -10e6,
            };
            let line = FaultLine {
                dip: right,
                heights: [-300.0, 300.0],
                elements: 120,
            };
            let far = FarStress {
                vertical: [0.0; 2],
                horizontal: [0.0; 2],
                pressure: [0.0; 2],
            };
            let fault = DisplacedFault::new(base.rock, line, far, (&blocks, change), acting);
            let normal = |z: f64| {
                let i = ((z + 300.0) / 5.0) as usize;
                fault.tractions(1.0).nth(i).map(|t| t[0]).unwrap()
            };
            // outside, one side, both
            [200.0, 100.0, 0.0].map(normal)
        };
        let bare = with(FaultPressure::Nowhere);
        for (acting, shares) in [
            (FaultPressure::Either, [0.0, 1.0, 1.0]),
            (FaultPressure::Mean, [0.0, 0.5, 1.0]),
            (FaultPressure::Both, [0.0, 0.0, 1.0]),
        ] {
            for (k, normal) in with(acting).iter().enumerate() {
                let expected = bare[k] - shares[k] * 10e6;
                assert!((normal - expected).abs() < 1.0, "{acting:?} {k}");
            }
        }
    }
}
