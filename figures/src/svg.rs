//! A page as SVG, on plotters' backend (which counts whole pixels, so a point is several of them).

use super::canvas::{Anchor, Ink, Label, Page, Quads, text_width};
use super::indices;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::fmt::Write as _;

/// Pixels per point.
const FINE: f64 = 8.0;
/// Fonts that look alike on every system; the page does not embed one.
const FONT: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// What drawing can fail with: plotters' error on a backend that writes into memory.
type DrawError = plotters::drawing::DrawingAreaErrorKind<std::io::Error>;

/// Writes a page.
pub(super) fn write(page: &Page) -> Result<String, DrawError> {
    let [width, height] = page.size;
    let pixels = |points: f64| (points * FINE).round() as u32;
    let size = (pixels(width), pixels(height));
    let [mut svg, mut rest] = [String::new(), String::new()];
    for (text, canvas, is_ground) in [
        (&mut svg, &page.under, true),
        (&mut rest, &page.over, false),
    ] {
        let area = SVGBackend::with_string(text, size).into_drawing_area();
        if is_ground {
            area.fill(&WHITE)?;
        }
        canvas.ink().iter().try_for_each(|ink| draw(&area, ink))?;
        area.present()?;
    }
    // between the two: plotters would write five times the bytes for cells
    let end = svg.rfind("</svg>").unwrap_or(svg.len());
    svg.truncate(end);
    svg += &paths(&page.cells);
    svg += rest
        .split_once('>')
        .map_or("", |(_, elements)| elements.trim_start());
    // The view box keeps the fine grid; the nominal size is in points.
    let fine = format!("width=\"{}\" height=\"{}\" viewBox", size.0, size.1);
    let nominal = format!("width=\"{width:.0}\" height=\"{height:.0}\" viewBox");
    Ok(indices::lower(&svg.replacen(&fine, &nominal, 1)))
}

fn pixel([x, y]: [f64; 2]) -> (i32, i32) {
    ((x * FINE).round() as i32, (y * FINE).round() as i32)
}

fn stroke(color: RGBAColor, width: f64) -> ShapeStyle {
    ShapeStyle {
        color,
        filled: false,
        stroke_width: (width * FINE).round().max(1.0) as u32,
    }
}

fn draw(area: &DrawingArea<SVGBackend<'_>, Shift>, ink: &Ink) -> Result<(), DrawError> {
    let pixels = |points: &[[f64; 2]]| points.iter().map(|p| pixel(*p)).collect::<Vec<_>>();
    match ink {
        Ink::Line(points, color, width) => {
            area.draw(&PathElement::new(pixels(points), stroke(*color, *width)))
        }
        Ink::Fill(corners, color) => area.draw(&Polygon::new(pixels(corners), color.filled())),
        Ink::Circle(center, radius, color, width) => {
            let style = width.map_or_else(|| color.filled(), |w| stroke(*color, w));
            let radius = (radius * FINE).round() as i32;
            area.draw(&Circle::new(pixel(*center), radius, style))
        }
        Ink::Text(label) => text(area, label),
    }
}

fn text(area: &DrawingArea<SVGBackend<'_>, Shift>, label: &Label) -> Result<(), DrawError> {
    let Label { at, text, size, .. } = label;
    // Not every viewer centres a text of several spans: such a text starts where its estimated width says.
    let half = 0.5 * text_width(text, *size);
    let (at, anchor) = match (indices::has_index(text), label.anchor) {
        (true, Anchor::Center) => ([at[0] - half, at[1]], Anchor::Left),
        (true, Anchor::Right) => ([at[0] - 2.0 * half, at[1]], Anchor::Left),
        (true, Anchor::Upwards) => ([at[0], at[1] + half], Anchor::UpwardsFrom),
        (_, anchor) => (*at, anchor),
    };
    let (h, v, turn) = match anchor {
        Anchor::Left => (HPos::Left, VPos::Center, FontTransform::None),
        Anchor::Center => (HPos::Center, VPos::Center, FontTransform::None),
        Anchor::Right => (HPos::Right, VPos::Center, FontTransform::None),
        Anchor::Upwards => (HPos::Center, VPos::Center, FontTransform::Rotate270),
        Anchor::UpwardsFrom => (HPos::Left, VPos::Center, FontTransform::Rotate270),
    };
    // plotters divides sizes by 1.24 for SVG.
    let font = (FONT, size * FINE * 1.24).into_font().transform(turn);
    let style = TextStyle::from(font)
        .color(&label.color)
        .pos(Pos::new(h, v));
    area.draw(&Text::new(text.clone(), pixel(at), style))
}

/// A path per colour.
fn paths(cells: &Quads) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for ((r, g, b), quads) in &cells.of_color {
        let _ = write!(text, "<path fill=\"#{r:02x}{g:02x}{b:02x}\" d=\"");
        for quad in quads {
            let mut last = None;
            for (x, y) in quad.map(pixel) {
                let _ = match last {
                    None => write!(text, "M{x} {y}"),
                    Some((_, b)) if b == y => write!(text, "H{x}"),
                    Some((a, _)) if a == x => write!(text, "V{y}"),
                    Some(_) => write!(text, "L{x} {y}"),
                };
                last = Some((x, y));
            }
            text.push('Z');
        }
        text += "\"/>\n";
    }
    text
}
