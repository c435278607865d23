//! Where points and lines lie on a fracture face.

use crate::mesh::{BuiltMesh, FractureFace};

/// Share of the radius of a face by which a point may lie beside it. Unit: 1.
const ON_FACE: f64 = 1e-6;

/// Sine of the angle between a line and a plane below which they are parallel. Unit: 1.
const PARALLEL: f64 = 1e-6;

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// How a line meets a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meeting {
    /// Not at all.
    Apart,
    /// It goes through it here [m].
    Through([f64; 3]),
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
        let sizes = corners.map(|x| minus(x, face.center)).map(|d| dot(d, d));
        Self {
            center: face.center,
            normal: face.frame[0],
            corners,
            radius: sizes.into_iter().fold(0.0, f64::max).sqrt(),
        }
    }

    /// `√(a² + b²)` of the sides a and b [m].
    pub(super) fn diagonal(&self) -> f64 {
        let [a, b] = [1, 3].map(|c: usize| minus(self.corners[c], self.corners[0]));
        (dot(a, a) + dot(b, b)).sqrt()
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
        let at = |share: f64| -> [f64; 3] { std::array::from_fn(|i| from[i] + share * along[i]) };
        let crossing = dot(along, self.normal);
        if crossing.abs() > PARALLEL * dot(along, along).sqrt() {
            let share = -self.height(from) / crossing;
            let place = at(share);
            return match (0.0..=1.0).contains(&share) && self.holds(place) {
                true => Meeting::Through(place),
                false => Meeting::Apart,
            };
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
                _ if here < 0.0 => return Meeting::Apart,
                _ => {}
            }
        }
        let beside = |share: f64| self.height(at(share)).abs() <= self.thickness();
        match first < last && beside(0.5 * (first + last)) {
            true => Meeting::Along,
            false => Meeting::Apart,
        }
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
