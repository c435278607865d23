//! Slip of a plane whose friction weakens, until it runs away.

use super::Rock;
use super::sliding_factor::SlidingFactor;
use fracas_operators::vector::axpy;

/// Rounds of the set of sliding elements, a handful of which do. Unit: 1.
const ROUNDS: usize = 10_000;

/// Rounds in which all elements change that have to. Unit: 1.
const AT_ONCE: usize = 50;

/// Share of the critical slip that an element may slip in one step before it is cut, and in a jump that is none. Unit: 1.
pub(super) const LARGEST_STEP: f64 = 0.2;

/// Sweeps of slip that grows through slopes that are not stable; a hundred do where it ends. Unit: 1.
const SWEEPS: usize = 4000;

/// A traction beyond its limit by less than this share of the largest limit is rounding. Unit: 1.
const ROUNDING: f64 = 1e-12;

/// A plane of equal elements of constant slip in plane strain, under a shear traction that it knows without slip:
/// ```text
/// τ_i = τ0_i − Σ_j k_|i−j| δ_j      k_m = G/(2π(1−ν)h) / (¼ − m²) · (−1)      |τ_i| ≤ L_i(|δ_i|)      δ_i ≠ 0 only along |τ_i| = L_i
/// L(γ) = max(L_s − W γ, L_d)
/// ```
/// so that k_0 > 0 and all others < 0; τ_i is taken at the middle of an element, τ0_i as its mean, as slip of constant pieces has no finite
/// mean traction on its own element. While slip is stable, `k − W` on what slides is a symmetric M-matrix: sets that only grow
/// from nothing end at the smallest slip, which does not depend on the path of a load that grows. Where `k − W` is no longer
/// positive definite slip runs away.
///
/// # Source
/// Edge dislocations: J. P. Hirth, J. Lothe, *Theory of Dislocations* (1982), §3.4; Crouch's constant displacement discontinuities: glide
/// leaves the normal traction of its plane alone, so that limits are known. Least element of a linear complementarity problem with an M-matrix: R. Chandrasekaran,
/// *A special case of the complementary pivot problem*, Opsearch 7 (1970) 263–268; one element at a time: K. G. Murty, *Note on a
/// Bard-type scheme for solving the complementarity problem*, Opsearch 11 (1974) 123–130. Loss of definiteness: K. Uenishi, J. R. Rice,
/// J. Geophys. Res. 108 (2003) 2042.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultFriction {
    /// k_m [Pa/m].
    stiffness: Vec<f64>,
}

/// Limits of the elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Before any slip, L_s ≥ 0 [Pa].
    pub peak: f64,
    /// After much slip, 0 ≤ L_d ≤ L_s [Pa].
    pub residual: f64,
    /// Slip between the two; 0 without weakening [m].
    pub critical_slip: f64,
}

impl Strength {
    /// A limit that does not weaken [Pa].
    pub fn constant(limit: f64) -> Self {
        Self {
            peak: limit,
            residual: limit,
            critical_slip: 0.0,
        }
    }

    /// W [Pa/m].
    fn slope(self) -> f64 {
        match self.critical_slip > 0.0 {
            true => (self.peak - self.residual) / self.critical_slip,
            false => 0.0,
        }
    }

    /// L(γ) [Pa].
    pub fn after(self, slip: f64) -> f64 {
        (self.peak - self.slope() * slip.abs()).max(self.residual.min(self.peak))
    }
}

/// What slides, and how.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sliding {
    /// δ per element [m].
    pub(super) slip: Vec<f64>,
    /// 0: stuck; ±1: slides along this sign.
    signs: Vec<f64>,
    /// Past its critical slip an element has its residual strength.
    spent: Vec<bool>,
}

impl Sliding {
    /// Nothing slides.
    pub(super) fn none(elements: usize) -> Self {
        Self {
            slip: vec![0.0; elements],
            signs: vec![0.0; elements],
            spent: vec![false; elements],
        }
    }

    /// Elements that slide.
    fn sliding(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.signs.len()).filter(|i| self.signs[*i] != 0.0)
    }

    /// Elements whose friction may fall between the two states, and the largest change of slip among them [m].
    pub(super) fn weakening_since(&self, before: &Self) -> (Vec<usize>, f64) {
        let change = |i: usize| (self.slip[i] - before.slip[i]).abs();
        let weakens = |i: &usize| change(*i) > 0.0 && !(self.spent[*i] && before.spent[*i]);
        let moved: Vec<usize> = (0..self.slip.len()).filter(weakens).collect();
        let largest = moved.iter().fold(0.0, |m, i| change(*i).max(m));
        (moved, largest)
    }
}

/// Why there is no slip in equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub enum NoState {
    /// Slip runs away: `k − W` is not positive definite.
    Runaway {
        /// Elements that slide as it does.
        sliding: Vec<usize>,
    },
    /// Elements still change between stick and slip.
    Unsettled,
}

impl FaultFriction {
    /// A plane of so many elements of length h [m].
    pub fn new(rock: Rock, elements: usize, h: f64) -> Self {
        let scale = rock.shear() / (2.0 * std::f64::consts::PI * (1.0 - rock.poisson) * h);
        let entry = |m: usize| {
            let m = m as f64;
            // 1/(m + ½) − 1/(m − ½) = −1/(m² − ¼)
            -scale / (m * m - 0.25)
        };
        Self {
            stiffness: (0..elements).map(entry).collect(),
        }
    }

    /// τ after a slip [Pa].
    pub fn shear_after(&self, shear: &[f64], slip: &[f64]) -> Vec<f64> {
        let mut tau = shear.to_vec();
        for (j, d) in slip.iter().enumerate().filter(|(_, d)| **d != 0.0) {
            let (below, above) = tau.split_at_mut(j);
            axpy(-d, &self.stiffness[..above.len()], above);
            for (tau, k) in below.iter_mut().rev().zip(&self.stiffness[1..]) {
                *tau -= k * d;
            }
        }
        tau
    }

    /// The smallest slip δ [m] under a shear traction [Pa], from none and in one step: where friction weakens it may lie beyond a jump,
    /// which [`super::FaultPath`] finds step by step.
    ///
    /// # Errors
    /// As [`FaultFriction::next`].
    pub fn slip(&self, shear: &[f64], strength: &[Strength]) -> Result<Vec<f64>, NoState> {
        let rest = Sliding::none(self.stiffness.len());
        let mut factor = SlidingFactor::default();
        let given = (shear, strength);
        let state = self.next(&mut factor, &rest, given, f64::INFINITY)?;
        Ok(state.slip)
    }

    /// What slides under a shear traction [Pa] that differs little from that of a state; `factor` is that of the call before, or none. Slip
    /// runs away, too, where what may weaken slips by more than `most` [m].
    ///
    /// # Cost
    /// O(n m + m² r) per round with m of n elements that slide and r that begin to, or whose slope is another; a handful of rounds.
    ///
    /// # Errors
    /// [`NoState`].
    pub(super) fn next(
        &self,
        factor: &mut SlidingFactor,
        start: &Sliding,
        (shear, strength): (&[f64], &[Strength]),
        most: f64,
    ) -> Result<Sliding, NoState> {
        let n = self.stiffness.len();
        assert!(
            shear.len() == n && strength.len() == n && start.slip.len() == n,
            "{n} elements, {} tractions, {} strengths",
            shear.len(),
            strength.len()
        );
        let largest = strength.iter().fold(0.0f64, |m, s| m.max(s.peak));
        let mut state = start.clone();
        self.balance_or_grow(factor, &mut state, start, (shear, strength))?;
        let mut sets = 0;
        for _ in 0..ROUNDS {
            let Sliding { slip, signs, spent } = &state;
            let tau = self.shear_after(shear, slip);
            // what was pulled along and turns back lets go; with one sign of shear there is none
            let lets_go = |i: usize| signs[i] != 0.0 && slip[i] * signs[i] < 0.0;
            let breaks =
                |i: usize| signs[i] == 0.0 && tau[i].abs() - strength[i].peak > ROUNDING * largest;
            let softens = |i: usize| {
                let critical = strength[i].critical_slip;
                critical > 0.0 && signs[i] != 0.0 && spent[i] != (slip[i].abs() > critical)
            };
            // slopes first: with those of less slip than there is, slip is too large, and too much would begin to slide
            let slopes: Vec<usize> = (0..n).filter(|i| softens(*i)).collect();
            let changed: Vec<usize> = match slopes.is_empty() {
                true => {
                    // what slides only grows from here, and slip with it
                    let (moved, largest) = state.weakening_since(start);
                    if largest > most {
                        return Err(NoState::Runaway { sliding: moved });
                    }
                    let changes = |i: &usize| lets_go(*i) || breaks(*i);
                    // all at once; where that goes in circles, the first alone, which ends
                    let count = if sets < AT_ONCE { n } else { 1 };
                    sets += 1;
                    (0..n).filter(changes).take(count).collect()
                }
                false => slopes,
            };
            if changed.is_empty() {
                return Ok(state);
            }
            let Sliding { slip, signs, spent } = &mut state;
            for i in changed {
                match (signs[i] != 0.0, slip[i] * signs[i] < 0.0) {
                    (false, _) => signs[i] = tau[i].signum(),
                    (true, true) => (signs[i], spent[i]) = (0.0, false),
                    (true, false) => spent[i] = !spent[i],
                }
            }
            self.balance_or_grow(factor, &mut state, start, (shear, strength))?;
        }
        Err(NoState::Unsettled)
    }

    /// Slip of what slides; where k − W of these slopes is not positive definite, it may be so of those that a little more slip leaves: an
    /// element begins to slide while another is about to pass its critical slip.
    fn balance_or_grow(
        &self,
        factor: &mut SlidingFactor,
        state: &mut Sliding,
        start: &Sliding,
        given: (&[f64], &[Strength]),
    ) -> Result<(), NoState> {
        let is_stable = self.balance(factor, state, given)
            || (self.grow(state, &start.slip, given) && self.balance(factor, state, given));
        match is_stable {
            true => Ok(()),
            false => Err(NoState::Runaway {
                sliding: state.sliding().collect(),
            }),
        }
    }

    /// Slip that grows from `from` by sweeps over what slides, `δ_i ← δ_i + (|τ_i| − L_i(δ_i))₊/k_0`, and the slopes at its end; false
    /// where it does not end within [`LARGEST_STEP`] of the critical slip.
    ///
    /// Each sweep is isotone, as k_0 > 0 is the only positive entry and L falls with slip, so that slip never passes its least state.
    fn grow(
        &self,
        state: &mut Sliding,
        from: &[f64],
        (shear, strength): (&[f64], &[Strength]),
    ) -> bool {
        let sliding: Vec<usize> = state.sliding().collect();
        let mut slip: Vec<f64> = sliding.iter().map(|i| from[*i]).collect();
        let largest = sliding.iter().fold(0.0f64, |m, i| m.max(strength[*i].peak));
        for _ in 0..SWEEPS {
            let mut most = 0.0f64;
            for (a, i) in sliding.iter().enumerate() {
                let released: f64 = (sliding.iter().zip(&slip))
                    .map(|(j, d)| self.stiffness[i.abs_diff(*j)] * d)
                    .sum();
                let sign = state.signs[*i];
                let excess = sign * (shear[*i] - released) - strength[*i].after(slip[a]);
                if excess > 0.0 {
                    most = most.max(excess);
                    slip[a] += sign * excess / self.stiffness[0];
                }
                if (slip[a] - from[*i]).abs() > LARGEST_STEP * strength[*i].critical_slip {
                    return false;
                }
            }
            if most <= ROUNDING.sqrt() * largest {
                for (i, d) in sliding.iter().zip(&slip) {
                    state.spent[*i] = d.abs() > strength[*i].critical_slip;
                }
                return true;
            }
        }
        false
    }

    /// Slip of what slides, the rest being stuck: `(k − W) δ = τ0 − s L` on the sliding elements; false where k − W is not positive
    /// definite.
    fn balance(
        &self,
        factor: &mut SlidingFactor,
        Sliding { slip, signs, spent }: &mut Sliding,
        (shear, strength): (&[f64], &[Strength]),
    ) -> bool {
        // of an element that slides: its limit without slip, and W
        let of = |i: usize| match spent[i] {
            true => (strength[i].residual, 0.0),
            false => (strength[i].peak, strength[i].slope()),
        };
        let own = |i: usize| (signs[i] != 0.0).then(|| self.stiffness[0] - of(i).1);
        let own: Vec<Option<f64>> = (0..signs.len()).map(own).collect();
        if !factor.bring_to(&self.stiffness, &own) {
            return false;
        }
        slip.fill(0.0);
        factor.solve(|i| shear[i] - signs[i] * of(i).0, slip);
        true
    }
}

#[cfg(test)]
mod tests;
