//! Where points and lines lie on a fracture face.

use crate::mesh::{BuiltMesh, FractureFace, cross, dot, minus, unit};

/// Share of the radius of a face by which a point may lie beside it. Unit: 1.
const ON_FACE: f64 = 1e-6;

/// Sine of the angle between a line and a plane below which they are parallel. Unit: 1.
const PARALLEL: f64 = 1e-6;

/// How a line meets a face.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meeting {
    /// It goes through it here, if anywhere: a face that is not plane may be met twice [m].
    Through(Vec<[f64; 3]>),
    /// A part of it lies in the face.
    Along,
}

/// The outline of a face: four corners around its centre.
pub(super) struct Outline {
    center: [f64; 3],
    normal: [f64; 3],
    corners: [[f64; 3]; 4],
    /// Largest distance of a corner from the centre [m].
    radius: f64,
}

impl Outline {
    pub(super) fn new(face: &FractureFace, built: &BuiltMesh) -> Self {
        let corners = face.minus.nodes.map(|n| built.mesh.nodes[n as usize]);
        Self::of_corners(corners, face.center, face.frame[0])
    }

    fn of_corners(corners: [[f64; 3]; 4], center: [f64; 3], normal: [f64; 3]) -> Self {
        let sizes = corners.map(|x| minus(x, center)).map(|d| dot(d, d));
        Self {
            center,
            normal,
            corners,
            radius: sizes.into_iter().fold(0.0, f64::max).sqrt(),
        }
    }

    /// `√(a² + b²)` of the sides a and b, which are the mean of opposite ones where they differ [m].
    pub(super) fn diagonal(&self) -> f64 {
        let (sides, d) = self.edges();
        let [a, b] = sides.map(|side| [0, 1, 2].map(|i: usize| side[i] + 0.5 * d[i]));
        (dot(a, a) + dot(b, b)).sqrt()
    }

    /// a, b and d of `x(r, s) = x_0 + r a + s b + r s d`, 0 ≤ r, s ≤ 1 [m].
    fn edges(&self) -> ([[f64; 3]; 2], [f64; 3]) {
        let [a, c, b] = [1, 2, 3].map(|k: usize| minus(self.corners[k], self.corners[0]));
        ([a, b], minus(minus(c, a), b))
    }

    /// True where two points are the same beside the size of the face.
    pub(super) fn is_same(&self, a: [f64; 3], b: [f64; 3]) -> bool {
        let d = minus(a, b);
        dot(d, d).sqrt() <= ON_FACE * self.radius
    }

    /// True where a point lies on the face, or beside it by rounding.
    pub(super) fn holds(&self, point: [f64; 3]) -> bool {
        let inside = (0..4).all(|a| {
            let (inward, slack) = self.side(a);
            dot(inward, minus(point, self.corners[a])) >= -slack
        });
        inside && self.height(point).abs() <= self.thickness()
    }

    /// How the segment from a point along a vector meets the face.
    pub(super) fn meeting(&self, from: [f64; 3], along: [f64; 3]) -> Meeting {
        if self.is_warped() {
            return self.warped_meeting(from, along);
        }
        let at = |share: f64| -> [f64; 3] { std::array::from_fn(|i| from[i] + share * along[i]) };
        let crossing = dot(along, self.normal);
        if crossing.abs() > PARALLEL * dot(along, along).sqrt() {
            let share = -self.height(from) / crossing;
            let place = at(share);
            let is_here = (0.0..=1.0).contains(&share) && self.holds(place);
            return Meeting::Through(is_here.then_some(place).into_iter().collect());
        }
        // the part of it between the four sides
        let (mut first, mut last) = (0.0f64, 1.0f64);
        for a in 0..4 {
            let (inward, _) = self.side(a);
            let (here, grows) = (
                dot(inward, minus(from, self.corners[a])),
                dot(inward, along),
            );
            match grows {
                g if g > 0.0 => first = first.max(-here / g),
                g if g < 0.0 => last = last.min(-here / g),
                _ if here < 0.0 => return Meeting::Through(Vec::new()),
                _ => {}
            }
        }
        let beside = |share: f64| self.height(at(share)).abs() <= self.thickness();
        match first < last && beside(0.5 * (first + last)) {
            true => Meeting::Along,
            false => Meeting::Through(Vec::new()),
        }
    }

    /// The same of a face that is not plane: its points are `x(r, s) = x_0 + r a + s b + r s d`, so that faces with a common edge share it. Across
    /// the line, in two directions, `α + β r + γ s + δ r s = 0`; r eliminated leaves a quadratic equation for s.
    fn warped_meeting(&self, from: [f64; 3], along: [f64; 3]) -> Meeting {
        let ([a, b], d) = self.edges();
        let to = minus(self.corners[0], from);
        let squared = dot(along, along);
        let across = self.corners.map(|x| cross(along, minus(x, self.center)));
        let first = (across.into_iter()).max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)));
        let first = first.unwrap_or([0.0; 3]);
        let second = cross(along, first);
        let [[a1, b1, c1, d1], [a2, b2, c2, d2]] = [first, second]
            .map(unit)
            .map(|e| [to, a, b, d].map(|v| dot(e, v)));
        let [q0, q1, q2] = [
            a1 * b2 - a2 * b1,
            a1 * d2 - a2 * d1 + c1 * b2 - c2 * b1,
            c1 * d2 - c2 * d1,
        ];
        let at = |r: f64, s: f64| -> [f64; 3] {
            std::array::from_fn(|i| self.corners[0][i] + r * (a[i] + s * d[i]) + s * b[i])
        };
        let inside = |t: f64| (-ON_FACE..=1.0 + ON_FACE).contains(&t);
        let share = |x: [f64; 3]| dot(minus(x, from), along) / squared;
        let row = |s: f64| {
            let rows = [[a1 + c1 * s, b1 + d1 * s], [a2 + c2 * s, b2 + d2 * s]];
            rows[usize::from(rows[1][1].abs() > rows[0][1].abs())]
        };
        // a straight line of the face, from one side to the other, along which the line goes
        let ruling = |number: f64, ends: [[f64; 3]; 2]| {
            let [first, last] = ends.map(share);
            let meets = first.min(last).max(0.0) < first.max(last).min(1.0);
            match inside(number) && meets {
                true => Meeting::Along,
                false => Meeting::Through(Vec::new()),
            }
        };
        let (tiny, all) = (ON_FACE * self.radius, [q0, q1, q2].map(f64::abs));
        if all.iter().all(|q| *q <= tiny * tiny) {
            let [value, slope] = row(0.5);
            let r = -value / slope;
            return ruling(r, [at(r, 0.0), at(r, 1.0)]);
        }
        let double = -0.5 * q1 / q2;
        let vanishes = |s: f64| {
            let [rows, others] = [[a1 + c1 * s, b1 + d1 * s], [a2 + c2 * s, b2 + d2 * s]];
            rows.iter().chain(&others).all(|v| v.abs() <= tiny)
        };
        if double.is_finite() && vanishes(double) {
            return ruling(double, [at(0.0, double), at(1.0, double)]);
        }
        let place = |s: f64| {
            let [value, slope] = row(s);
            let r = -value / slope;
            let x = at(r, s);
            let share = share(x);
            let on_line: [f64; 3] = std::array::from_fn(|i| from[i] + share * along[i]);
            let is_here = inside(r) && inside(s) && (0.0..=1.0).contains(&share);
            (is_here && self.is_same(x, on_line)).then_some(x)
        };
        let mut places: Vec<[f64; 3]> = roots(q2, q1, q0).into_iter().filter_map(place).collect();
        if let [x, y] = places[..]
            && self.is_same(x, y)
        {
            places.pop();
        }
        Meeting::Through(places)
    }

    /// True for a face that is not plane.
    fn is_warped(&self) -> bool {
        self.thickness() > ON_FACE * self.radius
    }

    /// Of the side from corner a on: what points inwards, of its length, and how far beside it is rounding; corners go round n.
    fn side(&self, a: usize) -> ([f64; 3], f64) {
        let along = minus(self.corners[(a + 1) % 4], self.corners[a]);
        let length = dot(along, along).sqrt();
        (cross(self.normal, along), ON_FACE * self.radius * length)
    }

    /// Height of a point over the mean plane [m].
    fn height(&self, point: [f64; 3]) -> f64 {
        dot(minus(point, self.center), self.normal)
    }

    /// How far points of the face lie off its mean plane: a face that is not plane has some [m].
    fn thickness(&self) -> f64 {
        let off = self.corners.map(|x| self.height(x).abs());
        off.into_iter().fold(ON_FACE * self.radius, f64::max)
    }
}

/// Real roots of `q2 s² + q1 s + q0`, without cancellation; those far away may be infinite.
fn roots(q2: f64, q1: f64, q0: f64) -> Vec<f64> {
    let discriminant = q1 * q1 - 4.0 * q2 * q0;
    if discriminant < 0.0 {
        return Vec::new();
    }
    let q = -0.5 * (q1 + discriminant.sqrt().copysign(q1));
    match q == 0.0 {
        true => vec![0.0],
        false => vec![q / q2, q0 / q],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::face_geometry;
    use fracas_operators::random::Random;

    fn outline(corners: [[f64; 3]; 4]) -> Outline {
        let shape = face_geometry(&corners);
        Outline::of_corners(corners, shape.center, shape.frame[0])
    }

    /// Two faces beside each other whose corners lie off any plane by up to `off`.
    fn two(random: &mut Random, off: f64) -> [[[f64; 3]; 4]; 2] {
        let mut at = |x: f64, y: f64| {
            let mut moved = || random.between(-0.2, 0.2);
            [x + moved(), y + moved(), off * 5.0 * moved()]
        };
        let [a, b, c, d, e, f] = [
            at(0.0, 0.0),
            at(1.0, 0.0),
            at(2.0, 0.0),
            at(0.0, 1.0),
            at(1.0, 1.0),
            at(2.0, 1.0),
        ];
        [[a, b, e, d], [b, c, f, e]]
    }

    fn point(corners: &[[f64; 3]; 4], [r, s]: [f64; 2]) -> [f64; 3] {
        std::array::from_fn(|i| {
            let [a, b, c, d] = corners.map(|x| x[i]);
            (1.0 - s) * ((1.0 - r) * a + r * b) + s * ((1.0 - r) * d + r * c)
        })
    }

    #[test]
    fn a_line_through_a_point_cuts_the_face_of_that_point_and_on_a_common_edge_both_once() {
        let mut random = Random::new(20_611);
        for case in 0..400 {
            let off = [0.0, 1e-9, 1e-4, 0.2][case % 4];
            let faces = two(&mut random, off);
            let (on_edge, own) = (random.chance(0.5), random.below(2));
            let s = random.between(0.05, 0.95);
            let r = match on_edge {
                true => [1.0, 0.0][own],
                false => random.between(0.05, 0.95),
            };
            let x = point(&faces[own], [r, s]);
            let along = [random.between(-0.4, 0.4), random.between(-0.4, 0.4), 3.0];
            let from: [f64; 3] = std::array::from_fn(|i| x[i] - 0.5 * along[i]);
            for (k, corners) in faces.iter().enumerate() {
                // any corner may be the first
                let turns = random.below(4);
                let corners = [0, 1, 2, 3].map(|a: usize| corners[(a + turns) % 4]);
                let outline = outline(corners);
                let Meeting::Through(places) = outline.meeting(from, along) else {
                    panic!("{case}");
                };
                let expected = usize::from(on_edge || k == own);
                assert_eq!(places.len(), expected, "{case} {k} {on_edge}");
                assert!(places.iter().all(|at| outline.is_same(*at, x)), "{case}");
            }
        }
    }

    #[test]
    fn the_diagonal_is_the_same_from_every_corner_and_that_of_the_sides_of_rectangles() {
        let mut random = Random::new(20_612);
        for _ in 0..50 {
            let [corners, _] = two(&mut random, 0.1);
            let turned = |turns: usize| [0, 1, 2, 3].map(|a: usize| corners[(a + turns) % 4]);
            let all = [0, 1, 2, 3].map(|turns| outline(turned(turns)).diagonal());
            assert!(all.iter().all(|d| (d - all[0]).abs() < 1e-14), "{all:?}");
        }
        let rectangle = [[0.0; 3], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
        assert!((outline(rectangle).diagonal() - 5.0).abs() < 1e-14);
    }

    #[test]
    fn a_line_may_cut_a_saddle_twice_and_run_along_its_rulings() {
        // z = x y
        let corners = [
            [-1.0, -1.0, 1.0],
            [1.0, -1.0, -1.0],
            [1.0, 1.0, 1.0],
            [-1.0, 1.0, -1.0],
        ];
        let saddle = outline(corners);
        let Meeting::Through(places) = saddle.meeting([-1.0, -1.0, 0.25], [2.0, 2.0, 0.0]) else {
            panic!("along");
        };
        assert_eq!(places.len(), 2);
        assert!(places.iter().all(|x| (x[0] * x[1] - 0.25).abs() < 1e-12));
        for turns in 0..4 {
            let saddle = outline([0, 1, 2, 3].map(|a: usize| corners[(a + turns) % 4]));
            for at in [-1.0, -0.3, 0.5, 1.0] {
                // z = x y along x = at and along y = at, and beside the face
                for (from, along) in [
                    ([at, -2.0, -2.0 * at], [0.0, 4.0, 4.0 * at]),
                    ([-2.0, at, -2.0 * at], [4.0, 0.0, 4.0 * at]),
                ] {
                    assert_eq!(saddle.meeting(from, along), Meeting::Along, "{turns} {at}");
                    let beyond = along.map(|v| 0.2 * v);
                    let apart = Meeting::Through(Vec::new());
                    assert_eq!(saddle.meeting(from, beyond), apart, "{turns} {at}");
                }
            }
            let apart = Meeting::Through(Vec::new());
            assert_eq!(saddle.meeting([5.0, -1.0, -5.0], [0.0, 2.0, 10.0]), apart);
            assert_eq!(saddle.meeting([-1.0, 5.0, -5.0], [2.0, 0.0, 10.0]), apart);
            assert_eq!(saddle.meeting([0.0, -2.0, 0.5], [0.0, 4.0, 0.0]), apart);
        }
    }
}
