use super::*;
use crate::saddle::relaxation::polynomial_of_degree;

/// An interval; ends carry a rounding of about 1e-15, against which [`below_zero`] keeps a distance.
type Interval = (f64, f64);

fn plus(a: Interval, b: Interval) -> Interval {
    (a.0 + b.0, a.1 + b.1)
}

fn times(k: f64, a: Interval) -> Interval {
    let (p, q) = (k * a.0, k * a.1);
    (p.min(q), p.max(q))
}

fn product(a: Interval, b: Interval) -> Interval {
    let all = [a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1];
    let ends = all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, v| {
        (e.0.min(*v), e.1.max(*v))
    });
    (ends.0, ends.1)
}

fn square(a: Interval) -> Interval {
    let (p, q) = (a.0 * a.0, a.1 * a.1);
    let low = if a.0 <= 0.0 && a.1 >= 0.0 {
        0.0
    } else {
        p.min(q)
    };
    (low, p.max(q))
}

/// q, q², a, (q − a)² for all x of an interval, q by its value in the middle and its slope.
fn parts(coefficients: &[f64], x: Interval) -> [Interval; 4] {
    let middle = 0.5 * (x.0 + x.1);
    let value = 1.0 + middle * coefficients.iter().rev().fold(0.0, |v, c| c + middle * v);
    let terms = coefficients.iter().enumerate().rev();
    let slope = terms.fold((0.0, 0.0), |v, (k, c)| {
        let term = (k + 1) as f64 * c;
        plus(product(v, x), (term, term))
    });
    let change = product(slope, (x.0 - middle, x.1 - middle));
    let q = plus((value, value), change);
    let q_squared = square(q);
    let a = product(x, q_squared);
    [q, q_squared, a, square(plus(q, times(-1.0, a)))]
}

/// True where f < −1e-12 on all of [0, end], by bisection.
fn below_zero(f: &dyn Fn(Interval) -> f64, x: Interval, depth: usize) -> bool {
    let middle = 0.5 * (x.0 + x.1);
    f(x) < -1e-12
        || (depth > 0
            && below_zero(f, (x.0, middle), depth - 1)
            && below_zero(f, (middle, x.1), depth - 1))
}

/// Largest `(q−a)²(φ − s(ψ − Δ))` at λ = i√L.
fn margin([q, q_squared, a, n]: [Interval; 4], square: f64, s: f64, delta: f64) -> f64 {
    let mut sum = times(2.0 * square * (s - 1.0), q);
    sum = plus(sum, times(square * (1.0 - s), a));
    sum = plus(sum, times(s - 1.0, product(q_squared, a)));
    sum = plus(sum, times(-s, product(a, a)));
    plus(sum, times(s * delta, n)).1 - s * square
}

/// A multiplier that serves both ends of an interval of L, from sampled x; `None` where there is none.
fn multiplier(coefficients: &[f64], end: f64, delta: f64, squares: [f64; 2]) -> Option<f64> {
    let (mut low, mut high) = (0.0f64, 1.0f64);
    for k in 0..=2000 {
        let x = end * f64::from(k) / 2000.0;
        let q = parts(coefficients, (x, x))[0].0;
        let a = x * q * q;
        for square in squares {
            let f = -(2.0 * q - a) * square - q * q * a;
            let g = (1.0 - 2.0 * q + a) * square + a * a - q * q * a - delta * (q - a).powi(2);
            if g > 0.0 {
                low = low.max(f / g);
            } else if g < 0.0 {
                high = high.min(f / g);
            }
        }
    }
    (low < high).then_some(0.5 * (low + high))
}

/// No eigenvalue i√L, L > 0, for W of this degree and S_u ⪯ Δ S̃_u.
fn is_proved(degree: usize, delta: f64) -> bool {
    /// Where an expansion in L takes over.
    const LEAST: f64 = 1e-2;
    const GROWTH: f64 = 1.02;
    let (end, coefficients) = polynomial_of_degree(degree);
    // L ≤ LEAST, s = L/Δ: L·slope − q²a
    let small = |x: Interval| {
        let [q, q_squared, a, n] = parts(coefficients, x);
        let cubic = product(q_squared, a);
        let mut inner = plus((1.0, 1.0), plus(times(-2.0, q), a));
        inner = product(inner, (0.0, LEAST));
        inner = plus(inner, plus(product(a, a), times(-1.0, cubic)));
        inner = plus(inner, times(-delta, n));
        let slope = plus(times(-2.0, q), plus(a, times(-1.0 / delta, inner))).1;
        if slope < 0.0 {
            -1.0
        } else {
            LEAST * slope - cubic.0
        }
    };
    // L ≥ 1.01 Δ, s = 1: the margin falls with L
    let large = |x: Interval| margin(parts(coefficients, x), 1.01 * delta, 1.0, delta);
    let mut all = below_zero(&small, (0.0, end), 40) && below_zero(&large, (0.0, end), 40);
    let mut square = LEAST;
    while all && square < 1.01 * delta {
        let ends = [square, square * GROWTH];
        // linear in L: both ends are enough
        all = multiplier(coefficients, end, delta, ends).is_some_and(|s| {
            ends.iter().all(|&square| {
                let f = |x: Interval| margin(parts(coefficients, x), square, s, delta);
                below_zero(&f, (0.0, end), 40)
            })
        });
        square *= GROWTH;
    }
    all
}

#[test]
fn no_eigenvalue_crosses_the_imaginary_axis_below_the_limits() {
    let (end, coefficients) = polynomial_of_degree(1);
    let right_of_zero = |x: Interval| {
        let [q, _, a, _] = parts(coefficients, x);
        plus(times(-2.0, q), a).1
    };
    assert!(below_zero(&right_of_zero, (0.0, end), 40));
    for degree in 2..=4 {
        assert!(is_proved(degree, LIMITS[degree - 1]), "degree {degree}");
    }
}

#[test]
fn the_limits_are_no_smaller_than_they_have_to_be() {
    // where no multiplier is left, δ, Δ and x alone say nothing: 2.415, 1.714, 1.275
    for (degree, beyond) in [(2, 2.45), (3, 1.75), (4, 1.3)] {
        assert!(!is_proved(degree, beyond), "degree {degree}");
    }
}
