//! Claims: enclosures hold eigenvalues that are known exactly, also of clustered and badly conditioned systems, and an end that is moved into
//! the spectrum is never proved.

use super::discs::discs;
use super::pencil::Pencil;
use super::*;
use crate::Named;
use crate::Silent;
use crate::direct::{DirectChoice, DirectSolver};
use crate::eigen::{dense, factors};
use crate::saddle::{AugmentationChoice, AugmentationRule};
use crate::spectrum::analyse;
use faer::Mat;
use fracas_operators::random::Random;
use fracas_operators::sparse::{SparseMatrix, Triplets};

fn sparse(m: &Mat<f64>) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((m.nrows(), m.ncols()));
    for i in 0..m.nrows() {
        (0..m.ncols()).for_each(|j| triplets.add_triplet(i, j, m[(i, j)]));
    }
    triplets.to_csr()
}

/// Hadamard's matrix, `H Hᵀ = n I`: with a power of two as n, products with whole numbers round nothing.
fn hadamard(n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| match (i & j).count_ones() % 2 {
        0 => 1.0,
        _ => -1.0,
    })
}

/// How the pieces of a case are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Plain,
    /// Eigenvalues that agree, or all but.
    Clustered,
    /// Stiffness and compliance over many powers of two.
    Stretched,
    /// A with a kernel.
    Singular,
    /// B2 is not B1ᵀ.
    Unsymmetric,
}

/// `[a b₁; b₂ −h]` and `[a b₁; b₁ −c]` side by side, in a basis that hides them: λ = (a h + b₁b₂)/(a c + b₁²), and 1.
struct Case {
    blocks: SaddleBlocks,
    c: AugmentationMatrix,
    /// The n_t eigenvalues beside 1.
    values: Vec<f64>,
}

impl Case {
    fn new(seed: u64, kind: Kind) -> Self {
        let dice = &mut Random::new(seed);
        let n_t = 1 << dice.below(4);
        let n_u = n_t << dice.below(3);
        let whole = |dice: &mut Random, low: u32, high: u32| f64::from(dice.whole(low, high));
        let (mut a, mut c, mut h) = (vec![0.0; n_u], vec![0.0; n_t], vec![0.0; n_t]);
        let (mut b1, mut b2) = (vec![0.0; n_t], vec![0.0; n_t]);
        for i in 0..n_u {
            a[i] = whole(dice, 1, 9);
        }
        for k in 0..n_t {
            (c[k], h[k], b1[k]) = (whole(dice, 1, 9), whole(dice, 0, 9), whole(dice, 1, 5));
            b2[k] = b1[k];
            match kind {
                Kind::Plain => {}
                Kind::Clustered => {
                    // the last digits of h tell them apart, or nothing does
                    (a[k], b1[k], b2[k], c[k]) = (2.0, 3.0, 3.0, 8.0);
                    h[k] = 4.0 + whole(dice, 0, 1) * (-30.0_f64).exp2();
                }
                Kind::Stretched => {
                    a[k] *= (-whole(dice, 0, 16)).exp2();
                    (c[k], h[k]) = (c[k] * 0.25, h[k] * 0.0625);
                }
                Kind::Singular => {
                    if dice.once_in(3) {
                        a[k] = 0.0;
                    }
                }
                Kind::Unsymmetric => b2[k] = whole(dice, 0, 9),
            }
        }
        let values = (0..n_t)
            .map(|k| (a[k] * h[k] + b1[k] * b2[k]) / (a[k] * c[k] + b1[k] * b1[k]))
            .collect();
        let (p, q) = (hadamard(n_u), hadamard(n_t));
        let diagonal = |d: &[f64], p: &Mat<f64>| {
            let n = d.len();
            let scaled = Mat::from_fn(n, n, |i, j| p[(i, j)] * d[j] / n as f64);
            &scaled * p.transpose()
        };
        let coupling = |b: &[f64]| {
            let scaled = Mat::from_fn(n_u, n_t, |i, k| p[(i, k)] * b[k] / n_t as f64);
            &scaled * q.transpose()
        };
        let a = diagonal(&a, &p);
        let b1 = coupling(&b1);
        let b2 = coupling(&b2);
        // B = P diag(b) Qᵀ/n_t, and with P = √n_u U, Q = √n_t V: b √(n_u/n_t); C and H take the square
        let ratio = (n_u / n_t) as f64;
        let times = |m: Mat<f64>| m * ratio;
        Self {
            blocks: SaddleBlocks {
                a: sparse(&a),
                b1: sparse(&b1),
                b2: (kind == Kind::Unsymmetric).then(|| sparse(&b2.transpose().to_owned())),
                h: Some(sparse(&times(diagonal(&h, &q)))),
                rhs_u: vec![0.0; n_u],
                rhs_t: vec![0.0; n_t],
                coordinates: None,
                flow: None,
            },
            c: AugmentationMatrix::from_dense(times(diagonal(&c, &q))).unwrap(),
            values,
        }
    }

    fn ends(&self) -> (f64, f64) {
        let all = self.values.iter().chain([&1.0]);
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        all.fold(none, |(a, b), v| (a.min(*v), b.max(*v)))
    }
}

/// One rounding of the quotient that is known.
const LAST: f64 = 4.0 * f64::EPSILON;

const KINDS: [Kind; 5] = [
    Kind::Plain,
    Kind::Clustered,
    Kind::Stretched,
    Kind::Singular,
    Kind::Unsymmetric,
];

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

/// C of the case that is asked about.
#[derive(Debug)]
struct Given(std::sync::Mutex<Option<AugmentationMatrix>>);

static GIVEN: Given = Given(std::sync::Mutex::new(None));

impl Named for Given {
    fn name(&self) -> &'static str {
        "given_by_the_certified_case"
    }
}

impl AugmentationRule for Given {
    fn is_local(&self) -> bool {
        false
    }

    fn compute(
        &self,
        _: &SaddleBlocks,
        _: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError> {
        Ok(self.0.lock().unwrap().clone().unwrap())
    }
}

#[test]
fn a_report_is_certified_where_it_is_true_and_says_why_where_it_is_not() {
    AugmentationChoice::register(&GIVEN).unwrap();
    let (mut certified, mut all) = (0, 0);
    for kind in KINDS {
        for seed in 100..130 {
            let case = Case::new(seed, kind);
            *GIVEN.0.lock().unwrap() = Some(case.c.clone());
            let request = SpectrumRequest {
                augmentation: "given_by_the_certified_case".parse().unwrap(),
                inner: InnerChoice::Exact {
                    backend: DirectChoice::Faer,
                },
                conditions: false,
                certify: true,
                ..SpectrumRequest::default()
            };
            // S_u may be singular to rounding, which factorizations refuse
            let Ok(report) = analyse(&case.blocks, &request, &mut Silent) else {
                continue;
            };
            all += 1;
            let enclosures = report.enclosures.unwrap();
            assert_eq!(report.certified, enclosures.is_complete());
            assert!(report.certified || enclosures.reason.is_some());
            certified += usize::from(report.certified);
            let (low, high) = case.ends();
            for (end, found) in [(low, enclosures.real_min), (high, enclosures.real_max)] {
                let Some((a, b)) = found else { continue };
                let room = LAST * end.abs();
                assert!(
                    a - room <= end && end <= b + room,
                    "{kind:?} {seed}: {end} in [{a}, {b}]"
                );
            }
        }
    }
    assert!(
        all > 100 && 10 * certified > 9 * all,
        "{certified} of {all}"
    );
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

/// `𝒜 = [A b; bᵀ −h]` and c.
fn with_one_traction(
    a: &Mat<f64>,
    b: &[f64],
    c: f64,
    h: f64,
) -> (SaddleBlocks, AugmentationMatrix) {
    let n_u = a.nrows();
    let blocks = SaddleBlocks {
        a: sparse(a),
        b1: sparse(&Mat::from_fn(n_u, 1, |i, _| b[i])),
        b2: None,
        h: Some(sparse(&Mat::from_fn(1, 1, |_, _| h))),
        rhs_u: vec![0.0; n_u],
        rhs_t: vec![0.0],
        coordinates: None,
        flow: None,
    };
    (blocks, AugmentationMatrix::from_diagonal(vec![c]).unwrap())
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

#[test]
fn a_verdict_that_the_proof_contradicts_is_not_certified_nor_is_a_system_without_displacements() {
    let a = Mat::from_fn(2, 2, |i, j| [[2.0, 0.5], [0.5, 2.0]][i][j]);
    let (mut blocks, _) = with_one_traction(&a, &[1.0, 1.0], 1.0, 0.5);
    let request = SpectrumRequest {
        inner: InnerChoice::Exact {
            backend: DirectChoice::Faer,
        },
        conditions: false,
        relaxation: 0.0,
        certify: true,
        ..SpectrumRequest::default()
    };
    let solver = DirectChoice::Faer.solver().unwrap();
    let c = request
        .augmentation
        .compute(&blocks, solver.as_ref())
        .unwrap()
        .matrix;
    let mut report = analyse(&blocks, &request, &mut Silent).unwrap();
    assert!(report.certified && report.contained == Some(true));
    report.contained = Some(false);
    let found = enclosures(&blocks, &c, &report);
    assert_eq!(found.contained, Some(true));
    assert!(!found.is_complete() && found.reason.is_some());
    // λ = h/c alone, and not 1
    (blocks.a, blocks.b1) = (sparse(&Mat::zeros(0, 0)), sparse(&Mat::zeros(0, 1)));
    assert_eq!(enclosures(&blocks, &c, &report).real_max, None);
}
