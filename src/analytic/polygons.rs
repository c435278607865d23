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

/// Two edges of a polygon that cross or touch although they do not follow each other, or that do and fold back: numbers of their first
/// corners, from 0. An edge leads from its corner to the next.
pub fn meeting_edges(polygon: &[[f64; 2]]) -> Option<[usize; 2]> {
    let n = polygon.len();
    let edge = |k: usize| [polygon[k], polygon[(k + 1) % n]];
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| [i, j]));
    pairs.into_iter().find(|[i, j]| {
        let ([a, b], [c, d]) = (edge(*i), edge(*j));
        if j - i == 1 {
            return folds(a, b, d);
        }
        if j - i == n - 1 {
            return folds(c, a, b);
        }
        let apart = |p: f64, q: f64| p * q > 0.0;
        let is_crossed =
            !apart(turn(a, b, c), turn(a, b, d)) && !apart(turn(c, d, a), turn(c, d, b));
        // on one line all turns are 0
        is_crossed
            && (0..2).all(|k| a[k].max(b[k]) >= c[k].min(d[k]) && c[k].max(d[k]) >= a[k].min(b[k]))
    })
}

/// Twice the area of a triangle, positive counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// True where the way from a over b to c turns back on itself, or stands still.
fn folds(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    let forward: f64 = (0..2).map(|k| (b[k] - a[k]) * (c[k] - b[k])).sum();
    turn(a, b, c) == 0.0 && forward <= 0.0
}

/// Area that two polygons without meeting edges share [m²]: the sum over their triangles from a corner, each with its sign.
pub fn shared_area(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let fan = |polygon: &[[f64; 2]]| -> Vec<[[f64; 2]; 3]> {
        let corner = polygon[0];
        let edges = polygon[1..].windows(2);
        edges.map(|edge| [corner, edge[0], edge[1]]).collect()
    };
    let (first, second) = (fan(a), fan(b));
    let pairs = first
        .iter()
        .flat_map(|t| second.iter().map(move |u| (t, u)));
    pairs
        .map(|(t, u)| shared_by_triangles(*t, *u))
        .sum::<f64>()
        .abs()
}

/// Area of the part of a triangle within another, with the sign of both: clipped edge by edge.
fn shared_by_triangles(t: [[f64; 2]; 3], u: [[f64; 2]; 3]) -> f64 {
    let sign = turn(u[0], u[1], u[2]).signum();
    let mut part = t.to_vec();
    for k in 0..3 {
        let (a, b) = (u[k], u[(k + 1) % 3]);
        let depth = |p: [f64; 2]| sign * turn(a, b, p);
        let mut kept = Vec::with_capacity(part.len() + 1);
        for (i, p) in part.iter().enumerate() {
            let q = part[(i + 1) % part.len()];
            let (at_p, at_q) = (depth(*p), depth(q));
            if at_p >= 0.0 {
                kept.push(*p);
            }
            if (at_p >= 0.0) != (at_q >= 0.0) {
                let share = at_p / (at_p - at_q);
                kept.push([0, 1].map(|k| p[k] + share * (q[k] - p[k])));
            }
        }
        part = kept;
    }
    sign * signed_area(&part)
}

/// Area, positive counter-clockwise [m²].
pub fn signed_area(polygon: &[[f64; 2]]) -> f64 {
    let Some(corner) = polygon.first() else {
        return 0.0;
    };
    let edges = polygon.windows(2);
    edges
        .map(|edge| 0.5 * turn(*corner, edge[0], edge[1]))
        .sum()
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

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::Random;

    /// A star: no edges of it meet.
    fn star(r: &mut Random) -> Vec<[f64; 2]> {
        let n = 3 + r.below(6);
        let middle = [r.between(-100.0, 100.0), r.between(-50.0, 50.0)];
        let corner = |k: usize, r: &mut Random| {
            let angle = (k as f64 + r.between(0.1, 0.4)) * std::f64::consts::TAU / n as f64;
            let size = r.scale(10.0, 200.0);
            [
                middle[0] + size * angle.cos(),
                middle[1] + size * angle.sin(),
            ]
        };
        (0..n).map(|k| corner(k, r)).collect()
    }

    #[test]
    fn shared_areas_are_those_of_counted_points() {
        let mut apart = 0;
        for seed in 0..60 {
            let r = &mut Random::new(seed);
            let (a, mut b) = (star(r), star(r));
            if r.chance(0.3) {
                b.iter_mut().for_each(|p| p[0] += 700.0);
            }
            let [from, to] = [[-350.0, -300.0], [350.0, 300.0]];
            let n = 500;
            let at = |k: usize, d: usize| from[d] + (to[d] - from[d]) * (k as f64 + 0.5) / n as f64;
            let points = (0..n).flat_map(|i| (0..n).map(move |j| [at(i, 0), at(j, 1)]));
            let both = points
                .filter(|x| contains(&a, *x) && contains(&b, *x))
                .count();
            let counted = both as f64 * (700.0 / n as f64) * (600.0 / n as f64);
            let found = shared_area(&a, &b);
            assert!(
                (found - counted).abs() < 60.0 + 0.02 * counted,
                "{seed}: {found} {counted}"
            );
            apart += usize::from(found < 1e-9);
            let own = signed_area(&a);
            assert!(own > 0.0 && (shared_area(&a, &a) / own - 1.0).abs() < 1e-12);
        }
        assert!((10..50).contains(&apart), "{apart}");
    }

    #[test]
    fn parts_of_a_cut_polygon_share_nothing() {
        for seed in 0..60 {
            let r = &mut Random::new(seed);
            let whole = star(r);
            let middle =
                [0, 1].map(|k| whole.iter().map(|p| p[k]).sum::<f64>() / whole.len() as f64);
            if !contains(&whole, middle) {
                continue;
            }
            let parts: Vec<Vec<[f64; 2]>> = (0..whole.len())
                .map(|k| vec![middle, whole[k], whole[(k + 1) % whole.len()]])
                .collect();
            let visible = parts.iter().all(|p| signed_area(p) > 0.0);
            for (i, a) in parts.iter().enumerate().filter(|_| visible) {
                for b in &parts[i + 1..] {
                    assert!(shared_area(a, b) < 1e-9 * signed_area(&whole), "{seed}");
                }
            }
        }
    }

    #[test]
    fn edges_meet_where_two_corners_change_places() {
        let mut tried = 0;
        for seed in 0..200 {
            let r = &mut Random::new(seed);
            let mut polygon = star(r);
            assert_eq!(meeting_edges(&polygon), None, "{seed}");
            polygon.reverse();
            assert_eq!(meeting_edges(&polygon), None, "{seed}");
            let n = polygon.len();
            let k = r.below(n);
            // a corner moved to the middle of an edge that is not next to it; no bit of quarters of a metre is lost
            polygon
                .iter_mut()
                .flatten()
                .for_each(|v| *v = (4.0 * *v).round() / 4.0);
            let [a, b] = [polygon[(k + 2) % n], polygon[(k + 3) % n]];
            if n < 5 {
                continue;
            }
            tried += 1;
            polygon[k] = [0, 1].map(|d| 0.5 * (a[d] + b[d]));
            assert!(meeting_edges(&polygon).is_some(), "{seed}: {polygon:?}");
            polygon[k] = polygon[(k + 1) % n];
            assert!(meeting_edges(&polygon).is_some(), "{seed}: {polygon:?}");
        }
        assert!(tried > 80, "{tried}");
        let bow = [[0.0, -1.0], [5.0, 1.0], [5.0, -1.0], [0.0, 2.0]];
        assert_eq!(meeting_edges(&bow), Some([0, 2]));
    }
}
