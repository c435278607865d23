//! Stress that a change of pore pressure in parts of a full space makes.

/// A uniform change of pore pressure in polygons of a homogeneous full space, plane strain.
///
/// # Source
/// J. D. Jansen, P. Singhal, F. C. Vossepoel, J. Geophys. Res. Solid Earth 124 (2019) 7193–7212: the closed form for displaced
/// reservoirs, here edge by edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depletion {
    /// Poisson's ratio ν [1].
    pub poisson: f64,
    /// Biot's coefficient α [1].
    pub biot: f64,
    /// Δp, negative where the pressure falls [Pa].
    pub pressure_change: f64,
}

impl Depletion {
    /// Change of total stress (xx, zz, xz), tension positive [Pa], at a point [m] on no edge:
    /// ```text
    /// Δσ_ij = C (g_ij − δ_ij tr g)        C = (1−2ν) α Δp/(2π (1−ν))
    /// g = −Σ_edges sym n ⊗ (n (atan(s2/d) − atan(s1/d)) − t ½ ln((d² + s2²)/(d² + s1²)))
    /// ```
    /// over edges from P1 to P2 with tangent t and outward normal n, `d = (x − P1)·n`, `s_k = (P_k − x)·t`; the trace of g is 2π
    /// inside and 0 outside. Polygons are counter-clockwise and do not overlap.
    pub fn stress_change(self, polygons: &[Vec<[f64; 2]>], x: [f64; 2]) -> [f64; 3] {
        self.summed(polygons, |p1, p2, t, n| {
            let from = |p: [f64; 2]| (p[0] - x[0]) * t[0] + (p[1] - x[1]) * t[1];
            let (s1, s2) = (from(p1), from(p2));
            let d = (x[0] - p1[0]) * n[0] + (x[1] - p1[1]) * n[1];
            let angle = (s2 / d).atan() - (s1 / d).atan();
            let log = 0.5 * ((d * d + s2 * s2) / (d * d + s1 * s1)).ln();
            [angle, log]
        })
    }

    /// Mean of [`Depletion::stress_change`] over a straight piece from A to B [m], on its right where it lies on an edge:
    /// ```text
    /// i angle − log = mean ln((z − P1)/(z − P2))        mean ln(z − P) = [ζ ln ζ − ζ]/h between ζ = (A − P)/T and (B − P)/T
    /// ```
    /// with the tangent T of the piece, its length h and the branch of the logarithm that is cut along the edge. It is finite where the
    /// piece meets a corner, at which stress grows like ln r.
    pub fn mean_stress_change(self, polygons: &[Vec<[f64; 2]>], piece: [[f64; 2]; 2]) -> [f64; 3] {
        use std::f64::consts::TAU;
        let [a, b] = piece;
        let h = (b[0] - a[0]).hypot(b[1] - a[1]);
        let tangent = [(b[0] - a[0]) / h, (b[1] - a[1]) / h];
        self.summed(polygons, |p1, p2, _, _| {
            let [c1, c2] = [p1, p2].map(|p| Corner::seen(p, a, tangent));
            let [[log1, angle1], [log2, angle2]] = [c1, c2].map(|c| c.mean_logarithm(h));
            // share of the piece before it crosses the edge, or its line between the corners
            let before = match c1.above == c2.above {
                true => 0.0,
                false => {
                    let at = -c1.x + (c1.x - c2.x) * c1.y / (c1.y - c2.y);
                    at.clamp(0.0, h) / h
                }
            };
            let turn = if c1.above { TAU } else { -TAU };
            [angle1 - angle2 - turn * before, log2 - log1]
        })
    }

    /// Sum over edges with these [angle, logarithm].
    fn summed(
        self,
        polygons: &[Vec<[f64; 2]>],
        seen: impl Fn([f64; 2], [f64; 2], [f64; 2], [f64; 2]) -> [f64; 2],
    ) -> [f64; 3] {
        let mut g = [0.0; 3];
        for polygon in polygons {
            for (k, p1) in polygon.iter().enumerate() {
                let p2 = polygon[(k + 1) % polygon.len()];
                let along = [p2[0] - p1[0], p2[1] - p1[1]];
                let length = along[0].hypot(along[1]);
                let t = along.map(|v| v / length);
                let n = [t[1], -t[0]];
                let [angle, log] = seen(*p1, p2, t, n);
                let v = [n[0] * angle - t[0] * log, n[1] * angle - t[1] * log];
                g[0] -= n[0] * v[0];
                g[1] -= n[1] * v[1];
                g[2] -= 0.5 * (n[0] * v[1] + n[1] * v[0]);
            }
        }
        let c = (1.0 - 2.0 * self.poisson) * self.biot * self.pressure_change
            / (std::f64::consts::TAU * (1.0 - self.poisson));
        [-c * g[1], -c * g[0], c * g[2]]
    }
}

/// A corner P seen from a straight piece: ζ = (A − P)/T = x + iy at its beginning.
#[derive(Clone, Copy, Debug)]
struct Corner {
    x: f64,
    y: f64,
    /// Im ζ > 0: the piece passes to the left of the corner.
    above: bool,
}

impl Corner {
    fn seen(p: [f64; 2], a: [f64; 2], tangent: [f64; 2]) -> Self {
        let from = [a[0] - p[0], a[1] - p[1]];
        let y = tangent[0] * from[1] - tangent[1] * from[0];
        Self {
            x: tangent[0] * from[0] + tangent[1] * from[1],
            // on its right: −0, of angle −π before the corner
            y: if y == 0.0 { -0.0 } else { y },
            above: y > 0.0,
        }
    }

    /// Real and imaginary part of mean ln ζ over a length h, from whichever end is further away, so that no digits are lost.
    fn mean_logarithm(self, h: f64) -> [f64; 2] {
        let Self { x, y, .. } = self;
        let far_first = x.abs() >= (x + h).abs();
        // mean = ln ζ_far − 1 + (ζ_near/±h) ln(ζ_near/ζ_far)
        let (far, near, h) = match far_first {
            true => (x, x + h, h),
            false => (x + h, x, -h),
        };
        let square = far * far + y * y;
        let rest = match near == 0.0 && y == 0.0 {
            true => [0.0; 2],
            false => {
                let grown = (2.0 * far + h) * h / square;
                let log = match grown < -0.5 {
                    true => 0.5 * ((near * near + y * y) / square).ln(),
                    false => 0.5 * grown.ln_1p(),
                };
                let angle = (-y * h).atan2(far * near + y * y);
                [(near * log - y * angle) / h, (near * angle + y * log) / h]
            }
        };
        [0.5 * square.ln() - 1.0 + rest[0], y.atan2(far) + rest[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::Random;

    const DEPLETION: Depletion = Depletion {
        poisson: 0.15,
        biot: 0.9,
        pressure_change: -20e6,
    };

    /// Two blocks on a fault that dips by 60°, displaced by 100 m.
    fn blocks() -> Vec<Vec<[f64; 2]>> {
        let slope = 1.0 / 60f64.to_radians().tan();
        let fault = |z: f64| [z * slope, z];
        vec![
            vec![[-5e3, -200.0], fault(-200.0), fault(100.0), [-5e3, 100.0]],
            vec![fault(-100.0), [5e3, -100.0], [5e3, 200.0], fault(200.0)],
        ]
    }

    fn at(x: [f64; 2]) -> [f64; 3] {
        DEPLETION.stress_change(&blocks(), x)
    }

    #[test]
    fn a_wide_reservoir_keeps_its_vertical_stress() {
        // Δσ_xx = −α (1−2ν)/(1−ν) Δp, Δσ_zz = 0
        let wide = vec![vec![[-1e6, -1.0], [1e6, -1.0], [1e6, 1.0], [-1e6, 1.0]]];
        let [xx, zz, xz] = DEPLETION.stress_change(&wide, [3.0, 0.2]);
        let expected = -0.9 * 0.7 / 0.85 * -20e6;
        assert!((xx - expected).abs() < 1e-5 * expected, "{xx} {expected}");
        assert!(zz.abs() < 1e-5 * expected && xz.abs() < 1e-5 * expected);
    }

    #[test]
    fn stresses_are_in_equilibrium_and_free_of_trace_outside() {
        for x in [
            [300.0, 400.0],
            [-700.0, -390.0],
            [150.0, 130.0],
            [90.0, -30.0],
            [-400.0, 20.0],
        ] {
            let h = 1e-2;
            let by = |k: usize| {
                let moved = |s: f64| {
                    let mut y = x;
                    y[k] += s;
                    at(y)
                };
                let (plus, minus) = (moved(h), moved(-h));
                [0, 1, 2].map(|i: usize| (plus[i] - minus[i]) / (2.0 * h))
            };
            let (dx, dz) = (by(0), by(1));
            let size = dx.iter().chain(&dz).fold(0.0f64, |m, v| m.max(v.abs()));
            assert!((dx[0] + dz[2]).abs() < 1e-6 * size, "{x:?}");
            assert!((dx[2] + dz[1]).abs() < 1e-6 * size, "{x:?}");
        }
        let [xx, zz, _] = at([300.0, 400.0]);
        assert!((xx + zz).abs() < 1e-9 * xx.abs());
    }

    #[test]
    fn tractions_pass_the_fault() {
        let (sin, cos) = 60f64.to_radians().sin_cos();
        let n = [sin, -cos];
        for z in [-150.0, 0.0, 60.0, 150.0] {
            let x = [z * cos / sin, z];
            let traction = |e: f64| {
                let [xx, zz, xz] = at([x[0] + e * n[0], x[1] + e * n[1]]);
                [xx * n[0] + xz * n[1], xz * n[0] + zz * n[1]]
            };
            let (plus, minus) = (traction(1e-6), traction(-1e-6));
            for k in 0..2 {
                assert!((plus[k] - minus[k]).abs() < 1.0, "{z} {plus:?} {minus:?}");
            }
        }
    }

    /// ∫ f over (0, 1), with singular ends: the tanh–sinh rule. f takes the distances from both ends.
    fn quadrature(mut f: impl FnMut(f64, f64) -> [f64; 3]) -> [f64; 3] {
        let (step, mut sum) = (1.0 / 32.0, [0.0; 3]);
        for k in -110..=110 {
            let t = step * f64::from(k);
            let u = std::f64::consts::FRAC_PI_2 * t.sinh();
            let weight = step * std::f64::consts::FRAC_PI_2 * t.cosh() / u.cosh().powi(2) / 2.0;
            let [left, right] = [u, -u].map(|u| 1.0 / (1.0 + (-2.0 * u).exp()));
            let value = f(left, right);
            for k in 0..3 {
                sum[k] += weight * value[k];
            }
        }
        sum
    }

    #[test]
    fn means_are_those_of_quadrature() {
        let mut crossed = 0;
        for seed in 0..400 {
            let r = &mut Random::new(seed);
            // a star around a random middle, every other one with two corners on the line of the piece
            let middle = [r.between(-80.0, 80.0), r.between(-40.0, 40.0)];
            let n = 3 + r.below(5);
            let mut star: Vec<[f64; 2]> = (0..n)
                .map(|k| {
                    let angle = (k as f64 + r.between(0.1, 0.9)) * std::f64::consts::TAU / n as f64;
                    let size = r.scale(5.0, 300.0);
                    [
                        middle[0] + size * angle.cos(),
                        middle[1] + size * angle.sin(),
                    ]
                })
                .collect();
            let [a, b] = [(); 2].map(|()| [r.between(-100.0, 100.0), r.between(-50.0, 50.0)]);
            let on = |share: f64| [0, 1].map(|k| a[k] + share * (b[k] - a[k]));
            if seed % 2 == 0 {
                (star[0], star[1]) = (on(r.between(-0.5, 0.9)), on(r.between(0.2, 1.5)));
            }
            let polygons = [star];
            let side = [b[1] - a[1], a[0] - b[0]];
            let t = [b[0] - a[0], b[1] - a[1]];
            let square = t[0] * t[0] + t[1] * t[1];
            let mut cuts = vec![0.0, 1.0];
            for (k, p) in polygons[0].iter().enumerate() {
                let q = polygons[0][(k + 1) % n];
                let seen = |p: [f64; 2]| {
                    let from = [p[0] - a[0], p[1] - a[1]];
                    [
                        (from[0] * t[0] + from[1] * t[1]) / square,
                        t[0] * from[1] - t[1] * from[0],
                    ]
                };
                let ([s1, d1], [s2, d2]) = (seen(*p), seen(q));
                let crossing = s1 + (s2 - s1) * d1 / (d1 - d2);
                let mut inner = vec![s1];
                if d1 * d2 < 0.0 {
                    inner.push(crossing);
                }
                cuts.extend(inner.iter().filter(|s| 0.0 < **s && **s < 1.0));
            }
            crossed += usize::from(cuts.len() > 2);
            cuts.sort_by(f64::total_cmp);
            let mut expected = [0.0; 3];
            for cut in cuts.windows(2) {
                let length = cut[1] - cut[0];
                let part = quadrature(|left, right| {
                    let s = match left < right {
                        true => cut[0] + length * left,
                        false => cut[1] - length * right,
                    };
                    let e = 1e-11;
                    let x = on(s);
                    DEPLETION.stress_change(&polygons, [x[0] + e * side[0], x[1] + e * side[1]])
                });
                for k in 0..3 {
                    expected[k] += length * part[k];
                }
            }
            let found = DEPLETION.mean_stress_change(&polygons, [a, b]);
            // tractions: along an edge that the piece lies on within rounding the third component has two sides
            let pull = |[xx, zz, xz]: [f64; 3]| {
                [xx * side[0] + xz * side[1], xz * side[0] + zz * side[1]]
                    .map(|v| v / square.sqrt())
            };
            let (found, expected) = (pull(found), pull(expected));
            for k in 0..2 {
                let error = (found[k] - expected[k]).abs();
                assert!(error < 1.0, "seed {seed}: {found:?} {expected:?}");
            }
        }
        assert!((100..400).contains(&crossed), "{crossed}");
    }
}
