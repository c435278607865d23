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
    /// Δσ_ij = C (g_ij − 2π δ_ij [x inside])        C = (1−2ν) α Δp/(2π (1−ν))
    /// g = −Σ_edges sym n ⊗ (n (atan(s2/d) − atan(s1/d)) − t ½ ln((d² + s2²)/(d² + s1²)))
    /// ```
    /// over edges from P1 to P2 with tangent t and outward normal n, `d = (x − P1)·n`, `s_k = (P_k − x)·t`; the trace of g is 2π
    /// inside and 0 outside. Polygons are counter-clockwise and do not overlap.
    pub fn stress_change(self, polygons: &[Vec<[f64; 2]>], x: [f64; 2]) -> [f64; 3] {
        use std::f64::consts::TAU;
        let mut g = [0.0; 3];
        for polygon in polygons {
            for (k, p1) in polygon.iter().enumerate() {
                let p2 = polygon[(k + 1) % polygon.len()];
                let along = [p2[0] - p1[0], p2[1] - p1[1]];
                let length = along[0].hypot(along[1]);
                let t = along.map(|v| v / length);
                let n = [t[1], -t[0]];
                let from = |p: [f64; 2]| (p[0] - x[0]) * t[0] + (p[1] - x[1]) * t[1];
                let (s1, s2) = (from(*p1), from(p2));
                let d = (x[0] - p1[0]) * n[0] + (x[1] - p1[1]) * n[1];
                let angle = (s2 / d).atan() - (s1 / d).atan();
                let log = 0.5 * ((d * d + s2 * s2) / (d * d + s1 * s1)).ln();
                let v = [n[0] * angle - t[0] * log, n[1] * angle - t[1] * log];
                g[0] -= n[0] * v[0];
                g[1] -= n[1] * v[1];
                g[2] -= 0.5 * (n[0] * v[1] + n[1] * v[0]);
            }
        }
        // 2π inside, 0 outside, up to rounding
        let inside = if g[0] + g[1] > 0.5 * TAU { TAU } else { 0.0 };
        let c = (1.0 - 2.0 * self.poisson) * self.biot * self.pressure_change
            / (TAU * (1.0 - self.poisson));
        [c * (g[0] - inside), c * (g[1] - inside), c * g[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
