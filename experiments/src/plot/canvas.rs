//! A page in points, on plotters' SVG backend (which counts whole pixels, so a point is several of them).

use super::indices;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Pixels per point.
const FINE: f64 = 8.0;
/// Fonts that look alike on every system; the page does not embed one.
const FONT: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// What drawing can fail with: plotters' error on a backend that writes into memory.
pub(super) type DrawError = plotters::drawing::DrawingAreaErrorKind<std::io::Error>;

/// A drawing surface measured in points.
pub(super) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

/// Draws on a page of `width × height` points and returns the SVG: what lies under the cells, cells, what lies over them.
pub(super) fn draw_page(
    [width, height]: [f64; 2],
    under: impl FnOnce(&Canvas<'_>) -> Result<(), DrawError>,
    cells: &Quads,
    over: impl FnOnce(&Canvas<'_>) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    let pixels = |points: f64| (points * FINE).round() as u32;
    let size = (pixels(width), pixels(height));
    let [mut svg, mut rest] = [String::new(), String::new()];
    {
        let canvas = Canvas::new(&mut svg, size);
        canvas.area.fill(&WHITE)?;
        under(&canvas)?;
        canvas.area.present()?;
    }
    {
        let canvas = Canvas::new(&mut rest, size);
        over(&canvas)?;
        canvas.area.present()?;
    }
    // between the two: plotters would write five times the bytes for cells
    let end = svg.rfind("</svg>").unwrap_or(svg.len());
    svg.truncate(end);
    svg += &cells.paths();
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

/// Where a text hangs on its point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    Left,
    Center,
    Right,
    /// Centred, reading upwards.
    Upwards,
    /// From the point upwards.
    UpwardsFrom,
}

/// Filled quadrilaterals by colour.
#[derive(Default)]
pub(super) struct Quads {
    paths: BTreeMap<(u8, u8, u8), String>,
}

impl Quads {
    /// Adds one, from corners in points.
    pub(super) fn add(&mut self, corners: &[[f64; 2]], color: RGBColor) {
        let path = self.paths.entry((color.0, color.1, color.2)).or_default();
        let mut last = None;
        for (x, y) in corners.iter().map(|p| pixel(*p)) {
            // Writing to a string cannot fail.
            let _ = match last {
                None => write!(path, "M{x} {y}"),
                Some((_, b)) if b == y => write!(path, "H{x}"),
                Some((a, _)) if a == x => write!(path, "V{y}"),
                Some(_) => write!(path, "L{x} {y}"),
            };
            last = Some((x, y));
        }
        path.push('Z');
    }

    fn paths(&self) -> String {
        let mut text = String::new();
        for ((r, g, b), path) in &self.paths {
            // as above
            let _ = writeln!(text, "<path fill=\"#{r:02x}{g:02x}{b:02x}\" d=\"{path}\"/>");
        }
        text
    }
}

impl<'a> Canvas<'a> {
    fn new(svg: &'a mut String, size: (u32, u32)) -> Self {
        Self {
            area: SVGBackend::with_string(svg, size).into_drawing_area(),
        }
    }
}

impl Canvas<'_> {
    /// An open line.
    pub(super) fn line(
        &self,
        points: &[[f64; 2]],
        color: RGBAColor,
        width: f64,
    ) -> Result<(), DrawError> {
        self.area.draw(&PathElement::new(
            points.iter().map(|p| pixel(*p)).collect::<Vec<_>>(),
            stroke(color, width),
        ))
    }

    /// A line of dashes.
    pub(super) fn dashed(
        &self,
        points: &[[f64; 2]],
        color: RGBAColor,
        width: f64,
    ) -> Result<(), DrawError> {
        let (dash, gap) = (5.0, 3.0);
        let mut along = 0.0;
        for pair in points.windows(2) {
            let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
            let length = (x1 - x0).hypot(y1 - y0);
            if length == 0.0 {
                continue;
            }
            let at = |s: f64| [x0 + (x1 - x0) * s / length, y0 + (y1 - y0) * s / length];
            let mut s = -along;
            while s < length {
                let (start, end) = (s.max(0.0), (s + dash).min(length));
                if end > start {
                    self.line(&[at(start), at(end)], color, width)?;
                }
                s += dash + gap;
            }
            along = length - (s - dash - gap);
        }
        Ok(())
    }

    /// A filled polygon.
    pub(super) fn fill(&self, corners: &[[f64; 2]], color: RGBAColor) -> Result<(), DrawError> {
        self.area.draw(&Polygon::new(
            corners.iter().map(|p| pixel(*p)).collect::<Vec<_>>(),
            color.filled(),
        ))
    }

    /// A circle, filled or not.
    pub(super) fn circle(
        &self,
        center: [f64; 2],
        radius: f64,
        color: RGBAColor,
        width: Option<f64>,
    ) -> Result<(), DrawError> {
        let style = width.map_or_else(|| color.filled(), |w| stroke(color, w));
        self.area.draw(&Circle::new(
            pixel(center),
            (radius * FINE).round() as i32,
            style,
        ))
    }

    /// A line of text.
    pub(super) fn text(
        &self,
        at: [f64; 2],
        text: &str,
        size: f64,
        anchor: Anchor,
    ) -> Result<(), DrawError> {
        self.colored_text(at, text, size, anchor, BLACK)
    }

    /// A line of text in a colour.
    pub(super) fn colored_text(
        &self,
        at: [f64; 2],
        text: &str,
        size: f64,
        anchor: Anchor,
        color: RGBColor,
    ) -> Result<(), DrawError> {
        // Not every viewer centres a text of several spans: such a text starts where its estimated width says.
        let half = 0.5 * text_width(text, size);
        let (at, anchor) = match (indices::has_index(text), anchor) {
            (true, Anchor::Center) => ([at[0] - half, at[1]], Anchor::Left),
            (true, Anchor::Right) => ([at[0] - 2.0 * half, at[1]], Anchor::Left),
            (true, Anchor::Upwards) => ([at[0], at[1] + half], Anchor::UpwardsFrom),
            (_, anchor) => (at, anchor),
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
        let style = TextStyle::from(font).color(&color).pos(Pos::new(h, v));
        self.area
            .draw(&Text::new(text.to_owned(), pixel(at), style))
    }
}

/// The size of letters, or a smaller one with which the text fits into this width.
pub(super) fn fitting_size(text: &str, size: f64, width: f64) -> f64 {
    size * (width / text_width(text, size)).min(1.0)
}

/// Width of a text in points, within about a tenth.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let em = |c: char| match c {
        'i' | 'l' | 'j' | '.' | ',' | ':' | ';' | '|' | '\'' | 'I' => 0.25,
        'f' | 't' | 'r' | ' ' | '(' | ')' | '[' | ']' | '-' | '/' => 0.33,
        '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' | '⁻' => 0.36,
        'm' | 'w' | 'M' | 'W' | '—' => 0.87,
        c if c.is_uppercase() => 0.70,
        '_' => 0.50,
        '=' | '+' | '≤' | '≥' | '×' | '−' | '±' => 0.84,
        _ => 0.63,
    };
    text.chars().map(em).sum::<f64>() * size
}
