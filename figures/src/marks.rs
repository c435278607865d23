//! Markers.

use super::canvas::Canvas;
use super::palette::{self, Shape};
use plotters::style::Color;

/// Half width of a marker, in points.
pub(super) const RADIUS: f64 = 3.0;

/// Draws the marker of the k-th series; crowded ones are hollow and let each other show through.
pub(super) fn draw(canvas: &Canvas, k: usize, [x, y]: [f64; 2], r: f64, crowded: bool) {
    let color = palette::color(k);
    let (ink, width) = if crowded {
        (color.mix(0.65), 0.7)
    } else {
        (color.mix(1.0), 1.0)
    };
    let corners: Vec<[f64; 2]> = match palette::shape(k) {
        Shape::Circle if crowded => return canvas.circle([x, y], r, ink, Some(width)),
        Shape::Circle => return canvas.circle([x, y], r, ink, None),
        Shape::Cross => {
            canvas.line(&[[x - r, y - r], [x + r, y + r]], ink, 1.2);
            return canvas.line(&[[x - r, y + r], [x + r, y - r]], ink, 1.2);
        }
        Shape::Plus => {
            canvas.line(&[[x - 1.2 * r, y], [x + 1.2 * r, y]], ink, 1.2);
            return canvas.line(&[[x, y - 1.2 * r], [x, y + 1.2 * r]], ink, 1.2);
        }
        Shape::Square => vec![
            [x - r, y - r],
            [x + r, y - r],
            [x + r, y + r],
            [x - r, y + r],
        ],
        Shape::Up => vec![
            [x, y - 1.25 * r],
            [x + 1.15 * r, y + 0.85 * r],
            [x - 1.15 * r, y + 0.85 * r],
        ],
        Shape::Down => vec![
            [x, y + 1.25 * r],
            [x + 1.15 * r, y - 0.85 * r],
            [x - 1.15 * r, y - 0.85 * r],
        ],
        Shape::Diamond => vec![
            [x, y - 1.35 * r],
            [x + 1.35 * r, y],
            [x, y + 1.35 * r],
            [x - 1.35 * r, y],
        ],
    };
    if crowded {
        let mut closed = corners;
        closed.push(closed[0]);
        canvas.line(&closed, ink, width)
    } else {
        canvas.fill(&corners, ink)
    }
}
