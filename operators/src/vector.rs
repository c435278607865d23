//! Vector primitives: parallel, allocation-free, with the same bits for any number of threads.
//!
//! Every reduction splits its range at multiples of [`CHUNK`], in a binary tree that depends on the length alone, so
//! the order of additions never depends on which thread ran what.

use crate::Real;

/// Entries that one thread handles without splitting. Unit: entries; 64 KiB of `f64`, about two L1 caches, so that a
/// task costs far more than handing it over.
pub const CHUNK: usize = 8192;

/// Midpoint of `n` entries on a chunk boundary.
fn half(n: usize) -> usize {
    (n / CHUNK).div_ceil(2) * CHUNK
}

/// Sum of products in eight independent lanes (vectorised; fixed order).
#[inline]
fn dot_chunk<R: Real>(x: &[R], y: &[R]) -> R {
    let mut lanes = [R::zero(); 8];
    let (mut xs, mut ys) = (x.chunks_exact(8), y.chunks_exact(8));
    for (a, b) in (&mut xs).zip(&mut ys) {
        for l in 0..8 {
            lanes[l] += a[l] * b[l];
        }
    }
    let mut sum = R::zero();
    for (a, b) in xs.remainder().iter().zip(ys.remainder()) {
        sum += *a * *b;
    }
    for lane in lanes {
        sum += lane;
    }
    sum
}

/// `xᵀ y`.
pub fn dot<R: Real>(x: &[R], y: &[R]) -> R {
    assert_eq!(x.len(), y.len(), "dot of vectors of different lengths");
    if x.len() <= CHUNK {
        return dot_chunk(x, y);
    }
    let m = half(x.len());
    let (left, right) = rayon::join(|| dot(&x[..m], &y[..m]), || dot(&x[m..], &y[m..]));
    left + right
}

/// `‖x‖₂` (no scaling: entries beyond about 1e154 overflow to infinity, which callers treat as breakdown).
pub fn norm2<R: Real>(x: &[R]) -> R {
    dot(x, x).sqrt()
}

/// `max |x_i|`, or NaN if any entry is NaN.
pub fn norm_inf<R: Real>(x: &[R]) -> R {
    x.iter().fold(R::zero(), |m, v| {
        if v.is_nan() || m.is_nan() {
            R::nan()
        } else {
            m.max(v.abs())
        }
    })
}

/// `y ← y + α x`.
pub fn axpy<R: Real>(alpha: R, x: &[R], y: &mut [R]) {
    for_each_pair(x, y, &|a, b| *b += alpha * a);
}

/// `y ← x + β y`.
pub fn xpby<R: Real>(x: &[R], beta: R, y: &mut [R]) {
    for_each_pair(x, y, &|a, b| *b = a + beta * *b);
}

/// `y ← α x + β y`.
pub fn axpby<R: Real>(alpha: R, x: &[R], beta: R, y: &mut [R]) {
    for_each_pair(x, y, &|a, b| *b = alpha * a + beta * *b);
}

/// `y ← x`.
pub fn copy<R: Real>(x: &[R], y: &mut [R]) {
    for_each_pair(x, y, &|a, b| *b = a);
}

/// `x ← α x`.
pub fn scale<R: Real>(alpha: R, x: &mut [R]) {
    if x.len() <= CHUNK {
        x.iter_mut().for_each(|v| *v *= alpha);
        return;
    }
    let m = half(x.len());
    let (a, b) = x.split_at_mut(m);
    rayon::join(|| scale(alpha, a), || scale(alpha, b));
}

/// Applies `update` to every pair of entries, in parallel chunks.
fn for_each_pair<R: Real>(x: &[R], y: &mut [R], update: &(impl Fn(R, &mut R) + Sync)) {
    assert_eq!(x.len(), y.len(), "vector update with different lengths");
    if x.len() <= CHUNK {
        for (a, b) in x.iter().zip(y) {
            update(*a, b);
        }
        return;
    }
    let m = half(x.len());
    let (y0, y1) = y.split_at_mut(m);
    rayon::join(
        || for_each_pair(&x[..m], y0, update),
        || for_each_pair(&x[m..], y1, update),
    );
}

/// `y_i ← row(i)` added for every row, in parallel over contiguous ranges of rows of at least `grain` entries.
/// `rows(range_start, y_part)` must write only its own part, so the result does not depend on the number of threads.
pub fn for_row_ranges<R: Real>(
    start: usize,
    grain: usize,
    y: &mut [R],
    rows: &(impl Fn(usize, &mut [R]) + Sync),
) {
    if y.len() <= grain {
        rows(start, y);
        return;
    }
    let m = (y.len() / grain).div_ceil(2) * grain;
    let (y0, y1) = y.split_at_mut(m);
    rayon::join(
        || for_row_ranges(start, grain, y0, rows),
        || for_row_ranges(start + m, grain, y1, rows),
    );
}

/// Runs `task(i)` for every i of a range, in parallel, without allocating.
pub fn for_each_task(range: std::ops::Range<usize>, task: &(impl Fn(usize) + Sync)) {
    if range.len() <= 1 {
        range.for_each(task);
        return;
    }
    let middle = range.start + range.len() / 2;
    rayon::join(
        || for_each_task(range.start..middle, task),
        || for_each_task(middle..range.end, task),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|i| ((i * i) as f64).sin()).collect()
    }

    #[test]
    fn dot_has_the_same_bits_for_any_number_of_threads() {
        let (x, y) = (wave(100_003), wave(100_003));
        let bits: Vec<u64> = [1, 2, 3]
            .iter()
            .map(|&t| {
                rayon::ThreadPoolBuilder::new()
                    .num_threads(t)
                    .build()
                    .unwrap()
                    .install(|| dot(&x, &y))
                    .to_bits()
            })
            .collect();
        assert!(bits.iter().all(|b| *b == bits[0]));
        let naive: f64 = x.iter().zip(&y).map(|(a, b)| a * b).sum();
        assert!((dot(&x, &y) - naive).abs() < 1e-9);
    }

    #[test]
    fn updates_do_what_their_formula_says() {
        let x = wave(20_000);
        let mut y = vec![1.0; 20_000];
        axpy(2.0, &x, &mut y);
        xpby(&x, 3.0, &mut y);
        scale(0.5, &mut y);
        for (a, b) in x.iter().zip(&y) {
            let expected = 0.5 * (a + 3.0 * (1.0 + 2.0 * a));
            assert!((expected - b).abs() < 1e-14);
        }
        assert!(norm_inf(&[1.0, f64::NAN, 2.0]).is_nan());
        assert_eq!(norm_inf(&[1.0, -3.0, 2.0]), 3.0);
    }
}
