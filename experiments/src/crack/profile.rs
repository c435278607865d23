//! What stands on a crack, face by face, and its distance from a closed form.

use super::Answer;
use fracas::scene::Body;

/// One face of a straight crack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// Where it starts and ends along the crack, from its middle [m].
    pub span: [f64; 2],
    /// Area [m²].
    pub area: f64,
    /// t_N and ‖t_T‖ [Pa].
    pub traction: [f64; 2],
    /// g_N and ‖g_T‖ [m].
    pub jump: [f64; 2],
}

impl Strip {
    /// Middle of the face along the crack [m].
    pub fn middle(&self) -> f64 {
        0.5 * (self.span[0] + self.span[1])
    }
}

/// The faces of a straight crack of plane strain, by increasing position.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Half-length [m].
    pub half_length: f64,
    /// Faces of every row across the thickness.
    pub strips: Vec<Strip>,
}

impl Profile {
    /// Reads an answer along the unit vector `along` of a crack whose middle is the origin.
    pub fn new(body: &Body, answer: &Answer, along: [f64; 3], half_length: f64) -> Self {
        let mut strips: Vec<Strip> = body
            .fractures
            .faces
            .iter()
            .enumerate()
            .map(|(f, face)| {
                let places = face.minus.nodes.map(|a| {
                    let x = body.mesh.nodes[a as usize];
                    x.iter().zip(along).map(|(x, d)| x * d).sum::<f64>()
                });
                let two = |v: &[f64]| [v[3 * f], v[3 * f + 1].hypot(v[3 * f + 2])];
                Strip {
                    span: [
                        places.into_iter().fold(f64::INFINITY, f64::min),
                        places.into_iter().fold(f64::NEG_INFINITY, f64::max),
                    ],
                    area: face.area,
                    traction: two(&answer.fields.traction),
                    jump: two(&answer.fields.jump),
                }
            })
            .collect();
        strips.sort_by(|a, b| a.middle().total_cmp(&b.middle()));
        Self {
            half_length,
            strips,
        }
    }

    /// Faces whose middle is farther from both tips than this share of the length.
    pub fn without_tips(&self, share: f64) -> impl Iterator<Item = &Strip> {
        let limit = self.half_length * (1.0 - 2.0 * share);
        self.strips
            .iter()
            .filter(move |s| s.middle().abs() <= limit)
    }

    /// `‖value − exact‖ / ‖exact‖` in L2 over the faces without tips.
    pub fn relative_error(
        &self,
        share: f64,
        value: impl Fn(&Strip) -> f64,
        exact: impl Fn(&Strip) -> f64,
    ) -> f64 {
        let (mut error, mut norm) = (0.0, 0.0);
        for strip in self.without_tips(share) {
            let truth = exact(strip);
            error += strip.area * (value(strip) - truth).powi(2);
            norm += strip.area * truth * truth;
        }
        (error / norm).sqrt()
    }

    /// Largest `|value − exact| / |exact|` over the faces without tips.
    pub fn largest_error(
        &self,
        share: f64,
        value: impl Fn(&Strip) -> f64,
        exact: impl Fn(&Strip) -> f64,
    ) -> f64 {
        self.without_tips(share).fold(0.0, |m: f64, strip| {
            m.max(((value(strip) - exact(strip)) / exact(strip)).abs())
        })
    }

    /// ∫ value ds over the crack, per unit of thickness.
    pub fn integral(&self, value: impl Fn(&Strip) -> f64) -> f64 {
        let total: f64 = self.strips.iter().map(|s| s.area).sum();
        let sum: f64 = self.strips.iter().map(|s| s.area * value(s)).sum();
        2.0 * self.half_length * sum / total
    }

    /// A face in the middle of the crack.
    pub fn central(&self) -> Option<&Strip> {
        let distance = |s: &&Strip| s.middle().abs();
        self.strips
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Length of the longest face [m].
    pub fn largest_face(&self) -> f64 {
        self.strips
            .iter()
            .map(|s| s.span[1] - s.span[0])
            .fold(0.0, f64::max)
    }

    /// Faces along the crack: those of one row across the thickness.
    pub fn row(&self) -> impl Iterator<Item = &Strip> {
        let same = |a: &Strip, b: &Strip| (a.middle() - b.middle()).abs() < 1e-9 * self.half_length;
        let first = move |k: usize| k == 0 || !same(&self.strips[k - 1], &self.strips[k]);
        (0..self.strips.len())
            .filter(move |k| first(*k))
            .map(|k| &self.strips[k])
    }
}
