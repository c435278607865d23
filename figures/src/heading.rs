//! Title and note above the plot.

use super::canvas::{Anchor, Canvas, fitting_size};
use super::figure::Figure;

const TITLE_SIZE: f64 = 12.0;
const NOTE_SIZE: f64 = 10.0;
/// Height that a note takes, in points.
const NOTE_SPACE: f64 = 16.0;

impl Figure {
    /// Height above the plot, in points.
    pub(super) fn heading_height(&self) -> f64 {
        let title = if self.title.is_empty() { 12.0 } else { 34.0 };
        title
            + if self.note.is_empty() {
                0.0
            } else {
                NOTE_SPACE
            }
    }

    /// Draws both centred on `middle`, no wider than the page.
    pub(super) fn draw_heading(&self, canvas: &Canvas, middle: f64, page_width: f64) {
        let room = 2.0 * middle.min(page_width - middle) - 8.0;
        let lines = [
            (&self.title, 18.0, TITLE_SIZE),
            (&self.note, self.heading_height() - 14.0, NOTE_SIZE),
        ];
        for (text, y, size) in lines.into_iter().filter(|(text, ..)| !text.is_empty()) {
            let size = fitting_size(text, size, room);
            canvas.text([middle, y], text, size, Anchor::Center);
        }
    }
}
