//! Colours that everybody can tell apart, each with a marker shape of its own.

use plotters::style::RGBColor;

/// Number of colours.
pub(super) const LEN: usize = 7;

/// Okabe & Ito's palette without yellow (too light for lines on white), darkest first.
///
/// # Source
/// M. Okabe, K. Ito, *Color Universal Design* (2008), <https://jfly.uni-koeln.de/color/>.
const COLORS: [RGBColor; LEN] = [
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
    mixed(from, to, share)
}

/// Viridis: even in lightness from dark to light, told apart by everybody, in grey as well.
///
/// # Source
/// S. van der Walt, N. Smith, matplotlib (2015), CC0; every sixteenth of its colours.
const VIRIDIS: [RGBColor; 17] = [
    RGBColor(68, 1, 84),
    RGBColor(72, 24, 106),
    RGBColor(71, 45, 123),
    RGBColor(66, 64, 134),
    RGBColor(59, 82, 139),
    RGBColor(51, 99, 141),
    RGBColor(44, 114, 142),
    RGBColor(38, 130, 142),
    RGBColor(33, 145, 140),
    RGBColor(31, 160, 136),
    RGBColor(40, 174, 128),
    RGBColor(63, 188, 115),
    RGBColor(94, 201, 98),
    RGBColor(132, 212, 75),
    RGBColor(173, 220, 48),
    RGBColor(216, 226, 25),
    RGBColor(253, 231, 37),
];

/// From dark to light: `place` 0 to 1.
pub(super) fn sequential(place: f64) -> RGBColor {
    let at = place.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let k = (at as usize).min(VIRIDIS.len() - 2);
    mixed(VIRIDIS[k], VIRIDIS[k + 1], at - k as f64)
}

/// Colour of the k-th class: the palette, lightened.
pub(super) fn class(k: usize) -> RGBColor {
    mixed(color(k), RGBColor(255, 255, 255), 0.45)
}

fn mixed(from: RGBColor, to: RGBColor, share: f64) -> RGBColor {
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
