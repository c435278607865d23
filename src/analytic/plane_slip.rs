//! Slip of a plane in a full space under known tractions.

use super::Rock;

/// Sweeps that the slip may take.
const SWEEPS: usize = 20_000;

/// Change of the slip in a sweep, relative to the largest, that ends it. Unit: 1.
const SETTLED: f64 = 1e-10;

/// A plane in plane strain, cut into elements of constant slip: glide leaves its normal traction alone, so that its limit is known.
/// ```text
/// τ_i = τ0_i + G/(2π(1−ν)) Σ_j δ_j (1/(s_i − b_j) − 1/(s_i − a_j))        |τ_i| ≤ τ_L,i        δ_i ≠ 0 only along |τ_i| = τ_L,i
/// ```
/// with s_i the middle of the element from a_i to b_i.
///
/// # Source
/// Edge dislocations: J. P. Hirth, J. Lothe, *Theory of Dislocations* (1982), §3.4; Crouch's constant displacement
/// discontinuities.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSlip {
    /// The rock.
    pub rock: Rock,
    /// Ends of the elements along the plane, increasing, one more than elements [m].
    pub ends: Vec<f64>,
    /// Shear traction τ0 without slip [Pa].
    pub shear: Vec<f64>,
    /// Limit τ_L ≥ 0 [Pa].
    pub limit: Vec<f64>,
}

impl PlaneSlip {
    /// τ at the middle of the elements after a slip [Pa].
    pub fn shear_after(&self, slip: &[f64]) -> Vec<f64> {
        let kernel = self.kernel();
        let released = kernel
            .iter()
            .map(|row| row.iter().zip(slip).map(|(k, d)| k * d).sum::<f64>());
        self.shear
            .iter()
            .zip(released)
            .map(|(t, r)| t + r)
            .collect()
    }

    /// ∂τ_i/∂δ_j [Pa/m].
    fn kernel(&self) -> Vec<Vec<f64>> {
        let scale = self.rock.shear() / (2.0 * std::f64::consts::PI * (1.0 - self.rock.poisson));
        let elements: Vec<(f64, f64)> = self.ends.windows(2).map(|e| (e[0], e[1])).collect();
        let row = |(a, b): &(f64, f64)| {
            let s = 0.5 * (a + b);
            let on = |(a, b): &(f64, f64)| scale * (1.0 / (s - b) - 1.0 / (s - a));
            elements.iter().map(on).collect()
        };
        elements.iter().map(row).collect()
    }

    /// δ per element [m], of the sign of the traction that drives it, reached from no slip in one step.
    ///
    /// # Cost
    /// O(elements²) per sweep of projected Gauss–Seidel.
    pub fn slip(&self) -> Vec<f64> {
        let n = self.shear.len();
        assert!(
            self.ends.len() == n + 1 && self.limit.len() == n,
            "{} ends, {} limits for {n} elements",
            self.ends.len(),
            self.limit.len()
        );
        let kernel = self.kernel();
        let mut slip = vec![0.0; n];
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for i in 0..n {
                let others: f64 = kernel[i].iter().zip(&slip).map(|(k, d)| k * d).sum();
                let own = -kernel[i][i];
                // the traction with no slip of its own, and what of it is beyond the limit
                let trial = self.shear[i] + others + own * slip[i];
                let excess = trial - trial.clamp(-self.limit[i], self.limit[i]);
                let new = excess / own;
                change = change.max((new - slip[i]).abs());
                largest = largest.max(new.abs());
                slip[i] = new;
            }
            if change <= SETTLED * largest {
                break;
            }
        }
        slip
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROCK: Rock = Rock {
        young: 25e9,
        poisson: 0.25,
    };

    #[test]
    fn a_uniform_load_gives_the_ellipse_of_a_crack() {
        let n = 200;
        let plane = PlaneSlip {
            rock: ROCK,
            ends: (0..=n)
                .map(|k| -1.0 + 2.0 * f64::from(k) / f64::from(n))
                .collect(),
            shear: vec![-5e6; 200],
            limit: vec![2e6; 200],
        };
        // δ = (4(1−ν²)/E) Δτ √(a² − x²), a longer by half an element with constant slip
        let peak = 4.0 * ROCK.plane_strain_compliance() * 3e6;
        for (i, slip) in plane.slip().iter().enumerate() {
            let x = -1.0 + (2.0 * i as f64 + 1.0) / f64::from(n);
            let exact = -peak * (1.0 - x * x).sqrt();
            if x.abs() < 0.9 {
                assert!((slip - exact).abs() < 0.015 * peak, "{x}: {slip} {exact}");
            }
        }
    }

    #[test]
    fn below_the_limit_nothing_slips_and_beyond_it_tractions_stay_there() {
        let n = 60;
        let wave = |i: usize| (0.2 * i as f64).sin();
        let plane = PlaneSlip {
            rock: ROCK,
            ends: (0..=n).map(|k| 0.1 * f64::from(k)).collect(),
            shear: (0..60).map(|i| 4e6 * wave(i)).collect(),
            limit: vec![2e6; 60],
        };
        let slip = plane.slip();
        assert!(slip.iter().any(|d| *d > 0.0) && slip.iter().any(|d| *d < 0.0));
        let stuck = PlaneSlip {
            limit: vec![4.1e6; 60],
            ..plane.clone()
        };
        assert!(stuck.slip().iter().all(|d| *d == 0.0));
        for (tau, d) in plane.shear_after(&slip).iter().zip(&slip) {
            assert!(tau.abs() <= 2e6 * (1.0 + 1e-6), "{tau}");
            assert!(
                *d == 0.0 || (tau - 2e6 * d.signum()).abs() < 2.0,
                "{tau} {d}"
            );
        }
    }
}
