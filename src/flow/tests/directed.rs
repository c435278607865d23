//! Conductivities that depend on the direction: what is linear is exact, sources spread in ellipses.

use super::super::vertex::flat;
use super::leaning::{Skewed, affine, dot, driven, highest, is_exact};
use super::*;
use crate::mesh::{FractureFace, cross};

/// A fluid with one channel whose conductivity is c_d along a direction and c_e across it.
fn directed_fluid(along: [f64; 3], [c_d, c_e]: [f64; 2]) -> Fluid {
    let mut fluid = fluid(&[(c_d * c_e).sqrt()], Vec::new());
    fluid.channels[0].directed = Some(Directed {
        along,
        ratio: c_d / c_e,
    });
    fluid
}

/// d and e of a face.
fn axes(along: [f64; 3], face: &FractureFace) -> [[f64; 3]; 2] {
    let [n, ..] = face.frame;
    let off = dot(along, n);
    let d: [f64; 3] = std::array::from_fn(|i| along[i] - off * n[i]);
    let length = dot(d, d).sqrt();
    let d = d.map(|v| v / length);
    [d, cross(n, d)]
}

#[test]
fn linear_potentials_are_exact_in_any_direction() {
    let mut exact_ones = 0;
    for seed in 0..120 {
        let r = &mut Random::new(seed + 5100);
        let mut grid = grid([7, 6, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        // rectangles, parallelograms and general quadrilaterals
        let kind = r.whole(0, 2);
        if kind > 0 {
            grid.warps = vec![Box::new(Skewed {
                seed,
                amplitude: if kind == 1 { 0.0 } else { r.between(0.0, 0.2) },
                junction: None,
                map: affine(r, 3.0),
            })];
        }
        let built = grid.build().unwrap();
        let faces = &built.fractures.faces;
        let [_, t1, t2] = faces[0].frame;
        // along an axis of the rectangles, or not
        let turn: f64 = match r.chance(0.3) {
            true => 0.0,
            false => r.between(0.0, 3.0),
        };
        let (cos, sin) = (turn.cos(), turn.sin());
        let along = [0, 1, 2].map(|i| 4.0 * (cos * t1[i] + sin * t2[i]));
        let both = [r.scale(1e-16, 1e-10), r.scale(1e-16, 1e-10)];
        let [c_d, c_e] = both.map(|c| c.clamp(1e-14, 1e-12));
        let fluid = directed_fluid(along, [c_d, c_e]);
        let channel = fluid.channels[0];
        let all_exact = |face: &FractureFace| {
            let evened = channel.directed.unwrap().evened(face, &built.mesh);
            [evened, flat(face, &built.mesh)].into_iter().all(is_exact)
        };
        if !faces.iter().all(all_exact) {
            continue;
        }
        exact_ones += 1;
        let slope = [r.between(-1e6, 1e6), r.between(-1e6, 1e6)];
        let gradient = [0, 1, 2].map(|i| slope[0] * t1[i] + slope[1] * t2[i]);
        let potential = |x: [f64; 3]| 1e6 + dot(gradient, x);
        let viscosity = fluid.viscosity;
        let (found, q) = driven(&built, fluid, potential);
        let range = highest(faces, potential);
        for ((face, found), q) in faces.iter().zip(&found).zip(q.chunks_exact(3)) {
            assert!(
                (found - potential(face.center)).abs() < 1e-8 * range,
                "seed {seed}"
            );
            let [d, e] = axes(along, face);
            let (by_d, by_e) = (c_d * dot(d, gradient), c_e * dot(e, gradient));
            let size = by_d.hypot(by_e) / viscosity;
            for i in 0..3 {
                let expected = -(by_d * d[i] + by_e * e[i]) / viscosity;
                assert!(
                    (q[i] - expected).abs() < 1e-5 * size,
                    "seed {seed}: {q:?} {expected}"
                );
            }
        }
    }
    assert!(exact_ones >= 80, "{exact_ones} of 120");
}

/// `p ~ ln |K̂^{-½} x|` about a point beside the plane.
#[test]
fn flow_from_a_point_converges_to_ellipses() {
    for seed in 0..8 {
        let r = &mut Random::new(seed + 5200);
        let (turn, ratio) = (r.between(0.0, 3.0f64), r.scale(0.05, 20.0));
        let (cos, sin) = (turn.cos(), turn.sin());
        let potential = |x: [f64; 3]| {
            let (a, b) = (x[0] + 1.5, x[1] + 1.5);
            let root = f64::sqrt(f64::sqrt(ratio));
            1e6 * ((cos * a + sin * b) / root)
                .hypot((cos * b - sin * a) * root)
                .ln()
        };
        let error = |cells: usize| {
            let grid = grid([cells, cells, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
            let built = grid.build().unwrap();
            let fluid = directed_fluid([cos, sin, 0.0], [1e-13 * ratio, 1e-13]);
            let (found, _) = driven(&built, fluid, potential);
            let faces = built.fractures.faces.iter().zip(&found);
            let squares = faces.map(|(face, p)| face.area * (p - potential(face.center)).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let errors = [8, 16, 32].map(error);
        let order = (errors[0] / errors[2]).log2() / 2.0;
        assert!(
            order > 1.5,
            "seed {seed}, ratio {ratio}: {order} of {errors:?}"
        );
    }
}

/// Along the sides of rectangles two-point fluxes do, and equal conductivities are none that depend on the direction.
#[test]
fn what_needs_no_vertices_has_none() {
    let built = grid([7, 6, 4], vec![PlaneFracture::through("F", 2, 2.0)])
        .build()
        .unwrap();
    for (along, both, vertices) in [
        ([1.0, 0.0, 0.0], [1e-12, 1e-14], false),
        ([0.0, -2.0, 5.0], [1e-14, 1e-12], false),
        ([1.0, 1.0, 0.0], [1e-12, 1e-14], true),
        ([1.0, 1.0, 0.0], [1e-13, 1e-13], false),
    ] {
        let fluid = directed_fluid(along, both);
        let balance = balance(&fluid, &built);
        assert_eq!(
            balance.network.around().count() > 0,
            vertices,
            "{along:?} {both:?}"
        );
    }
}
