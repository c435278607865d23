//! A plane, and the directions in it.

/// `n·x = offset`.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Of length 1.
    pub normal: [f64; 3],
    /// m.
    pub offset: f64,
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
    pub fn words(&self) -> String {
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

/// A direction in a plane, and what is read along it.
#[derive(Clone, Debug)]
pub struct Direction {
    /// Of length 1.
    pub along: [f64; 3],
    /// `x`, or `along strike`.
    pub name: String,
    /// What is read along it: `x`, or `along strike, from the end`.
    pub label: String,
    /// Gradient of the coordinate: `along`, or the axis z in a plane that is steep enough. Unit: 1.
    reading: [f64; 3],
    /// Where the coordinate is 0, over `reading` [m].
    origin: f64,
}

/// Sine of the dip above which heights are read in a plane, and below which lengths: that of 30°. Unit: 1.
const STEEP: f64 = 0.5;

impl Direction {
    /// Along this unit vector or against it, so that it points up, or north, or east; named by its axis where it has one, and else read from
    /// the lowest of these points [m], since a distance from the origin of the world says nothing.
    fn new(
        along: [f64; 3],
        [name, from]: [&str; 2],
        points: impl Iterator<Item = [f64; 3]>,
    ) -> Self {
        let largest = along.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let leading = along.iter().rev().find(|x| x.abs() > 0.9 * largest);
        let sign = leading.map_or(1.0, |x| x.signum());
        let along = along.map(|x| sign * x);
        match (0..3).find(|k| along[*k] > 1.0 - 1e-9) {
            Some(k) => Self {
                along,
                name: ["x", "y", "z"][k].into(),
                label: ["x", "y", "z"][k].into(),
                reading: along,
                origin: 0.0,
            },
            None => {
                let lowest = points.map(|x| dot(along, x)).reduce(f64::min);
                Self {
                    along,
                    name: name.into(),
                    label: format!("{name}, {from}"),
                    reading: along,
                    origin: lowest.unwrap_or(0.0),
                }
            }
        }
    }

    /// Read by z [m].
    fn by_height(self) -> Self {
        Self {
            label: "z".into(),
            reading: [0.0, 0.0, 1.0],
            origin: 0.0,
            ..self
        }
    }

    /// m.
    pub fn at(&self, x: [f64; 3]) -> f64 {
        dot(self.reading, x) - self.origin
    }

    /// Length in the plane over the difference of the coordinate. Unit: 1.
    pub fn stretch(&self) -> f64 {
        1.0 / dot(self.along, self.reading)
    }
}

/// Along strike and up dip of a plane with this normal, of any length; x and y of a level one. Where the plane dips by more than 30° heights z
/// are read in it; where neither an axis nor z serves, lengths from the lower end of what these points span.
pub fn in_plane(
    normal: [f64; 3],
    points: impl Iterator<Item = [f64; 3]> + Clone,
) -> [Direction; 2] {
    let n = unit(normal);
    // z × n
    let strike = match n[0].hypot(n[1]) {
        level if level < 1e-9 => [1.0, 0.0, 0.0],
        _ => unit([-n[1], n[0], 0.0]),
    };
    let up = Direction::new(
        cross(n, strike),
        ["up dip", "from the lower end"],
        points.clone(),
    );
    [
        Direction::new(strike, ["along strike", "from the end"], points),
        match up.along[2] > STEEP {
            true => up.by_height(),
            false => up,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_of_the_axes_are_named_by_them_and_dipping_ones_by_height_or_dip() {
        let (strike, dip) = ("along strike, from the end", "up dip, from the lower end");
        for (normal, names) in [
            ([2.0, 0.0, 0.0], ["y", "z"]),
            ([0.0, -3.0, 0.0], ["x", "z"]),
            ([0.0, 0.0, 1.0], ["x", "y"]),
            ([1.0, 0.0, -1.0], ["y", "z"]),
            ([0.2, 0.0, -1.0], ["y", dip]),
            ([0.2, 0.3, -1.0], [strike, dip]),
            ([1.0, 1.0, 0.0], [strike, "z"]),
        ] {
            // a square in the plane, there and 20 km away
            let [e, f] = in_plane(normal, std::iter::empty()).map(|d| d.along);
            let corner =
                |a: f64, b: f64| [0, 1, 2].map(|k| 7.0 + 50.0 * a * e[k] + 50.0 * b * f[k]);
            let square = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)];
            let away = square.map(|[x, y, z]| [x + 2e4, y - 1.7e4, z]);
            let here = in_plane(normal, square.into_iter());
            let there = in_plane(normal, away.into_iter());
            assert_eq!(here.each_ref().map(|d| &*d.label), names);
            for (d, (direction, moved)) in here.iter().zip(&there).enumerate() {
                assert!(dot(direction.along, normal).abs() < 1e-12);
                // lengths in the plane are those between the points
                let side = direction.at(square[2]) - direction.at(square[0]);
                assert!(
                    (side * direction.stretch() - 100.0).abs() < 1e-9,
                    "{names:?}"
                );
                match &*direction.label {
                    "z" => assert_eq!(direction.at(square[1]), square[1][2]),
                    "x" | "y" => continue,
                    _ => assert!(direction.at(square[0]).abs() < 1e-9, "{d}"),
                }
                for (near, far) in square.iter().zip(&away) {
                    assert!((direction.at(*near) - moved.at(*far)).abs() < 1e-9);
                }
            }
            assert!(here[1].along[2] >= 0.0);
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
