//! The legend: rows below the plot, where it cannot cover data.

use super::canvas::{Anchor, Canvas, fitting_size, text_width};
use super::figure::{Figure, Mark, Region};
use super::{marks, palette};
use plotters::style::Color;

const SIZE: f64 = 10.0;
const ROW: f64 = 16.0;
const SWATCH: f64 = 22.0;
const GAP: f64 = 18.0;

/// What an entry shows.
enum Swatch<'a> {
    Series(usize, Mark),
    Shade(usize, &'a Region),
}

/// Entries and the rows that they fill.
pub(super) struct Legend<'a> {
    rows: Vec<Vec<(Swatch<'a>, String)>>,
    /// Points that a row has.
    width: f64,
}

impl<'a> Legend<'a> {
    /// Breaks the entries of a figure into rows of at most `width` points.
    pub(super) fn new(figure: &'a Figure, hidden: &[usize], width: f64) -> Self {
        let mut entries: Vec<(Swatch<'a>, String)> = Vec::new();
        for (k, series) in figure
            .series
            .iter()
            .enumerate()
            .filter(|(_, s)| !s.name.is_empty())
        {
            let name = match hidden[k] {
                0 => series.name.clone(),
                _ if series.mark == Mark::Bars => format!("{} (✗ no result)", series.name),
                n => format!(
                    "{} ({n} of {} cannot be shown)",
                    series.name,
                    series.points.len()
                ),
            };
            entries.push((Swatch::Series(series.tone.unwrap_or(k), series.mark), name));
        }
        for (k, shade) in figure
            .shades
            .iter()
            .enumerate()
            .filter(|(_, s)| !s.name.is_empty())
        {
            entries.push((Swatch::Shade(k, &shade.region), shade.name.clone()));
        }
        let mut rows: Vec<Vec<(Swatch<'a>, String)>> = Vec::new();
        let mut used = f64::INFINITY;
        for entry in entries {
            let wide = entry_width(&entry.1, width);
            if used + wide > width {
                rows.push(Vec::new());
                used = 0.0;
            }
            used += wide + GAP;
            if let Some(row) = rows.last_mut() {
                row.push(entry);
            }
        }
        Self { rows, width }
    }

    /// Height in points.
    pub(super) fn height(&self) -> f64 {
        if self.rows.is_empty() {
            0.0
        } else {
            6.0 + ROW * self.rows.len() as f64
        }
    }

    /// Draws the rows centred on `x`, from `y` downwards.
    pub(super) fn draw(&self, canvas: &Canvas, x: f64, y: f64) {
        for (r, row) in self.rows.iter().enumerate() {
            let total: f64 = row
                .iter()
                .map(|(_, name)| entry_width(name, self.width))
                .sum::<f64>()
                + GAP * (row.len() - 1) as f64;
            let (mut at, y) = (x - 0.5 * total, y + 6.0 + ROW * (r as f64 + 0.5));
            for (swatch, name) in row {
                draw_swatch(canvas, swatch, at, y);
                let size = size_of(name, self.width);
                canvas.text([at + SWATCH + 5.0, y], name, size, Anchor::Left);
                at += entry_width(name, self.width) + GAP;
            }
        }
    }
}

fn entry_width(name: &str, width: f64) -> f64 {
    SWATCH + 5.0 + text_width(name, size_of(name, width))
}

/// Size of the letters of an entry in a row of this width.
fn size_of(name: &str, width: f64) -> f64 {
    fitting_size(name, SIZE, width - SWATCH - 5.0)
}

fn draw_swatch(canvas: &Canvas, swatch: &Swatch<'_>, x: f64, y: f64) {
    let middle = [x + 0.5 * SWATCH, y];
    let block = |h: f64| {
        [
            [x, y - h],
            [x + SWATCH, y - h],
            [x + SWATCH, y + h],
            [x, y + h],
        ]
    };
    match swatch {
        Swatch::Series(k, mark) => {
            let ink = palette::color(*k).mix(1.0);
            match mark {
                Mark::Line => canvas.line_of(*k, &[[x, y], [x + SWATCH, y]], ink),
                Mark::LinePoints => canvas.line(&[[x, y], [x + SWATCH, y]], ink, 1.5),
                Mark::Dashed => canvas.dashed(&[[x, y], [x + SWATCH, y]], ink, 1.5),
                Mark::Bars => canvas.fill(&block(4.5), ink),
                Mark::Points => {}
            }
            if matches!(mark, Mark::Points | Mark::LinePoints) {
                marks::draw(canvas, *k, middle, marks::RADIUS, false);
            }
        }
        Swatch::Shade(k, region) => {
            let color = palette::shade(*k);
            if let Region::RealInterval(_) = region {
                return canvas.fill(&block(3.5), color.mix(0.5));
            }
            canvas.fill(&block(5.0), color.mix(0.22));
            let mut outline = block(5.0).to_vec();
            outline.push(outline[0]);
            canvas.line(&outline, color.mix(1.0), 0.8)
        }
    }
}
