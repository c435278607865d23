//! What a preconditioner makes of the contact rows of a face in its state.

use super::jacobian::FaceTangent;

pub(super) type Matrix3 = fracas_operators::small::Matrix3<f64>;

/// Share of a jump row below which it counts as a law for its own traction. Unit: 1.
const NO_JUMP: f64 = 1e-3;

/// C of a direction with a law of its own, over the C of a jump: it adds nothing to S_u. Unit: 1.
const LAW: f64 = 1e8;

/// A face whose rows are `D jump − L t = x_t`, D and L diagonal in the directions n, a (across the slip) and m (along it) up
/// to the coupling of friction: directions with a jump are kept as rows `jump − C t = x/δ`, the others solved for their own
/// traction.
/// ```text
/// n            δ = 1     C = C_n                          closed
/// a            δ         C = C_a + λ_a/δ                  stick: δ = 1, λ = 0
/// a            δ         C = C⁰_a + λ_a/δ                 slip: C⁰ = C of H = 0 where H does not act
/// m            law       t_m = −x_m/λ_m − (L_mn/λ_m) t_n  slip
/// n, t1, t2    law       t = −x/λ                         open
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceRule {
    /// C of the kept directions, [`LAW`] times as much in the others: what S_u is built with.
    pub(super) c: Matrix3,
    /// C⁻¹ of the kept directions, 0 in the others.
    pub(super) g: Matrix3,
    /// `x_t ↦ x/δ` in the kept directions.
    pub(super) kept: Matrix3,
    /// `x_t ↦ −t` in the directions with a law.
    pub(super) law: Matrix3,
    /// `t_n ↦ −t_m` of friction.
    pub(super) friction: Matrix3,
}

impl FaceRule {
    /// From the tangent of a face, the block of C that its jumps get in stick, `inverse` of it, and `free`, what
    /// stands for it in directions with a law.
    pub(super) fn new(face: &FaceTangent, [c, inverse, free]: [&Matrix3; 3]) -> Self {
        if *face == FaceTangent::STICK {
            return Self {
                c: *c,
                g: *inverse,
                kept: face.by_jump,
                law: [[0.0; 3]; 3],
                friction: [[0.0; 3]; 3],
            };
        }
        let mut rule = Self {
            c: [[0.0; 3]; 3],
            g: [[0.0; 3]; 3],
            kept: [[0.0; 3]; 3],
            law: [[0.0; 3]; 3],
            friction: [[0.0; 3]; 3],
        };
        let l = &face.law;
        for e in directions(face) {
            let (delta, lambda) = (along(&face.by_jump, e), along(l, e));
            let jump = along(if lambda > 0.0 { free } else { c }, e);
            if delta > NO_JUMP {
                let c = jump + (lambda / delta).max(0.0);
                add(&mut rule.c, c, e, e);
                add(&mut rule.g, 1.0 / c, e, e);
                add(&mut rule.kept, 1.0 / delta, e, e);
            } else {
                add(&mut rule.c, LAW * jump, e, e);
                add(&mut rule.law, 1.0 / lambda, e, e);
                // e·L n, for e ≠ n
                let coupled = if e[0] == 0.0 {
                    e[1] * l[1][0] + e[2] * l[2][0]
                } else {
                    0.0
                };
                add(&mut rule.friction, coupled / lambda, e, [1.0, 0.0, 0.0]);
            }
        }
        rule
    }

    /// `E = Σ e eᵀ` over the kept directions, and what is added to `E C E`: `Σ λ/δ e eᵀ` there, the diagonal of C in the others.
    pub(super) fn projected(face: &FaceTangent, c: &Matrix3) -> (Matrix3, Matrix3) {
        if *face == FaceTangent::STICK {
            return (face.by_jump, face.law);
        }
        let (mut kept, mut extra) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for e in directions(face) {
            let (delta, lambda) = (along(&face.by_jump, e), along(&face.law, e));
            if delta > NO_JUMP {
                add(&mut kept, 1.0, e, e);
                add(&mut extra, (lambda / delta).max(0.0), e, e);
            } else {
                add(&mut extra, along(c, e), e, e);
            }
        }
        (kept, extra)
    }
}

/// n, a and m.
fn directions(face: &FaceTangent) -> [[f64; 3]; 3] {
    let d = &face.by_jump;
    // D_TT is δ a aᵀ in slip, I in stick: a is its first eigenvector
    let [p, q, r] = [d[1][1], 0.5 * (d[1][2] + d[2][1]), d[2][2]];
    let angle = 0.5 * (2.0 * q).atan2(p - r);
    let (sin, cos) = angle.sin_cos();
    [[1.0, 0.0, 0.0], [0.0, cos, sin], [0.0, -sin, cos]]
}

/// `eᵀ M e`.
fn along(m: &Matrix3, e: [f64; 3]) -> f64 {
    (0..3)
        .flat_map(|i| (0..3).map(move |j| (i, j)))
        .map(|(i, j)| e[i] * m[i][j] * e[j])
        .sum()
}

/// `M ← M + α u vᵀ`.
fn add(m: &mut Matrix3, alpha: f64, u: [f64; 3], v: [f64; 3]) {
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] += alpha * u[i] * v[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rule for a diagonal C, and half of it where H does not act.
    fn rule(face: &FaceTangent, c: [f64; 3]) -> FaceRule {
        let block = |d: [f64; 3]| -> Matrix3 {
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { d[i] } else { 0.0 }))
        };
        FaceRule::new(
            face,
            [
                &block(c),
                &block(c.map(|c| 1.0 / c)),
                &block(c.map(|c| 0.5 * c)),
            ],
        )
    }

    const I: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const NONE: Matrix3 = [[0.0; 3]; 3];

    fn close(a: Matrix3, b: Matrix3) {
        for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
            assert!((x - y).abs() < 1e-12 * (1.0 + y.abs()), "{a:?} {b:?}");
        }
    }

    #[test]
    fn stick_keeps_all_and_open_none() {
        let stick = rule(
            &FaceTangent {
                by_jump: I,
                law: NONE,
            },
            [2.0, 4.0, 4.0],
        );
        close(
            stick.g,
            [[0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.25]],
        );
        close(stick.kept, I);
        close(stick.law, NONE);
        let open = rule(
            &FaceTangent {
                by_jump: NONE,
                law: I.map(|row| row.map(|v| 3.0 * v)),
            },
            [2.0; 3],
        );
        close(open.g, NONE);
        close(open.law, I.map(|row| row.map(|v| v / 3.0)));
    }

    #[test]
    fn slip_keeps_the_direction_across_and_solves_the_one_along() {
        let (m, a) = ([0.0, 0.6, 0.8], [0.0, -0.8, 0.6]);
        let mut face = FaceTangent {
            by_jump: NONE,
            law: NONE,
        };
        // δ = 0.25, λ_a = 3 (1 − δ), λ_m = 3, tan φ = 0.5
        add(&mut face.by_jump, 1.0, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        add(&mut face.by_jump, 0.25, a, a);
        add(&mut face.law, 2.25, a, a);
        add(&mut face.law, 3.0, m, m);
        add(&mut face.law, 1.5, m, [1.0, 0.0, 0.0]);
        let found = rule(&face, [2.0; 3]);
        let mut g = NONE;
        add(&mut g, 0.5, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        add(&mut g, 1.0 / 10.0, a, a);
        close(found.g, g);
        let mut law = NONE;
        add(&mut law, 1.0 / 3.0, m, m);
        close(found.law, law);
        let mut friction = NONE;
        add(&mut friction, 0.5, m, [1.0, 0.0, 0.0]);
        close(found.friction, friction);
    }
}
