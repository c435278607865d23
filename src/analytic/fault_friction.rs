//! Slip of a plane whose friction weakens, until it runs away.

use super::Rock;

/// Rounds of the set of sliding elements, a handful of which do. Unit: 1.
const ROUNDS: usize = 10_000;

/// Rounds in which all elements change that have to. Unit: 1.
const AT_ONCE: usize = 50;

/// A traction beyond its limit by less than this share of the largest limit is rounding. Unit: 1.
const ROUNDING: f64 = 1e-12;

/// A plane of equal elements of constant slip in plane strain, under a shear traction that it knows without slip:
/// ```text
/// τ_i = τ0_i − Σ_j k_|i−j| δ_j      k_m = G/(2π(1−ν)h) / (¼ − m²) · (−1)      |τ_i| ≤ L_i(|δ_i|)      δ_i ≠ 0 only along |τ_i| = L_i
/// L(γ) = max(L_s − W γ, L_d)
/// ```
/// so that k_0 > 0 and all others < 0. While slip is stable, `k − W` on what slides is a symmetric M-matrix: sets that only grow
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
pub struct Sliding {
    /// δ per element [m].
    pub slip: Vec<f64>,
    /// 0: stuck; ±1: slides along this sign.
    signs: Vec<f64>,
    /// Past its critical slip an element has its residual strength.
    spent: Vec<bool>,
}

impl Sliding {
    /// Nothing slides.
    pub fn none(elements: usize) -> Self {
        Self {
            slip: vec![0.0; elements],
            signs: vec![0.0; elements],
            spent: vec![false; elements],
        }
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
        let sliding: Vec<usize> = (0..slip.len()).filter(|j| slip[*j] != 0.0).collect();
        let released = |i: usize| -> f64 {
            (sliding.iter())
                .map(|j| self.stiffness[i.abs_diff(*j)] * slip[*j])
                .sum()
        };
        (shear.iter().enumerate())
            .map(|(i, tau)| tau - released(i))
            .collect()
    }

    /// The smallest slip δ [m] under a shear traction [Pa], from none.
    ///
    /// # Errors
    /// As [`FaultFriction::next`].
    pub fn slip(&self, shear: &[f64], strength: &[Strength]) -> Result<Vec<f64>, NoState> {
        let rest = Sliding::none(self.stiffness.len());
        Ok(self.next(&rest, shear, strength)?.slip)
    }

    /// What slides under a shear traction [Pa] that differs little from that of a state.
    ///
    /// # Cost
    /// O(m³) per round with m sliding elements; a handful of rounds.
    ///
    /// # Errors
    /// [`NoState`].
    pub fn next(
        &self,
        start: &Sliding,
        shear: &[f64],
        strength: &[Strength],
    ) -> Result<Sliding, NoState> {
        let n = self.stiffness.len();
        assert!(
            shear.len() == n && strength.len() == n && start.slip.len() == n,
            "{n} elements, {} tractions, {} strengths",
            shear.len(),
            strength.len()
        );
        let largest = strength.iter().fold(0.0f64, |m, s| m.max(s.peak));
        let Sliding {
            mut slip,
            mut signs,
            mut spent,
        } = start.clone();
        self.balance(&mut slip, &signs, shear, strength, &spent)?;
        for round in 0..ROUNDS {
            let tau = self.shear_after(shear, &slip);
            // what was pulled along and turns back lets go; with one sign of shear there is none
            let lets_go = |i: usize| signs[i] != 0.0 && slip[i] * signs[i] < 0.0;
            let breaks =
                |i: usize| signs[i] == 0.0 && tau[i].abs() - strength[i].peak > ROUNDING * largest;
            let softens = |i: usize| {
                let critical = strength[i].critical_slip;
                critical > 0.0 && signs[i] != 0.0 && spent[i] != (slip[i].abs() > critical)
            };
            let changes = |i: &usize| lets_go(*i) || breaks(*i) || softens(*i);
            // all at once; where that goes in circles, the first alone, which ends
            let most = if round < AT_ONCE { n } else { 1 };
            let changed: Vec<usize> = (0..n).filter(changes).take(most).collect();
            if changed.is_empty() {
                return Ok(Sliding { slip, signs, spent });
            }
            for i in changed {
                match (signs[i] != 0.0, slip[i] * signs[i] < 0.0) {
                    (false, _) => signs[i] = tau[i].signum(),
                    (true, true) => (signs[i], spent[i]) = (0.0, false),
                    (true, false) => spent[i] = !spent[i],
                }
            }
            self.balance(&mut slip, &signs, shear, strength, &spent)?;
        }
        Err(NoState::Unsettled)
    }

    /// Slip of what slides, the rest being stuck.
    fn balance(
        &self,
        slip: &mut [f64],
        signs: &[f64],
        shear: &[f64],
        strength: &[Strength],
        spent: &[bool],
    ) -> Result<(), NoState> {
        let sliding: Vec<usize> = (0..signs.len()).filter(|i| signs[*i] != 0.0).collect();
        let Some(solved) = self.on(&sliding, signs, shear, strength, spent) else {
            return Err(NoState::Runaway { sliding });
        };
        slip.fill(0.0);
        for (i, d) in sliding.iter().zip(solved) {
            slip[*i] = d;
        }
        Ok(())
    }

    /// `(k − W) δ = τ0 − s L` on the sliding elements, by Cholesky's factorization; `None` where it is not positive definite.
    fn on(
        &self,
        sliding: &[usize],
        signs: &[f64],
        shear: &[f64],
        strength: &[Strength],
        spent: &[bool],
    ) -> Option<Vec<f64>> {
        let m = sliding.len();
        // rows of L, packed
        let row = |i: usize| i * (i + 1) / 2;
        let mut l = vec![0.0; row(m)];
        let mut x = Vec::with_capacity(m);
        for (a, i) in sliding.iter().enumerate() {
            let s = strength[*i];
            let (limit, slope) = match spent[*i] {
                true => (s.residual, 0.0),
                false => (s.peak, s.slope()),
            };
            let mut rhs = shear[*i] - signs[*i] * limit;
            for (b, j) in sliding[..=a].iter().enumerate() {
                let mut v = self.stiffness[i.abs_diff(*j)];
                if a == b {
                    v -= slope;
                }
                let (head, tail) = l.split_at_mut(row(a));
                let own = &mut tail[..=b];
                let other = if a == b {
                    &own[..b]
                } else {
                    &head[row(b)..row(b) + b]
                };
                v -= own[..b].iter().zip(other).map(|(p, q)| p * q).sum::<f64>();
                own[b] = match a == b {
                    true if v > 0.0 => v.sqrt(),
                    true => return None,
                    false => v / head[row(b) + b],
                };
                if a == b {
                    rhs -= own[..b]
                        .iter()
                        .zip(&x)
                        .map(|(p, q): (&f64, &f64)| p * q)
                        .sum::<f64>();
                    x.push(rhs / own[b]);
                }
            }
        }
        for a in (0..m).rev() {
            x[a] /= l[row(a) + a];
            let (head, tail) = x.split_at_mut(a);
            for (v, entry) in head.iter_mut().zip(&l[row(a)..]) {
                *v -= entry * tail[0];
            }
        }
        Some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::super::LinearWeakening;
    use super::*;

    const ROCK: Rock = Rock {
        young: 25e9,
        poisson: 0.25,
    };

    fn plane(n: usize, length: f64) -> FaultFriction {
        FaultFriction::new(ROCK, n, length / n as f64)
    }

    /// δ by projected Gauss–Seidel sweeps, `τ_i = τ0_i + G/(2π(1−ν)) Σ_j δ_j (1/(s_i − b_j) − 1/(s_i − a_j))` in the middle s_i of
    /// elements from a_j to b_j.
    fn sweeps(length: f64, shear: &[f64], limit: &[f64]) -> Vec<f64> {
        let n = shear.len();
        let scale = ROCK.shear() / (2.0 * std::f64::consts::PI * (1.0 - ROCK.poisson));
        let end = |k: usize| length * k as f64 / n as f64;
        let kernel = |i: usize, j: usize| {
            let s = 0.5 * (end(i) + end(i + 1));
            scale * (1.0 / (s - end(j + 1)) - 1.0 / (s - end(j)))
        };
        let mut slip = vec![0.0; n];
        for _ in 0..20_000 {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for i in 0..n {
                let others: f64 = (0..n)
                    .filter(|j| *j != i)
                    .map(|j| kernel(i, j) * slip[j])
                    .sum();
                let trial = shear[i] + others;
                // what of the traction is beyond the limit
                let new = (trial - trial.clamp(-limit[i], limit[i])) / -kernel(i, i);
                change = change.max((new - slip[i]).abs());
                largest = largest.max(new.abs());
                slip[i] = new;
            }
            if change <= 1e-10 * largest {
                break;
            }
        }
        slip
    }

    #[test]
    fn a_uniform_load_gives_the_ellipse_of_a_crack() {
        let n = 200;
        let strength = vec![Strength::constant(2e6); n];
        let slip = plane(n, 2.0).slip(&vec![-5e6; n], &strength).unwrap();
        // δ = (4(1−ν²)/E) Δτ √(a² − x²), a longer by half an element with constant slip
        let peak = 4.0 * ROCK.plane_strain_compliance() * 3e6;
        for (i, slip) in slip.iter().enumerate() {
            let x = -1.0 + (2.0 * i as f64 + 1.0) / n as f64;
            let exact = -peak * (1.0 - x * x).sqrt();
            if x.abs() < 0.9 {
                assert!((slip - exact).abs() < 0.015 * peak, "{x}: {slip} {exact}");
            }
        }
    }

    /// Uniform in [0, 1): a linear congruential generator.
    fn random(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn without_weakening_slip_is_that_of_projected_sweeps() {
        let mut seed = 7;
        for case in 0..40 {
            let n = 20 + case;
            let waves: Vec<[f64; 3]> = (0..4)
                .map(|_| [0, 1, 2].map(|_| random(&mut seed)))
                .collect();
            let shear: Vec<f64> = (0..n)
                .map(|i| {
                    let s = i as f64 / n as f64;
                    (waves.iter())
                        .map(|[a, k, p]| 8e6 * (a - 0.3) * (12.0 * k * s + 6.0 * p).sin())
                        .sum()
                })
                .collect();
            let limit: Vec<f64> = (0..n).map(|_| 5e6 * random(&mut seed)).collect();
            let strength: Vec<Strength> = limit.iter().map(|l| Strength::constant(*l)).collect();
            let slip = plane(n, 2.0).slip(&shear, &strength).unwrap();
            let sweeps = sweeps(2.0, &shear, &limit);
            assert!(slip.iter().any(|d| *d != 0.0));
            let size = sweeps.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            for (i, (a, b)) in slip.iter().zip(&sweeps).enumerate() {
                assert!(
                    (a - b).abs() < 1e-6 * size,
                    "case {case}, element {i}: {a} {b}"
                );
            }
        }
    }

    #[test]
    fn weakened_elements_carry_what_is_left_of_their_strength() {
        let n = 200;
        let strength = Strength {
            peak: 10e6,
            residual: 8e6,
            critical_slip: 10e-3,
        };
        // a peak in the middle that slides a little
        let shear: Vec<f64> = (0..n)
            .map(|i| 10.6e6 - 4e6 * ((f64::from(i) - 99.5) / 100.0).powi(2))
            .collect();
        let plane = plane(200, 20.0);
        let strengths = vec![strength; 200];
        let slip = plane.slip(&shear, &strengths).unwrap();
        let tau = plane.shear_after(&shear, &slip);
        let sliding = slip.iter().filter(|d| **d > 0.0).count();
        assert!(sliding > 20 && sliding < 200, "{sliding} slide");
        for (tau, d) in tau.iter().zip(&slip) {
            let limit = strength.after(*d);
            assert!(*tau <= limit * (1.0 + 1e-9), "{tau} {limit}");
            assert!(*d == 0.0 || (tau - limit).abs() < 1e-6 * limit);
        }
    }

    #[test]
    fn slip_runs_away_at_the_universal_length() {
        // Uenishi and Rice: whatever the curvature of the load, at a half-length of 0.5789 G/((1−ν) W)
        let weak = LinearWeakening {
            static_friction: 0.6,
            dynamic_friction: 0.1,
            critical_slip: 20e-3,
            normal_traction: -20e6,
        };
        let expected = weak.nucleation_half_length(ROCK);
        let strength = Strength {
            peak: 12e6,
            residual: 2e6,
            critical_slip: 20e-3,
        };
        let n = 800;
        let (length, plane) = (6.0 * expected, plane(n, 6.0 * expected));
        for curvature in [0.5e6, 2e6] {
            let shear = |load: f64| -> Vec<f64> {
                (0..n)
                    .map(|i| {
                        let s = ((i as f64 + 0.5) / n as f64 - 0.5) * length / expected;
                        load - curvature * s * s
                    })
                    .collect()
            };
            let (mut stable, mut gone, mut half) = (12e6, 16e6, 0.0);
            while gone - stable > 1e2 {
                let middle = 0.5 * (stable + gone);
                match plane.slip(&shear(middle), &vec![strength; n]) {
                    Ok(slip) => {
                        let sliding = slip.iter().filter(|d| **d > 0.0).count();
                        half = 0.5 * sliding as f64 * length / n as f64;
                        assert!(slip.iter().all(|d| *d < 20e-3), "still on the slope");
                        stable = middle;
                    }
                    Err(_) => gone = middle,
                }
            }
            assert!((half / expected - 1.0).abs() < 0.03, "{half} {expected}");
        }
    }

    #[test]
    fn nothing_slides_below_the_limit() {
        let slip = plane(50, 1.0)
            .slip(&[2e6; 50], &[Strength::constant(2e6); 50])
            .unwrap();
        assert!(slip.iter().all(|d| *d == 0.0));
    }
}
