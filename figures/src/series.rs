//! Lines, markers and bars inside the frame.

use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas};
use super::draw::Frame;
use super::figure::{Mark, Series};
use super::{marks, palette};
use plotters::style::Color;

/// Series with more points are drawn hollow.
const CROWD: usize = 60;

impl Frame<'_> {
    /// Draws every series, first to last.
    pub(super) fn all_series(&self, canvas: &Canvas) {
        let bars = self
            .figure
            .series
            .iter()
            .filter(|s| s.mark == Mark::Bars)
            .count();
        let mut bar = 0;
        for (k, series) in self.figure.series.iter().enumerate() {
            if series.mark == Mark::Bars {
                self.bars(canvas, series.tone.unwrap_or(k), series, bar, bars);
                bar += 1;
            } else {
                self.points(canvas, series.tone.unwrap_or(k), series);
            }
        }
    }

    fn points(&self, canvas: &Canvas, tone: usize, series: &Series) {
        let line = matches!(series.mark, Mark::Line | Mark::Dashed);
        let shown: Vec<[f64; 2]> = series
            .points
            .iter()
            .filter_map(|p| {
                if line {
                    self.to_the_edge(*p)
                } else {
                    self.figure.place(*p)
                }
            })
            .filter(|p| self.inside(*p))
            .map(|p| self.at(p))
            .collect();
        let ink = palette::color(tone).mix(1.0);
        match series.mark {
            Mark::Line => canvas.line_of(tone, &shown, ink),
            Mark::LinePoints => canvas.line(&shown, ink, 1.5),
            Mark::Dashed => canvas.dashed(&shown, ink, 1.5),
            Mark::Points | Mark::Bars => {}
        }
        if matches!(series.mark, Mark::Points | Mark::LinePoints) {
            let crowded = shown.len() > CROWD;
            let radius = if crowded { 2.2 } else { marks::RADIUS };
            for point in shown {
                marks::draw(canvas, tone, point, radius, crowded);
            }
        }
    }

    /// Bars side by side in each category; a value that cannot be shown (a failed method) is a cross.
    fn bars(&self, canvas: &Canvas, tone: usize, series: &Series, place: usize, of: usize) {
        let width = 0.8 / of as f64;
        let base = self.y[0].max(if self.figure.y.scale == Scale::Linear {
            0.0_f64.min(self.y[1])
        } else {
            self.y[0]
        });
        for [x, y] in &series.points {
            let start = x - 0.4 + width * place as f64;
            let Some(height) = self.figure.y.linearize(*y) else {
                let [px, py] = self.at([start + 0.5 * width, base]);
                canvas.colored_text(
                    [px, py - 8.0],
                    "✗",
                    12.0,
                    Anchor::Center,
                    palette::color(tone),
                );
                continue;
            };
            let (a, b) = (
                self.at([start + 0.04 * width, base]),
                self.at(self.clamped([start + 0.96 * width, height])),
            );
            canvas.fill(
                &[a, [b[0], a[1]], b, [a[0], b[1]]],
                palette::color(tone).mix(0.9),
            );
        }
    }

    /// Linearized coordinates, where values ≤ 0 on a logarithmic axis lie on its lower end.
    fn to_the_edge(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let end = |axis: &Axis, value: f64, low: f64| {
            axis.linearize(value)
                .or_else(|| (value <= 0.0).then_some(low))
        };
        Some([
            end(&self.figure.x, x, self.x[0])?,
            end(&self.figure.y, y, self.y[0])?,
        ])
    }
}
