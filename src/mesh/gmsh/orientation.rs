//! Which way the normal of a fracture points.

use super::GmshDefect;
use super::faces::mean;
use crate::mesh::face_geometry::{cross, dot, minus};

/// Sums below this share of Σ‖a_f‖ count as zero: rounding in coordinates of seven digits.
const ZERO: f64 = 1e-6;

/// A direction is along an axis if its component there is at least this share of its largest one. Away from the dips of
/// 30, 45, 60 and 90 deg, so that rounding does not decide.
const ALONG: f64 = 0.5;

/// Area vector of a quadrilateral: ½ (x₂ − x₀) × (x₃ − x₁) [m²].
fn area(x: &[[f64; 3]; 4]) -> [f64; 3] {
    cross(minus(x[2], x[0]), minus(x[3], x[1])).map(|v| 0.5 * v)
}

fn add(sum: &mut [f64; 3], v: [f64; 3], factor: f64) {
    for d in 0..3 {
        sum[d] += factor * v[d];
    }
}

/// Whether the first axis that a direction is along has a positive component.
fn is_positive(v: [f64; 3]) -> bool {
    let largest = v.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    let along = v.iter().find(|c| c.abs() >= ALONG * largest);
    along.is_some_and(|c| *c > 0.0)
}

/// For every face of a fracture whether its cycle of nodes has to be turned around, so that the normals agree across every
/// edge of exactly two faces, and every part that such edges join points as follows.
///
/// N = Σ a_f over a part: N is positive along the first of x, y, z along which it has at least half its largest component.
/// Where N = 0 (a closed surface), normals point outwards: Σ (x_f − x̄)·a_f > 0. Where that is zero, too, the face with the
/// lowest centre (in x, then y, then z) has a positive normal. No rule looks at the order in the file.
///
/// # Cost
/// O(n log n).
///
/// # Errors
/// [`GmshDefect::OneSided`] for a surface like a Möbius strip.
pub(super) fn turned(
    name: &str,
    quads: &[[u32; 4]],
    nodes: &[[f64; 3]],
) -> Result<Vec<bool>, GmshDefect> {
    let mut next: Vec<Vec<(usize, bool)>> = vec![Vec::new(); quads.len()];
    let mut edges: Vec<([u32; 2], usize, bool)> = Vec::with_capacity(4 * quads.len());
    for (f, quad) in quads.iter().enumerate() {
        for a in 0..4 {
            let [p, q] = [quad[a], quad[(a + 1) % 4]];
            edges.push(([p.min(q), p.max(q)], f, p < q));
        }
    }
    edges.sort_unstable();
    for users in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, f, along_f), (_, g, along_g)] = users {
            // cycles that agree run through their edge in opposite directions
            let differ = along_f == along_g;
            next[*f].push((*g, differ));
            next[*g].push((*f, differ));
        }
    }
    let corners = |f: usize| quads[f].map(|n| nodes[n as usize]);
    let mut turn: Vec<Option<bool>> = vec![None; quads.len()];
    for start in 0..quads.len() {
        if turn[start].is_some() {
            continue;
        }
        turn[start] = Some(false);
        let mut part = vec![(start, false)];
        let mut done = 0;
        while let Some((f, sign)) = part.get(done).copied() {
            done += 1;
            for (g, differ) in &next[f] {
                let wanted = sign ^ differ;
                match turn[*g] {
                    None => {
                        turn[*g] = Some(wanted);
                        part.push((*g, wanted));
                    }
                    Some(found) if found != wanted => {
                        return Err(GmshDefect::OneSided {
                            fracture: name.into(),
                            center: mean(&corners(*g)),
                        });
                    }
                    Some(_) => {}
                }
            }
        }
        if !points_right(&part, corners) {
            for (f, sign) in part {
                turn[f] = Some(!sign);
            }
        }
    }
    Ok(turn.into_iter().map(|t| t == Some(true)).collect())
}

/// Whether a part, turned as it says, follows the rule.
fn points_right(part: &[(usize, bool)], corners: impl Fn(usize) -> [[f64; 3]; 4]) -> bool {
    let sign = |turned: bool| if turned { -1.0 } else { 1.0 };
    let (mut sum, mut size) = ([0.0; 3], 0.0);
    let (mut middle, mut extent) = ([0.0; 3], [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]);
    for (f, turned) in part {
        let x = corners(*f);
        let a = area(&x);
        add(&mut sum, a, sign(*turned));
        size += dot(a, a).sqrt();
        let center = mean(&x);
        add(&mut middle, center, 1.0 / part.len() as f64);
        for d in 0..3 {
            extent[0][d] = extent[0][d].min(center[d]);
            extent[1][d] = extent[1][d].max(center[d]);
        }
    }
    if dot(sum, sum).sqrt() > ZERO * size {
        return is_positive(sum);
    }
    let outwards: f64 = part
        .iter()
        .map(|(f, turned)| {
            let x = corners(*f);
            sign(*turned) * dot(minus(mean(&x), middle), area(&x))
        })
        .sum();
    let across = minus(extent[1], extent[0]);
    if outwards.abs() > ZERO * size * dot(across, across).sqrt() {
        return outwards > 0.0;
    }
    let lowest = part.iter().min_by(|a, b| {
        let [x, y] = [mean(&corners(a.0)), mean(&corners(b.0))];
        let by_x = x[0].total_cmp(&y[0]);
        by_x.then(x[1].total_cmp(&y[1])).then(x[2].total_cmp(&y[2]))
    });
    lowest.is_some_and(|(f, turned)| is_positive(area(&corners(*f)).map(|v| sign(*turned) * v)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Outward faces of a cube [0, 1]³ in VTK numbering.
    const CUBE: [[f64; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
    ];

    fn reversed(quad: [u32; 4]) -> [u32; 4] {
        [quad[3], quad[2], quad[1], quad[0]]
    }

    #[test]
    fn a_closed_surface_points_outwards_whatever_the_order() {
        let quads = crate::mesh::FACES.map(|f| f.map(|n| n as u32));
        for flips in 0..64u32 {
            let given: Vec<[u32; 4]> = (0..6)
                .map(|f| match flips >> f & 1 {
                    1 => reversed(quads[f]),
                    _ => quads[f],
                })
                .collect();
            let turn = turned("F", &given, &CUBE).unwrap();
            for f in 0..6 {
                assert_eq!(turn[f], flips >> f & 1 == 1);
            }
        }
    }

    #[test]
    fn an_open_surface_points_along_the_first_axis_it_is_along() {
        // an L of the faces x = 1 and z = 1: N = (1, 0, 1)
        let quads = [[1, 2, 6, 5], [4, 5, 6, 7]];
        for given in [
            quads,
            [reversed(quads[0]), quads[1]],
            [reversed(quads[1]), quads[0]],
        ] {
            let turn = turned("F", &given, &CUBE).unwrap();
            let mut sum = [0.0; 3];
            for (quad, turn) in given.iter().zip(turn) {
                let a = area(&quad.map(|n| CUBE[n as usize]));
                add(&mut sum, a, if turn { -1.0 } else { 1.0 });
            }
            assert_eq!(sum, [1.0, 0.0, 1.0]);
        }
        assert!(is_positive([1e-3, 1.0, -0.2]) && !is_positive([1e-3, -1.0, 0.2]));
        assert!(is_positive([0.577, -1.0, 0.0]) && !is_positive([-1.0, 1.0, 0.0]));
    }

    #[test]
    fn a_strip_with_one_side_is_refused() {
        let count = 12u32;
        let mut nodes = Vec::new();
        for i in 0..count {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
            for side in [-0.5, 0.5] {
                let r = 2.0 + side * (0.5 * angle).cos();
                nodes.push([r * angle.cos(), r * angle.sin(), side * (0.5 * angle).sin()]);
            }
        }
        let strip = |twisted: bool| -> Vec<[u32; 4]> {
            (0..count)
                .map(|i| {
                    let [a, b] = [2 * i, 2 * i + 1];
                    let [c, d] = [(2 * i + 2) % (2 * count), (2 * i + 3) % (2 * count)];
                    match twisted && i == count - 1 {
                        true => [a, b, c, d],
                        false => [a, b, d, c],
                    }
                })
                .collect()
        };
        assert!(turned("F", &strip(false), &nodes).is_ok());
        let error = turned("F", &strip(true), &nodes).unwrap_err();
        assert!(matches!(error, GmshDefect::OneSided { .. }), "{error}");
    }
}
