//! Straight cracks that cross, open, close and slide.

use super::Rock;

/// Sweeps that the jumps may take: some thousands do for 80 elements. Unit: 1.
const SWEEPS: usize = 50_000;

/// Change of the jumps in a sweep, relative to the largest, that ends it. Unit: 1.
const SETTLED: f64 = 1e-9;

/// One crack of a [`CrackNetwork`], in the plane (x, z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightCrack {
    /// Its ends [m]; the tangent t goes from the first to the second, the normal n = (−t_z, t_x) lies to the left of it.
    pub ends: [[f64; 2]; 2],
    /// Friction coefficient tan φ; there is no cohesion [1].
    pub friction: f64,
    /// Pressure of the fluid inside [Pa].
    pub pressure: f64,
}

/// Cracks in a full space in plane strain under a uniform stress, cut into elements of constant jump: an element is a pair of
/// edge dislocations of opposite sign at its ends.
/// ```text
/// t_i = σ n_i + Σ_j K_ij g_j        g = (g_n, g_s), t = (t_n, t_s)
/// g_n ≥ 0,  t_n + p ≤ 0,  g_n (t_n + p) = 0,    |t_s| ≤ −(t_n + p) tan φ, g_s ≠ 0 only at the limit
/// ```
/// Elements of a crack of length 2a end at `s_k = −a cos((k−½)π/n)`, k = 1…n, and are solved at `−a cos(kπ/n)`: Gauss–Chebyshev
/// quadrature, exact for a uniform load but for the factor `(π/2n)/sin(π/2n)` of the jumps. Cracks may cross in their middles,
/// where elements end.
///
/// # Source
/// F. Erdogan, G. D. Gupta, *On the numerical solution of singular integral equations*, Q. Appl. Math. 29 (1972) 525–534.
/// Edge dislocations: J. P. Hirth, J. Lothe, *Theory of Dislocations* (1982), §3.4; S. L. Crouch, *Solution of plane
/// elasticity problems by the displacement discontinuity method*, Int. J. Numer. Meth. Engng 10 (1976) 301–343.
#[derive(Clone, Debug, PartialEq)]
pub struct CrackNetwork {
    /// The rock.
    pub rock: Rock,
    /// Stress without cracks (xx, zz, xz), tension positive [Pa].
    pub stress: [f64; 3],
    /// The cracks.
    pub cracks: Vec<StraightCrack>,
    /// Elements per crack, an even number.
    pub elements: usize,
}

/// What a crack of a network shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkCrack {
    /// Ends of the elements, distances from the middle of the crack [m].
    pub ends: Vec<f64>,
    /// Opening and slip `u(left) − u(right)` along (n, t) per element [m].
    pub jump: Vec<[f64; 2]>,
    /// Contact traction (t_n + p, t_s) where the elements are solved [Pa].
    pub traction: Vec<[f64; 2]>,
}

/// Share of a stretch that elements cover where they reach its ends but for rounding. Unit: 1.
const COVERED: f64 = 0.99;

impl NetworkCrack {
    /// Mean opening and slip between two distances from the middle [m].
    pub fn mean_jump(&self, from: f64, to: f64) -> [f64; 2] {
        let (sum, _) = self.integral(&self.jump, [from, to]);
        sum.map(|s| s / (to - from))
    }

    /// Mean traction between two distances from the middle [Pa]; `None` where elements do not reach.
    pub fn mean_traction(&self, from: f64, to: f64) -> Option<[f64; 2]> {
        let (sum, length) = self.integral(&self.traction, [from, to]);
        (length > COVERED * (to - from)).then(|| sum.map(|s| s / length))
    }

    /// The integral over the elements between two distances from the middle, and the length of these.
    fn integral(&self, values: &[[f64; 2]], [from, to]: [f64; 2]) -> ([f64; 2], f64) {
        let (mut sum, mut length) = ([0.0; 2], 0.0);
        for (end, value) in self.ends.windows(2).zip(values) {
            let common = (end[1].min(to) - end[0].max(from)).max(0.0);
            length += common;
            sum = [0, 1].map(|k: usize| sum[k] + common * value[k]);
        }
        (sum, length)
    }
}

/// A piece of a crack.
struct Element {
    ends: [[f64; 2]; 2],
    /// Where it is solved.
    at: [f64; 2],
    t: [f64; 2],
    friction: f64,
    /// Contact traction without jumps.
    traction: [f64; 2],
}

impl Element {
    fn normal(&self) -> [f64; 2] {
        [-self.t[1], self.t[0]]
    }

    /// (t_n, t_s) of a stress.
    fn resolve(&self, [xx, zz, xz]: [f64; 3]) -> [f64; 2] {
        let (t, n) = (self.t, self.normal());
        let on = [xx * n[0] + xz * n[1], xz * n[0] + zz * n[1]];
        [on[0] * n[0] + on[1] * n[1], on[0] * t[0] + on[1] * t[1]]
    }
}

/// Stress (xx, zz, xz) at x from an edge dislocation of Burgers vector b at the origin, over G/(2π(1−ν)).
fn edge_dislocation(b: [f64; 2], [x, z]: [f64; 2]) -> [f64; 3] {
    let (xx, zz) = (x * x, z * z);
    let r4 = (xx + zz) * (xx + zz);
    [
        (-b[0] * z * (3.0 * xx + zz) + b[1] * x * (xx - zz)) / r4,
        (b[0] * z * (xx - zz) + b[1] * x * (xx + 3.0 * zz)) / r4,
        (xx - zz) * (b[0] * x + b[1] * z) / r4,
    ]
}

impl CrackNetwork {
    /// `−a cos((k + ½)π/n)` for a crack of length 2a, n = elements + 1: ends of elements at integer k, their points half-way.
    fn place(&self, a: f64, k: f64) -> f64 {
        let n = (self.elements + 1) as f64;
        // sin of the angle from the middle: 0 there without rounding
        a * (std::f64::consts::PI * (k - 0.5 * self.elements as f64) / n).sin()
    }

    /// Ends of the elements of a crack of length 2a, from its middle.
    fn places(&self, a: f64) -> Vec<f64> {
        (0..=self.elements)
            .map(|k| self.place(a, k as f64))
            .collect()
    }

    fn cut(&self, crack: &StraightCrack) -> Vec<Element> {
        let [from, to] = crack.ends;
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        let t = along.map(|v| v / length);
        let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
        let point = |s: f64| [middle[0] + s * t[0], middle[1] + s * t[1]];
        let place = |k: f64| point(self.place(0.5 * length, k));
        let element = |k: usize| {
            let k = k as f64;
            let mut element = Element {
                ends: [place(k), place(k + 1.0)],
                at: place(k + 0.5),
                t,
                friction: crack.friction,
                traction: [0.0; 2],
            };
            element.traction = element.resolve(self.stress);
            element.traction[0] += crack.pressure;
            element
        };
        (0..self.elements).map(element).collect()
    }

    /// `K_ij` in rows of two numbers per element, `kernel[2i + k][2j + l]` = ∂t_k/∂g_l [Pa/m].
    fn kernel(&self, elements: &[Element]) -> Vec<Vec<f64>> {
        let scale = self.rock.shear() / (2.0 * std::f64::consts::PI * (1.0 - self.rock.poisson));
        let mut kernel = vec![vec![0.0; 2 * elements.len()]; 2 * elements.len()];
        for (i, on) in elements.iter().enumerate() {
            let x = on.at;
            for (j, of) in elements.iter().enumerate() {
                for (l, b) in [of.normal(), of.t].into_iter().enumerate() {
                    let from = |end: [f64; 2]| edge_dislocation(b, [x[0] - end[0], x[1] - end[1]]);
                    let (first, last) = (from(of.ends[0]), from(of.ends[1]));
                    let stress = [0, 1, 2].map(|k: usize| scale * (last[k] - first[k]));
                    let traction = on.resolve(stress);
                    kernel[2 * i][2 * j + l] = traction[0];
                    kernel[2 * i + 1][2 * j + l] = traction[1];
                }
            }
        }
        kernel
    }

    /// The state reached from no jump in one step, crack by crack.
    ///
    /// # Cost
    /// O(elements²) per sweep of Gauss–Seidel, each element solved for its contact.
    pub fn solve(&self) -> Vec<NetworkCrack> {
        assert!(
            self.elements > 0 && self.elements.is_multiple_of(2),
            "{} elements per crack: an even number",
            self.elements
        );
        let elements: Vec<Element> = self.cracks.iter().flat_map(|c| self.cut(c)).collect();
        let kernel = self.kernel(&elements);
        let mut jump = vec![0.0; 2 * elements.len()];
        let traction = |row: usize, jump: &[f64]| -> f64 {
            let released: f64 = kernel[row].iter().zip(jump).map(|(k, g)| k * g).sum();
            elements[row / 2].traction[row % 2] + released
        };
        let mut settled = false;
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for (i, element) in elements.iter().enumerate() {
                let (n, s) = (2 * i, 2 * i + 1);
                let own = -kernel[n][n];
                // tractions with no jump of its own, and what of them contact cannot carry
                let normal = traction(n, &jump) + own * jump[n];
                let opening = normal.max(0.0) / own;
                let limit = element.friction * (-normal).max(0.0);
                let shear = traction(s, &jump) + own * jump[s];
                let slip = (shear - shear.clamp(-limit, limit)) / own;
                change = change
                    .max((opening - jump[n]).abs())
                    .max((slip - jump[s]).abs());
                (jump[n], jump[s]) = (opening, slip);
                largest = largest.max(opening).max(slip.abs());
            }
            settled = change <= SETTLED * largest;
            if settled {
                break;
            }
        }
        assert!(settled, "jumps still change after {SWEEPS} sweeps");
        let crack = |(c, crack): (usize, &StraightCrack)| {
            let [from, to] = crack.ends;
            let rows = c * self.elements..(c + 1) * self.elements;
            NetworkCrack {
                ends: self.places(0.5 * (to[0] - from[0]).hypot(to[1] - from[1])),
                jump: rows
                    .clone()
                    .map(|i| [jump[2 * i], jump[2 * i + 1]])
                    .collect(),
                traction: rows
                    .map(|i| [2 * i, 2 * i + 1].map(|row| traction(row, &jump)))
                    .collect(),
            }
        };
        self.cracks.iter().enumerate().map(crack).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{InclinedCrack, LineCrack};
    use super::*;

    const ROCK: Rock = Rock {
        young: 25e9,
        poisson: 0.25,
    };

    /// A crack of 2 m through the origin, at an angle to z.
    fn at(angle_deg: f64, friction: f64, pressure: f64) -> StraightCrack {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        StraightCrack {
            ends: [[-sin, -cos], [sin, cos]],
            friction,
            pressure,
        }
    }

    fn network(stress: [f64; 3], cracks: Vec<StraightCrack>, elements: usize) -> Vec<NetworkCrack> {
        let network = CrackNetwork {
            rock: ROCK,
            stress,
            cracks,
            elements,
        };
        network.solve()
    }

    /// ∫ g ds.
    fn area(crack: &NetworkCrack) -> [f64; 2] {
        crack.mean_jump(-1.0, 1.0).map(|g| 2.0 * g)
    }

    #[test]
    fn one_crack_slides_as_its_closed_form() {
        let exact = InclinedCrack {
            rock: ROCK,
            compression: 100e6,
            inclination: 20f64.to_radians(),
            friction_angle: 30f64.to_radians(),
            cohesion: 0.0,
            half_length: 1.0,
        };
        let friction = 30f64.to_radians().tan();
        let found = network([0.0, -100e6, 0.0], vec![at(20.0, friction, 0.0)], 40);
        let peak = exact.peak_slip();
        for (ends, jump) in found[0].ends.windows(2).zip(&found[0].jump) {
            let mean = exact.mean_slip(ends[0], ends[1]);
            assert_eq!(jump[0], 0.0);
            // where the slope of the ellipse is infinite the value at a point is no mean
            let share = if ends[0].abs() < 0.9 { 1e-3 } else { 1e-2 };
            assert!((jump[1].abs() - mean).abs() < share * peak, "{ends:?}");
        }
        approx::assert_relative_eq!(
            area(&found[0])[1].abs(),
            exact.slip_area(),
            max_relative = 1e-6
        );
        for traction in &found[0].traction {
            approx::assert_relative_eq!(traction[0], exact.normal_traction(), max_relative = 1e-9);
        }
    }

    #[test]
    fn one_crack_opens_as_its_closed_form_wherever_it_points() {
        let exact = LineCrack {
            rock: ROCK,
            half_length: 1.0,
            pressure: 2e6,
        };
        for angle in [0.0, 37.0, 120.0] {
            // 3 MPa of fluid in a rock under 1 MPa
            let found = network([-1e6, -1e6, 0.0], vec![at(angle, 0.3, 3e6)], 40);
            let [volume, slip] = area(&found[0]);
            approx::assert_relative_eq!(volume, exact.volume(), max_relative = 1e-6);
            assert!(slip.abs() < 1e-9 * volume);
        }
    }

    #[test]
    fn a_cross_under_pressure_has_its_known_energy() {
        // K_I = k p √(πa), k = 0.8636 (D. P. Rooke, I. N. Sneddon, Int. J. Engng Sci. 7 (1969) 1079–1089), and
        // dU/da = 4 K_I² (1−ν²)/E with U = pV/2: V = 4π k² p a² (1−ν²)/E
        let cracks = vec![at(0.0, 0.0, 2e6), at(90.0, 0.0, 2e6)];
        let found = network([0.0; 3], cracks, 40);
        let [a, b] = [0, 1].map(|c: usize| area(&found[c])[0]);
        approx::assert_relative_eq!(a, b, max_relative = 1e-6);
        let unit = 4.0 * std::f64::consts::PI * 2e6 * ROCK.plane_strain_compliance();
        let k = ((a + b) / unit).sqrt();
        assert!((k - 0.8636).abs() < 1.5e-4, "{k}");
    }

    #[test]
    fn crossing_cracks_obey_contact_and_mirror_each_other() {
        for angle in [30.0, 45.0] {
            let cracks = vec![at(angle, 0.3, 0.0), at(-angle, 0.3, 0.0)];
            let found = network([0.0, -10e6, 0.0], cracks, 40);
            for crack in &found {
                for (g, t) in crack.jump.iter().zip(&crack.traction) {
                    assert!(
                        g[0] >= 0.0 && t[0] < 10.0 && g[0] * t[0] > -1e-3,
                        "{g:?} {t:?}"
                    );
                    let limit = -0.3 * t[0];
                    assert!(t[1].abs() < limit.max(0.0) + 10.0, "{t:?}");
                    assert!(g[1] == 0.0 || (t[1] - limit * g[1].signum()).abs() < 10.0);
                }
            }
            let [a, b] = [0, 1].map(|c: usize| area(&found[c])[1]);
            assert!((a + b).abs() < 1e-6 * a.abs() && a != 0.0, "{a} {b}");
        }
    }
}
