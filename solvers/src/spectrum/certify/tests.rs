//! Claims: enclosures hold eigenvalues that are known exactly, also of clustered and badly conditioned systems, and an end that is moved into
//! the spectrum is never proved.

use super::cases::{Case, KINDS, Kind, LAST, sparse, with_one_traction};
use super::discs::discs;
use super::pencil::Pencil;
use super::*;
use crate::eigen::{dense, factors};
use faer::Mat;
use fracas_operators::random::Random;

#[test]
fn signs_enclose_spectra_that_are_known_and_prove_no_end_inside() {
    let mut decided = 0;
    for kind in [Kind::Plain, Kind::Clustered, Kind::Stretched] {
        for seed in 0..60 {
            let case = Case::new(seed, kind);
            let pencil = Pencil::new(&case.blocks, &case.c);
            assert!(pencil.is_symmetric());
            let Some(route) = pencil.route() else {
                continue;
            };
            let (low, high) = case.ends();
            for shift in [1e-6, 1e-3, 0.1] {
                // inside by a little: refused; an eigenvalue beyond: not denied
                let (inside_low, inside_high) = (low + shift * low.abs(), high - shift * high);
                assert!(!pencil.none_below(inside_low), "{kind:?} {seed}: {low}");
                assert!(
                    !pencil.none_above(inside_high, route),
                    "{kind:?} {seed}: {high}"
                );
                assert!(!pencil.one_below(low - shift * low.abs() - 1e-9));
                assert!(!pencil.one_above(high + shift * high, route));
                // outside by as much: proved
                if low < 1.0 - 1e-6 && low > 0.0 {
                    assert!(
                        pencil.none_below(low - shift * low),
                        "{kind:?} {seed}: {low}"
                    );
                    decided += 1;
                }
                if high > 1.0 + 1e-6 {
                    assert!(
                        pencil.none_above(high + shift * high, route),
                        "{kind:?} {seed}: {high}"
                    );
                    decided += 1;
                }
            }
        }
    }
    assert!(decided > 300, "{decided}");
}

#[test]
fn discs_hold_spectra_that_are_known_whatever_the_kind() {
    let (mut sharp, mut all) = (0, 0);
    for kind in KINDS {
        for seed in 0..60 {
            let case = Case::new(seed, kind);
            all += 1;
            let Ok(found) = discs(&Pencil::new(&case.blocks, &case.c)) else {
                continue;
            };
            assert_eq!(found.len(), case.values.len());
            for value in &case.values {
                let holds = found.iter().any(|disc| {
                    (disc.center.re - value).hypot(disc.center.im)
                        <= disc.radius + LAST * value.abs()
                });
                assert!(holds, "{kind:?} {seed}: {value} in none of {found:?}");
            }
            sharp += usize::from(found.iter().all(|disc| disc.radius < 1e-8));
        }
    }
    assert!(10 * sharp > 9 * all, "{sharp} of {all}");
}

#[test]
fn eigenvalues_of_random_unsymmetric_systems_lie_in_the_discs() {
    let (mut complex, mut found_discs) = (0, 0);
    for seed in 0..60 {
        let dice = &mut Random::new(seed);
        let (n_u, n_t) = (3 + dice.below(10), 2 + dice.below(8));
        let random = |dice: &mut Random, m, n| Mat::from_fn(m, n, |_, _| dice.between(-1.0, 1.0));
        let r = random(dice, n_u, n_u);
        let a = &r * r.transpose() + Mat::<f64>::identity(n_u, n_u) * 0.1;
        let b = random(dice, n_u, n_t);
        let b2 = b.transpose() + random(dice, n_t, n_u);
        let h = random(dice, n_t, n_t);
        let c = vec![dice.between(0.5, 2.0); n_t];
        let blocks = SaddleBlocks {
            a: sparse(&a),
            b1: sparse(&b),
            b2: Some(sparse(&b2)),
            h: Some(sparse(&h)),
            rhs_u: vec![0.0; n_u],
            rhs_t: vec![0.0; n_t],
            coordinates: None,
            flow: None,
        };
        let c = AugmentationMatrix::from_diagonal(c).unwrap();
        let pencil = Pencil::new(&blocks, &c);
        let Ok(found) = discs(&pencil) else { continue };
        found_discs += 1;
        // M⁻¹𝒜 itself
        let n = n_u + n_t;
        let whole = |t: &dyn Fn(usize, usize) -> f64, c: &dyn Fn(usize, usize) -> f64| {
            Mat::from_fn(n, n, |i, j| match (i < n_u, j < n_u) {
                (true, true) => a[(i, j)],
                (true, false) => b[(i, j - n_u)],
                (false, true) => t(i - n_u, j),
                (false, false) => -c(i - n_u, j - n_u),
            })
        };
        let m = whole(&|k, i| b[(i, k)], &|i, j| {
            if i == j { c.diagonal_entries()[i] } else { 0.0 }
        });
        let product =
            factors::inverse(m.as_ref()).unwrap() * whole(&|k, i| b2[(k, i)], &|i, j| h[(i, j)]);
        for value in dense::general_eigenvalues(product.as_ref()).unwrap() {
            // 1 is one with chains: only its cube root of rounding is known
            let near_one = (value.re - 1.0).hypot(value.im) < 1e-4;
            let inside = found.iter().any(|disc| {
                (disc.center.re - value.re).hypot(disc.center.im - value.im) <= disc.radius + 1e-8
            });
            assert!(near_one || inside, "{seed}: {value:?}");
            complex += usize::from(value.im.abs() > 1e-3);
        }
    }
    assert!(complex > 50 && found_discs > 50, "{complex} {found_discs}");
}

#[test]
fn no_end_is_proved_on_the_wrong_side_by_one_unit_in_the_last_place_or_more() {
    for kind in [Kind::Plain, Kind::Clustered, Kind::Stretched] {
        for seed in 200..230 {
            let case = Case::new(seed, kind);
            let pencil = Pencil::new(&case.blocks, &case.c);
            let Some(route) = pencil.route() else {
                continue;
            };
            // each is one rounding away from what is exact
            let (low, high) = case.ends();
            for digits in (0..40).step_by(3) {
                let off = |at: f64| 2.0 * f64::EPSILON * at * f64::from(digits).exp2();
                let (above, below) = (low + off(low), high - off(high));
                assert!(!pencil.none_below(above), "{kind:?} {seed} {digits}");
                assert!(!pencil.one_below(low - off(low)));
                assert!(!pencil.none_above(below, route), "{kind:?} {seed} {digits}");
                assert!(!pencil.one_above(high + off(high), route));
            }
        }
    }
}

#[test]
fn what_overflows_on_the_way_hides_no_error() {
    let mut refused = 0;
    for seed in 0..1000 {
        let dice = &mut Random::new(seed);
        let n_u = 3 + dice.below(4);
        let whole =
            |dice: &mut Random, most: u32| f64::from(dice.whole(0, 2 * most)) - f64::from(most);
        let rest = Mat::from_fn(n_u, n_u, |_, _| whole(dice, 3));
        // the first row of A is g (0, 1, 1, 0, …), and b = 0 there: λ does not depend on g
        let with = |g: f64| {
            Mat::from_fn(n_u, n_u, |i, j| match (i, j) {
                (0, 1 | 2) => g,
                (0, _) => 0.0,
                _ => rest[(i, j)],
            })
        };
        let b: Vec<f64> = (0..n_u)
            .map(|i| if i == 0 { 0.0 } else { whole(dice, 9) })
            .collect();
        let Some(inverse) = factors::inverse(with(1.0).as_ref()) else {
            continue;
        };
        let x = &inverse * Mat::from_fn(n_u, 1, |i, _| b[i]);
        let s: f64 = (0..n_u).map(|i| b[i] * x[(i, 0)]).sum();
        // c + s is next to nothing, so that Y = [−A⁻¹b; 1]·t is large, t = −1/(c + s)
        let c = -s * (1.0 + 1e-6);
        if !(c > 0.1 && c < 1e3 && x[(1, 0)].abs() > 1e-3) {
            continue;
        }
        let found = |g: f64| {
            let (blocks, c) = with_one_traction(&with(g), &b, c, 0.0);
            discs(&Pencil::new(&blocks, &c)).map(|discs| discs[0])
        };
        let Ok(sound) = found(1.0) else { continue };
        for share in [0.9, 0.999, 1.001, 1.05, 1.3] {
            // g Y overflows from 1 on
            let g = share * f64::MAX / (x[(1, 0)] / (c + s)).abs();
            match found(g) {
                Ok(disc) => {
                    let distance = (disc.center.re - sound.center.re).abs();
                    assert!(
                        distance <= 1.01 * (disc.radius + sound.radius),
                        "{seed} {share}: {disc:?} and {sound:?}"
                    );
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > 25, "{refused}");
}

#[test]
fn nothing_is_proved_of_what_is_no_number_or_infinite() {
    let sound = [[2.0, 0.5], [0.5, 2.0]];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.7e308] {
        for place in 0..5 {
            let a = Mat::from_fn(2, 2, |i, j| match (place, i, j) {
                (0, 0, 0) | (1, 1, 1) | (2, 0, 1) | (2, 1, 0) => bad,
                _ => sound[i][j],
            });
            let b = [1.0, if place == 3 { bad } else { 1.0 }];
            let (blocks, c) = with_one_traction(&a, &b, 1.0, if place == 4 { bad } else { 0.5 });
            let pencil = Pencil::new(&blocks, &c);
            assert!(
                bad.is_finite() || discs(&pencil).is_err(),
                "{bad} at {place}"
            );
            let Some(route) = pencil.is_symmetric().then(|| pencil.route()).flatten() else {
                continue;
            };
            for sigma in [
                f64::NAN,
                f64::INFINITY,
                f64::NEG_INFINITY,
                -1e3,
                0.9,
                2.0,
                1e3,
            ] {
                let proved = [
                    pencil.none_below(sigma),
                    pencil.one_below(sigma),
                    pencil.none_above(sigma, route),
                    pencil.one_above(sigma, route),
                ];
                let may = bad.is_finite() && sigma.is_finite();
                assert!(
                    may || proved == [false; 4],
                    "{bad} at {place}, {sigma}: {proved:?}"
                );
            }
        }
    }
}
