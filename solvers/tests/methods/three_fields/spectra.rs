//! Where eigenvalues lie.

use super::*;

/// Exact S_u and S_p and C = H: nothing but ones, whatever Q2 is; triangular forms too.
#[test]
fn with_exact_parts_and_c_equal_to_h_every_eigenvalue_is_one() {
    for seed in 0..30 {
        let derivative = if seed % 2 == 0 { 0.0 } else { 0.8 };
        let mut blocks = stick_with_flow(seed, Flow { derivative, ..FLOW });
        let h: Vec<f64> = (0..6).map(|k| 0.5 + 0.4 * signed(seed * 10 + k)).collect();
        let mut diagonal = Triplets::new((6, 6));
        (0..6).for_each(|k| diagonal.add_triplet(k, k, h[k]));
        blocks.h = Some(diagonal.to_csr());
        let flow = flow_of(&blocks);
        let parts = Parts::new(&blocks, h);
        let s_p = full(&flow.t) + parts.given(flow);
        for form in Form::ALL {
            let m = ThreeFieldsInverse::new(
                parts.racp(&blocks),
                csr(&flow.q1),
                Some(csr(&flow.q2)),
                DenseInverse::of(&s_p),
                form,
            );
            let found = spectrum(&m, &blocks).unwrap();
            // a triangular factor has Jordan blocks of two, which rounding splits by its root
            let tolerance = if form == Form::Full { 1e-7 } else { 1e-4 };
            assert_spectrum(&found, vec![1.0; 20], tolerance);
        }
    }
}

/// Smallest and largest eigenvalue of the pencil (x, y) of symmetric matrices, y positive definite.
fn pencil(x: &Mat<f64>, y: &Mat<f64>) -> (f64, f64) {
    let l = dense::cholesky(y.clone()).unwrap();
    let mut left = x.clone();
    dense::solve_lower(l.as_ref(), &mut left);
    let mut both = left.transpose().to_owned();
    dense::solve_lower(l.as_ref(), &mut both);
    dense::symmetrize(&mut both);
    let values = dense::symmetric_eigenvalues(both.as_ref()).unwrap();
    (values[0], values[values.len() - 1])
}

/// The theorem of [`ThreeFieldsInverse`], over a slice of the seeds, or 10,000 with `--ignored`.
fn eigenvalues_lie_in_the_product_of_two_intervals(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let size = 10f64.powf(4.0 * signed(seed));
        let rate = 10f64.powf(3.0 * signed(seed + 1_000_000));
        let blocks = stick_with_flow(
            seed,
            Flow {
                open: 1.0,
                size,
                rate,
                ..FLOW
            },
        );
        let flow = flow_of(&blocks);
        let c = (0..6).map(|k| 10f64.powf(signed(seed * 31 + k))).collect();
        let parts = Parts::new(&blocks, c);
        let t = full(&flow.t);
        // some M: the exact one times up to ten either way, or none
        let given = parts.given(flow);
        let share = |i: u64| 10f64.powf(signed(seed * 17 + i));
        let m = Mat::from_fn(2, 2, |i, j| match (i == j, seed % 5) {
            (true, 1..) => share(i as u64) * given[(i, i)],
            _ => 0.0,
        });
        let s_p = &t + &m;
        let inverse_of = ThreeFieldsInverse::new(
            parts.racp(&blocks),
            csr(&flow.q1),
            Some(csr(&flow.q2)),
            DenseInverse::of(&s_p),
            Form::Full,
        );
        let found = spectrum(&inverse_of, &blocks).unwrap();
        // δ_p, Δ_p of (T + S, T + M); all symmetric, as Q2 = −Q1ᵀ/Δt
        let mut with_given = &t + &given;
        dense::symmetrize(&mut with_given);
        let (delta, upper) = pencil(&with_given, &s_p);
        // γ, Γ of (S_t + H, S_t + C), S_t = Bᵀ (A + Q1 T⁻¹ Q1ᵀ/Δt)⁻¹ B
        let q1 = full(&flow.q1);
        let undrained = &parts.a + (&q1 * inverse(&t) * q1.transpose()) * faer::Scale(rate);
        let mut s_t = parts.b.transpose() * (inverse(&undrained) * &parts.b);
        dense::symmetrize(&mut s_t);
        let h = full(blocks.h.as_ref().unwrap());
        let (gamma, above) = pencil(&(&s_t + &h), &(&s_t + parts.diagonal()));
        let (low, high) = (
            delta.min(1.0) * gamma.min(1.0),
            upper.max(1.0) * above.max(1.0),
        );
        let slack = 1e-6 * high;
        for value in &found {
            assert!(
                value.im.abs() < slack && value.re > low - slack && value.re < high + slack,
                "seed {seed}: {value} outside [{low}, {high}]"
            );
        }
        let ones = found.iter().filter(|v| (v.re - 1.0).hypot(v.im) < 1e-5);
        assert!(ones.count() >= 12, "seed {seed}");
    }
}

#[test]
fn eigenvalues_of_symmetric_systems_lie_where_the_theorem_says() {
    eigenvalues_lie_in_the_product_of_two_intervals(0..400);
}

#[test]
#[ignore = "10,000 systems"]
fn eigenvalues_of_ten_thousand_symmetric_systems_lie_where_the_theorem_says() {
    eigenvalues_lie_in_the_product_of_two_intervals(0..10_000);
}

/// With derivatives of the conductivity in Q2 the interval does not hold: a counterexample is soon found.
#[test]
fn unsymmetric_derivatives_leave_the_interval() {
    let leaves = |seed: u64| {
        let flow = Flow {
            open: 1.0,
            size: 0.1,
            derivative: 3.0,
            ..FLOW
        };
        let blocks = stick_with_flow(seed, flow);
        let flow = flow_of(&blocks);
        let parts = Parts::new(&blocks, vec![1.0; 6]);
        let given = parts.given(flow);
        let m = Mat::from_fn(2, 2, |i, j| if i == j { given[(i, i)].abs() } else { 0.0 });
        let inverse_of = ThreeFieldsInverse::new(
            parts.racp(&blocks),
            csr(&flow.q1),
            Some(csr(&flow.q2)),
            DenseInverse::of(&(full(&flow.t) + m)),
            Form::Full,
        );
        let found = spectrum(&inverse_of, &blocks).unwrap();
        found.iter().any(|v| v.im.abs() > 1e-3 || v.re < 0.0)
    };
    assert!((0..50).any(leaves));
}
