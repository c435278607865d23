//! What theorems bound holds, what was printed does not, and thresholds separate.

use super::*;

/// S̃_u of different quality: damped Jacobi and SSOR.
fn inner_of(seed: u64) -> InnerChoice {
    let omega = 0.15 + 1.7 * (seed % 97) as f64 / 97.0;
    if seed.is_multiple_of(2) {
        InnerChoice::Jacobi(Jacobi {
            omega,
            ..Jacobi::default()
        })
    } else {
        InnerChoice::Ssor(Ssor { omega })
    }
}

#[test]
fn bounds_and_disc_hold_on_800_random_systems() {
    let (mut with_complex, mut printed_fails) = (0, 0);
    for seed in 0..800 {
        let n_u = 4 + (seed % 7) as usize;
        let n_t = 1 + (seed % 5) as usize;
        let h = if seed % 3 == 0 {
            0.0
        } else {
            0.05 * (seed % 41) as f64
        };
        let mut blocks = random(n_u, n_t, h, 31 + seed);
        if seed % 4 == 0 {
            // A singular: its last unknown floats.
            blocks.a = sparse(n_u, n_u, |i, j| {
                if i.max(j) + 1 == n_u {
                    0.0
                } else {
                    *blocks.a.get(i, j).unwrap()
                }
            });
        }
        let request = SpectrumRequest {
            augmentation: if seed % 5 == 0 {
                AugmentationChoice::Global
            } else {
                AugmentationChoice::LocalH
            },
            inner: inner_of(seed),
            ..SpectrumRequest::default()
        };
        let report = analyse(&blocks, &request, &mut Silent).unwrap();
        let theorem = if blocks.h.is_some() {
            Theorem::WithH
        } else {
            Theorem::WithoutH
        };
        assert_eq!(report.bounds.theorem, theorem);
        assert_eq!(
            report.contained,
            Some(true),
            "seed {seed}: {:?}",
            report.outside
        );
        with_complex += usize::from(report.n_complex > 0);
        printed_fails += usize::from(!report.printed.unwrap().outside.is_empty());
    }
    // The sample is not trivial.
    assert!(with_complex > 200, "{with_complex}");
    assert!(printed_fails > 50, "{printed_fails}");
}

#[test]
fn the_printed_complex_bound_fails_for_h_not_zero() {
    // A = B = C = 1, S_u = 2, S̃_u = 4, H = ½: T = [5/8 1/4; −1/4 1/2], λ = 9/16 ± i√15/16, printed Re λ = K/2 = 3/8.
    let one = || sparse(1, 1, |_, _| 1.0);
    let mut blocks = random(1, 1, 0.0, 1);
    (blocks.a, blocks.b1, blocks.h) = (one(), one(), Some(sparse(1, 1, |_, _| 0.5)));
    let request = SpectrumRequest {
        augmentation: AugmentationChoice::Global,
        inner: InnerChoice::Jacobi(Jacobi {
            omega: 0.5,
            ..Jacobi::default()
        }),
        ..SpectrumRequest::default()
    };
    let report = analyse(&blocks, &request, &mut Silent).unwrap();
    for (re, im) in report.eigenvalues.iter() {
        assert!((re - 9.0 / 16.0).abs() < 1e-14);
        assert!((im.abs() - 15f64.sqrt() / 16.0).abs() < 1e-14);
    }
    let printed = report.printed.unwrap();
    assert!(!printed.applies);
    assert_eq!(printed.outside.len(), 2);
    assert!(
        printed
            .outside
            .iter()
            .all(|o| o.verdict == Verdict::RealPart)
    );
    assert_eq!(printed.bounds.re_high, Some(0.375));
    assert_eq!(report.contained, Some(true));
}

#[test]
fn when_beta_u_is_below_twice_alpha_t_no_real_eigenvalue_lies_below_alpha_u() {
    // One spring: K = k̃, G = g; λ² − kλ + g² = 0 has no real root when k < 2g.
    let ingredients = Ingredients {
        k: (0.5, 0.9),
        g: (0.6, 0.7),
        h_hat: (0.0, 0.0),
        k_h: (0.5, 0.9),
        coupling: 0.7,
        sigma: (0.5, 0.9),
        h: (0.0, 0.0),
    };
    let bounds = Bounds::printed(&ingredients);
    assert_eq!(bounds.real_low, Some(0.5));
    let narrow = Ingredients {
        g: (0.1, 0.7),
        ..ingredients
    };
    let expected = 2.0 * 0.01 / (0.9 + (0.81f64 - 0.04).sqrt());
    assert!((Bounds::printed(&narrow).real_low.unwrap() - expected).abs() < 1e-15);
    let real = Ingredients {
        g: (0.1, 0.2),
        ..ingredients
    };
    assert_eq!(Bounds::printed(&real).im_max, Some(0.0));
}

/// `f M⁻¹`.
struct Scaled(f64, Box<dyn Preconditioner<f64>>);

impl Preconditioner<f64> for Scaled {
    fn size(&self) -> usize {
        self.1.size()
    }
    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.1.solve(r, z, work);
        z.iter_mut().for_each(|z| *z *= self.0);
    }
    fn work_len(&self) -> usize {
        self.1.work_len()
    }
    fn flops(&self) -> u64 {
        self.1.flops() + self.size() as u64
    }
    fn properties(&self) -> Properties {
        self.1.properties()
    }
}

#[test]
fn when_alpha_u_is_at_least_two_the_spectrum_is_real() {
    // H = 0: a non-real λ has |λ|² ≤ Re λ = k/2 and hence k < 2.
    let mut non_real_below = 0;
    for seed in 0..60 {
        let blocks = random(
            6 + seed as usize % 5,
            1 + seed as usize % 4,
            0.0,
            400 + seed,
        );
        let choice = inner_of(seed);
        let request = SpectrumRequest {
            augmentation: AugmentationChoice::Local,
            inner: choice,
            ..SpectrumRequest::default()
        };
        let scaled = |factor: f64| {
            let build = |blocks: &SaddleBlocks, c: &AugmentationMatrix| {
                let inner = choice.prepare(blocks, c)?.inverse;
                Ok(Box::new(Scaled(factor, inner)) as Box<dyn Preconditioner<f64>>)
            };
            let report = analyse_around(&blocks, &request, &build, &mut Silent).unwrap();
            (report.bounds.alpha_u.unwrap(), report.n_complex > 0)
        };
        let (alpha_u, _) = scaled(1.0);
        let (two, non_real) = scaled(2.0 / alpha_u);
        assert!((two - 2.0).abs() < 1e-9 && !non_real, "seed {seed}");
        non_real_below += usize::from(scaled(0.5 / alpha_u).1);
    }
    // Not so below: the threshold separates.
    assert!(non_real_below > 30, "{non_real_below}");
}
