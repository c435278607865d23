//! Values on quadrilaterals as colours, with a bar that says which is which.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, DrawError};
use super::draw::Frame;
use super::palette;
use plotters::style::{BLACK, Color};

/// One value per quadrilateral of the plane.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Quantity and unit, beside the bar.
    pub label: String,
    /// Corners, in order around.
    pub quads: Vec<[[f64; 2]; 4]>,
    /// A value for each.
    pub values: Vec<f64>,
    /// Values at the ends of the bar; those beyond take the colour of the end.
    pub range: [f64; 2],
}

/// How far cells reach beyond their corners, in points: no ground shines through between two that touch.
const OVERLAP: f64 = 0.25;

/// Corners a little further out.
fn grown(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let count = corners.len() as f64;
    let middle = [0, 1].map(|d: usize| corners.iter().map(|p| p[d]).sum::<f64>() / count);
    let out = |p: &[f64; 2]| [0, 1].map(|d: usize| p[d] + OVERLAP * (p[d] - middle[d]).signum());
    corners.iter().map(out).collect()
}

/// Width that the bar takes beside the plot, in points.
pub(super) const BAR_SPACE: f64 = 78.0;
const BAR: f64 = 12.0;
const STEPS: usize = 64;
const TICK_SIZE: f64 = 10.0;
const LABEL_SIZE: f64 = 11.0;

impl Cells {
    /// Centre of a quadrilateral.
    pub(super) fn center(quad: &[[f64; 2]; 4]) -> [f64; 2] {
        [0, 1].map(|d: usize| 0.25 * quad.iter().map(|p| p[d]).sum::<f64>())
    }

    /// Place of a value on the bar, 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }
}

impl Frame<'_> {
    /// Every quadrilateral whose corners can be shown and whose value is a number.
    pub(super) fn cells(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let Some(cells) = &self.figure.cells else {
            return Ok(());
        };
        for (quad, value) in cells.quads.iter().zip(&cells.values) {
            let corners: Vec<[f64; 2]> = quad
                .iter()
                .filter_map(|p| self.figure.place(*p))
                .map(|p| self.at(self.clamped(p)))
                .collect();
            if corners.len() == 4 && value.is_finite() {
                canvas.fill(
                    &grown(&corners),
                    palette::diverging(cells.place(*value)).mix(1.0),
                )?;
            }
        }
        self.bar(canvas, cells)
    }

    fn bar(&self, canvas: &Canvas<'_>, cells: &Cells) -> Result<(), DrawError> {
        let (left, right) = (
            self.left + self.width + 10.0,
            self.left + self.width + 10.0 + BAR,
        );
        let bottom = self.top + self.height;
        let y = |place: f64| bottom - place * self.height;
        for k in 0..STEPS {
            let (a, b) = (k as f64 / STEPS as f64, (k + 1) as f64 / STEPS as f64);
            let box_ = [[left, y(a)], [right, y(a)], [right, y(b)], [left, y(b)]];
            canvas.fill(&box_, palette::diverging(0.5 * (a + b)).mix(1.0))?;
        }
        let (low, high) = (y(0.0), y(1.0));
        canvas.line(
            &[
                [left, low],
                [right, low],
                [right, high],
                [left, high],
                [left, low],
            ],
            BLACK.mix(1.0),
            0.8,
        )?;
        for tick in Axis::linear("").ticks(cells.range, 7) {
            let Some(label) = &tick.label else { continue };
            let at = y(cells.place(tick.at));
            canvas.line(&[[right, at], [right + 4.0, at]], BLACK.mix(1.0), 0.8)?;
            canvas.text([right + 7.0, at], label, TICK_SIZE, Anchor::Left)?;
        }
        let beside = [right + 48.0, 0.5 * (low + high)];
        canvas.text(beside, &cells.label, LABEL_SIZE, Anchor::Upwards)
    }
}
