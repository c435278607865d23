//! Colours that everybody can tell apart, each with a marker shape of its own.

use plotters::style::RGBColor;

/// Okabe & Ito's palette without yellow (too light for lines on white), darkest first.
///
/// # Source
/// M. Okabe, K. Ito, *Color Universal Design* (2008), <https://jfly.uni-koeln.de/color/>.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// Marker shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
    Cross,
    Plus,
}

const SHAPES: [Shape; 7] = [
    Shape::Circle,
    Shape::Square,
    Shape::Up,
    Shape::Diamond,
    Shape::Down,
    Shape::Cross,
    Shape::Plus,
];

/// Fills of shaded regions, light enough for data on top.
const SHADES: [RGBColor; 4] = [
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];

/// From the first colour of the palette through near-white to the second: `place` 0 to 1.
pub(super) fn diverging(place: f64) -> RGBColor {
    const MIDDLE: RGBColor = RGBColor(247, 247, 247);
    let (from, to, share) = match place < 0.5 {
        true => (COLORS[0], MIDDLE, 2.0 * place),
        false => (MIDDLE, COLORS[1], 2.0 * place - 1.0),
    };
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}

/// Colour of the k-th series.
pub(super) fn color(k: usize) -> RGBColor {
    COLORS[k % COLORS.len()]
}

/// Marker of the k-th series; shapes shift after each round of colours so that pairs do not repeat.
pub(super) fn shape(k: usize) -> Shape {
    SHAPES[(k + k / COLORS.len()) % SHAPES.len()]
}

/// Fill of the k-th region.
pub(super) fn shade(k: usize) -> RGBColor {
    SHADES[k % SHADES.len()]
}
