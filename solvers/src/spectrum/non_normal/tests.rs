//! Claims: σ_min agrees with a full SVD; discs of radius ε lie in the ε-pseudospectrum, and are it for a normal matrix; GMRES never lies above
//! the bounds.

use super::*;
use crate::spectrum::report::Eigenvalues;
use faer::c64;
use fracas_operators::random::Random;

/// σ_min(zI − T) by a singular value decomposition of `[xI − T, y; −y, xI − T]`.
fn by_svd(t: &Mat<f64>, z: c64) -> f64 {
    let n = t.nrows();
    let whole = Mat::from_fn(2 * n, 2 * n, |i, j| {
        let (p, q) = (i % n, j % n);
        let here = |v: f64| if p == q { v } else { 0.0 };
        match (i < n, j < n) {
            (true, true) | (false, false) => here(z.re) - t[(p, q)],
            (true, false) => here(-z.im),
            (false, true) => here(z.im),
        }
    });
    *dense::singular_values(whole.as_ref())
        .unwrap()
        .last()
        .unwrap()
}

fn smallest(resolvent: &Resolvent, z: c64) -> f64 {
    resolvent.smallest(&[z], 1e-8).unwrap()[0]
}

fn eigenvalues(t: &Mat<f64>) -> Eigenvalues {
    Eigenvalues::sorted(dense::general_eigenvalues(t.as_ref()).unwrap())
}

/// Eigenvalues in the right half plane, coupled more or less strongly above the diagonal, in a random basis.
fn case(seed: u64) -> Mat<f64> {
    let dice = &mut Random::new(seed);
    let n = 2 + dice.below(28);
    let coupling = dice.scale(1e-3, 3.0);
    let shift = dice.scale(0.3, 3.0);
    let mut t = Mat::from_fn(n, n, |i, j| match j.cmp(&i) {
        std::cmp::Ordering::Equal => shift + dice.between(0.0, 1.0),
        std::cmp::Ordering::Greater => coupling * dice.between(-1.0, 1.0),
        std::cmp::Ordering::Less => 0.0,
    });
    for i in (1..n).step_by(2) {
        // a pair of conjugate eigenvalues
        if dice.once_in(2) {
            t[(i, i)] = t[(i - 1, i - 1)];
            let v = dice.between(0.1, 0.8);
            (t[(i - 1, i)], t[(i, i - 1)]) = (v, -v);
        }
    }
    // a reflection I − 2vvᵀ
    let v = Mat::from_fn(n, 1, |_, _| dice.between(-1.0, 1.0));
    let q = Mat::<f64>::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_l2().powi(2));
    &q * t * &q
}

#[test]
fn the_resolvent_agrees_with_a_full_svd_at_every_point() {
    for seed in 0..60 {
        let t = case(seed);
        let resolvent = Resolvent::new(&t).unwrap();
        let dice = &mut Random::new(1000 + seed);
        // no multiple of the points that a register holds
        let points: Vec<c64> = (0..13)
            .map(|_| c64::new(dice.between(-1.0, 4.0), dice.between(-2.0, 2.0)))
            .collect();
        let together = resolvent.smallest(&points, 1e-8).unwrap();
        for (z, found) in points.into_iter().zip(together) {
            let expected = by_svd(&t, z);
            assert_eq!(found, smallest(&resolvent, z), "{seed}: beside others");
            assert!(
                (found - expected).abs() <= 1e-6 * expected + 1e-13,
                "{seed}: {found} {expected}"
            );
        }
    }
}

#[test]
fn discs_about_eigenvalues_lie_in_pseudospectra_and_are_them_for_a_normal_matrix() {
    let distance = |values: &Eigenvalues, z: c64| {
        let each = values.iter().map(|(re, im)| (z.re - re).hypot(z.im - im));
        each.fold(f64::INFINITY, f64::min)
    };
    let mut strictly = 0;
    for seed in 0..60 {
        let general = case(seed);
        // λI + (K − Kᵀ) is normal
        let skew = Mat::from_fn(general.nrows(), general.nrows(), |i, j| {
            let diagonal = if i == j { 2.0 } else { 0.0 };
            diagonal + general[(i, j)] - general[(j, i)]
        });
        let dice = &mut Random::new(2000 + seed);
        for (t, is_normal) in [(&general, false), (&skew, true)] {
            let (resolvent, values) = (Resolvent::new(t).unwrap(), eigenvalues(t));
            for _ in 0..8 {
                let z = c64::new(dice.between(0.0, 3.0), dice.between(-1.0, 1.0));
                let (sigma, far) = (smallest(&resolvent, z), distance(&values, z));
                // rounding of a defective eigenvalue moves it, and with it its distance
                assert!(sigma <= far + 1e-6, "{seed}: {sigma} {far}");
                if is_normal {
                    assert!((sigma - far).abs() <= 1e-6, "{seed}: {sigma} {far}");
                } else {
                    strictly += usize::from(sigma < 0.9 * far);
                }
            }
        }
    }
    assert!(
        strictly > 100,
        "{strictly}: hardly any of the matrices is far from normal"
    );
}

#[test]
fn gmres_never_lies_above_its_bounds() {
    let (mut by_resolvent, mut by_field) = (0, 0);
    for seed in 0..16 {
        let t = case(seed);
        let n = t.nrows();
        let request = NonNormalRequest {
            points: 0,
            ..NonNormalRequest::default()
        };
        let values = eigenvalues(&t);
        for start in 0..2 {
            let r_0: Vec<f64> = probe(n, 10 * seed + start);
            let found = NonNormal::of_matrix(&t, &r_0, &values, &request)
                .unwrap()
                .gmres;
            for (k, measured) in found.measured.iter().enumerate() {
                for bound in [found.resolvent[k], found.field_of_values[k]] {
                    assert!(
                        *measured <= bound * (1.0 + 1e-8) + 1e-11,
                        "{seed}, {k}: {measured} {bound}"
                    );
                }
            }
            by_resolvent += usize::from(found.steps[1].is_some());
            by_field += usize::from(found.steps[2].is_some());
        }
    }
    assert!(
        by_resolvent > 20 && by_field > 8,
        "{by_resolvent} {by_field}"
    );
}

#[test]
fn a_bound_too_small_is_seen() {
    // GMRES on the shift makes no progress before its last step, and zero lies in its field of values
    let n = 8;
    let shift = Mat::from_fn(n, n, |i, j| if i == (j + 1) % n { 1.0 } else { 0.0 });
    let r_0: Vec<f64> = (0..n).map(|i| if i == 0 { 1.0 } else { 0.0 }).collect();
    let request = NonNormalRequest::default();
    let found = NonNormal::of_matrix(&shift, &r_0, &eigenvalues(&shift), &request).unwrap();
    assert!(found.departure < 1e-6 && !found.field_of_values.excludes_zero);
    assert!(
        found
            .gmres
            .resolvent
            .iter()
            .chain(&found.gmres.field_of_values)
            .all(|b| *b == 1.0)
    );
    let grid = found.pseudospectra.unwrap();
    assert_eq!(grid.log10_epsilon.len(), grid.im.len());
    assert_eq!(grid.log10_epsilon[0].len(), grid.re.len());
}

#[test]
fn what_is_the_identity_beside_a_small_space_is_left_out_without_loss() {
    for seed in 0..20 {
        let dice = &mut Random::new(seed);
        let (n, rank) = (30 + dice.below(20), 1 + dice.below(6));
        let random = |dice: &mut Random, m, n| Mat::from_fn(m, n, |_, _| dice.between(-1.0, 1.0));
        let (p, q) = (random(dice, n, rank), random(dice, n, rank));
        let t = Mat::<f64>::identity(n, n) + &p * q.transpose() * (0.5 / n as f64);
        let r: Vec<f64> = probe(n, seed);
        let (small, r_small) = compress::compressed(&t, &r).unwrap();
        assert_eq!((small.nrows(), r_small.len()), (2 * rank + 1, 2 * rank + 1));
        let resolvent = Resolvent::new(&small).unwrap();
        for _ in 0..6 {
            let z = c64::new(dice.between(0.0, 2.0), dice.between(-1.0, 1.0));
            let (found, expected) = (smallest(&resolvent, z), by_svd(&t, z));
            assert!(
                (found - expected).abs() <= 1e-6 * expected,
                "{seed}: {found} {expected}"
            );
        }
        // W and GMRES
        let field = |t: &Mat<f64>| field_of_values::of_matrix(t.as_ref(), "").unwrap().support;
        for (a, b) in field(&t).iter().zip(field(&small)) {
            assert!((a - b).abs() < 1e-6, "{seed}: {a} {b}");
        }
        let history = |t: &Mat<f64>, r: &[f64]| {
            let n = r.len();
            transient::residuals(&Dense::from_fn(Shape::square(n), |i, j| t[(i, j)]), r)
        };
        for (a, b) in history(&t, &r).iter().zip(history(&small, &r_small)) {
            assert!((a - b).abs() < 1e-8, "{seed}: {a} {b}");
        }
    }
    assert!(compress::compressed(&case(3), &[1.0; 40][..case(3).nrows()]).is_none());
}
