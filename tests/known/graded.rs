//! Grid lines that move apart.

/// Lines `start < x ≤ end` whose spacing grows from h by a quarter each.
pub(crate) fn growing(start: f64, mut h: f64, end: f64) -> Vec<f64> {
    let (mut x, mut lines) = (start, Vec::new());
    while x + 1.75 * h < end {
        x += h;
        lines.push(x);
        h *= 1.25;
    }
    lines.push(end);
    lines
}
