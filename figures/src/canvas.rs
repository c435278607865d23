//! A page in points as data: lines, areas, circles, cells and texts, which `svg.rs` and `pdf.rs` write.

use super::palette;
use plotters::style::{BLACK, RGBAColor, RGBColor};
use std::cell::{Ref, RefCell};
use std::collections::BTreeMap;

/// Lengths of dashes and of the gaps between them, in points.
const DASHES: [(f64, f64); 3] = [(5.0, 3.0), (1.5, 2.0), (10.0, 2.5)];

/// Something drawn; lengths are in points, y runs downwards.
#[derive(Clone, Debug)]
pub(super) enum Ink {
    /// An open line of a width.
    Line(Vec<[f64; 2]>, RGBAColor, f64),
    /// A filled polygon.
    Fill(Vec<[f64; 2]>, RGBAColor),
    /// A circle of a radius, filled where no width of its line is given.
    Circle([f64; 2], f64, RGBAColor, Option<f64>),
    /// A line of text.
    Text(Label),
}

/// A line of text on a page.
#[derive(Clone, Debug)]
pub(super) struct Label {
    pub(super) at: [f64; 2],
    pub(super) text: String,
    /// Of the letters, in points.
    pub(super) size: f64,
    pub(super) anchor: Anchor,
    pub(super) color: RGBColor,
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

/// A figure on paper: what lies under the cells, cells, what lies over them.
pub(super) struct Page {
    /// Width and height.
    pub(super) size: [f64; 2],
    pub(super) under: Canvas,
    pub(super) cells: Quads,
    pub(super) over: Canvas,
}

/// Corners in points.
pub(super) type Quad = [[f64; 2]; 4];

/// Filled quadrilaterals by colour.
#[derive(Default)]
pub(super) struct Quads {
    pub(super) of_color: BTreeMap<(u8, u8, u8), Vec<Quad>>,
}

impl Quads {
    /// Adds one.
    pub(super) fn add(&mut self, corners: Quad, color: RGBColor) {
        let color = (color.0, color.1, color.2);
        self.of_color.entry(color).or_default().push(corners);
    }
}

/// A drawing surface measured in points.
#[derive(Default)]
pub(super) struct Canvas {
    ink: RefCell<Vec<Ink>>,
}

impl Canvas {
    fn add(&self, ink: Ink) {
        self.ink.borrow_mut().push(ink);
    }

    /// What was drawn, in this order.
    pub(super) fn ink(&self) -> Ref<'_, Vec<Ink>> {
        self.ink.borrow()
    }

    /// An open line.
    pub(super) fn line(&self, points: &[[f64; 2]], color: RGBAColor, width: f64) {
        self.add(Ink::Line(points.to_vec(), color, width));
    }

    /// The line of a series: solid in every colour, then dashed in one way after the other.
    pub(super) fn line_of(&self, tone: usize, points: &[[f64; 2]], color: RGBAColor) {
        match tone / palette::LEN {
            0 => self.line(points, color, 1.5),
            again => self.dashes(DASHES[(again - 1) % DASHES.len()], points, color, 1.5),
        }
    }

    /// A line of dashes.
    pub(super) fn dashed(&self, points: &[[f64; 2]], color: RGBAColor, width: f64) {
        self.dashes(DASHES[0], points, color, width);
    }

    fn dashes(&self, (dash, gap): (f64, f64), points: &[[f64; 2]], color: RGBAColor, width: f64) {
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
                    self.line(&[at(start), at(end)], color, width);
                }
                s += dash + gap;
            }
            along = length - (s - dash - gap);
        }
    }

    /// A filled polygon.
    pub(super) fn fill(&self, corners: &[[f64; 2]], color: RGBAColor) {
        self.add(Ink::Fill(corners.to_vec(), color));
    }

    /// A circle, filled or not.
    pub(super) fn circle(
        &self,
        center: [f64; 2],
        radius: f64,
        color: RGBAColor,
        width: Option<f64>,
    ) {
        self.add(Ink::Circle(center, radius, color, width));
    }

    /// A line of text.
    pub(super) fn text(&self, at: [f64; 2], text: &str, size: f64, anchor: Anchor) {
        self.colored_text(at, text, size, anchor, BLACK);
    }

    /// A line of text in a colour.
    pub(super) fn colored_text(
        &self,
        at: [f64; 2],
        text: &str,
        size: f64,
        anchor: Anchor,
        color: RGBColor,
    ) {
        self.add(Ink::Text(Label {
            at,
            text: text.to_owned(),
            size,
            anchor,
            color,
        }));
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
