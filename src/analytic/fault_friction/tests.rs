use super::*;
use crate::analytic::LinearWeakening;

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
    let n = 400;
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
            // slip past the critical one is a state beyond the jump
            let given = (&shear(middle)[..], &vec![strength; n][..]);
            let rest = Sliding::none(n);
            let factor = &mut SlidingFactor::default();
            match plane.next(factor, &rest, given, strength.critical_slip) {
                Ok(Sliding { slip, .. }) => {
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
