//! A plane, and the directions in it.

/// `n·x = offset`.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    /// Of length 1.
    pub(crate) normal: [f64; 3],
    /// m.
    pub(crate) offset: f64,
}

/// Cosine of the angle below which two directions are the same: 3°.
const SAME: f64 = 0.9986;

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

pub(super) fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

/// True for directions that differ by less than 3°, whichever way they point.
pub(super) fn is_same(a: [f64; 3], b: [f64; 3]) -> bool {
    dot(a, b).abs() > SAME
}

impl Plane {
    /// Distance of a point, with its sign [m].
    pub(super) fn at(&self, x: [f64; 3]) -> f64 {
        dot(self.normal, x) - self.offset
    }

    /// Where it lies, for a caption: `y = 2.5 m`.
    pub(crate) fn words(&self) -> String {
        let axis = (0..3).find(|k| self.normal[*k].abs() > 1.0 - 1e-9);
        match axis {
            Some(k) => {
                let at = self.offset * self.normal[k].signum();
                format!("{} = {} m", ["x", "y", "z"][k], short(at))
            }
            None => {
                let [a, b, c] = self.normal.map(|x| format!("{x:.2}").replace('-', "−"));
                format!("{a} x + {b} y + {c} z = {} m", short(self.offset)).replace("+ −", "− ")
            }
        }
    }
}

/// A number with four digits.
fn short(x: f64) -> String {
    let digits = (3.0 - x.abs().max(1e-300).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    text.replace('-', "−")
}

/// A direction in a plane.
#[derive(Clone, Debug)]
pub(crate) struct Direction {
    /// Of length 1.
    pub(crate) along: [f64; 3],
    /// `x`, or `along strike`.
    pub(crate) name: String,
}

impl Direction {
    /// Along this unit vector or against it, so that it points up, or north, or east.
    fn new(along: [f64; 3], otherwise: &str) -> Self {
        let largest = along.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let leading = along.iter().rev().find(|x| x.abs() > 0.9 * largest);
        let sign = leading.map_or(1.0, |x| x.signum());
        let along = along.map(|x| sign * x);
        let axis = (0..3).find(|k| along[*k] > 1.0 - 1e-9);
        let name = axis.map_or(otherwise, |k| ["x", "y", "z"][k]).to_owned();
        Self { along, name }
    }

    /// m.
    pub(crate) fn at(&self, x: [f64; 3]) -> f64 {
        dot(self.along, x)
    }
}

/// Along strike and up dip of a plane with this normal, of any length; x and y of a level one.
pub(crate) fn in_plane(normal: [f64; 3]) -> [Direction; 2] {
    let n = unit(normal);
    // z × n
    let strike = match n[0].hypot(n[1]) {
        level if level < 1e-9 => [1.0, 0.0, 0.0],
        _ => unit([-n[1], n[0], 0.0]),
    };
    [
        Direction::new(strike, "along strike"),
        Direction::new(cross(n, strike), "up dip"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_of_the_axes_are_named_by_them_and_dipping_ones_by_strike_and_dip() {
        for (normal, names) in [
            ([2.0, 0.0, 0.0], ["y", "z"]),
            ([0.0, -3.0, 0.0], ["x", "z"]),
            ([0.0, 0.0, 1.0], ["x", "y"]),
            ([1.0, 0.0, -1.0], ["y", "up dip"]),
            ([1.0, 1.0, 0.0], ["along strike", "z"]),
        ] {
            let found = in_plane(normal);
            assert_eq!(found.each_ref().map(|d| &*d.name), names);
            for direction in &found {
                assert!(direction.at(normal).abs() < 1e-12);
                assert!((direction.at(direction.along) - 1.0).abs() < 1e-12);
            }
            assert!(found[1].along[2] >= 0.0);
        }
    }

    #[test]
    fn planes_are_told_as_people_do() {
        let words = |normal, offset| Plane { normal, offset }.words();
        assert_eq!(words([0.0, -1.0, 0.0], -2.5), "y = 2.5 m");
        assert_eq!(words([0.0, 0.0, 1.0], -2012.5), "z = −2012 m");
        assert_eq!(
            words([0.6, 0.0, -0.8], 12.0),
            "0.60 x + 0.00 y − 0.80 z = 12 m"
        );
    }
}
