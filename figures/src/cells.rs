//! Values on quadrilaterals as colours, with a bar that says which is which.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Quads, fitting_size, text_width};
use super::draw::{Frame, tick_count};
use super::palette;
use plotters::style::{BLACK, Color, RGBColor};

/// One value per quadrilateral of the plane.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Quantity and unit, beside the bar.
    pub label: String,
    /// Which colours.
    pub colors: Colors,
    /// Corners, in order around.
    pub quads: Vec<[[f64; 2]; 4]>,
    /// A value for each.
    pub values: Vec<f64>,
    /// Values at the ends of the bar; those beyond take the colour of the end.
    pub range: [f64; 2],
}

/// Colours of values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Colors {
    /// From one colour through near-white to another: values on both sides of a middle.
    #[default]
    Diverging,
    /// From dark to light: magnitudes.
    Sequential,
    /// A colour per name; values are numbers of names.
    Classes(Vec<String>),
}

/// How far cells reach beyond their corners, in points: no ground shines through between two that touch.
const OVERLAP: f64 = 0.25;

/// Least width that the bar takes beside the plot, in points.
const BAR_SPACE: f64 = 78.0;
const BAR: f64 = 12.0;
/// From the plot to the bar, and from the bar to its numbers, in points.
const BESIDE: f64 = 10.0;
const NUMBERS: f64 = 7.0;
/// From the numbers of a bar to the middle of its label, and from there on, in points.
const LABEL_SPACE: f64 = 13.0;
/// Smallest letters of a label: a longer one is cut down to its unit.
const SMALL: f64 = 8.0;
/// Colours of a bar, and of the cells beside it.
const STEPS: usize = 64;
const TICK_SIZE: f64 = 10.0;
const LABEL_SIZE: f64 = 11.0;
/// Space for the name of a class beside the bar, in points.
const CLASS_SPACE: f64 = 54.0;

/// Corners a little further out.
fn grown(corners: &[[f64; 2]; 4]) -> [[f64; 2]; 4] {
    let middle = Cells::center(corners);
    corners.map(|p| [0, 1].map(|d: usize| p[d] + OVERLAP * (p[d] - middle[d]).signum()))
}

/// Left, right, top and bottom of a quadrilateral whose sides lie along the axes.
fn rectangle(corners: &[[f64; 2]; 4]) -> Option<[f64; 4]> {
    let end = |d: usize, pick: fn(f64, f64) -> f64| {
        let at = corners.iter().map(|p| p[d]);
        at.reduce(pick).unwrap_or_default()
    };
    let [left, right] = [end(0, f64::min), end(0, f64::max)];
    let [top, bottom] = [end(1, f64::min), end(1, f64::max)];
    let is_corner = |p: &[f64; 2]| [left, right].contains(&p[0]) && [top, bottom].contains(&p[1]);
    // opposite corners differ in both
    let crosses = corners[0][0] != corners[2][0] && corners[0][1] != corners[2][1];
    (corners.iter().all(is_corner) && crosses).then_some([left, right, top, bottom])
}

impl Cells {
    /// Centre of a quadrilateral.
    pub(super) fn center(quad: &[[f64; 2]; 4]) -> [f64; 2] {
        [0, 1].map(|d: usize| 0.25 * quad.iter().map(|p| p[d]).sum::<f64>())
    }

    /// Numbers beside a bar of this height, in points.
    fn ticks(&self, height: f64) -> Vec<(f64, String)> {
        let ticks = Axis::linear("").ticks(self.range, tick_count(height));
        let labelled = ticks.into_iter().filter_map(|t| Some((t.at, t.label?)));
        labelled.collect()
    }

    fn widest(&self, height: f64) -> f64 {
        let widths = self.ticks(height).into_iter();
        let widths = widths.map(|(_, label)| text_width(&label, TICK_SIZE));
        widths.fold(0.0, f64::max)
    }

    /// Width that the bar takes beside a plot of about this height, in points.
    pub(super) fn bar_space(&self, height: f64) -> f64 {
        match &self.colors {
            Colors::Classes(_) => BAR_SPACE,
            _ => BAR_SPACE.max(BESIDE + BAR + NUMBERS + self.widest(height) + 2.0 * LABEL_SPACE),
        }
    }

    /// Place of a value on the bar, 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// Number of the colour of a value.
    fn step(&self, value: f64) -> usize {
        match &self.colors {
            Colors::Classes(_) => value.max(0.0) as usize,
            _ => ((self.place(value) * STEPS as f64) as usize).min(STEPS - 1),
        }
    }

    fn steps(&self) -> usize {
        match &self.colors {
            Colors::Classes(names) => names.len(),
            _ => STEPS,
        }
    }

    fn color(&self, step: usize) -> RGBColor {
        let place = (step as f64 + 0.5) / STEPS as f64;
        match &self.colors {
            Colors::Diverging => palette::diverging(place),
            Colors::Sequential => palette::sequential(place),
            Colors::Classes(_) => palette::class(step),
        }
    }
}

impl Frame<'_> {
    /// Every quadrilateral whose corners can be shown and whose value is a number; rectangles of one colour in a row are one.
    pub(super) fn cells(&self) -> Quads {
        let mut quads = Quads::default();
        let Some(cells) = &self.figure.cells else {
            return quads;
        };
        let mut add = |corners: &[[f64; 2]; 4], step| quads.add(grown(corners), cells.color(step));
        let flat = |[l, r, t, b]: [f64; 4]| [[l, b], [r, b], [r, t], [l, t]];
        let mut row: Option<([f64; 4], usize)> = None;
        for (quad, value) in cells.quads.iter().zip(&cells.values) {
            let placed = quad.map(|p| self.figure.place(p));
            let [Some(a), Some(b), Some(c), Some(d)] = placed else {
                continue;
            };
            if !value.is_finite() {
                continue;
            }
            let corners = [a, b, c, d].map(|p| self.at(self.clamped(p)));
            let step = cells.step(*value);
            let Some(next) = rectangle(&corners) else {
                add(&corners, step);
                continue;
            };
            let close = |x: f64, y: f64| (x - y).abs() < 1e-6;
            row = match row {
                Some((before, color))
                    if color == step
                        && close(before[1], next[0])
                        && close(before[2], next[2])
                        && close(before[3], next[3]) =>
                {
                    Some(([before[0], next[1], before[2], before[3]], step))
                }
                before => {
                    if let Some((before, color)) = before {
                        add(&flat(before), color);
                    }
                    Some((next, step))
                }
            };
        }
        if let Some((before, color)) = row {
            add(&flat(before), color);
        }
        // the bar
        let [left, right] = self.bar_ends();
        let steps = cells.steps();
        let y = |k: usize| self.top + self.height * (1.0 - k as f64 / steps as f64);
        (0..steps).for_each(|k| quads.add(flat([left, right, y(k + 1), y(k)]), cells.color(k)));
        quads
    }

    /// Left and right end of the bar.
    fn bar_ends(&self) -> [f64; 2] {
        [BESIDE, BESIDE + BAR].map(|x| self.left + self.width + x)
    }

    /// Frame, ticks and label of the bar.
    pub(super) fn bar(&self, canvas: &Canvas) {
        let Some(cells) = &self.figure.cells else {
            return;
        };
        let [left, right] = self.bar_ends();
        let y = |place: f64| self.top + (1.0 - place) * self.height;
        let (low, high) = (y(0.0), y(1.0));
        let ring = [
            [left, low],
            [right, low],
            [right, high],
            [left, high],
            [left, low],
        ];
        canvas.line(&ring, BLACK.mix(1.0), 0.8);
        if let Colors::Classes(names) = &cells.colors {
            for (k, name) in names.iter().enumerate() {
                let at = y((k as f64 + 0.5) / cells.steps() as f64);
                let size = fitting_size(name, TICK_SIZE, CLASS_SPACE);
                canvas.text([right + 5.0, at], name, size, Anchor::Left);
            }
            return;
        }
        for (value, label) in cells.ticks(self.height) {
            let at = y(cells.place(value));
            canvas.line(&[[right, at], [right + 4.0, at]], BLACK.mix(1.0), 0.8);
            canvas.text([right + NUMBERS, at], &label, TICK_SIZE, Anchor::Left);
        }
        let numbers = cells.widest(self.height).max(28.0);
        let beside = [right + NUMBERS + numbers + LABEL_SPACE, 0.5 * (low + high)];
        let room = self.height + 20.0;
        let (size, label) = match fitting_size(&cells.label, LABEL_SIZE, room) {
            size if size >= SMALL => (size, cells.label.as_str()),
            // what it is of stands in the caption
            _ => (LABEL_SIZE, unit(&cells.label)),
        };
        canvas.text(beside, label, size, Anchor::Upwards)
    }
}

/// `[mm]` of `Displacement [mm]`.
fn unit(label: &str) -> &str {
    label.rfind('[').map_or(label, |at| &label[at..])
}
