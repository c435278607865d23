//! Polygons of blocks: what lies inside, where a line meets them, whether they make sense.

/// True for points inside a polygon.
pub(super) fn contains(polygon: &[[f64; 2]], x: [f64; 2]) -> bool {
    let mut inside = false;
    for (k, a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        if (a[1] > x[1]) != (b[1] > x[1]) {
            let crossing = a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            inside ^= x[0] < crossing;
        }
    }
    inside
}

/// Distances from (0, 0) along a tangent at which the line meets edges, or passes corners within `close` [m]; increasing.
pub(super) fn crossings(polygons: &[Vec<[f64; 2]>], t: [f64; 2], close: f64) -> Vec<f64> {
    let seen = |p: [f64; 2]| [p[0] * t[0] + p[1] * t[1], t[0] * p[1] - t[1] * p[0]];
    let mut all = Vec::new();
    for polygon in polygons {
        for (k, p) in polygon.iter().enumerate() {
            let [[s1, d1], [s2, d2]] = [*p, polygon[(k + 1) % polygon.len()]].map(seen);
            if d1.abs() <= close {
                all.push(s1);
            }
            if (d1 > 0.0) != (d2 > 0.0) {
                all.push(s1 + (s2 - s1) * d1 / (d1 - d2));
            }
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Two blocks of one reservoir on both sides of a fault through (0, 0): each so thick and so wide [m], that on the side of n lower by
/// the throw, their middles at heights ± throw/2.
pub fn displaced_blocks(dip: f64, thickness: f64, throw: f64, width: f64) -> Vec<Vec<[f64; 2]>> {
    let slope = dip.cos() / dip.sin();
    let fault = |z: f64| [z * slope, z];
    let [low, high] = [-0.5 * thickness, 0.5 * thickness];
    let up = 0.5 * throw;
    vec![
        vec![
            [-width, low + up],
            fault(low + up),
            fault(high + up),
            [-width, high + up],
        ],
        vec![
            fault(low - up),
            [width, low - up],
            [width, high - up],
            fault(high - up),
        ],
    ]
}
