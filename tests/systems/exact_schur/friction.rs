//! What friction does to eigenvalues.

use super::{Case, Side, Without, in_short, largest, scenes, seeds, transposed};
use faer::{Mat, c64};
use fracas::contact::{ContactState, JumpStabilization};
use fracas::jacobian::{ContactPoint, ContactSystem};
use fracas_operators::laws::probe;
use fracas_solvers::eigen::dense;

/// Rounding in the blocks of M⁻¹𝒜, relative to the largest entry.
const ROUNDING: f64 = 1e-9;

/// Rounding of eigenvalues, which are not normal, relative to max(1, |λ|).
const OF_EIGENVALUES: f64 = 2e-5;

/// How far M⁻¹𝒜, or (𝒜M⁻¹)ᵀ on the other side, is from [I *; 0 Z_E], relative.
fn distance_from_form(case: &Case, side: Side) -> f64 {
    let [n_u, n_t] = case.sizes();
    let form = match side {
        Side::First => &case.m_inverse * case.system(side),
        Side::Second => transposed(&(case.system(side) * &case.m_inverse)),
    };
    let z = case.pencil(side);
    let difference = Mat::from_fn(n_u + n_t, n_u + n_t, |i, j| match (i < n_u, j < n_u) {
        (_, true) => form[(i, j)] - f64::from(u8::from(i == j)),
        (true, false) => 0.0,
        (false, false) => form[(i, j)] - z[(i - n_u, j - n_u)],
    });
    largest(&difference) / largest(&form).max(1.0)
}

/// Of the eigenvalues of M⁻¹𝒜: how far those of the pencil are from theirs, each taken once, and the others from 1.
fn distance_of_eigenvalues(case: &Case, side: Side) -> f64 {
    let product = &case.m_inverse * case.system(side);
    let mut left = dense::general_eigenvalues(product.as_ref()).unwrap();
    let mut farthest = 0.0f64;
    for value in dense::general_eigenvalues(case.pencil(side).as_ref()).unwrap() {
        let distance = |l: &c64| (l - value).norm();
        let nearest = (0..left.len())
            .min_by(|i, j| distance(&left[*i]).total_cmp(&distance(&left[*j])))
            .unwrap();
        let found = left.swap_remove(nearest);
        farthest = farthest.max((found - value).norm() / value.norm().max(1.0));
    }
    left.iter().fold(farthest, |m, l| m.max((l - 1.0).norm()))
}

/// How far eigenvalues are outside the interval of the symmetric part of (S + H, S + C) plus the field of values of what is left, in the
/// norm of S + C.
fn outside_of_field(case: &Case) -> f64 {
    let l = dense::cholesky(case.norm()).unwrap();
    let scaled = |k: &Mat<f64>| {
        let mut half = k.clone();
        dense::solve_lower(l.as_ref(), &mut half);
        let mut whole = transposed(&half);
        dense::solve_lower(l.as_ref(), &mut whole);
        transposed(&whole)
    };
    let even = |k: &Mat<f64>| (k + k.transpose()) * 0.5;
    let ends = |k: &Mat<f64>| {
        let values = dense::symmetric_eigenvalues(even(k).as_ref()).unwrap();
        [values[0], values[values.len() - 1]]
    };
    let z = scaled(&(case.norm() - &case.c + even(&case.h)));
    let moved = scaled(&(case.friction() + &case.h - even(&case.h)));
    let ([z_low, z_high], [low, high]) = (ends(&z), ends(&moved));
    let skew = dense::singular_values((&moved - even(&moved)).as_ref()).unwrap();
    let most = skew.iter().fold(0.0f64, |m, v| m.max(*v));
    let whole = &z + &moved;
    let values = dense::general_eigenvalues(whole.as_ref()).unwrap();
    let outside = values.iter().fold(0.0f64, |m, l| {
        let beyond = (z_low + low - l.re).max(l.re - z_high - high);
        m.max(beyond).max(l.im.abs() - most)
    });
    outside / largest(&whole).max(1.0)
}

#[test]
fn friction_moves_eigenvalues_by_its_term_of_the_pencil() {
    let (mut systems, mut worst, mut non_real) = (0, [0.0f64; 3], 0);
    for seed in seeds() {
        let case = Case::new(seed, true, Without::Nothing).unwrap();
        for side in [Side::First, Side::Second] {
            let found = [
                distance_from_form(&case, side),
                distance_of_eigenvalues(&case, side),
                outside_of_field(&case),
            ];
            let limits = [ROUNDING, OF_EIGENVALUES, ROUNDING];
            for (k, limit) in limits.into_iter().enumerate() {
                assert!(found[k] < limit, "{side:?}, seed {seed}: {found:?}");
                worst[k] = worst[k].max(found[k]);
            }
        }
        let values = dense::general_eigenvalues(case.pencil(Side::First).as_ref()).unwrap();
        non_real += usize::from(values.iter().any(|l| l.im.abs() > 1e-6));
        systems += 1;
    }
    println!(
        "{systems} systems with slip on either side, {non_real} with non-real eigenvalues; differences: form {:.1e}, eigenvalues {:.1e}, field {:.1e}",
        worst[0], worst[1], worst[2]
    );
    assert!(non_real > systems / 20);
}

#[test]
fn each_hypothesis_is_needed() {
    let (mut systems, mut other_s_u, mut other_b) = (0, 0, 0);
    for seed in seeds() {
        let case = Case::new(seed, true, Without::Exact).unwrap();
        let is_outside = |case: &Case, side| {
            distance_from_form(case, side) > ROUNDING
                && distance_of_eigenvalues(case, side) > OF_EIGENVALUES
        };
        other_s_u += usize::from(is_outside(&case, Side::First));
        // M of another B than that of the rows which friction leaves alone
        let exact = Case::new(seed, true, Without::Nothing).unwrap();
        let moved = Case {
            b: &exact.b + &exact.e,
            e: &exact.e * -1.0,
            ..exact
        };
        other_b += usize::from(is_outside(&moved, Side::First));
        systems += 1;
    }
    println!(
        "{systems} systems; violated with another S_u in {other_s_u}, with another B in {other_b}"
    );
    assert!(other_s_u > 9 * systems / 10 && other_b > 9 * systems / 10);
}

#[test]
fn slip_of_assembled_scenes_moves_eigenvalues_by_its_term() {
    use ContactState::{NewSlip, Open, Slip, Stick};
    let cycle = [Slip, Slip, Stick, Open, NewSlip, Slip, Stick];
    let (mut systems, mut worst) = (0, [0.0f64; 3]);
    for seed in scenes() {
        let body = super::scene(seed).build().unwrap();
        let stick = body.stick_system(Some(JumpStabilization::default()));
        let system =
            ContactSystem::new(stick, &body.forces().unwrap(), |f| body.friction_of(f)).unwrap();
        let (n_u, n_t) = (system.stick().n_u(), system.stick().n_t());
        let sized = |n: usize, seed, size: f64| -> Vec<f64> {
            probe::<f64>(n, seed).iter().map(|v| size * v).collect()
        };
        let (u, mut t) = (sized(n_u, 1, 1e-3), sized(n_t, 2, 1e6));
        t.iter_mut().step_by(3).for_each(|t_n| *t_n = -5e6 - *t_n);
        let (start_jump, start_t) = (sized(n_t, 3, 1e-4), sized(n_t, 4, 1e6));
        let point = ContactPoint {
            u: &u,
            t: &t,
            start_jump: &start_jump,
            start_t: &start_t,
        };
        let states: Vec<_> = (0..n_t / 3).map(|f| cycle[f % cycle.len()]).collect();
        let blocks = system.linearize(&states, &point).unwrap();
        assert!(blocks.b2.is_some());
        let case = Case::assembled(blocks).unwrap();
        let found = [
            distance_from_form(&case, Side::Second),
            distance_of_eigenvalues(&case, Side::Second),
            outside_of_field(&case),
        ];
        for k in 0..3 {
            worst[k] = worst[k].max(found[k]);
        }
        systems += 1;
    }
    println!(
        "{systems} assembled systems with slip; largest differences {}",
        in_short(&worst)
    );
    assert!(
        worst[0] < 1e-7 && worst[1] < 1e-3 && worst[2] < 1e-7,
        "{worst:?}"
    );
}
